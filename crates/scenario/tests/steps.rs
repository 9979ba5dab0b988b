//! Tasks of several steps.

use cranny_plan::{AfterPlacing, AuditSettings, Outcome, PlanError, Unobserved};
use cranny_scenario::{
    GivenGrasps, OpenOptions, PlanSource, Scenario, ScenarioError, SequenceJudgement, SequencePlan, Step,
    StepDemand, TargetPhysics, sequences,
};
use cranny_solve::{PoseRadius, Request, Timing};

fn solved(id: &str) -> (Scenario, SequencePlan) {
    solved_with(id, StepDemand::default())
}

fn solved_with(id: &str, demand: StepDemand) -> (Scenario, SequencePlan) {
    let scenario = Scenario::open(id, &OpenOptions::default()).unwrap();
    let source = source(id);
    let request = Request { timing: Some(Timing::default()), ..Request::default() };
    let (plans, is_solved) =
        SequencePlan::solve(&scenario, (&source, demand), &request, &mut Unobserved).unwrap();
    assert!(is_solved, "{id}");
    (scenario, plans)
}

fn source(id: &str) -> PlanSource {
    PlanSource { scenario: id.to_owned(), ..PlanSource::default() }
}

fn judged(scenario: &Scenario, plans: &SequencePlan) -> Result<SequenceJudgement, ScenarioError> {
    let task = (scenario, &source(&scenario.id));
    plans.judge(task, SequencePlan::own_problem, AuditSettings::default())
}

#[test]
fn what_stands_in_the_way_is_put_aside_and_then_the_object() {
    for entry in sequences() {
        let (scenario, plans) = solved(entry.id);
        let outcomes: Vec<Outcome> = plans.steps.iter().map(|plan| plan.outcome).collect();
        assert_eq!(outcomes, vec![Outcome::Solved; scenario.steps.len()], "{}", entry.id);
        assert!(plans.duration_s.unwrap() > 10.0);
        let judgement = judged(&scenario, &plans).unwrap();
        assert!(judgement.valid, "{}", entry.id);
        // Each begins where the one before ends.
        for pair in plans.steps.windows(2) {
            assert_eq!(pair[0].waypoints.last(), pair[1].waypoints.first());
        }
    }
}

