use std::path::{Path, PathBuf};
use std::time::Duration;

use cranny_collision::Margins;
use cranny_grasp::ScoreKind;
use cranny_path::{AuditSettings, Clearances, path_length};
use cranny_plan::{Budget, NoGrasp, Outcome, RefusedClaim, Statistics};
use cranny_scenario::{Geometry, GivenGrasps, NamedTask, ScenarioError, write_whole_file};
use cranny_solve::{Answer, HoldFactors, Paces, Request, Robustness, Tilt, Timing, ToolSlack};
use cranny_task::{Criterion, FoundGrasp, GraspFailure, NotChecked, Segment, Stage};
use serde::{Deserialize, Serialize};

use crate::betterment::{PlanOptimisation, PlanShortening};
use crate::timing::PlanTiming;
use crate::{LeftOut, PlanAttempt, PlanPick, RecordError};

/// Contents of a `*.plan.json`: an answer, with all data needed to audit it and to reproduce it.
///
/// Every number is read back bit by bit. Values that were not measured or do not exist (a clearance where nothing is near, a
/// proof under the `paper` criterion) are `None`, never a made-up number.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlanFile {
    /// [`PlanFile::FORMAT`].
    pub format: String,
    /// Id of the scenario: a built-in id, or the name of its folder.
    pub scenario: String,
    /// Name of the task, if it is one of those of the scenario.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub task_name: Option<String>,
    /// Stages of the task; empty if the task is the goal of the scenario alone.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub task: Vec<Stage>,
    /// URDF that replaces the scenario's robot, if given.
    pub robot: Option<String>,
    /// Geometry of a released scenario, if requested.
    pub geometry: Option<String>,
    /// File of grasps that replaces the scenario's own, if given; `none` for no set of grasps.
    #[serde(default)]
    pub grasps: Option<String>,
    /// Name of the planner.
    pub planner: String,
    /// Settings of the planner.
    pub settings: serde_json::Value,
    /// Criterion by which the problem counts as solved.
    pub criterion: Criterion,
    /// Score of the grasps that was used.
    #[serde(default)]
    pub score: ScoreKind,
    /// Least score of the goal grasps, if requested.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub min_score: Option<f64>,
    /// Number of grasps excluded by `min_score`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub below_min_score: Option<usize>,
    /// Under `paper`: the value of `½·mm + ½·deg` below which the gripper has arrived.
    pub goal_threshold: Option<f64>,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Version of Cranny: with the same version the seed gives the same path.
    pub version: String,
    /// Outcome of the search.
    pub outcome: Outcome,
    /// Required clearance.
    pub margins: Margins,
    /// Budget of the search.
    pub budget: PlanBudget,
    /// Names of the joints, in the order of every way point.
    pub joint_names: Vec<String>,
    /// Index of the grasp at the end of the path, or of the first pick.
    pub grasp: Option<usize>,
    /// Distance of the gripper from this grasp at the end, in metres.
    pub translation_error_m: Option<f64>,
    /// Angle between gripper and grasp at the end, in radians.
    pub rotation_error_rad: Option<f64>,
    /// Grasp at the end of the path that the planner generated, if no set was given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub own_grasp: Option<FoundGrasp>,
    /// Grasps of the picks that follow the first.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub picks: Vec<PlanPick>,
    /// Proven lower bound of the clearance along the whole path, in metres.
    pub clearance_m: Option<f64>,
    /// Proven lower bound of the clearance of each edge, in metres; `None` if nothing is near, empty without a proof.
    pub clearances_per_edge_m: Vec<Option<f64>>,
    /// Pairs that touch and were not compared: the path is proven except for these.
    #[serde(default)]
    pub not_checked: Vec<NotChecked>,
    /// Length of the path in the plain norm of `q` (m and rad alike).
    pub path_length: f64,
    /// Proven lower bound of the length of every path of the task; `None` if not requested or unknown.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub least_length: Option<f64>,
    /// Path in segments: `waypoints` and `clearances_per_edge_m` are those of all segments.
    #[serde(default)]
    pub segments: Vec<Segment>,
    /// Way points of the path: one value per joint each (m, rad), straight lines between.
    pub waypoints: Vec<Vec<f64>>,
    /// Timing of the path; `None` for a robot without limits of acceleration.
    #[serde(default)]
    pub timing: Option<PlanTiming>,
    /// Statistics of the search; of the first one, if others followed to improve its path.
    pub statistics: Statistics,
    /// Shortening of the path; `None` if there was none, or the file is older than this key.
    #[serde(default)]
    pub shortening: Option<PlanShortening>,
    /// Optimisation of the path after the first search; `None` if there was none.
    #[serde(default)]
    pub optimisation: Option<PlanOptimisation>,
    /// Reason for the failure of each grasp, from a planner that records them; empty if solved.
    #[serde(default)]
    pub failures: Vec<GraspFailure>,
    /// Reasons why each goal configuration was refused, in sentences, if all of them were.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub goal_faults: Vec<Vec<String>>,
    /// Reason why no grasp was reached, after a search in which the arm reached none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub no_grasp: Option<NoGrasp>,
    /// Path that the planner claimed and the proof refused, if that is the outcome.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub refused: Option<RefusedClaim>,
    /// Tolerated deviations from the path, for each kind of error by itself; `None` if not requested, or without a proof.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub robustness: Option<Robustness>,
    /// Proven tilt of the held object along the whole motion; `None` if it is not limited.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tilt: Option<Tilt>,
    /// Proven distance of the tool within each of its bounds along the whole motion.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub tool: Vec<ToolSlack>,
    /// Required factor by which loads may grow before the object in the hand slips; `None` if nothing was required.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub hold_demanded: Option<f64>,
    /// Measured factor of the hold; `None` if nothing is carried, or it cannot be computed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub hold: Option<HoldFactors>,
    /// Plans that were tried in simulation, this one last; empty if none was.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub tries: Vec<PlanAttempt>,
}

