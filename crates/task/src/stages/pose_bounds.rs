use std::f64::consts::{FRAC_PI_2, PI, TAU};

use cranny_spatial::nalgebra::Quaternion;
use cranny_spatial::{FARTHEST_M, Pose, PoseDifference, Rotation, Stream, Vector, sin_cos};

/// Bounds on a pose relative to a frame: `B_w` of a task space region (Berenson, Srinivasa & Kuffner 2011, §4.1).
#[derive(Clone, Debug, PartialEq)]
pub enum PoseBounds {
    /// A box of positions, and rotations up to an angle.
    Within {
        /// Greatest distances along the axes of the frame, in metres.
        within_m: [f64; 3],
        /// Greatest angle of the rotation, in degrees.
        within_deg: f64,
    },
    /// Intervals of x, y, z and of roll, pitch, yaw, with the rotation `R_z(yaw)·R_y(pitch)·R_x(roll)`.
    Intervals {
        /// Lower and upper bounds of x, y, z, in metres.
        position_m: [[f64; 2]; 3],
        /// Lower and upper bounds of roll, pitch and yaw, in degrees.
        rpy_deg: [[f64; 2]; 3],
    },
}

/// Greatest bound of an angle, in degrees: an interval of two turns contains every angle.
const MOST_DEG: f64 = 360.0;

impl PoseBounds {
    /// Returns the fault, in words, of invalid bounds.
    pub fn fault(&self) -> Option<String> {
        match self {
            Self::Within { within_m, within_deg } => {
                if !within_m.iter().all(|side_m| (0.0..=FARTHEST_M).contains(side_m)) {
                    return Some("`within_m` has to be three distances of 0 m or more".to_owned());
                }
                let is_angle = (0.0..=180.0).contains(within_deg);
                (!is_angle).then(|| "`within_deg` has to be 0 to 180".to_owned())
            }
            Self::Intervals { position_m, rpy_deg } => {
                let metres = ["x", "y", "z"].into_iter().zip(position_m).map(|row| (row, FARTHEST_M));
                let degrees =
                    ["roll_deg", "pitch_deg", "yaw_deg"].into_iter().zip(rpy_deg).map(|row| (row, MOST_DEG));
                metres.chain(degrees).find_map(|((key, [lower, upper]), most)| {
                    if !(lower.abs() <= most && upper.abs() <= most) {
                        return Some(format!(
                            "'{key}' is [{lower}, {upper}], but both bounds have to lie in -{most} to {most}"
                        ));
                    }
                    (lower > upper).then(|| {
                        format!("'{key}' is [{lower}, {upper}], which is empty; give the lower bound first")
                    })
                })
            }
        }
    }

    /// Draws a pose in the frame of the bounds: positions are uniform; roll, pitch and yaw are uniform, or rotations have uniform axes and uniform angles.
    pub fn draw(&self, random: &mut Stream) -> Pose {
        match self {
            Self::Within { within_m, within_deg } => {
                let place = Vector::from_fn(|axis, _| within_m[axis] * random.uniform_between(-1.0, 1.0));
                let turn = random.rotation() * Vector::z() * (random.uniform() * within_deg.to_radians());
                Pose::from_parts(place.into(), Rotation::from_scaled_axis(turn))
            }
            Self::Intervals { .. } => self.at(&std::array::from_fn(|_| random.uniform())),
        }
    }

    /// Returns the central pose in the frame of the bounds.
    pub fn middle(&self) -> Pose {
        self.at(&[0.5; 6])
    }

    /// Returns the pose, in the frame of the bounds, at these shares of the intervals, each in [0, 1]; the identity for other bounds.
    pub fn at(&self, shares: &[f64; 6]) -> Pose {
        let Self::Intervals { position_m, rpy_deg } = self else { return Pose::identity() };
        let value = |[lower, upper]: [f64; 2], share: f64| lower + (upper - lower) * share;
        let place = Vector::from_fn(|axis, _| value(position_m[axis], shares[axis]));
        let rpy: [f64; 3] = std::array::from_fn(|axis| {
            let [lower, upper] = rpy_deg[axis].map(f64::to_radians);
            value([lower, upper.min(lower + TAU)], shares[3 + axis])
        });
        Pose::from_parts(place.into(), rotation_of(rpy))
    }

    /// Returns true for each interval that is longer than 0.
    pub fn is_free(&self) -> [bool; 6] {
        let Self::Intervals { position_m, rpy_deg } = self else { return [false; 6] };
        let is_long = |[lower, upper]: [f64; 2]| upper > lower;
        std::array::from_fn(|axis| is_long(if axis < 3 { position_m[axis] } else { rpy_deg[axis - 3] }))
    }

    /// Returns the sum of the widths of all intervals (m, rad), angles up to a turn: the weight of a region among several
    /// (Berenson, Srinivasa & Kuffner 2011, §4.3).
    pub fn width(&self) -> f64 {
        match self {
            Self::Within { within_m, within_deg } => {
                2.0 * (within_m.iter().sum::<f64>() + within_deg.to_radians())
            }
            Self::Intervals { position_m, rpy_deg } => {
                let turns = rpy_deg.map(|[lower, upper]| (upper - lower).to_radians().min(TAU));
                position_m.iter().map(|[lower, upper]| upper - lower).chain(turns).sum()
            }
        }
    }

