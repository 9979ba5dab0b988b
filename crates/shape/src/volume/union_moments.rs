use cranny_spatial::nalgebra::Matrix3;
use cranny_spatial::{Rotation, Vector};

use crate::{ShapeError, TriangleSoup, VolumeMoments};

/// Moments of the union of closed surfaces, which may overlap.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UnionMoments {
    /// Volume, centre of mass and inertia.
    pub moments: VolumeMoments,
    /// Bound on the error of the centre of mass, in metres: 0 where nothing overlaps.
    pub error_m: f64,
}

/// Number of lines in each of two directions that measure shared volume.
const LINES: u32 = 256;
/// Error of the centre from these lines, as a share of the greatest extent: twenty times the error in the test
/// (`the_centre_of_overlapping_boxes_is_that_of_their_union`).
const ERROR_SHARE: f64 = 5e-4;
/// Rotation of the lines, in radians: along no face of a usual model, so that lines spread over each face.
const TURN_RAD: [f64; 3] = [0.611_8, 0.382_7, 0.916_3];

impl UnionMoments {
    /// Moments of surfaces with normals outwards, and inwards around cavities.
    ///
    /// Subtracts the surplus of shared volume from the moments of [`VolumeMoments::of_mesh`], in which it counts once per
    /// surface around it. Integrates the surplus along parallel lines, exactly along each: a point counts as often as the
    /// surfaces wind around it. The centre is exact if no line meets shared volume.
    ///
    /// # Errors
    /// Those of [`VolumeMoments::of_mesh`].
    pub fn of_mesh(soup: &TriangleSoup) -> Result<Self, ShapeError> {
        let all = VolumeMoments::of_mesh(soup)?;
        let [roll, pitch, yaw] = TURN_RAD;
        let turn = Rotation::from_euler_angles(roll, pitch, yaw);
        // Coordinates are about the centre, so that sums do not cancel far from the origin.
        let points: Vec<Vector> = soup.vertices.iter().map(|vertex| turn * (vertex - all.center)).collect();
        let used = || soup.triangles.iter().flatten().map(|vertex| points[*vertex as usize]);
        let start = points[soup.triangles[0][0] as usize];
        let (low, high) =
            used().fold((start, start), |(low, high), point| (low.inf(&point), high.sup(&point)));
        let lines = Lines { low, step: (high - low) / f64::from(LINES) };
        let mut crossings: Vec<Crossing> = Vec::new();
        for triangle in &soup.triangles {
            lines.cross(triangle.map(|vertex| points[vertex as usize]), &mut crossings);
        }
        crossings
            .sort_by(|a, b| a.line.cmp(&b.line).then(a.z.total_cmp(&b.z)).then(a.winding.cmp(&b.winding)));
        let (mut excess_m3, mut first, mut second) = (0.0, Vector::zeros(), Matrix3::zeros());
        for line in crossings.chunk_by(|a, b| a.line == b.line) {
            let place = lines.at(line[0].line);
            let mut winding = 0;
            for pair in line.windows(2) {
                winding += pair[0].winding;
                let surplus = f64::from((winding - 1).max(0));
                let volume_m3 = surplus * (pair[1].z - pair[0].z) * lines.step.x * lines.step.y;
                let at = Vector::new(place[0], place[1], 0.5 * (pair[0].z + pair[1].z));
                let size = Vector::new(lines.step.x, lines.step.y, pair[1].z - pair[0].z);
                excess_m3 += volume_m3;
                first += at * volume_m3;
                let of_block = Matrix3::from_diagonal(&(size.component_mul(&size) / 12.0));
                second += (at * at.transpose() + of_block) * volume_m3;
            }
        }
        // Neighbours that touch share the rounding of a line.
        if excess_m3 < NOTHING * all.volume_m3 {
            return Ok(Self { moments: all, error_m: 0.0 });
        }
        // These sums are about the common centre, along the rotated axes.
        let to_own = turn.inverse().to_rotation_matrix();
        let volume_m3 = all.volume_m3 - excess_m3;
        let shift = to_own * (-first / volume_m3);
        let spread = |inertia: Matrix3<f64>| Matrix3::identity() * (0.5 * inertia.trace()) - inertia;
        let second = spread(all.inertia_per_mass_m2) * all.volume_m3 - to_own * second * to_own.transpose();
        let covariance = second / volume_m3 - shift * shift.transpose();
        let moments = VolumeMoments {
            volume_m3,
            center: all.center + shift,
            inertia_per_mass_m2: Matrix3::identity() * covariance.trace() - covariance,
        };
        Ok(Self { moments, error_m: ERROR_SHARE * (high - low).max() })
    }
}

