use std::path::Path;

use cranny_plan::Statistics;
use cranny_scenario::ScenarioError;
use cranny_task::{Criterion, Move, SpeedLimits, Stage, check_segments, joined};
use serde::Deserialize;
use serde_json::{Map, Value};

use crate::file::PlanFile;
use crate::{RecordError, old_formats};

/// Checks that the stages and segments of a plan match, and that the segments contain its way points.
///
/// # Errors
/// [`ScenarioError::Content`] for a mismatch.
fn check_task(path: &Path, plan: &PlanFile) -> Result<(), RecordError> {
    let own = [Stage::pick()];
    let stages = if plan.task.is_empty() { &own[..] } else { &plan.task };
    let clearances_m: Vec<Option<f64>> =
        plan.segments.iter().flat_map(|segment| segment.clearances_m.iter().copied()).collect();
    let unknown = plan.geometry.as_ref().filter(|_| plan.given_geometry().is_none());
    let joints = plan.joint_names.len();
    let ends = plan.task.iter().filter_map(|stage| match stage {
        Stage::Move(Move::Configurations(ends)) => Some(ends),
        _ => None,
    });
    let mut ends = ends;
    let problem = if let Some(geometry) = unknown {
        format!("its 'geometry' is '{geometry}', but must be 'scene' or 'export'")
    } else if let Err(problem) = plan.margins.check() {
        format!("its 'margins': {problem}")
    } else if let Err(problem) = check_segments(stages, &plan.segments) {
        problem
    } else if joined(&plan.segments) != plan.waypoints || clearances_m != plan.clearances_per_edge_m {
        "its segments do not match its way points and clearances".to_owned()
    } else if ends.any(|ends| ends.is_empty() || ends.iter().any(|end| end.len() != joints)) {
        format!("its 'task' has a move without a configuration of {joints} values")
    } else if plan.criterion == Criterion::Paper && plan.segments.iter().any(|s| !s.corners.is_empty()) {
        "its corners are rounded, which needs the criterion 'exact'".to_owned()
    } else {
        return Ok(());
    };
    Err(fault(path, problem))
}

fn fault(path: &Path, problem: String) -> RecordError {
    ScenarioError::Content { path: path.to_owned(), problem }.into()
}

impl PlanFile {
    /// Reads a plan.
    ///
    /// # Errors
    /// [`ScenarioError`] with file and line if it cannot be read, is not a plan, has a way point without one value per joint,
    /// or segments that this version does not know.
    pub fn read(path: &Path) -> Result<Self, RecordError> {
        let text = cranny_file::TABLE
            .bytes(path)
            .map_err(|reason| ScenarioError::Unreadable { path: path.to_owned(), reason })?;
        if text.trim_ascii().is_empty() {
            return Err(ScenarioError::Empty { path: path.to_owned() }.into());
        }
        let malformed = |reason| ScenarioError::Json { path: path.to_owned(), reason };
        // The format decides which keys are valid.
        let Head { format } = cranny_file::json(&text).map_err(malformed)?;
        let plan: Self = match format.as_deref() {
            Some(Self::FORMAT) => cranny_file::json(&text).map_err(malformed)?,
            None | Some(old_formats::FIRST) => {
                let mut plan = cranny_file::json(&text).map_err(malformed)?;
                old_formats::of_first(&mut plan).map_err(|problem| fault(path, problem))?;
                Self::of_value(path, plan)?
            }
            Some(old_formats::SEQUENCE) => {
                let plans = cranny_file::json(&text).map_err(malformed)?;
                let plan = old_formats::of_sequence(plans).map_err(|problem| fault(path, problem))?;
                Self::of_value(path, plan)?
            }
            Some(other) => {
                let problem = format!(
                    "its format is '{other}', but this version reads '{}' and those before it",
                    Self::FORMAT
                );
                return Err(fault(path, problem));
            }
        };
        plan.check_waypoints(path, plan.joint_names.len())?;
        check_task(path, &plan)?;
        // Plans of earlier versions cut corners by curves that no file states, so that their timing cannot be recomputed.
        let is_rounded = plan.segments.iter().any(|segment| !segment.corners.is_empty());
        Ok(Self { timing: plan.timing.clone().filter(|timing| is_rounded || !timing.blended), ..plan })
    }

    fn of_value(path: &Path, plan: Map<String, Value>) -> Result<Self, RecordError> {
        serde_json::from_value(plan.into()).map_err(|problem| fault(path, problem.to_string()))
    }

    /// Checks that JSON can represent all numbers of the plan.
    pub(crate) fn check_finite(&self, path: &Path) -> Result<(), RecordError> {
        let fault = |field| RecordError::NotFinite { path: path.to_owned(), field };
        self.field_not_finite().map_or(Ok(()), |field| Err(fault(field)))
    }

    /// Returns the way points (m, rad; one value per joint) of the plan, which was read from `path`.
    ///
    /// # Errors
    /// [`RecordError::Waypoint`] unless each has `joints` values, [`RecordError::NoPath`] if there is none.
    pub fn into_waypoints(self, path: &Path, joints: usize) -> Result<Vec<Vec<f64>>, RecordError> {
        self.check_path(path, joints)?;
        Ok(self.waypoints)
    }

