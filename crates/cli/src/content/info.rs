use std::fmt::Write;

use cranny_file::counted;
use cranny_scenario::CloudCounts;
use cranny_task::NotChecked;
use serde::Serialize;

use crate::arguments::{Output, TaskArguments};
use crate::failure::Failure;
use crate::planning::task::{Demand, Task};
use crate::{Answer, start, text};

#[derive(Serialize)]
struct Info {
    scenario: String,
    robot: String,
    joints: Vec<String>,
    tip: String,
    start: Vec<f64>,
    start_is_free: bool,
    start_clearance_m: Option<f64>,
    start_faults: Vec<String>,
    bodies: Vec<Body>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    clouds: Vec<CloudCounts>,
    target: Option<String>,
    places: Vec<String>,
    regions: Vec<String>,
    tasks: Vec<String>,
    grasps: usize,
    scored_grasps: usize,
    known_ik_solutions: usize,
    self_collision_pairs: usize,
    not_checked: Vec<NotChecked>,
}

#[derive(Serialize)]
struct Body {
    name: String,
    parts: usize,
}

pub fn run(arguments: &TaskArguments, output: Output) -> Result<Answer, Failure> {
    let Task { scenario, problem, .. } = Task::open(arguments, Demand::default(), output)?;
    let (robot, world) = (&scenario.robot, &scenario.world);
    let mut info = Info {
        scenario: scenario.id.clone(),
        robot: robot.name().to_owned(),
        joints: robot.joint_names().to_vec(),
        tip: robot.links()[robot.tip()].name.clone(),
        start: scenario.start.clone(),
        start_is_free: problem.start_is_free(),
        start_clearance_m: None,
        start_faults: start::faults(&problem),
        bodies: world
            .bodies()
            .iter()
            .map(|body| Body { name: body.name.clone(), parts: body.parts.len() })
            .collect(),
        clouds: scenario.clouds.clone(),
        target: scenario.target.map(|target| world.bodies()[target].name.clone()),
        places: scenario.places.iter().map(|place| place.name.clone()).collect(),
        regions: scenario.regions.keys().cloned().collect(),
        tasks: scenario.tasks.iter().map(|task| task.name.clone()).collect(),
        grasps: scenario.grasps.len(),
        scored_grasps: scenario.grasps.grasps().iter().filter(|g| g.score.is_some()).count(),
        known_ik_solutions: scenario.ik.len(),
        self_collision_pairs: 0,
        not_checked: problem.not_checked(),
    };
    if let Some(cell) = problem.cell() {
        let mut scratch = cell.scratch();
        let clearance_m = cell.clearance(&scenario.start, &mut scratch);
        info.start_clearance_m = Some(clearance_m).filter(|c| c.is_finite());
        info.self_collision_pairs = cell.self_pairs().len();
    }
    text::answer(&info, || page(&info), output.aloud())?;
    Ok(Answer::Done)
}

fn page(info: &Info) -> String {
    let mut page = String::new();
    let mut line = |name: &str, value: String| {
        let _ = writeln!(page, "  {name:<12}{value}");
    };
    line("scenario", info.scenario.clone());
    line("robot", format!("{} ({}, tip {})", info.robot, counted(info.joints.len(), "joint"), info.tip));
    for (index, body) in info.bodies.iter().enumerate() {
        let name = if index == 0 { "bodies" } else { "" };
        let role = if info.target.as_ref() == Some(&body.name) { "  (target)" } else { "" };
        line(name, format!("{} ({}){role}", body.name, counted(body.parts, "part")));
    }
    for CloudCounts { body, file, points, not_finite, thinned, kept } in &info.clouds {
        line(
            "cloud",
            format!(
                "{body}: {kept} of {points} points of {file} ({not_finite} not finite, {thinned} in the voxel of another)"
            ),
        );
    }
    for (index, place) in info.places.iter().enumerate() {
        line(if index == 0 { "places" } else { "" }, place.clone());
    }
    for (index, region) in info.regions.iter().enumerate() {
        line(if index == 0 { "regions" } else { "" }, region.clone());
    }
    for (index, task) in info.tasks.iter().enumerate() {
        line(if index == 0 { "tasks" } else { "" }, task.clone());
    }
    line("grasps", format!("{} ({} scored)", info.grasps, info.scored_grasps));
    line("known IK", counted(info.known_ik_solutions, "configuration"));
    if info.self_collision_pairs > 0 {
        line("self pairs", format!("{} of links checked", counted(info.self_collision_pairs, "pair")));
    }
    for (_, pairs) in text::not_checked(&info.not_checked) {
        line("not checked", pairs);
    }
    let clearance =
        info.start_clearance_m.map_or_else(String::new, |c| format!(", {}", text::millimetres(c)));
    let state = if info.start_is_free { "free" } else { "NOT free" };
    line("start", format!("{state}{clearance}"));
    for fault in &info.start_faults {
        line("", fault.clone());
    }
    page
}