/// Share of the volume below which shared volume is rounding.
const NOTHING: f64 = 1e-9;

/// Parallel lines along z through the centres of the cells of a grid.
struct Lines {
    low: Vector,
    step: Vector,
}

/// Intersection of a line with a surface.
struct Crossing {
    line: u32,
    z: f64,
    /// 1 where the line enters the enclosed volume, −1 where it leaves.
    winding: i32,
}

impl Lines {
    fn coordinate(&self, axis: usize, index: u32) -> f64 {
        self.low[axis] + (f64::from(index) + 0.5) * self.step[axis]
    }

    fn at(&self, line: u32) -> [f64; 2] {
        [self.coordinate(0, line % LINES), self.coordinate(1, line / LINES)]
    }

    /// Lines whose coordinate along an axis may lie in a range.
    fn range(&self, axis: usize, low: f64, high: f64) -> std::ops::Range<u32> {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "clamped to the lines that there are"
        )]
        let index =
            |value: f64| ((value - self.low[axis]) / self.step[axis]).clamp(0.0, f64::from(LINES)) as u32;
        index(low).saturating_sub(1)..(index(high) + 1).min(LINES)
    }

    fn cross(&self, [a, b, c]: [Vector; 3], crossings: &mut Vec<Crossing>) {
        let normal = (b - a).cross(&(c - a));
        if normal.z == 0.0 {
            return;
        }
        let (low, high) = (a.inf(&b).inf(&c), a.sup(&b).sup(&c));
        let winding = if normal.z < 0.0 { 1 } else { -1 };
        for row in self.range(1, low.y, high.y) {
            for column in self.range(0, low.x, high.x) {
                let [x, y] = [self.coordinate(0, column), self.coordinate(1, row)];
                let is_left = [(a, b), (b, c), (c, a)].map(|(from, to)| is_left(from, to, [x, y]));
                if is_left == [winding < 0; 3] {
                    let z = a.z - (normal.x * (x - a.x) + normal.y * (y - a.y)) / normal.z;
                    crossings.push(Crossing {
                        line: row * LINES + column,
                        z: z.clamp(low.z, high.z),
                        winding,
                    });
                }
            }
        }
    }
}

/// Returns true if a point lies left of an edge, seen along z. The reversed edge always gives the opposite.
fn is_left(from: Vector, to: Vector, [x, y]: [f64; 2]) -> bool {
    let turn = |from: Vector, to: Vector| (to.x - from.x) * (y - from.y) - (to.y - from.y) * (x - from.x);
    if (from.x, from.y) < (to.x, to.y) { turn(from, to) >= 0.0 } else { turn(to, from) < 0.0 }
}

#[cfg(test)]
mod tests {
    use cranny_spatial::Pose;
    use proptest::prelude::*;

    use super::*;
    use crate::{Solid, Surface};

    fn boxes(of: &[([f64; 3], [f64; 3])]) -> TriangleSoup {
        let mut soup = TriangleSoup::default();
        for ([x, y, z], half_m) in of {
            soup.append(&Surface::cuboid_soup(&(*half_m).into()), &Pose::translation(*x, *y, *z));
        }
        soup
    }

