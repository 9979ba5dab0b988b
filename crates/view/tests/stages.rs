//! Tests of the stages of a task on the page.

use cranny_collision::Margins;
use cranny_plan::{Outcome, Unobserved};
use cranny_record::{LeftOut, PlanAttempt, PlanFile, PlanSource};
use cranny_scenario::{OpenOptions, Scenario};
use cranny_solve::{Request, Timing, solve};
use cranny_spatial::Pose;
use cranny_task::{FailureReason, GraspFailure, Stage};
use cranny_view::{PagePlan, PageTask, StageOutcome};

/// Returns the plan of a task and its stages on the page.
fn planned(id: &str, stages: Vec<Stage>, hold: Option<f64>) -> (Scenario, PlanFile) {
    let scenario = Scenario::open(id, &OpenOptions::default()).unwrap();
    let problem = scenario.problem(Margins::default()).unwrap();
    let request = Request { stages, hold, timing: Some(Timing::default()), ..Request::default() };
    let answer = solve(&problem, &request, &mut Unobserved).unwrap();
    let source = PlanSource { scenario: id.to_owned(), ..PlanSource::default() };
    (scenario, PlanFile::of(&answer, &source))
}

fn page_task(scenario: &Scenario, plan: &PlanFile) -> (PageTask, f64) {
    let timed = plan.trajectory(&scenario.robot).unwrap();
    let page = PagePlan::of_file("p", plan, &scenario.robot, timed.as_ref(), None, Vec::new()).unwrap();
    (page.task.expect("a list of stages"), page.path.map_or(0.0, |path| path.ends_s()))
}

fn outcomes(task: &PageTask) -> Vec<StageOutcome> {
    task.stages.iter().map(|stage| stage.outcome).collect()
}

#[test]
fn the_stages_of_a_path_follow_each_other_without_a_gap() {
    let stages = vec![Stage::pick(), Stage::place("outside"), Stage::home()];
    let (scenario, plan) = planned("031", stages, None);
    let (task, ends_s) = page_task(&scenario, &plan);
    assert_eq!(outcomes(&task), [StageOutcome::Done; 3]);
    assert_eq!((task.failed_at, task.tried, task.not_tried), (None, None, None));
    let kinds: Vec<&str> = task.stages.iter().map(|stage| stage.kind).collect();
    assert_eq!(kinds, ["pick", "place", "move"]);
    assert_eq!(task.stages[0].from_s, Some(0.0));
    for pair in task.stages.windows(2) {
        assert_eq!(pair[0].until_s.map(f64::to_bits), pair[1].from_s.map(f64::to_bits));
        assert!(pair[1].from_s > pair[0].from_s);
    }
    let last_s = task.stages[2].until_s.expect("a time");
    assert!((last_s - ends_s).abs() < 1e-9, "{last_s} s, but the path ends at {ends_s} s");
    assert_eq!((task.stages[0].grasp, task.stages[1].grasp), (plan.grasp, None));
    let least = task.stages.iter().filter_map(|stage| stage.clearance_m).fold(f64::INFINITY, f64::min);
    assert_eq!(Some(least.to_bits()), plan.clearance_m.map(f64::to_bits));
    assert!(task.stages.iter().all(|stage| stage.failed.is_empty() && stage.left.is_none()));
}

#[test]
fn a_task_without_a_path_names_the_stage_at_which_each_grasp_failed() {
    // No grasp holds the box under nine times its weight.
    let stages = vec![Stage::pick(), Stage::place("outside"), Stage::home()];
    let (scenario, mut plan) = planned("035", stages, Some(9.0));
    let (task, _) = page_task(&scenario, &plan);
    let grasps = plan.failures.len();
    assert_eq!((plan.outcome, task.failed_at), (Outcome::NoReachableGrasp, Some(0)));
    assert_eq!((task.tried, task.not_tried), (Some(grasps), Some(0)));
    assert_eq!(outcomes(&task), [StageOutcome::Failed, StageOutcome::NotReached, StageOutcome::NotReached]);
    let counts = GraspFailure::counted(&plan.failures);
    let of_page: Vec<(String, usize)> =
        task.stages[0].failed.iter().map(|failed| (failed.reason.clone(), failed.count)).collect();
    assert_eq!(of_page, counts);
    assert_eq!(task.stages[0].left, Some(0));

    // Each grasp counts at the stage at which it failed, and what is left decreases by it.
    let later = FailureReason::Later { stage: 2, because: Box::new(FailureReason::NotReturned) };
    for (grasp, reason) in
        [(0, FailureReason::NotTried), (1, FailureReason::NotBroughtThere), (2, later.clone()), (3, later)]
    {
        plan.failures[grasp].reason = reason;
    }
    plan.outcome = Outcome::BudgetExhausted;
    let (task, _) = page_task(&scenario, &plan);
    assert_eq!((task.failed_at, task.tried, task.not_tried), (Some(2), Some(grasps - 1), Some(1)));
    assert_eq!(outcomes(&task), [StageOutcome::Passed, StageOutcome::Passed, StageOutcome::Failed]);
    let left: Vec<Option<usize>> = task.stages.iter().map(|stage| stage.left).collect();
    assert_eq!(left, [Some(3), Some(2), Some(0)]);
    assert_eq!(task.stages[1].failed[0].grasps, [1]);
    let last = &task.stages[2].failed[0];
    assert_eq!((&last.grasps[..], last.count), (&[2, 3][..], 2));
    assert_eq!(last.because, FailureReason::NotReturned.sentence());
    assert!(last.reason.contains("the later stage 3 failed"), "{}", last.reason);
}

#[test]
fn what_the_file_does_not_state_is_not_known() {
    let (scenario, mut plan) = planned("035", vec![Stage::pick(), Stage::home()], Some(9.0));
    plan.failures.clear();
    plan.outcome = Outcome::BudgetExhausted;
    let (task, _) = page_task(&scenario, &plan);
    assert_eq!((task.failed_at, task.tried), (None, None));
    assert_eq!(outcomes(&task), [StageOutcome::Unknown; 2]);
    plan.outcome = Outcome::StartInvalid;
    assert_eq!(page_task(&scenario, &plan).0.failed_at, Some(0));
    plan.task.clear();
    let page = PagePlan::of_file("p", &plan, &scenario.robot, None, None, Vec::new()).unwrap();
    assert_eq!(page.task, None);
}

#[test]
fn plans_that_failed_in_simulation_count_at_the_stage_of_their_grasp() {
    let (scenario, mut plan) = planned("031", vec![Stage::pick(), Stage::home()], None);
    let attempt = |left_out: Option<LeftOut>, outcome: &str| PlanAttempt {
        seed: 0,
        outcome: outcome.to_owned(),
        kept: left_out.is_none(),
        as_planned: left_out.is_none(),
        left_out,
    };
    let grasp = || Some(LeftOut::new(0, &Pose::identity()));
    plan.tries = vec![attempt(grasp(), "slipped"), attempt(grasp(), "slipped"), attempt(None, "held")];
    let (task, _) = page_task(&scenario, &plan);
    let [failed] = &task.stages[0].failed[..] else { panic!("one reason") };
    assert_eq!((failed.count, failed.grasps.len()), (2, 0));
    assert!(failed.reason.contains("slipped"), "{}", failed.reason);
}
