use std::f64::consts::TAU;

use cranny_path::least_length as least_to_goal;
use cranny_task::{Move, Problem, Stage, State};

/// Returns a lower bound on the length of all paths through these stages, in the plain norm of `q` (m and rad alike), and at
/// most `most`, the length of a known path. Without stages, the goal of the problem counts. `None` for tasks other than to pick
/// an object, to reach a configuration, or to pick and return home, and where [`cranny_path::least_length`] returns `None`.
pub fn least_length(problem: &Problem, stages: &[Stage], most: f64) -> Option<f64> {
    let picking = |pick| State::start(problem)?.picking(problem, pick).ok();
    match stages {
        [] => least_to_goal(problem, most),
        [Stage::Pick(pick)] => least_to_goal(&picking(pick)?, most),
        [Stage::Move(goal)] => {
            let moving = State::start(problem)?.moving(goal.ends(problem)?).ok()?;
            least_to_goal(&moving, most)
        }
        // The path goes there and back. A continuous joint may return to another, nearer turn: then only one direction counts.
        [Stage::Pick(pick), Stage::Move(Move::Home)] => {
            let robot = problem.robot();
            let is_endless = |joint: usize| robot.joint_difference(joint, 0.0, TAU) < 1.0;
            let ways = if (0..robot.dof()).any(is_endless) { 1.0 } else { 2.0 };
            Some(ways * least_to_goal(&picking(pick)?, most / ways)?)
        }
        _ => None,
    }
}
