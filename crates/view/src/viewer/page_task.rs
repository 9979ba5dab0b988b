use std::cmp::Reverse;
use std::collections::BTreeMap;

use cranny_plan::Outcome;
use cranny_record::PlanFile;
use cranny_task::{FailureReason, GraspFailure, Pick, Stage};
use serde::Serialize;

use crate::SampledPath;

/// Stages of a task on a page, with what the plan file states of each.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PageTask {
    /// Stages in order.
    pub stages: Vec<PageStage>,
    /// Index of the farthest stage at which an alternative failed; `None` if the task was solved, or if the plan file does not
    /// state it.
    pub failed_at: Option<usize>,
    /// Number of grasps of the first pick that were tried, if the plan file states the outcome of each.
    pub tried: Option<usize>,
    /// Number of grasps of the first pick that were not tried, if the plan file states the outcome of each.
    pub not_tried: Option<usize>,
}

/// Stage of a task on a page.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PageStage {
    /// Kind: `pick`, `move` or `place`.
    pub kind: &'static str,
    /// Description in words.
    pub name: String,
    /// Outcome.
    pub outcome: StageOutcome,
    /// Start on the path, in seconds; `None` without a path.
    pub from_s: Option<f64>,
    /// End on the path, in seconds; `None` without a path.
    pub until_s: Option<f64>,
    /// Index of the scenario's grasp that a pick takes, if it is one of them.
    pub grasp: Option<usize>,
    /// Proven lower bound of the clearance along the stage, in metres; `None` if nothing is near, or without a proof.
    pub clearance_m: Option<f64>,
    /// Alternatives that failed at this stage, by reason, most frequent first.
    pub failed: Vec<FailedAlternatives>,
    /// Number of alternatives that had not failed after this stage, if the plan file states the outcome of each.
    pub left: Option<usize>,
}

/// Outcome of a stage.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum StageOutcome {
    /// The path of the plan leads through it.
    Done,
    /// At least one alternative led through it, but none through the whole task.
    Passed,
    /// No alternative led beyond it.
    Failed,
    /// No alternative came as far.
    NotReached,
    /// The plan file does not state it.
    Unknown,
}

/// Alternatives that failed for one reason.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct FailedAlternatives {
    /// Reason, in the words in which the page lists it for single grasps.
    pub reason: String,
    /// The same without the number of the stage.
    pub because: String,
    /// Number of alternatives.
    pub count: usize,
    /// Indices of the scenario's grasps among them, ascending.
    pub grasps: Vec<usize>,
}

impl PageTask {
    /// Collects the stages of a plan with the times of its path; `None` for a plan without a list of stages.
    pub(crate) fn of(plan: &PlanFile, path: Option<&SampledPath>) -> Option<Self> {
        let stages = &plan.task;
        if stages.is_empty() {
            return None;
        }
        let first_pick = stages.iter().position(|stage| matches!(stage, Stage::Pick(_))).unwrap_or_default();
        let is_tried = |failure: &&GraspFailure| failure.reason != FailureReason::NotTried;
        let tried = plan.failures.iter().filter(is_tried).count();
        let mut failed = by_stage(plan, first_pick);
        let is_solved = !plan.segments.is_empty();
        let failed_at = if is_solved { None } else { farthest(plan, &failed) };
        let stated = !plan.failures.is_empty();
        let mut left = tried;
        let of_stage = |(index, stage): (usize, &Stage)| {
            let failed = failed.remove(&index).unwrap_or_default();
            left -= if stated { failed.iter().map(|alternatives| alternatives.count).sum() } else { 0 };
            let [from_s, until_s] = times(plan, path, index);
            PageStage {
                kind: kind(stage),
                name: name(stage),
                outcome: outcome(index, is_solved, failed_at),
                from_s,
                until_s,
                grasp: (index == first_pick).then_some(plan.grasp).flatten(),
                clearance_m: clearance_m(plan, index),
                failed,
                left: stated.then_some(left),
            }
        };
        let stages = stages.iter().enumerate().map(of_stage).collect();
        let of_stated = |count: usize| stated.then_some(count);
        let not_tried = of_stated(plan.failures.len() - tried);
        Some(Self { stages, failed_at, tried: of_stated(tried), not_tried })
    }
}

