use std::path::Path;

use cranny_plan::Statistics;
use cranny_solve::FARTHEST_CLEAR_M;
use serde::Deserialize;

use crate::PlanFileError;
use crate::error::ScenarioError;
use crate::plan::file::PlanFile;
use crate::plan::segment::{PlanSegment, segments_of};

/// Whether a file is of a format that this version knows: its own, or none, as before there was any.
///
/// # Errors
/// [`ScenarioError::Content`] for another.
pub(crate) fn check_format(path: &Path, format: Option<&str>) -> Result<(), ScenarioError> {
    let Some(other) = format.filter(|format| *format != PlanFile::FORMAT) else { return Ok(()) };
    let hint = if other.starts_with("cranny-sequence/") {
        "; a plan of several steps is for `verify`, `view`, `render` and `simulate plan`"
    } else {
        ""
    };
    Err(fault(path, format!("its format is '{other}', but this version reads '{}'{hint}", PlanFile::FORMAT)))
}

/// Checks the segments of a plan that was read, or makes that of one written before there were any.
///
/// # Errors
/// [`ScenarioError::Content`] for a segment that this version does not know, or segments that say something else than
/// the plan's own way points.
pub(crate) fn check_segments(path: &Path, plan: &mut PlanFile) -> Result<(), ScenarioError> {
    let of_waypoints = segments_of(&plan.waypoints, &plan.clearances_per_edge_m);
    if plan.format.is_none() && plan.segments.is_empty() {
        plan.segments = of_waypoints;
        plan.format = Some(PlanFile::FORMAT.to_owned());
        return Ok(());
    }
    if plan.format.is_none() {
        let problem = format!("it has segments, but no 'format' ('{}')", PlanFile::FORMAT);
        return Err(fault(path, problem));
    }
    let joined = PlanSegment::joined(&plan.segments).map_err(|problem| fault(path, problem))?;
    let clearances_m: Vec<Option<f64>> =
        plan.segments.iter().flat_map(|segment| segment.clearances_m.iter().copied()).collect();
    if joined != plan.waypoints || clearances_m != plan.clearances_per_edge_m {
        return Err(fault(path, "its segments are not its way points and clearances".to_owned()));
    }
    Ok(())
}

/// Checks that a plan states a known geometry, and one end for what it carries, which a path can have.
///
/// # Errors
/// [`ScenarioError::Content`] for one that it cannot, or for corners that are cut while something is held.
fn check_task(path: &Path, plan: &PlanFile) -> Result<(), ScenarioError> {
    let joints = plan.joint_names.len();
    let ends = [plan.carry_to.is_some(), plan.carry_clear_m.is_some(), plan.place.is_some()];
    let unknown = plan.geometry.as_ref().filter(|_| plan.given_geometry().is_none());
    let problem = if let Some(geometry) = unknown {
        format!("its 'geometry' is '{geometry}', but there are 'scene' and 'export'")
    } else if ends.into_iter().filter(|is_stated| *is_stated).count() > 1 {
        "of 'carry_to', 'carry_clear_m' and 'place' it states more than one".to_owned()
    } else if plan.carry_to.as_ref().is_some_and(Vec::is_empty) {
        "its 'carry_to' names no configuration that the object is carried to".to_owned()
    } else if plan.carry_to.iter().flatten().any(|end| end.len() != joints) {
        format!("its 'carry_to' has a configuration without {joints} values")
    } else if let Some(clear_m) = plan.carry_clear_m.filter(|m| !(0.0..=FARTHEST_CLEAR_M).contains(m)) {
        format!("its 'carry_clear_m', {clear_m}, is no clearance")
    } else if plan.is_task() && plan.timing.as_ref().is_some_and(|timing| timing.blended) {
        "its 'timing' is 'blended', but corners are not cut where an object is carried".to_owned()
    } else {
        return Ok(());
    };
    Err(fault(path, problem))
}

fn fault(path: &Path, problem: String) -> ScenarioError {
    ScenarioError::Content { path: path.to_owned(), problem }
}

impl PlanFile {
    /// Reads a plan.
    ///
    /// # Errors
    /// [`ScenarioError`] with file and line if it cannot be read, is no plan, has a way point without one value per
    /// joint, or segments that this version does not know.
    pub fn read(path: &Path) -> Result<Self, ScenarioError> {
        let text = cranny_file::TABLE
            .argument()
            .bytes(path)
            .map_err(|reason| ScenarioError::Unreadable { path: path.to_owned(), reason })?;
        if text.trim_ascii().is_empty() {
            return Err(ScenarioError::Empty { path: path.to_owned() });
        }
        let malformed = |reason| ScenarioError::Json { path: path.to_owned(), reason };
        // What another format holds is not known.
        let Head { format } = cranny_file::json(&text).map_err(malformed)?;
        check_format(path, format.as_deref())?;
        let mut plan: Self = cranny_file::json(&text).map_err(malformed)?;
        plan.check_waypoints(path, plan.joint_names.len())?;
        check_segments(path, &mut plan)?;
        check_task(path, &plan)?;
        Ok(plan)
    }