    /// Returns the centre of the box of positions, and half its diagonal, in metres.
    pub fn box_ball(&self) -> (Vector, f64) {
        let (lower, upper) = match self {
            Self::Within { within_m, .. } => (-Vector::from(*within_m), Vector::from(*within_m)),
            Self::Intervals { position_m, .. } => {
                let [lower, upper] = [0, 1].map(|end| Vector::from(position_m.map(|interval| interval[end])));
                (lower, upper)
            }
        };
        ((lower + upper) * 0.5, (upper - lower).norm() * 0.5)
    }

    /// Returns the deviation of a pose in the frame of the bounds: the distance of its position from the box (m), and the angle
    /// of its rotation from the nearest one within the bounds (rad). `off = 0` within the bounds. For intervals the nearest
    /// rotation is that of least difference in roll, pitch and yaw, over their images by whole turns and the flipped triple
    /// (roll + π, π − pitch, yaw + π), so that the angle is an upper bound of the least one.
    pub fn off(&self, pose: &Pose) -> PoseDifference {
        let place = &pose.translation.vector;
        match self {
            Self::Within { within_m, within_deg } => {
                let beyond = Vector::from_fn(|axis, _| (place[axis].abs() - within_m[axis]).max(0.0));
                let PoseDifference { rotation_rad, .. } = PoseDifference::between(&Pose::identity(), pose);
                let rotation_rad = (rotation_rad - within_deg.to_radians()).max(0.0);
                PoseDifference { translation_m: beyond.norm(), rotation_rad }
            }
            Self::Intervals { position_m, rpy_deg } => {
                let beyond = Vector::from_fn(|axis, _| {
                    let [lower, upper] = position_m[axis];
                    place[axis] - place[axis].clamp(lower, upper)
                });
                let [roll, pitch, yaw] = rpy_of(&pose.rotation);
                let images = [[roll, pitch, yaw], [roll + PI, PI - pitch, yaw + PI]];
                let angle = |rpy: [f64; 3]| {
                    let nearest = std::array::from_fn(|axis| nearest_image(rpy[axis], rpy_deg[axis]));
                    let nearest = Pose::from_parts(Vector::zeros().into(), rotation_of(nearest));
                    PoseDifference::between(&nearest, pose).rotation_rad
                };
                let [straight, flipped] = images.map(angle);
                PoseDifference { translation_m: beyond.norm(), rotation_rad: straight.min(flipped) }
            }
        }
    }
}

/// Returns the angle (rad) within bounds (degrees) that is nearest to an angle (rad), modulo whole turns.
fn nearest_image(angle: f64, bounds_deg: [f64; 2]) -> f64 {
    let [lower, upper] = bounds_deg.map(f64::to_radians);
    let image = angle - TAU * ((angle - 0.5 * (lower + upper)) / TAU).round();
    image.clamp(lower, upper)
}

/// Returns the rotation `R_z(yaw)·R_y(pitch)·R_x(roll)` of three angles (rad).
pub(crate) fn rotation_of([roll, pitch, yaw]: [f64; 3]) -> Rotation {
    let [(sr, cr), (sp, cp), (sy, cy)] = [roll, pitch, yaw].map(|angle| sin_cos(0.5 * angle));
    Rotation::from_quaternion(Quaternion::new(
        cr * cp * cy + sr * sp * sy,
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
    ))
}

