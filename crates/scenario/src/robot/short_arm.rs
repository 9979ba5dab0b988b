use cranny_grasp::Grasp;
use cranny_robot::{DampedInverse, Robot, Twist};
use cranny_spatial::{EXACT_TRANSLATION_M, Pose, Stream, Vector};

/// Minimum number of joints with which an arm can bring its hand to any pose.
pub(crate) const ALL_POSES_DOF: usize = 6;

/// Number of start configurations tried per grasp, and of iterations from each.
const STARTS: usize = 12;
const ITERATIONS: usize = 60;

/// Maximum deviation from the grasp, in metres and radians: a tenth of the tolerance for exact poses.
const NEAR: f64 = 0.1 * EXACT_TRANSLATION_M;

/// Returns a grasp on the same two contacts that an arm of fewer than six joints can reach: the approach rotates about the
/// closing axis until the arm reaches it. `None` if it fails from all of a few configurations.
///
/// Damped least squares (Nakamura & Hanafusa 1986, whole; see
/// [`damped_pseudo_inverse_step`](cranny_robot::damped_pseudo_inverse_step)) on five rows: the position, and the rotations
/// about the other two axes.
pub(crate) fn held(robot: &Robot, grasp: &Grasp, random: &mut Stream) -> Option<Grasp> {
    let pose = &grasp.world_from_gripper;
    let (mut frames, mut jacobian) = (robot.frames(), robot.empty_jacobian());
    let mut step = vec![0.0; robot.dof()];
    for _ in 0..STARTS {
        let mut q = robot.random_configuration(random);
        for _ in 0..ITERATIONS {
            robot.forward_kinematics(&q, &mut frames);
            let tip = *frames.link(robot.tip());
            let twist = twist_without_approach(&tip, pose);
            if twist.norm() < NEAR {
                return Some(Grasp { world_from_gripper: tip, ..*grasp });
            }
            robot.jacobian(&frames, robot.tip(), &mut jacobian);
            for mut column in jacobian.column_iter_mut() {
                let turn = tip.rotation.inverse() * Vector::new(column[3], column[4], column[5]);
                (column[3], column[4], column[5]) = (turn.x, 0.0, turn.z);
            }
            /// Damping, small compared to the lengths of arms, in metres.
            const DAMPING: f64 = 0.02;
            let Some(inverse) = DampedInverse::new(&jacobian, DAMPING) else { break };
            inverse.step(&jacobian, &twist, &mut step);
            for ((value, step), limits) in q.iter_mut().zip(&step).zip(robot.limits()) {
                *value = limits.clamp(*value + step);
            }
        }
    }
    None
}

/// Returns the twist from the tip to a pose without the rotation about the tip's y axis: translation in the root frame,
/// rotation in the tip frame.
fn twist_without_approach(tip: &Pose, pose: &Pose) -> Twist {
    let way = pose.translation.vector - tip.translation.vector;
    let y_in_tip = tip.rotation.inverse() * (pose.rotation * Vector::y());
    let turn = Vector::y().cross(&y_in_tip);
    // Half a turn about y gives the same closing axis; the opposite direction is the twin grasp.
    let sign = if y_in_tip.y < 0.0 { -1.0 } else { 1.0 };
    Twist::new(way.x, way.y, way.z, sign * turn.x, 0.0, sign * turn.z)
}
