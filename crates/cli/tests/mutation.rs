//! Mutations of every key of the four formats: a plan, a scenario, the files of a robot, a campaign.
//!
//! A file with a key renamed, removed, added or changed in value is refused, or is read with a difference that its reader
//! shows, or is unchanged because its key is exempt for the reason given here.

use std::fs;
use std::path::{Path, PathBuf};

use cranny_bench::Campaign;
use cranny_path::AuditSettings;
use cranny_plan::{Registry, Unobserved};
use cranny_record::{PlanFile, PlanSource};
use cranny_robot::{Robot, RobotDescription, RobotOptions};
use cranny_scenario::{OpenOptions, STEPS, Scenario};
use cranny_solve::{Request, Timing, solve};
use cranny_spatial::Stream;
use cranny_task::{CLEAR_M, Move, Stage};
use serde_json::{Value, json};

/// Function that reads a text and returns a description, `None` if it is refused.
type Read<'a> = Box<dyn Fn(&str) -> Option<String> + 'a>;

/// File of one of the formats, and its reader: a description, or `None` if it is refused.
struct Format<'a> {
    name: &'a str,
    whole: Value,
    /// First keys of values without an effect, each with the reason.
    exempt: &'a [(&'a str, &'a str)],
    read: Read<'a>,
}

/// Number of changes by their effect.
#[derive(Default)]
struct Counts {
    refused: usize,
    shown: usize,
    exempt: usize,
}

impl Format<'_> {
    /// Reads every change, or `most` sampled ones unless the run is long.
    fn check(&self, most: usize) -> Vec<String> {
        let text = self.whole.to_string();
        let base = (self.read)(&text).unwrap_or_else(|| panic!("{}: the file itself is refused", self.name));
        assert_eq!((self.read)(&text).as_deref(), Some(&*base), "{}: it is read alike twice", self.name);
        let mut changes = changes(&self.whole);
        let all = changes.len();
        if std::env::var_os("CRANNY_LONG").is_none() {
            // Way points are compared with those of the segments, and would make up nearly all changes of a plan.
            changes.retain(|(_, key, _)| !key.contains("waypoints["));
            let mut stream = Stream::new(48, 0);
            while changes.len() > most {
                changes.swap_remove(stream.index(changes.len()));
            }
        }
        let (mut counts, mut silent) = (Counts::default(), Vec::new());
        for (what, key, text) in &changes {
            match (self.read)(text) {
                None => counts.refused += 1,
                Some(found) if found != base => counts.shown += 1,
                Some(_) if self.is_exempt(key) => counts.exempt += 1,
                Some(_) => silent.push(format!("{}: {what} of {key}", self.name)),
            }
        }
        let Counts { refused, shown, exempt } = counts;
        let name = self.name;
        println!(
            "{name}: {} of {all} changes: {refused} refused, {shown} shown, {exempt} exempt, silent: {silent:?}",
            changes.len(),
        );
        silent
    }

    fn is_exempt(&self, key: &str) -> bool {
        self.exempt.iter().any(|(first, _)| key.trim_start_matches('.').starts_with(first))
    }
}

/// Placeholder for a value that is not a number until the document is text: JSON cannot represent it, YAML writes it so.
const NOT_A_NUMBER: &str = "<not a number>";

/// Returns every change of a document: its description, the key, and the text.
fn changes(whole: &Value) -> Vec<(&'static str, String, String)> {
    let mut found = Vec::new();
    walk(whole, &mut Vec::new(), &mut |path, key, what, change| {
        let mut other = whole.clone();
        let place = path.iter().fold(&mut other, |place, step| match step {
            Step::Key(key) => &mut place[key.as_str()],
            Step::Index(index) => &mut place[*index],
        });
        change(place);
        if other != *whole {
            let text = other.to_string().replace(&format!("\"{NOT_A_NUMBER}\""), ".nan");
            found.push((what, name_of(path) + key, text));
        }
    });
    found
}

enum Step {
    Key(String),
    Index(usize),
}