/// Returns roll, pitch and yaw of a rotation (rad), with pitch in [−π/2, π/2].
fn rpy_of(rotation: &Rotation) -> [f64; 3] {
    let matrix = rotation.to_rotation_matrix();
    let pitch = -libm::asin(matrix[(2, 0)].clamp(-1.0, 1.0));
    [
        libm::atan2(matrix[(2, 1)], matrix[(2, 2)]),
        pitch.clamp(-FRAC_PI_2, FRAC_PI_2),
        libm::atan2(matrix[(1, 0)], matrix[(0, 0)]),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn intervals(random: &mut Stream) -> PoseBounds {
        let mut pair = |most: f64| {
            let [a, b] = [0, 1].map(|_| random.uniform_between(-most, most));
            [a.min(b), a.max(b)]
        };
        PoseBounds::Intervals {
            position_m: [pair(1.0), pair(1.0), pair(1.0)],
            rpy_deg: [pair(180.0), pair(80.0), pair(300.0)],
        }
    }

    #[test]
    fn draws_are_within_the_bounds_also_as_other_triples_of_the_same_rotation() {
        let mut random = Stream::new(3, 0);
        for _ in 0..300 {
            let bounds = intervals(&mut random);
            for _ in 0..20 {
                let off = bounds.off(&bounds.draw(&mut random));
                assert!(off.translation_m <= 0.0 && off.rotation_rad < 1e-6, "{bounds:?}: {off:?}");
            }
        }
    }

    /// Compares with a search over a grid of each interval, refined about its best cell.
    #[test]
    fn deviations_are_those_of_a_search_over_the_bounds() {
        let mut random = Stream::new(5, 0);
        for _ in 0..40 {
            let bounds = intervals(&mut random);
            let away = Pose::from_parts(Vector::new(0.5, -0.4, 0.3).into(), random.rotation());
            let pose = Pose::from_parts((away.translation.vector * 2.0).into(), away.rotation);
            let off = bounds.off(&pose);
            let (mut best, mut middle, mut width) = (f64::MAX, [0.5; 6], 0.5);
            let mut place = f64::MAX;
            for _ in 0..12 {
                const STEPS: u32 = 8;
                let around = middle;
                for cell in 0..(STEPS + 1).pow(3) {
                    let step =
                        |axis: u32| f64::from(cell / (STEPS + 1).pow(axis) % (STEPS + 1)) / f64::from(STEPS);
                    let mut shares = around;
                    for axis in 0..3u32 {
                        let share = around[3 + axis as usize] + width * (2.0 * step(axis) - 1.0);
                        shares[3 + axis as usize] = share.clamp(0.0, 1.0);
                        let share = around[axis as usize] + width * (2.0 * step(axis) - 1.0);
                        shares[axis as usize] = share.clamp(0.0, 1.0);
                    }
                    let found = PoseDifference::between(&bounds.at(&shares), &pose);
                    place = place.min(found.translation_m);
                    if found.rotation_rad < best {
                        (best, middle) = (found.rotation_rad, shares);
                    }
                }
                width *= 0.6;
            }
            // The nearest in roll, pitch and yaw is an upper bound of the least angle, and exact where that is 0.
            assert!(off.rotation_rad > best - 1e-3, "{bounds:?}: {off:?}, {best}");
            assert!(best > 1e-2 || off.rotation_rad < 0.05, "{bounds:?}: {off:?}, {best}");
            assert!(off.translation_m <= place + 1e-9, "{off:?}, {place}");
        }
    }

    /// χ² over ten cells of each interval, with 9 degrees of freedom: 27.9 is exceeded once in 1000.
    #[test]
    fn draws_are_uniform() {
        const CELLS: usize = 10;
        const DRAWS: usize = 20_000;
        let bounds = PoseBounds::Intervals {
            position_m: [[-0.2, 0.3], [1.0, 1.5], [-2.0, -1.0]],
            rpy_deg: [[-170.0, 150.0], [-60.0, 80.0], [10.0, 100.0]],
        };
        let PoseBounds::Intervals { position_m, rpy_deg } = &bounds else { return };
        let mut random = Stream::new(11, 0);
        let mut counts = [[0_usize; CELLS]; 6];
        for _ in 0..DRAWS {
            let pose = bounds.draw(&mut random);
            let rpy = rpy_of(&pose.rotation).map(f64::to_degrees);
            for axis in 0..6 {
                let (value, [lower, upper]) = if axis < 3 {
                    (pose.translation.vector[axis], position_m[axis])
                } else {
                    (rpy[axis - 3], rpy_deg[axis - 3])
                };
                #[expect(
                    clippy::cast_possible_truncation,
                    clippy::cast_sign_loss,
                    reason = "a share of CELLS"
                )]
                let cell = ((value - lower) / (upper - lower) * CELLS as f64) as usize;
                counts[axis][cell.min(CELLS - 1)] += 1;
            }
        }
        let expected = DRAWS as f64 / CELLS as f64;
        for counts in counts {
            let chi_squared: f64 =
                counts.iter().map(|count| (*count as f64 - expected).powi(2) / expected).sum();
            assert!(chi_squared < 27.9, "{counts:?}: {chi_squared}");
        }
    }

    #[test]
    fn a_whole_turn_contains_every_angle() {
        let bounds = PoseBounds::Intervals {
            position_m: [[0.0; 2]; 3],
            rpy_deg: [[0.0; 2], [0.0; 2], [-180.0, 180.0]],
        };
        for yaw in [-3.0, 0.0, 3.1, 7.0] {
            let pose = Pose::from_parts(Vector::zeros().into(), rotation_of([0.0, 0.0, yaw]));
            assert!(bounds.off(&pose).rotation_rad < 1e-9);
        }
    }

    #[test]
    fn empty_and_infinite_bounds_are_faults() {
        let with = |yaw: [f64; 2], x: [f64; 2]| PoseBounds::Intervals {
            position_m: [x, [0.0; 2], [0.0; 2]],
            rpy_deg: [[0.0; 2], [0.0; 2], yaw],
        };
        assert!(with([0.0, 0.0], [0.0, 0.1]).fault().is_none());
        assert!(with([1.0, 0.0], [0.0, 0.1]).fault().is_some_and(|fault| fault.contains("yaw_deg")));
        assert!(with([0.0, f64::NAN], [0.0, 0.1]).fault().is_some());
        assert!(with([0.0, 0.0], [f64::NEG_INFINITY, 0.1]).fault().is_some());
    }
}