/// Source of a plan: the data that an [`Answer`] does not have.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PlanSource {
    /// Id of the scenario.
    pub scenario: String,
    /// URDF that replaces the scenario's robot, if given.
    pub robot: Option<PathBuf>,
    /// Geometry of a released scenario, if requested.
    pub geometry: Option<Geometry>,
    /// Source of the grasps.
    pub grasps: GivenGrasps,
    /// Required clearance.
    pub margins: Margins,
    /// Task of the scenario that was planned, if it has a name.
    pub task: Option<NamedTask>,
}

/// Budget of a search.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlanBudget {
    /// Iteration limit; `None`: no limit.
    pub iterations: Option<u64>,
    /// Limit of wall-clock time, in seconds; `None`: no limit.
    pub time_limit_s: Option<f64>,
}

impl PlanBudget {
    fn of(budget: &Budget) -> Self {
        Self {
            iterations: (budget.iterations < u64::MAX).then_some(budget.iterations),
            time_limit_s: (budget.time < Duration::MAX).then_some(budget.time.as_secs_f64()),
        }
    }
}

impl PlanFile {
    /// Format that this program writes.
    pub const FORMAT: &'static str = "cranny-plan/2";

    /// Version that this program writes into its plans.
    pub const VERSION: &'static str = env!("CARGO_PKG_VERSION");