    /// Volume, centre and trace of the inertia for 1 kg, summed over the cells between all faces.
    fn of_boxes(of: &[([f64; 3], [f64; 3])]) -> (f64, Vector, f64) {
        let cuts = [0, 1, 2].map(|axis| {
            let mut cuts: Vec<f64> =
                of.iter().flat_map(|(at, half)| [at[axis] - half[axis], at[axis] + half[axis]]).collect();
            cuts.sort_by(f64::total_cmp);
            cuts
        });
        let (mut volume, mut first, mut squares) = (0.0, Vector::zeros(), 0.0);
        for x in cuts[0].windows(2) {
            for y in cuts[1].windows(2) {
                for z in cuts[2].windows(2) {
                    let sides = [x, y, z];
                    let middle = sides.map(|side| 0.5 * (side[0] + side[1]));
                    let is_in = |(at, half): &([f64; 3], [f64; 3])| {
                        (0..3).all(|axis| (middle[axis] - at[axis]).abs() < half[axis])
                    };
                    if of.iter().any(is_in) {
                        let cell: f64 = sides.iter().map(|side| side[1] - side[0]).product();
                        volume += cell;
                        first += Vector::from(middle) * cell;
                        let size = Vector::from(sides.map(|side| side[1] - side[0]));
                        squares += cell * (Vector::from(middle).norm_squared() + size.norm_squared() / 12.0);
                    }
                }
            }
        }
        let center = first / volume;
        (volume, center, 2.0 * (squares / volume - center.norm_squared()))
    }

    fn a_box() -> impl Strategy<Value = ([f64; 3], [f64; 3])> {
        (proptest::array::uniform3(-0.1..0.1_f64), proptest::array::uniform3(0.005..0.1_f64))
    }

    proptest! {
        #[test]
        fn the_centre_of_overlapping_boxes_is_that_of_their_union(of in proptest::collection::vec(a_box(), 1..6)) {
            let found = UnionMoments::of_mesh(&boxes(&of)).unwrap();
            let (volume_m3, center, inertia_m2) = of_boxes(&of);
            let off_m = (found.moments.center.coords - center).norm();
            prop_assert!(off_m <= 1e-12 + found.error_m / 4.0, "{off_m} {}", found.error_m);
            prop_assert!((found.moments.volume_m3 / volume_m3 - 1.0).abs() < 2e-3);
            prop_assert!((found.moments.inertia_per_mass_m2.trace() / inertia_m2 - 1.0).abs() < 2e-3);
        }
    }

    #[test]
    fn what_is_inside_counts_once_and_cavities_do_not() {
        let plate = ([0.0; 3], [0.1, 0.02, 0.015]);
        let inner = ([0.07, 0.0, 0.0], [0.03, 0.02, 0.015]);
        let repeated = UnionMoments::of_mesh(&boxes(&[plate, inner, inner, inner, inner, inner])).unwrap();
        assert!(repeated.moments.center.coords.norm() < 2e-5 && repeated.error_m < 2e-4, "{repeated:?}");
        let beside = ([0.3, 0.0, 0.0], [0.1, 0.02, 0.015]);
        let apart = UnionMoments::of_mesh(&boxes(&[plate, beside])).unwrap();
        assert!((apart.moments.center.x - 0.15).abs() < 1e-12 && apart.error_m == 0.0, "{apart:?}");
        // The boxes touch face to face.
        let touching = ([0.2, 0.0, 0.0], [0.1, 0.02, 0.015]);
        let touching = UnionMoments::of_mesh(&boxes(&[plate, touching])).unwrap();
        assert!((touching.moments.center.x - 0.1).abs() < 1e-9 && touching.error_m == 0.0, "{touching:?}");
        let mut hollow = boxes(&[plate]);
        let mut cavity = boxes(&[([0.05, 0.0, 0.0], [0.04, 0.01, 0.01])]);
        cavity.triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
        hollow.append(&cavity, &Pose::identity());
        let of_hollow = UnionMoments::of_mesh(&hollow).unwrap();
        assert_eq!(of_hollow.moments, VolumeMoments::of_mesh(&hollow).unwrap());
        let ball = Solid::sphere(0.03).unwrap().tessellation().unwrap();
        assert!(UnionMoments::of_mesh(&ball).unwrap().error_m.abs() < f64::MIN_POSITIVE);
    }
}