fn kind(stage: &Stage) -> &'static str {
    match stage {
        Stage::Pick(_) => "pick",
        Stage::Move(_) => "move",
        Stage::Place(_) => "place",
    }
}

/// Name of a stage in words, without the distances of its options.
fn name(stage: &Stage) -> String {
    match stage {
        Stage::Pick(Pick { object, .. }) => format!("pick '{}'", object.as_deref().unwrap_or("target")),
        Stage::Place(place) => format!("put down in '{}'", place.place),
        Stage::Move(_) => stage.to_string(),
    }
}

fn outcome(index: usize, is_solved: bool, failed_at: Option<usize>) -> StageOutcome {
    match failed_at {
        _ if is_solved => StageOutcome::Done,
        None => StageOutcome::Unknown,
        Some(at) if index < at => StageOutcome::Passed,
        Some(at) if index == at => StageOutcome::Failed,
        Some(_) => StageOutcome::NotReached,
    }
}

/// Returns the farthest stage at which an alternative failed. Without such a record only an invalid start or goal, and a target
/// without a reachable grasp, are known to end the search at its first stage.
fn farthest(plan: &PlanFile, failed: &BTreeMap<usize, Vec<FailedAlternatives>>) -> Option<usize> {
    let is_at_start = matches!(
        plan.outcome,
        Outcome::StartInvalid | Outcome::GoalsInvalid | Outcome::NoReachableGrasp | Outcome::RegionOutOfReach
    );
    failed.keys().next_back().copied().or_else(|| is_at_start.then_some(0))
}

/// Returns the failed alternatives of each stage: the grasps of a task without a path, or those of earlier plans that failed in
/// simulation.
fn by_stage(plan: &PlanFile, first_pick: usize) -> BTreeMap<usize, Vec<FailedAlternatives>> {
    let mut known: BTreeMap<usize, BTreeMap<String, FailedAlternatives>> = BTreeMap::new();
    let mut add = |stage: usize, reason: String, because: String, grasp: Option<usize>| {
        let alternatives = known
            .entry(stage)
            .or_default()
            .entry(reason.clone())
            .or_insert_with(|| FailedAlternatives { reason, because, count: 0, grasps: Vec::new() });
        alternatives.count += 1;
        alternatives.grasps.extend(grasp);
    };
    for failure in &plan.failures {
        if let Some(stage) = stage_of(&failure.reason, &plan.task, first_pick) {
            let because = innermost(&failure.reason).sentence();
            add(stage, failure.reason.sentence(), because, Some(failure.grasp));
        }
    }
    if plan.failures.is_empty() {
        let (_, before) = plan.tries.split_last().unzip();
        for tried in before.unwrap_or_default() {
            let Some(left_out) = &tried.left_out else { continue };
            let reason = format!("an earlier plan failed in simulation (outcome: {})", tried.outcome);
            add(left_out.stage, reason.clone(), reason, None);
        }
    }
    let sorted = |by_reason: BTreeMap<String, FailedAlternatives>| {
        let mut all: Vec<FailedAlternatives> = by_reason.into_values().collect();
        for alternatives in &mut all {
            alternatives.grasps.sort_unstable();
        }
        all.sort_by_key(|alternatives| Reverse(alternatives.count));
        all
    };
    known.into_iter().map(|(stage, by_reason)| (stage, sorted(by_reason))).collect()
}

/// Reason of the stage that failed.
fn innermost(reason: &FailureReason) -> &FailureReason {
    match reason {
        FailureReason::Later { because, .. } => innermost(because),
        reason => reason,
    }
}