    /// Creates the contents of a plan file from an answer.
    pub fn of(answer: &Answer, source: &PlanSource) -> Self {
        let goal = answer.audit.as_ref().and_then(|audit| audit.goal);
        let waypoints: Vec<Vec<f64>> = answer.waypoints();
        let clearances_m: Vec<Option<f64>> =
            answer.segments.iter().flat_map(|segment| segment.clearances_m.iter().copied()).collect();
        Self {
            format: Self::FORMAT.to_owned(),
            scenario: source.scenario.clone(),
            task_name: source.task.as_ref().map(|task| task.name.clone()),
            task: answer.stages.clone(),
            robot: source.robot.as_ref().map(|file| file.display().to_string()),
            geometry: source.geometry.map(|geometry| geometry.name().to_owned()),
            grasps: source.grasps.text(),
            planner: answer.planner.clone(),
            settings: answer.settings.clone(),
            criterion: answer.criterion,
            score: answer.score,
            min_score: answer.min_score,
            below_min_score: answer.below_min_score,
            goal_threshold: answer.goal_threshold,
            seed: answer.seed,
            version: Self::VERSION.to_owned(),
            outcome: answer.outcome,
            margins: source.margins,
            budget: PlanBudget::of(&answer.budget),
            joint_names: answer.joint_names.clone(),
            grasp: goal.map(|goal| goal.grasp),
            translation_error_m: goal.map(|goal| goal.translation_error_m),
            rotation_error_rad: goal.map(|goal| goal.rotation_error_rad),
            own_grasp: answer.audit.as_ref().and_then(|audit| audit.own_grasp),
            picks: answer.audit.as_ref().map(PlanPick::all_of).unwrap_or_default(),
            clearance_m: answer.audit.as_ref().and_then(|audit| audit.clearance_m),
            not_checked: answer.not_checked.clone(),
            path_length: path_length(&waypoints),
            least_length: answer.least_length,
            segments: answer.segments.clone(),
            clearances_per_edge_m: clearances_m,
            waypoints,
            timing: answer.timed.as_ref().map(|timed| PlanTiming::of(&timed.trajectory)),
            statistics: answer.statistics,
            shortening: answer.shortening.as_ref().map(PlanShortening::of),
            optimisation: answer.optimisation.as_ref().map(PlanOptimisation::of),
            failures: answer.failures.clone(),
            goal_faults: answer
                .goal_faults
                .iter()
                .map(|faults| faults.iter().map(ToString::to_string).collect())
                .collect(),
            no_grasp: answer.no_grasp.clone(),
            refused: answer.refused.clone(),
            robustness: answer.robustness,
            tilt: answer.tilt.clone(),
            tool: answer.tool.clone(),
            hold_demanded: answer.hold_demanded,
            hold: answer.hold,
            tries: Vec::new(),
        }
    }

    /// Returns the request that reproduces the plan, limited by iterations alone: the time of the original search does not
    /// apply to this machine.
    pub fn request(&self) -> Request {
        let mut paces = Paces::default();
        paces.of_modes.extend(self.segments.iter().map(|segment| (segment.mode, segment.pace)));
        Request {
            planner: Some(self.planner.clone()),
            settings: self.settings.as_object().cloned().unwrap_or_default(),
            budget: Budget { iterations: self.statistics.iterations, time: Duration::MAX },
            seed: self.seed,
            score: Some(self.score),
            min_score: self.min_score,
            goal_threshold: self.goal_threshold,
            keep_path: self.shortening.is_none(),
            stages: self.task.clone(),
            hold: self.hold_demanded,
            left_out: LeftOut::before_last(&self.tries),
            paces,
            // The positions of the way points depend on the timing with rounded corners.
            timing: self.timing.as_ref().map(|timing| Timing {
                method: Some(timing.method),
                stops: !timing.blended,
                is_demanded: false,
                torque_up: timing.torque_up,
            }),
            // The plan already states the clearances of this path.
            audit: AuditSettings { clearances: Clearances::None, ..AuditSettings::default() },
            ..Request::default()
        }
    }

    /// Source of the grasps.
    pub fn given_grasps(&self) -> GivenGrasps {
        GivenGrasps::of_text(self.grasps.as_deref())
    }

    /// Geometry of a released scenario, if requested.
    pub fn given_geometry(&self) -> Option<Geometry> {
        self.geometry.as_deref()?.parse().ok()
    }

    /// Writes the plan, as a whole or not at all.
    ///
    /// # Errors
    /// [`RecordError::NotFinite`] for a number that JSON cannot represent, [`ScenarioError::Unwritable`]. In both cases an
    /// existing file is untouched.
    pub fn write(&self, path: &Path) -> Result<(), RecordError> {
        self.check_finite(path)?;
        let mut text = serde_json::to_string_pretty(self)
            .map_err(|reason| ScenarioError::Unwritable { path: path.to_owned(), reason: reason.into() })?;
        text.push('\n');
        Ok(write_whole_file(path, text.as_bytes())?)
    }
}

#[cfg(test)]
mod tests {
    use cranny_path::{CostKind, TimingMethod};
    use cranny_plan::Improvement;
    use cranny_task::{FailureReason, NotCheckedReason};

    use std::fs;

    use super::*;
    use crate::RecordError;

