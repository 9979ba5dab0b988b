use cranny_robot::Robot;

use crate::MotionLimits;

/// A metric of configuration space whose joints weigh as much as they move: the farthest that any point of
/// the robot beyond the joint lies from its origin at `q = 0`, in metres, at most 1; 1 for a prismatic joint.
///
/// With weights by reach a sample is near where the robot looks alike, not where its wrist happens to be
/// turned alike.
#[derive(Clone, Debug, PartialEq)]
pub struct JointMetric {
    weights: Vec<f64>,
}

impl JointMetric {
    /// Of the joints of a robot, as above.
    pub fn by_reach(robot: &Robot) -> Self {
        // A joint that moves nothing still tells configurations apart.
        const LEAST_WEIGHT: f64 = 0.1;
        Self { weights: robot.joint_reaches().iter().map(|reach| reach.clamp(LEAST_WEIGHT, 1.0)).collect() }
    }

    /// The plain L2 norm, metres and radians alike.
    pub fn plain(dof: usize) -> Self {
        Self { weights: vec![1.0; dof] }
    }

    /// Joints weigh as many seconds as they take for a unit.
    pub fn by_speed(limits: &MotionLimits) -> Self {
        Self { weights: limits.velocity.iter().map(|velocity| velocity.recip()).collect() }
    }

    /// Writes `q` (m, rad; one per joint) in coordinates in which the plain L2 distance is this metric.
    pub fn scale(&self, q: &[f64], scaled: &mut [f64]) {
        for ((scaled, q), weight) in scaled.iter_mut().zip(q).zip(&self.weights) {
            *scaled = q * weight;
        }
    }

    /// The inverse of [`Self::scale`], which writes `q` (m, rad; one per joint).
    pub fn unscale(&self, scaled: &[f64], q: &mut [f64]) {
        for ((q, scaled), weight) in q.iter_mut().zip(scaled).zip(&self.weights) {
            *q = scaled / weight;
        }
    }

    /// The distance of two configurations (m, rad; one per joint).
    pub fn distance(&self, a: &[f64], b: &[f64]) -> f64 {
        let sum: f64 =
            a.iter().zip(b).zip(&self.weights).map(|((a, b), weight)| ((a - b) * weight).powi(2)).sum();
        sum.sqrt()
    }
}
