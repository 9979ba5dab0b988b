use cranny_robot::{JointKind, Robot};
use cranny_spatial::Point;

/// A metric of configuration space whose joints weigh as much as they move: the farthest that any point of
/// the robot beyond the joint lies from its origin at `q = 0`, in metres, at most 1; 1 for a prismatic joint.
///
/// With weights by reach a sample is near where the robot looks alike, not where its wrist happens to be
/// turned alike.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct JointMetric {
    weights: Vec<f64>,
}

impl JointMetric {
    pub fn by_reach(robot: &Robot) -> Self {
        let mut frames = robot.frames();
        robot.forward_kinematics(&vec![0.0; robot.dof()], &mut frames);
        let origin = |link: usize| frames.link(link).translation.vector;
        let weight = |joint: &cranny_robot::GroupJoint| match joint.kind {
            JointKind::Prismatic => 1.0,
            JointKind::Revolute => {
                let axis_at = origin(joint.child_link);
                let moved = (0..robot.links().len())
                    .filter(|&link| robot.ancestors(link).iter().any(|m| m.child_link == joint.child_link));
                let reach_m = moved
                    .flat_map(|link| robot.links()[link].collisions.iter().map(move |shape| (link, shape)))
                    .map(|(link, shape)| {
                        let ball = shape.solid.ball();
                        let center: Point = frames.link(link) * (shape.link_from_shape * ball.center);
                        (center.coords - axis_at).norm() + ball.radius_m
                    })
                    .fold(0.0, f64::max);
                // A joint that moves nothing still tells configurations apart.
                const LEAST_WEIGHT: f64 = 0.1;
                reach_m.clamp(LEAST_WEIGHT, 1.0)
            }
        };
        Self { weights: robot.joints().iter().map(weight).collect() }
    }

    /// Writes `q` in coordinates in which the plain L2 distance is this metric.
    pub fn scale(&self, q: &[f64], scaled: &mut [f64]) {
        for ((scaled, q), weight) in scaled.iter_mut().zip(q).zip(&self.weights) {
            *scaled = q * weight;
        }
    }

    pub fn distance(&self, a: &[f64], b: &[f64]) -> f64 {
        let sum: f64 =
            a.iter().zip(b).zip(&self.weights).map(|((a, b), weight)| ((a - b) * weight).powi(2)).sum();
        sum.sqrt()
    }
}