    fn plan() -> PlanFile {
        let waypoints = vec![vec![-0.0, 1.0 / 3.0], vec![f64::MAX, 1e-17]];
        let clearances_m = vec![Some(5e-324), None];
        PlanFile {
            format: PlanFile::FORMAT.into(),
            scenario: "021".into(),
            task_name: None,
            task: Vec::new(),
            robot: None,
            geometry: None,
            grasps: None,
            planner: "ik-rrt".into(),
            settings: serde_json::json!({"p_goal": 0.01}),
            score: ScoreKind::Physics,
            min_score: Some(0.25),
            below_min_score: Some(2),
            goal_threshold: None,
            criterion: Criterion::Exact,
            seed: u64::MAX,
            version: PlanFile::VERSION.into(),
            outcome: Outcome::Solved,
            margins: Margins { margin_m: 0.001, grasp_margin_m: 0.0, ..Margins::default() },
            budget: PlanBudget { iterations: None, time_limit_s: Some(120.0) },
            joint_names: vec!["a".into(), "b".into()],
            grasp: Some(7),
            translation_error_m: Some(1e-4 / 3.0),
            rotation_error_rad: Some(0.1 + 0.2),
            own_grasp: Some(FoundGrasp {
                world_from_gripper: [[0.1 + 0.2; 4]; 4],
                opening_m: 0.1 / 3.0,
                score: 1e-17,
                uneven_m: Some(0.1 / 7.0),
            }),
            picks: Vec::new(),
            clearance_m: None,
            segments: vec![Segment::reach(waypoints.clone(), clearances_m.clone())],
            clearances_per_edge_m: clearances_m,
            path_length: std::f64::consts::SQRT_2,
            least_length: Some(0.1 + 0.2),
            waypoints,
            timing: Some(PlanTiming {
                method: TimingMethod::JerkLimited,
                blended: false,
                torque_up: None,
                duration_s: 0.1 + 0.7,
                waypoint_times_s: vec![0.0, 0.1 + 0.7],
                hand_s: vec![[0.1, 0.1 + 0.2]],
            }),
            statistics: Statistics { iterations: 12, planning_time_s: 0.3, ..Statistics::default() },
            shortening: Some(PlanShortening { attempts: 100, searches: 2 }),
            optimisation: Some(PlanOptimisation {
                time_limit_s: 2.0,
                cost: CostKind::Time,
                score_weight: 0.1,
                time_s: 2.1,
                iterations: 70,
                improvements: vec![Improvement { time_s: 0.3, iterations: 13, cost: -0.7 / 3.0 }],
            }),
            not_checked: vec![NotChecked {
                first: "hand".to_owned(),
                second: "wrist".to_owned(),
                depth_m: 0.1 / 3.0,
                reason: NotCheckedReason::AlwaysTouching,
                contact: None,
            }],
            failures: vec![GraspFailure {
                grasp: 4,
                reason: FailureReason::NotConnected { goals: 2 },
                attempts: 0,
            }],
            goal_faults: Vec::new(),
            no_grasp: None,
            refused: None,
            robustness: None,
            tool: vec![ToolSlack { name: "box".into(), slack_m: Some(0.1 / 7.0), slack_rad: None }],
            tilt: Some(Tilt { object: "cup".to_owned(), greatest_rad: 0.1 / 3.0, most_rad: 0.1 + 0.2 }),
            hold_demanded: Some(1.5),
            tries: Vec::new(),
            hold: Some(HoldFactors { factor: Some(0.1 + 0.2), at_rest: 0.1 / 3.0, mass_assumed: true }),
        }
    }

