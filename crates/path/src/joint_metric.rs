use cranny_robot::Robot;

use crate::MotionLimits;

/// Weighted L2 metric of configuration space.
#[derive(Clone, Debug, PartialEq)]
pub struct JointMetric {
    weights: Vec<f64>,
}

impl JointMetric {
    /// Creates the metric in which a joint weighs its reach: the largest distance, at `q = 0`, of a point of the robot beyond
    /// the joint from the joint origin, in metres, from 0.1 to 1; 1 for a prismatic joint. Configurations are then near each
    /// other if the robot has a similar shape, even if wrist angles differ.
    pub fn by_reach(robot: &Robot) -> Self {
        // A joint that moves nothing must still distinguish configurations.
        const LEAST_WEIGHT: f64 = 0.1;
        Self { weights: robot.joint_reaches().iter().map(|reach| reach.clamp(LEAST_WEIGHT, 1.0)).collect() }
    }

    /// Creates the plain L2 norm, metres and radians alike.
    pub fn plain(dof: usize) -> Self {
        Self { weights: vec![1.0; dof] }
    }

    /// Creates the metric that weights each joint by its time per unit at full speed, in seconds.
    pub fn by_speed(limits: &MotionLimits) -> Self {
        Self { weights: limits.velocity.iter().map(|velocity| velocity.recip()).collect() }
    }

    /// Writes `q` (m, rad; one per joint) in coordinates in which the plain L2 distance is this metric.
    pub fn scale(&self, q: &[f64], scaled: &mut [f64]) {
        for ((scaled, q), weight) in scaled.iter_mut().zip(q).zip(&self.weights) {
            *scaled = q * weight;
        }
    }

    /// Inverts [`Self::scale`] and writes `q` (m, rad; one per joint).
    pub fn unscale(&self, scaled: &[f64], q: &mut [f64]) {
        for ((q, scaled), weight) in q.iter_mut().zip(scaled).zip(&self.weights) {
            *q = scaled / weight;
        }
    }

    /// Returns the distance between two configurations (m, rad; one per joint).
    pub fn distance(&self, a: &[f64], b: &[f64]) -> f64 {
        let sum: f64 =
            a.iter().zip(b).zip(&self.weights).map(|((a, b), weight)| ((a - b) * weight).powi(2)).sum();
        sum.sqrt()
    }
}