    /// Checks that the plan, which was read from `path`, has way points of the right length.
    ///
    /// # Errors
    /// As [`Self::into_waypoints`].
    pub fn check_path(&self, path: &Path, joints: usize) -> Result<(), RecordError> {
        self.check_waypoints(path, joints)?;
        if self.waypoints.is_empty() {
            let outcome = self.outcome.name();
            return Err(RecordError::NoPath { path: path.to_owned(), outcome });
        }
        Ok(())
    }

    fn check_waypoints(&self, path: &Path, expected: usize) -> Result<(), RecordError> {
        match self.waypoints.iter().enumerate().find(|(_, q)| q.len() != expected) {
            None => Ok(()),
            Some((waypoint, q)) => {
                Err(RecordError::Waypoint { path: path.to_owned(), waypoint, expected, actual: q.len() })
            }
        }
    }

    pub(crate) fn field_not_finite(&self) -> Option<&'static str> {
        let Statistics { planning_time_s, ik_time_s, collision_time_s, proof_time_s, nearest_time_s, .. } =
            self.statistics;
        let times = [planning_time_s, ik_time_s, collision_time_s, proof_time_s, nearest_time_s];
        let timing = self
            .timing
            .iter()
            .flat_map(|t| t.waypoint_times_s.iter().chain([&t.duration_s]).chain(t.hand_s.iter().flatten()));
        let optimisation = self.optimisation.iter().flat_map(|o| {
            let improvements = o.improvements.iter().flat_map(|i| [i.time_s, i.cost]);
            improvements.chain([o.time_limit_s, o.score_weight, o.time_s])
        });
        let own_grasp = self.own_grasp.iter().flat_map(|grasp| {
            let pose = grasp.world_from_gripper.iter().flatten().copied();
            pose.chain([grasp.opening_m, grasp.score]).chain(grasp.uneven_m)
        });
        let left_out = self.tries.iter().filter_map(|tried| tried.left_out.as_ref());
        let left_out = left_out.flat_map(|grasp| grasp.world_from_gripper.into_iter().flatten());
        let hold = self.hold.iter().flat_map(|hold| hold.factor.into_iter().chain([hold.at_rest]));
        let speeds = self.segments.iter().flat_map(|segment| {
            let points = segment.corners.iter().flat_map(|corner| corner.control_points.iter().flatten());
            let SpeedLimits { velocity, acceleration, tool_m_s, turn_rad_s } = segment.pace;
            let paces = [velocity, acceleration].into_iter().chain(tool_m_s).chain(turn_rad_s);
            let load = segment
                .payload
                .iter()
                .flat_map(|load| [load.mass_kg].into_iter().chain(load.center_m).chain(load.inertia_kg_m2));
            points.copied().chain(paces).chain(segment.speed).chain(load)
        });
        let fields: [(&'static str, Vec<f64>); 18] = [
            ("own_grasp", own_grasp.collect()),
            ("waypoints", self.waypoints.concat()),
            ("clearances_per_edge_m", self.clearances_per_edge_m.iter().copied().flatten().collect()),
            ("goal_threshold", self.goal_threshold.into_iter().collect()),
            ("clearance_m", self.clearance_m.into_iter().collect()),
            ("translation_error_m", self.translation_error_m.into_iter().collect()),
            ("rotation_error_rad", self.rotation_error_rad.into_iter().collect()),
            ("path_length", vec![self.path_length]),
            (
                "margins",
                [self.margins.margin_m, self.margins.grasp_margin_m]
                    .into_iter()
                    .chain(self.margins.tilt_rad)
                    .collect(),
            ),
            ("budget", self.budget.time_limit_s.into_iter().collect()),
            ("statistics", times.to_vec()),
            ("timing", timing.copied().collect()),
            ("optimisation", optimisation.collect()),
            ("hold", hold.chain(self.hold_demanded).collect()),
            ("tilt", self.tilt.iter().flat_map(|tilt| [tilt.greatest_rad, tilt.most_rad]).collect()),
            (
                "tool",
                self.tool.iter().flat_map(|tool| tool.slack_m.into_iter().chain(tool.slack_rad)).collect(),
            ),
            ("segments", speeds.collect()),
            ("tries", left_out.collect()),
        ];
        fields.iter().find(|(_, values)| values.iter().any(|x| !x.is_finite())).map(|(field, _)| *field)
    }
}

/// Returns the way points, or an error if there are none.
pub(crate) fn some(path: &Path, waypoints: Vec<Vec<f64>>) -> Result<Vec<Vec<f64>>, RecordError> {
    if waypoints.is_empty() {
        Err(ScenarioError::Empty { path: path.to_owned() }.into())
    } else {
        Ok(waypoints)
    }
}

/// Key of a plan that is read before the rest.
// Other keys are read by the reader of the format.
#[derive(Deserialize)]
pub(crate) struct Head {
    #[serde(default)]
    pub format: Option<String>,
}
