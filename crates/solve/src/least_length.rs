use cranny_path::least_length as least_to_goal;
use cranny_task::{Move, Problem, Stage, State};

/// A length, in the plain norm of `q` (m and rad alike), that no path through these stages goes below, at most `most`, the
/// length of a known one; no stages stand for the goal of the problem. `None` where it is not known: for other tasks than to
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
        // There and back.
        [Stage::Pick(pick), Stage::Move(Move::Home)] => {
            Some(2.0 * least_to_goal(&picking(pick)?, 0.5 * most)?)
        }
        _ => None,
    }
}