    #[test]
    fn a_plan_is_read_back_bit_by_bit() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("021.plan.json");
        plan().write(&path).unwrap();
        let read = PlanFile::read(&path).unwrap();
        assert_eq!(read, plan());
        assert_eq!(read.waypoints[0][0].to_bits(), (-0.0_f64).to_bits());
        assert_eq!(crate::read_waypoints(&path, 2).unwrap(), plan().waypoints);
        assert!(matches!(crate::read_waypoints(&path, 3), Err(RecordError::Waypoint { waypoint: 0, .. })));
        let text = fs::read_to_string(&path).unwrap();
        assert!(text.contains("\"criterion\": \"exact\"") && text.contains("\"outcome\": \"solved\""));
    }

    #[test]
    fn a_plan_without_timing_is_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("021.plan.json");
        let untimed = PlanFile {
            timing: None,
            shortening: None,
            optimisation: None,
            not_checked: Vec::new(),
            failures: Vec::new(),
            ..plan()
        };
        untimed.write(&path).unwrap();
        assert_eq!(PlanFile::read(&path).unwrap(), untimed);
        // Plans were written like this before any of these keys existed.
        let mut old: serde_json::Value = serde_json::from_slice(&fs::read(&path).unwrap()).unwrap();
        let keys = old.as_object_mut().unwrap();
        for key in ["format", "segments", "shortening", "timing", "not_checked", "optimisation", "failures"] {
            assert!(keys.remove(key).is_some(), "{key}");
        }
        fs::write(&path, old.to_string()).unwrap();
        assert_eq!(PlanFile::read(&path).unwrap(), untimed);
    }

    #[test]
    fn what_this_version_does_not_know_is_refused_by_name() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("021.plan.json");
        plan().write(&path).unwrap();
        let sound: serde_json::Value = serde_json::from_slice(&fs::read(&path).unwrap()).unwrap();
        for (pointer, value, says) in [
            ("/format", "cranny-plan/3".into(), "'cranny-plan/3', but this version reads 'cranny-plan/2'"),
            ("/segments/0/kind", "spline".into(), "a segment is of kind 'spline'"),
            ("/segments/0", serde_json::json!({"kind": "arc"}), "a segment is of kind 'arc'"),
            ("/segments/0/mode", "place".into(), "a segment is of mode 'place'"),
            ("/segments/0/mode", "carry".into(), "segment 0, 'carry', holds an object that was not picked"),
            ("/segments/0/attached", "ball".into(), "segment 0, 'reach', states what is in the hand"),
            ("/segments/0/opening_m", 0.04.into(), "segment 0, 'reach', states what is in the hand"),
            ("/segments/0/stage", 1.into(), "segment 0, 'reach', is of a stage that the task does not have"),
            ("/segments/0/waypoints/0/0", 0.5.into(), "its segments do not match its way points"),
            ("/segments", serde_json::json!([]), "its segments do not match its way points"),
        ] {
            let mut other = sound.clone();
            *other.pointer_mut(pointer).unwrap() = value;
            fs::write(&path, other.to_string()).unwrap();
            let fault = PlanFile::read(&path).unwrap_err().to_string();
            assert!(fault.contains("021.plan.json:") && fault.contains(says), "{fault}");
        }
        fs::write(&path, r#"{"format": "cranny-plan/3", "anything": {}}"#).unwrap();
        assert!(PlanFile::read(&path).unwrap_err().to_string().contains("'cranny-plan/3'"));
    }

    #[test]
    fn what_cannot_be_written_leaves_the_earlier_plan_as_it_was() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("021.plan.json");
        plan().write(&path).unwrap();
        let broken = PlanFile { waypoints: vec![vec![f64::NAN, 0.0]], ..plan() };
        assert!(matches!(broken.write(&path), Err(RecordError::NotFinite { field: "waypoints", .. })));
        assert_eq!(PlanFile::read(&path).unwrap(), plan());
        let timing = PlanTiming { duration_s: f64::INFINITY, ..plan().timing.unwrap() };
        let broken = PlanFile { timing: Some(timing), ..plan() };
        assert!(matches!(broken.write(&path), Err(RecordError::NotFinite { field: "timing", .. })));
        let nowhere = folder.path().join("no/such/folder/x.plan.json");
        let unwritable = |fault: RecordError| matches!(fault, RecordError::Scenario(fault) if matches!(*fault, ScenarioError::Unwritable { .. }));
        assert!(unwritable(plan().write(&nowhere).unwrap_err()));
        let onto_a_folder = folder.path().join("folder.plan.json");
        fs::create_dir(&onto_a_folder).unwrap();
        assert!(unwritable(plan().write(&onto_a_folder).unwrap_err()));
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2);
    }

    #[test]
    fn faults_name_file_and_line() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x.plan.json");
        let fault = |text: &str| {
            fs::write(&path, text).unwrap();
            PlanFile::read(&path).unwrap_err().to_string()
        };
        assert!(fault("").contains("x.plan.json: the file is empty"));
        assert!(fault("{\n\"scenario\": \"021\",\n").contains("x.plan.json:3: the file ends too early"));
        assert!(
            fault("{\"format\": \"cranny-plan/2\",\n\"scenario\": 21}")
                .contains("x.plan.json:2: invalid type")
        );
        plan().write(&path).unwrap();
        let text = fs::read_to_string(&path).unwrap();
        assert!(
            fault(&text.replace("\"a\",", "\"a\",\"c\",")).contains("way point 0 has 2 values instead of 3")
        );
        assert!(fault(&text.replace("\"exact\"", "\"exakt\"")).contains("unknown variant `exakt`"));
    }
}