    /// Whether a plan that was read with others from `path` holds together.
    pub(crate) fn check(&self, path: &Path) -> Result<(), ScenarioError> {
        check_format(path, self.format.as_deref())?;
        self.check_waypoints(path, self.joint_names.len())?;
        check_segments(path, &mut self.clone())?;
        check_task(path, self)
    }

    /// Whether JSON can hold all of its numbers.
    pub(crate) fn check_finite(&self, path: &Path) -> Result<(), ScenarioError> {
        let fault = |field| PlanFileError::NotFinite { path: path.to_owned(), field }.into();
        self.field_not_finite().map_or(Ok(()), |field| Err(fault(field)))
    }

    /// The way points of the plan, which was read from `path`.
    ///
    /// # Errors
    /// [`PlanFileError::Waypoint`] unless each has `joints` values, [`PlanFileError::NoPath`] if there is none.
    pub fn into_waypoints(self, path: &Path, joints: usize) -> Result<Vec<Vec<f64>>, ScenarioError> {
        self.check_path(path, joints)?;
        Ok(self.waypoints)
    }

    /// Checks that the plan, which was read from `path`, has way points of the right length.
    ///
    /// # Errors
    /// As [`Self::into_waypoints`].
    pub fn check_path(&self, path: &Path, joints: usize) -> Result<(), ScenarioError> {
        self.check_waypoints(path, joints)?;
        if self.waypoints.is_empty() {
            let outcome = self.outcome.name();
            return Err(PlanFileError::NoPath { path: path.to_owned(), outcome }.into());
        }
        Ok(())
    }

    fn check_waypoints(&self, path: &Path, expected: usize) -> Result<(), ScenarioError> {
        match self.waypoints.iter().enumerate().find(|(_, q)| q.len() != expected) {
            None => Ok(()),
            Some((waypoint, q)) => {
                Err(PlanFileError::Waypoint { path: path.to_owned(), waypoint, expected, actual: q.len() }
                    .into())
            }
        }
    }

    pub(crate) fn field_not_finite(&self) -> Option<&'static str> {
        let Statistics { planning_time_s, ik_time_s, collision_time_s, proof_time_s, nearest_time_s, .. } =
            self.statistics;
        let times = [planning_time_s, ik_time_s, collision_time_s, proof_time_s, nearest_time_s];
        let timing = self.timing.iter().flat_map(|t| {
            t.waypoint_times_s
                .iter()
                .chain([&t.duration_s])
                .chain(t.closing_s.iter().chain(&t.opening_s).flatten())
        });
        let optimisation = self.optimisation.iter().flat_map(|o| {
            let improvements = o.improvements.iter().flat_map(|i| [i.time_s, i.cost]);
            improvements.chain([o.time_limit_s, o.score_weight, o.time_s])
        });
        let own_grasp = self.own_grasp.iter().flat_map(|grasp| {
            let pose = grasp.world_from_gripper.iter().flatten().copied();
            pose.chain([grasp.opening_m, grasp.score]).chain(grasp.uneven_m)
        });
        let fields: [(&'static str, Vec<f64>); 15] = [
            ("own_grasp", own_grasp.collect()),
            ("waypoints", self.waypoints.concat()),
            ("carry_to", self.carry_to.iter().flatten().flatten().copied().collect()),
            ("carry_clear_m", self.carry_clear_m.into_iter().collect()),
            ("clearances_per_edge_m", self.clearances_per_edge_m.iter().copied().flatten().collect()),
            ("goal_threshold", self.goal_threshold.into_iter().collect()),
            ("clearance_m", self.clearance_m.into_iter().collect()),
            ("translation_error_m", self.translation_error_m.into_iter().collect()),
            ("rotation_error_rad", self.rotation_error_rad.into_iter().collect()),
            ("path_length", vec![self.path_length]),
            ("margins", vec![self.margins.margin_m, self.margins.grasp_margin_m]),
            ("budget", self.budget.time_limit_s.into_iter().collect()),
            ("statistics", times.to_vec()),
            ("timing", timing.copied().collect()),
            ("optimisation", optimisation.collect()),
        ];
        fields.iter().find(|(_, values)| values.iter().any(|x| !x.is_finite())).map(|(field, _)| *field)
    }
}

/// The way points, if there are any.
pub(crate) fn some(path: &Path, waypoints: Vec<Vec<f64>>) -> Result<Vec<Vec<f64>>, ScenarioError> {
    if waypoints.is_empty() { Err(ScenarioError::Empty { path: path.to_owned() }) } else { Ok(waypoints) }
}

/// What is read of a plan before the rest.
// Other keys are read by the reader of the format.
#[derive(Deserialize)]
pub(crate) struct Head {
    #[serde(default)]
    pub format: Option<String>,
}