fn name_of(path: &[Step]) -> String {
    let mut name = String::new();
    for step in path {
        match step {
            Step::Key(key) if name.is_empty() => name.push_str(key),
            Step::Key(key) => name.extend([".", key.as_str()]),
            Step::Index(index) => name.extend(["[", index.to_string().as_str(), "]"]),
        }
    }
    name
}

/// Callback for a change of the value at a path, with the key within it.
type Visit<'a> = dyn FnMut(&[Step], &str, &'static str, &dyn Fn(&mut Value)) + 'a;

fn walk(value: &Value, path: &mut Vec<Step>, visit: &mut Visit<'_>) {
    match value {
        Value::Object(entries) => {
            let add = |place: &mut Value| place["typo_m"] = 1.into();
            visit(path, ".typo_m", "an unknown key", &add);
            for (key, inner) in entries {
                let take = |place: &mut Value| place.as_object_mut().unwrap().remove(key).unwrap();
                let rename = |place: &mut Value| {
                    let value = take(place);
                    place[format!("{key}x")] = value;
                };
                let within = format!(".{key}");
                visit(path, &within, "another name", &rename);
                // A key without a value, with an empty list, or with its default is equivalent to a missing key.
                let defaults = [Value::Null, json!([]), json!("polyline"), json!(CLEAR_M)];
                let is_first_stage = key == "stage" && *inner == json!(0);
                if !defaults.contains(inner) && !is_first_stage {
                    visit(path, &within, "no such key", &|place| drop(take(place)));
                }
                path.push(Step::Key(key.clone()));
                walk(inner, path, visit);
                path.pop();
            }
        }
        Value::Array(list) => {
            visit(path, "", "an empty list", &|place| *place = json!([]));
            visit(path, "", "a shorter list", &|place| drop(place.as_array_mut().unwrap().pop()));
            for (index, inner) in list.iter().enumerate() {
                path.push(Step::Index(index));
                walk(inner, path, visit);
                path.pop();
            }
        }
        other => {
            let values = other_values(other).into_iter();
            for (what, value) in values.filter(|(_, value)| !(value.is_null() && *other == json!(CLEAR_M))) {
                visit(path, "", what, &|place| *place = value.clone());
            }
        }
    }
}

pub fn other_values(value: &Value) -> Vec<(&'static str, Value)> {
    match value {
        Value::Number(number) => {
            let x = number.as_f64().unwrap();
            let more = number.as_u64().map_or(json!(x + 1.0), |n| json!(n.wrapping_add(1)));
            vec![
                ("another sign", json!(-x)),
                ("a tenth more", json!(if x == 0.0 { 0.1 } else { 1.1 * x })),
                ("one more", more),
                ("no number", NOT_A_NUMBER.into()),
                ("nothing", Value::Null),
            ]
        }
        Value::Bool(yes) => vec![("the contrary", (!yes).into())],
        Value::String(_) => {
            vec![("another text", "zzz".into()), ("a number", 1.into()), ("nothing", Value::Null)]
        }
        _ => vec![("a text", "zzz".into()), ("a number", 1.into())],
    }
}

/// Keys of a plan that record the search: the verdict does not depend on them, and lists them as not compared.
const RECORD: [(&str, &str); 10] = [
    ("planner", "the name of what found the path"),
    ("settings", "those of the planner"),
    ("score", "which scores the planner preferred"),
    ("seed", "of the search"),
    ("version", "of the program that planned"),
    ("budget", "of the search"),
    ("statistics", "times and counts of the search"),
    ("shortening", "how the path was shortened"),
    ("optimisation", "how better paths were looked for"),
    ("failures", "grasps that the search gave up"),
];

/// Reader of plans as in `verify`: requirements of the file become those of the problem.
pub struct PlanReader {
    id: &'static str,
    file: PathBuf,
    pub scenario: Scenario,
    pub source: PlanSource,
}

impl PlanReader {
    pub fn new(id: &'static str, folder: &Path) -> Self {
        let scenario = Scenario::open(id, &OpenOptions::default()).unwrap();
        let source = PlanSource { scenario: id.to_owned(), ..PlanSource::default() };
        Self { id, file: folder.join(format!("{id}.plan.json")), scenario, source }
    }