#[test]
fn a_file_of_several_steps_is_read_and_judged_and_lies_are_seen() {
    let (scenario, plans) = solved("213");
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("213.plan.json");
    plans.write(&file).unwrap();
    let read = SequencePlan::read(&file).unwrap().unwrap();
    assert_eq!(read, plans);
    let valid = |plans: &SequencePlan| -> Result<bool, ScenarioError> { Ok(judged(&scenario, plans)?.valid) };
    assert!(valid(&plans).unwrap());
    // The screwdriver alone, or before what stands in the way; the order is given, and columns are no screwdrivers.
    let short = SequencePlan { steps: plans.steps[..2].to_vec(), ..plans.clone() };
    assert!(!valid(&short).unwrap());
    let mut swapped = plans.clone();
    swapped.steps.swap(0, 1);
    assert!(matches!(valid(&swapped), Err(ScenarioError::Plan(PlanError::Place { .. }))));
    // Who planned for an obstacle, for which nobody has grasps, had those of the target all the same.
    let mut without = plans.clone();
    without.steps[0].grasps = Some("none".to_owned());
    assert_eq!(without.given_grasps(), GivenGrasps::Own);
    without.steps.iter_mut().for_each(|plan| plan.grasps = Some("none".to_owned()));
    assert_eq!(without.given_grasps(), GivenGrasps::None);
    // A step too many, or a scenario that has none.
    let mut long = plans.clone();
    long.steps.push(plans.steps[2].clone());
    assert!(!valid(&long).unwrap());
    let other = Scenario::open("021", &OpenOptions::default()).unwrap();
    let elsewhere = judged(&other, &plans).unwrap();
    assert!(elsewhere.steps.is_empty() && !elsewhere.valid);
    // Another place than the step says.
    let mut elsewhere = plans.clone();
    elsewhere.steps[0].place.as_mut().unwrap().name = "outside".to_owned();
    assert!(matches!(valid(&elsewhere), Err(ScenarioError::Plan(PlanError::Place { .. }))));
    // A hand that stays nearer than a step asks.
    let mut near = plans.clone();
    near.steps[0].place.as_mut().unwrap().clear_m = 0.001;
    assert!(matches!(valid(&near), Err(ScenarioError::Plan(PlanError::Place { .. }))));
    // Margins of later steps count, and so does the time of all.
    let mut wide = plans.clone();
    wide.steps[2].margins.margin_m = 0.02;
    let judgement = judged(&scenario, &wide).unwrap();
    assert!(!judgement.valid && judgement.steps.len() == 3 && judgement.steps[1].audit.valid);
    let faster = SequencePlan { duration_s: Some(1.0), ..plans.clone() };
    let judgement = judged(&scenario, &faster).unwrap();
    let lie = "duration_s: the file states 1.00 s,";
    assert!(!judgement.valid && judgement.violations[0].to_string().starts_with(lie));
    // Whatever else differs without being of another task, and what its steps state.
    let mut modest = faster.clone();
    modest.steps[0].clearance_m = Some(0.0);
    modest.steps[1].grasps = Some("none".to_owned());
    modest.steps[2].grasps = Some("gone.csv".to_owned());
    let judgement = judged(&scenario, &modest).unwrap();
    assert!(!judgement.valid && judgement.violations[0].to_string().starts_with(lie));
    let differs =
        judgement.steps.iter().flat_map(|step| step.differs.iter().map(|statement| &*statement.key));
    assert_eq!(differs.collect::<Vec<_>>(), ["clearance_m", "grasps"]);
    modest.steps[1].grasps = Some("gone.csv".to_owned());
    assert_eq!(judged(&scenario, &modest).unwrap().steps[1].differs[0].key, "grasps");
    // A robot, a criterion or a scenario that only one step names.
    for (key, step) in [("robot", 1), ("criterion", 2), ("scenario", 0), ("geometry", 2)] {
        let mut other = serde_json::to_value(&plans).unwrap();
        let value = if key == "criterion" { "paper" } else { "scene" };
        other["steps"][step][key] = value.into();
        std::fs::write(&file, other.to_string()).unwrap();
        let fault = SequencePlan::read(&file).unwrap_err().to_string();
        assert!(
            fault.contains(&format!("step {} states '{value}' as its {key}", step + 1)) || step == 0,
            "{fault}"
        );
    }
    // Another file is none of these, and half a one is a fault.
    plans.steps[0].write(&file).unwrap();
    assert_eq!(SequencePlan::read(&file).unwrap(), None);
    std::fs::write(&file, r#"{"format": "cranny-sequence/1", "steps": 3}"#).unwrap();
    assert!(SequencePlan::read(&file).unwrap_err().to_string().contains("213.plan.json"));
}

#[test]
fn an_error_that_is_to_be_forgiven_is_demanded_of_every_step() {
    let radius = PoseRadius { translation_m: 0.0005, rotation_rad: 0.001 };
    let (scenario, plans) = solved_with("235", StepDemand { robust: Some(radius), all_pairs: true });
    assert!(plans.steps.iter().all(|plan| plan.margins.object_margin_m > radius.translation_m));
    let judgement = judged(&scenario, &plans).unwrap();
    let mut exceptions = judgement.steps.iter().flat_map(|step| &step.measured.not_checked);
    assert!(judgement.valid && exceptions.all(|pair| pair.contact.is_some() || !pair.is_exception()));
}

#[test]
fn what_a_step_picks_becomes_the_target() {
    let scenario = Scenario::open("213", &OpenOptions::default()).unwrap();
    let step = |pick: &str| Step {
        pick: pick.to_owned(),
        place: "outside".to_owned(),
        then: AfterPlacing::Stay,
        physics: TargetPhysics::default(),
    };
    let own = scenario.at_step(&step("screwdriver")).unwrap();
    assert!(own.has_grasp_set && own.target == scenario.target);
    let column = scenario.at_step(&step("column 1")).unwrap();
    assert!(!column.has_grasp_set && column.grasps.is_empty());
    assert_eq!(column.world.bodies()[column.target.unwrap()].name, "column 1");
    assert!(scenario.at_step(&step("vase")).unwrap_err().to_string().contains("vase"));
}
