use std::f64::consts::TAU;

use cranny_path::least_length as least_to_goal;
use cranny_task::{Move, Problem, Stage, State};

/// Lower bound of the length of every path through these stages, in the plain norm of `q` (m and rad alike), at most `most`,
/// the length of a known path; no stages stand for the goal of the problem. `None` if it is unknown: for tasks other than to
/// pick an object, to reach a configuration, or to pick an object and return home, and as [`cranny_path::least_length`].
pub fn least_length(problem: &Problem, stages: &[Stage], most: f64) -> Option<f64> {
    let picking = |pick| State::start(problem)?.picking(problem, pick).ok();
    match stages {
        [] => least_to_goal(problem, most),
        [Stage::Pick(pick)] => least_to_goal(&picking(pick)?, most),
        [Stage::Move(goal)] => {
            let moving = State::start(problem)?.moving(goal.ends(problem)?).ok()?;
            least_to_goal(&moving, most)
        }
        // There and back. A continuous joint may come home by another turn, which may be nearer.
        [Stage::Pick(pick), Stage::Move(Move::Home)] => {
            let robot = problem.robot();
            let is_endless = |joint: usize| robot.joint_difference(joint, 0.0, TAU) < 1.0;
            let ways = if (0..robot.dof()).any(is_endless) { 1.0 } else { 2.0 };
            Some(ways * least_to_goal(&picking(pick)?, most / ways)?)
        }
        _ => None,
    }
}