    /// Plans a task, as that of the scenario if it has the same stages.
    pub fn plan(&self, stages: Vec<Stage>, rounds: bool) -> Value {
        let problem = self.scenario.problem(self.source.margins).unwrap();
        let timing = Some(Timing { stops: !rounds, ..Timing::default() });
        let request = Request { stages, timing, robustness: true, ..Request::default() };
        let answer = solve(&problem, &request, &mut Unobserved).unwrap();
        assert!(answer.is_solved());
        let task = self.scenario.tasks.iter().find(|task| task.stages == answer.stages).cloned();
        serde_json::to_value(PlanFile::of(&answer, &PlanSource { task, ..self.source.clone() })).unwrap()
    }

    fn opened(&self, plan: &PlanFile) -> Option<(Scenario, PlanSource)> {
        let options = OpenOptions {
            criterion: Some(plan.criterion),
            robot: plan.robot.clone().map(PathBuf::from),
            geometry: plan.given_geometry(),
            grasps: plan.given_grasps(),
        };
        let is_own = options == OpenOptions { criterion: options.criterion, ..OpenOptions::default() };
        let scenario = if is_own && plan.criterion == self.scenario.criterion {
            self.scenario.clone()
        } else {
            Scenario::open(self.id, &options).ok()?
        };
        let OpenOptions { robot, geometry, grasps, .. } = options;
        Some((scenario, PlanSource { robot, geometry, grasps, margins: plan.margins, ..self.source.clone() }))
    }

    /// Returns the verdict on a plan as text; `None` if it is refused.
    pub fn read(&self, text: &str) -> Option<String> {
        fs::write(&self.file, text).unwrap();
        let plan = PlanFile::read(&self.file).ok()?;
        let (scenario, task) = self.opened(&plan)?;
        let task = plan.source_in(&scenario, &task);
        plan.check_joints(&self.file, &scenario.robot).ok()?;
        plan.check_path(&self.file, scenario.robot.dof()).ok()?;
        let problem = scenario.problem(plan.margins).ok()?;
        let found = plan.judge(&task, &problem, AuditSettings::default()).ok()??;
        let brought = (problem.criterion(), &plan.robot, &plan.grasps, &plan.geometry);
        Some(serde_json::to_string(&(found, brought)).unwrap())
    }
}

#[test]
fn no_key_of_a_plan_is_changed_unseen() {
    let folder = tempfile::tempdir().unwrap();
    let mut silent = Vec::new();
    let mut check = |name, id, plan: &dyn Fn(&PlanReader) -> Value, most| {
        let reader = PlanReader::new(id, folder.path());
        let whole = plan(&reader);
        let read = Box::new(|text: &str| reader.read(text));
        silent.extend(Format { name, whole, exempt: &RECORD, read }.check(most));
    };
    let carry = |goal: Move| vec![Stage::pick(), Stage::Move(goal)];
    check("a reach", "021", &|reader| reader.plan(Vec::new(), false), 60);
    check("rounded corners", "021", &|reader| reader.plan(Vec::new(), true), 8);
    check("a carry", "035", &|reader| reader.plan(carry(Move::Home), true), 15);
    check("a carry out", "035", &|reader| reader.plan(carry(Move::Clear { clear_m: 0.05 }), false), 4);
    let place = vec![Stage::pick(), Stage::place("outside"), Stage::home()];
    check("a place", "012", &|reader| reader.plan(place.clone(), true), 8);
    let steps = |reader: &PlanReader| reader.plan(reader.scenario.task(STEPS).unwrap().stages.clone(), false);
    check("steps", "235", &steps, 4);
    assert!(silent.is_empty(), "{silent:#?}");
}

/// Formats the result of a reader, without a table of names whose order varies.
fn shown(thing: &impl std::fmt::Debug) -> String {
    let whole = format!("{thing:?}");
    match whole.split_once("links_by_name: {") {
        Some((before, after)) => before.to_owned() + after.split_once('}').map_or("", |(_, after)| after),
        None => whole,
    }
}

