use cranny_scenario::Friction;
use cranny_spatial::{Pose, Rotation, Stream, Vector};

/// Deviation of a grasp and its object from their models.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disturbance {
    /// Pose of the hand in the gripper frame of the grasp: equivalent to an error of the object pose.
    pub grasp_from_hand: Pose,
    /// Factor on a coefficient of friction that is one number.
    pub friction: f64,
    /// Share of the way from the lower to the upper end of a coefficient that is a range, in [0, 1].
    pub friction_share: f64,
    /// Factor on the mass.
    pub mass: f64,
    /// Factor on the closing force.
    pub closing_force: f64,
}

impl Disturbance {
    /// Returns the coefficient of friction of an object with this one.
    pub fn friction_of(&self, stated: &Friction) -> f64 {
        if stated.is_range() {
            stated.low + self.friction_share * (stated.high - stated.low)
        } else {
            stated.low * self.friction
        }
    }

    /// Draws the errors of an executed plan from a seed: of the hand 2 mm along and 2° about each axis, of the friction 30 % or
    /// its stated range, of the mass 20 %, each uniform.
    pub fn of_execution(seed: u64) -> Self {
        let wrong = Uncertainty {
            position_m: 0.002,
            rotation_rad: 2_f64.to_radians(),
            friction: 0.3,
            mass: 0.2,
            closing_force: 0.0,
        };
        wrong.design(1, seed).pop().unwrap_or_default()
    }
}

impl Default for Disturbance {
    fn default() -> Self {
        Self {
            grasp_from_hand: Pose::identity(),
            friction: 1.0,
            friction_share: 0.0,
            mass: 1.0,
            closing_force: 1.0,
        }
    }
}

/// Uncertainty of a grasp: half-widths of uniform distributions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Uncertainty {
    /// Translation of the hand along each axis, in metres.
    pub position_m: f64,
    /// Rotation of the hand about each axis, in radians.
    pub rotation_rad: f64,
    /// Relative error of the friction, in [0, 1).
    pub friction: f64,
    /// Relative error of the mass, in [0, 1).
    pub mass: f64,
    /// Relative error of the closing force, in [0, 1).
    pub closing_force: f64,
}

impl Default for Uncertainty {
    fn default() -> Self {
        Self {
            position_m: 0.003,
            rotation_rad: 3_f64.to_radians(),
            friction: 0.25,
            mass: 0.1,
            closing_force: 0.1,
        }
    }
}

impl Uncertainty {
    /// Draws `count` disturbances as a Latin hypercube (`McKay`, Beckman & Conover 1979, "A comparison of three methods for
    /// selecting values of input variables in the analysis of output from a computer code", whole): one value in each of
    /// `count` equal intervals of every range. They depend only on the seed, so all grasps get the same ones.
    pub fn design(&self, count: usize, seed: u64) -> Vec<Disturbance> {
        let mut random = Stream::new(seed, 0);
        let columns: Vec<Vec<f64>> = (0..9).map(|_| column(count, &mut random)).collect();
        let vector = |row: usize, first: usize| {
            Vector::new(columns[first][row], columns[first + 1][row], columns[first + 2][row])
        };
        let disturbance = |row: usize| Disturbance {
            grasp_from_hand: Pose::from_parts(
                (vector(row, 0) * self.position_m).into(),
                Rotation::from_scaled_axis(vector(row, 3) * self.rotation_rad),
            ),
            friction: 1.0 + self.friction * columns[6][row],
            friction_share: 0.5 + 0.5 * columns[6][row],
            mass: 1.0 + self.mass * columns[7][row],
            closing_force: 1.0 + self.closing_force * columns[8][row],
        };
        (0..count).map(disturbance).collect()
    }
}

/// Draws one value in (−1, 1) from each of `count` equal intervals, in random order.
fn column(count: usize, random: &mut Stream) -> Vec<f64> {
    let mut values: Vec<f64> =
        (0..count).map(|part| 2.0 * (part as f64 + random.uniform()) / count as f64 - 1.0).collect();
    for last in (1..count).rev() {
        values.swap(last, random.index(last + 1));
    }
    values
}