/// Returns the first stage at which the reason can occur after the pick of index `pick`; `None` for a grasp that was not tried.
fn stage_of(reason: &FailureReason, stages: &[Stage], pick: usize) -> Option<usize> {
    let after = |from: usize, is_it: fn(&Stage) -> bool| {
        (from + 1..stages.len()).find(|index| is_it(&stages[*index])).unwrap_or(from)
    };
    let place = after(pick, |stage| matches!(stage, Stage::Place(_)));
    let is_move = |stage: &Stage| matches!(stage, Stage::Move(_));
    match reason {
        FailureReason::NotTried => None,
        FailureReason::Later { stage, because } => {
            let stage = (*stage).min(stages.len() - 1);
            let of_pick = matches!(stages[stage], Stage::Pick(_)).then(|| stage_of(because, stages, stage));
            of_pick.flatten().or(Some(stage))
        }
        FailureReason::NotCarried
        | FailureReason::EndBlocked { .. }
        | FailureReason::EndOutOfBounds { .. } => Some(after(pick, |_| true)),
        FailureReason::NotMoved => Some(after(pick, is_move)),
        FailureReason::NoPlace
        | FailureReason::PlaceBlocked { .. }
        | FailureReason::PlaceOutOfReach
        | FailureReason::SetDownBlocked { .. }
        | FailureReason::SetDownOutOfReach
        | FailureReason::OpeningCollides { .. }
        | FailureReason::RetreatBlocked { .. }
        | FailureReason::RetreatOutOfReach
        | FailureReason::NotBroughtThere => Some(place),
        FailureReason::NotReturned => Some(after(place, is_move)),
        _ => Some(pick),
    }
}

/// Returns start and end of a stage on the path, in seconds; `None` if it has no segment there.
fn times(plan: &PlanFile, path: Option<&SampledPath>, stage: usize) -> [Option<f64>; 2] {
    let Some(path) = path else { return [None, None] };
    let edges_before = |of: &dyn Fn(usize) -> bool| -> usize {
        let segments = plan.segments.iter().take_while(|segment| of(segment.stage));
        segments.map(|segment| segment.waypoints.len().saturating_sub(1)).sum()
    };
    if plan.segments.iter().all(|segment| segment.stage != stage) {
        return [None, None];
    }
    [edges_before(&|of| of < stage), edges_before(&|of| of <= stage)]
        .map(|waypoint| path.waypoint_times_s.get(waypoint).copied())
}

fn clearance_m(plan: &PlanFile, stage: usize) -> Option<f64> {
    let segments = plan.segments.iter().filter(|segment| segment.stage == stage);
    segments.flat_map(|segment| &segment.clearances_m).flatten().copied().min_by(f64::total_cmp)
}

#[cfg(test)]
mod tests {
    use cranny_task::AfterPlacing;
    use cranny_task::PlaceAt;

    use super::*;

    fn later(stage: usize, because: FailureReason) -> FailureReason {
        FailureReason::Later { stage, because: Box::new(because) }
    }

    #[test]
    fn a_reason_belongs_to_the_first_stage_at_which_it_can_occur() {
        let one = Stage::put_down(PlaceAt::named("shelf"), AfterPlacing::Home);
        let stages = [one.clone(), one].concat();
        let first = "pad".to_owned();
        let blocked = FailureReason::PlaceBlocked { first: first.clone(), second: first };
        for (reason, expected) in [
            (FailureReason::NoIk, Some(0)),
            (FailureReason::Slips, Some(0)),
            (FailureReason::NotCarried, Some(1)),
            (blocked, Some(1)),
            (FailureReason::NotBroughtThere, Some(1)),
            (FailureReason::NotReturned, Some(2)),
            (later(3, FailureReason::NoIk), Some(3)),
            (later(3, FailureReason::NotBroughtThere), Some(4)),
            (later(3, FailureReason::NotReturned), Some(5)),
            (later(3, FailureReason::NotTried), Some(3)),
            (later(2, FailureReason::NotReturned), Some(2)),
            (FailureReason::NotTried, None),
        ] {
            assert_eq!(stage_of(&reason, &stages, 0), expected, "{reason:?}");
        }
    }

    #[test]
    fn a_stage_that_the_task_lacks_is_the_last_known_one() {
        let stages = [Stage::pick(), Stage::home()];
        assert_eq!(stage_of(&FailureReason::NoPlace, &stages, 0), Some(0));
        assert_eq!(stage_of(&FailureReason::NotReturned, &stages, 0), Some(1));
        assert_eq!(stage_of(&later(9, FailureReason::NoIk), &stages, 0), Some(1));
    }
}