#[test]
fn no_key_of_a_scenario_is_changed_unseen() {
    let folder = tempfile::tempdir().unwrap();
    let own = folder.path().join("own");
    fs::create_dir(&own).unwrap();
    fs::write(own.join("cart.urdf"), CART).unwrap();
    fs::write(own.join("other.srdf"), SLIDE).unwrap();
    fs::write(own.join("part.obj"), tetrahedron()).unwrap();
    let pose = json!({"position": [0.1, 0.2, 0.3], "rotation_rpy_deg": [0.0, 0.0, 30.0]});
    let whole = json!({
        "robot": "cart.urdf", "srdf": "other.srdf", "group": "arm", "tip": "carriage",
        "about": {"title": "a", "author": "b", "licence": "MIT", "citation": "d"},
        "fixed": {"z": 0.1}, "unchecked_pairs": [["ball", "bridge"]], "frame": pose,
        "start": {"x": 0.1}, "floor": -1.5,
        "obstacles": [
            {"name": "wall", "pose": pose, "shapes": [
                {"pose": {"position": [0.0, 0.1, 0.0], "quaternion_xyzw": [0.0, 0.6, 0.0, 0.8]},
                 "box": {"size": [0.1, 0.2, 0.3]}},
                {"sphere": {"radius": 0.1}}, {"cylinder": {"radius": 0.1, "length": 0.2}},
                {"capsule": {"radius": 0.1, "length": 0.2}}, {"mesh": {"file": "part.obj", "scale": 0.5}},
                {"hull": {"file": "part.obj", "scale": 0.5}},
            ]},
            {"name": "post", "pose": pose, "shapes": [{"box": {"size": [0.1, 0.1, 0.1]}}]},
        ],
        "target": {"name": "ball to take", "pose": pose, "mass_kg": 0.2, "friction": 0.4,
                   "shapes": [{"sphere": {"radius": 0.02}}]},
        "places": [
            {"name": "there", "on": "wall", "pose": pose, "size": [0.1, 0.2]},
            {"name": "exactly", "target_pose": pose},
        ],
        "steps": [{"pick": "post", "place": "there", "then": "stay", "mass_kg": 0.3, "friction": 0.5}],
        "criterion": "exact",
    });
    let read = |text: &str| {
        fs::write(own.join("scenario.yaml"), text).unwrap();
        Scenario::open(own.to_str().unwrap(), &OpenOptions::default()).ok().map(|scenario| shown(&scenario))
    };
    let exempt = [("about", "who made it: no part of the task"), ("criterion", "exact is the default")];
    let silent = Format { name: "a scenario", whole, exempt: &exempt, read: Box::new(read) }.check(400);
    assert!(silent.is_empty(), "{silent:#?}");
}

#[test]
fn no_key_of_the_files_of_a_robot_is_changed_unseen() {
    let folder = tempfile::tempdir().unwrap();
    let robot = folder.path();
    fs::write(robot.join("cart.urdf"), CART).unwrap();
    fs::write(robot.join("cart.srdf"), SRDF).unwrap();
    let whole = json!({
        "urdf": "cart.urdf", "group": "arm", "tip": "ball", "fixed": {"z": 0.2}, "solid_meshes": ["ball"],
        "start": {"x": 0.1, "y": 0.2}, "floor_m": -0.5,
        "hand": {"name": "grip", "tip": "ball", "fingers": {"z": {"open": 0.2, "closed": 0.1}}, "opening_m": 0.08,
                 "finger_depth_m": 0.03, "closing_force_n": 20.0},
    });
    let limits = json!({"joints": {"x": {"lower": -0.5, "upper": 0.5, "velocity": 0.4, "acceleration": 2.0, "jerk": 9.0}}});
    let load = || Robot::load(robot, &RobotOptions::default()).ok();
    let read = |text: &str| {
        fs::write(robot.join("robot.yaml"), text).unwrap();
        fs::write(robot.join("limits.yaml"), limits.to_string()).unwrap();
        let description = RobotDescription::parse(text, "robot.yaml").ok()?;
        load().map(|_| shown(&description))
    };
    let mut silent =
        Format { name: "robot.yaml", whole: whole.clone(), exempt: &[], read: Box::new(read) }.check(400);
    let read = |text: &str| {
        fs::write(robot.join("robot.yaml"), whole.to_string()).unwrap();
        fs::write(robot.join("limits.yaml"), text).unwrap();
        load().map(|robot| shown(&robot.limits()))
    };
    silent.extend(
        Format { name: "limits.yaml", whole: limits.clone(), exempt: &[], read: Box::new(read) }.check(400),
    );
    assert!(silent.is_empty(), "{silent:#?}");
}

