use std::sync::Arc;

use cranny_collision::Scratch;
use cranny_path::{Audit, AuditSettings, Clearances, audit_along, audit_with, path_length};
use cranny_plan::PlanError;
use cranny_solve::{TaskTrajectory, Timing};
use cranny_task::{Carrier, Problem, Segment, Stage, StateSequence, joined};

use crate::DatasetError;
use crate::demonstration::Demonstration;
use crate::scene_row::pose_numbers;

/// Least share of the true clearance that a stated one is: a tighter bound takes longer than the search.
pub const KEPT_SHARE: f64 = 0.5;

/// Figures of a path that are measured from its way points alone, the same when it is made and when it is checked.
pub(crate) struct Figures {
    /// True if the path is proven, from the start to a grasp and through all stages.
    pub is_valid: bool,
    /// Verdict on the path.
    pub audit: Audit,
    /// Its trajectory, with a stop at each way point.
    pub trajectory: Option<TaskTrajectory>,
    grasp: Option<usize>,
    grasp_pose: Vec<f64>,
    load: Option<f64>,
    clearance_m: f64,
    path_length: f64,
}

/// Settings of the proofs of a path.
pub(crate) fn proof_settings() -> AuditSettings {
    AuditSettings { clearances: Clearances::None, ..AuditSettings::default() }
}

impl Figures {
    /// Proves and measures the segments of a task; `None` without an exact cell.
    pub fn of(
        problem: &Problem,
        stages: &[Stage],
        segments: &[Segment],
        carrier: Option<&Arc<Carrier>>,
        scratch: &mut Scratch,
    ) -> Result<Option<Self>, DatasetError> {
        let path = joined(segments);
        let share = 1.0 - KEPT_SHARE;
        let (audit, clearance_m) = if stages.len() == 1 {
            let audit = audit_with(problem, &path, proof_settings())?;
            let cell = problem.exact_cell("dataset")?;
            let clearance_m = if audit.valid { cell.path_clearance(&path, share, scratch) } else { 0.0 };
            (audit, clearance_m)
        } else {
            let along = StateSequence::with_carrier(problem, stages, segments, carrier)?;
            let Some(along) = along else { return Ok(None) };
            let audit = audit_along(problem, stages, (segments, &along), proof_settings())?;
            let free =
                segments.iter().zip(&along.states).filter(|(segment, _)| segment.mode.rests_at.is_none());
            let clearances = free.map(|(segment, state)| {
                let cell = state.cell();
                cell.path_clearance(&segment.waypoints, share, &mut cell.scratch())
            });
            let clearance_m = if audit.valid { clearances.fold(f64::INFINITY, f64::min) } else { 0.0 };
            (audit, clearance_m)
        };
        let timing = Timing { stops: true, ..Timing::default() };
        let trajectory = match TaskTrajectory::of(timing, problem.robot(), segments) {
            Ok(trajectory) => trajectory,
            Err(fault) if audit.valid => return Err(PlanError::into(fault)),
            Err(_) => None,
        };
        let grasp = audit.picks.first().map_or(audit.goal, |pick| pick.goal).map(|goal| goal.grasp);
        let chosen = grasp.and_then(|grasp| problem.grasps()?.grasps().get(grasp));
        Ok(Some(Self {
            is_valid: audit.valid,
            trajectory,
            grasp_pose: chosen
                .map(|grasp| pose_numbers(&grasp.world_from_gripper).to_vec())
                .unwrap_or_default(),
            load: chosen.and_then(|grasp| grasp.load),
            grasp,
            clearance_m,
            path_length: path_length(&path),
            audit,
        }))
    }

    /// Writes the figures into a row.
    pub fn write(&self, row: &mut Demonstration) {
        row.grasp = self.grasp.and_then(|grasp| i64::try_from(grasp).ok()).unwrap_or(-1);
        row.grasp_pose.clone_from(&self.grasp_pose);
        row.load = self.load.unwrap_or(f64::NAN);
        row.clearance_m = self.clearance_m;
        row.path_length = self.path_length;
        row.duration_s = self.trajectory.as_ref().map_or(f64::NAN, TaskTrajectory::duration_s);
        row.times_s = self.trajectory.as_ref().map(TaskTrajectory::waypoint_times_s).unwrap_or_default();
    }
}