#[test]
fn no_key_of_a_campaign_is_changed_unseen() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(
        folder.path().join("planner.sh"),
        "exit 0
",
    )
    .unwrap();
    let file = folder.path().join("campaign.yaml");
    let of = |planners: Value, more: Value| {
        let mut whole = json!({
            "scenarios": ["01x", "045"], "planners": planners, "runs": 20,
            "first_seed": 100, "time_limit_s": 30.5, "iteration_limit": 100_000, "memory_limit_mb": 512,
            "exceptions": [{"scenario": "045", "planner": "reach", "time_limit_s": 900.0}],
        });
        whole.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
        whole
    };
    let read = |text: &str| {
        fs::write(&file, text).unwrap();
        Campaign::read(&file, &Registry::default()).ok().map(|campaign| shown(&campaign))
    };
    let planners = json!([
        {"planner": "reach", "score": "physics"},
        {"name": "each", "planner": "ik-rrt", "settings": {"p_goal": 0.05}, "each_goal": true, "runs": 5, "time_limit_s": 5.0},
        {"exec": ["sh", "planner.sh", "{seed}"]},
    ]);
    let own = json!([{"planner": "reach"}, {"planner": "grasp-reach", "name": "other"}]);
    let demand = json!({"carry": "home", "margin_m": 0.002, "grasp_margin_m": 0.001,
                        "robust_m": 0.001, "robust_rad": 0.01, "measure_clearance": false});
    let mut silent = Vec::new();
    for (name, whole) in [
        (
            "a campaign",
            of(
                planners,
                json!({"criteria": ["exact", "paper"], "judge_both": true, "measure_clearance": false}),
            ),
        ),
        ("a campaign of carrying", of(own, demand)),
    ] {
        silent.extend(Format { name, whole, exempt: &[], read: Box::new(read) }.check(400));
    }
    assert!(silent.is_empty(), "{silent:#?}");
}

/// URDF of a ball on slides.
const CART: &str = r#"<robot name="cart">
  <link name="rail"/><link name="bridge"><collision><geometry><sphere radius="0.05"/></geometry></collision></link>
  <link name="carriage"/>
  <link name="ball"><collision><geometry><sphere radius="0.05"/></geometry></collision></link>
  <joint name="x" type="prismatic"><parent link="rail"/><child link="bridge"/><axis xyz="1 0 0"/>
    <limit lower="-1" upper="1" velocity="1" effort="1"/></joint>
  <joint name="y" type="prismatic"><parent link="bridge"/><child link="carriage"/><axis xyz="0 1 0"/>
    <limit lower="-1" upper="1" velocity="1" effort="1"/></joint>
  <joint name="z" type="prismatic"><parent link="carriage"/><child link="ball"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" velocity="1" effort="1"/></joint>
</robot>"#;

/// Group of a single slide, in a file that is not found beside the URDF; a reader must name it explicitly.
const SLIDE: &str = r#"<robot name="cart"><group name="arm"><joint name="x"/></group></robot>"#;

const SRDF: &str =
    r#"<robot name="cart"><group name="arm"><joint name="x"/><joint name="y"/></group></robot>"#;

fn tetrahedron() -> &'static str {
    "v 0 0 0
v 0.2 0 0
v 0 0.2 0
v 0 0 0.2
f 1 3 2
f 1 2 4
f 1 4 3
f 2 3 4
"
}
