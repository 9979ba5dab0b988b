use cranny_collision::Cell;
use cranny_plan::{Audit, GraspFailure, Outcome, Trajectory, path_length};
use cranny_robot::Robot;
use cranny_scenario::PlanFile;
use serde::Serialize;

use crate::clearance_profile::ClearanceRows;
use crate::tree_recording::SearchTreeRows;
use crate::{ClearanceProfile, ShownPath, TreeRecording, ViewError, number_row};

/// A plan as a page shows it: the path in time, what `verify` says of it, or why there is none.
#[derive(Clone, Debug)]
pub struct PagePlan {
    /// What it is called: the name of its file.
    pub name: String,
    /// The planner; empty for bare way points.
    pub planner: String,
    /// How the search ended; None for bare way points.
    pub outcome: Option<Outcome>,
    /// Of its path, as [`cranny_plan::path_length`] has it.
    pub path_length: f64,
    /// The path in time; `None` for a plan without a path.
    pub path: Option<ShownPath>,
    /// What `verify` says; `None` for a plan without a path.
    pub verification: Option<Audit>,
    /// What stood between the robot and each grasp.
    pub failures: Vec<GraspFailure>,
    /// The trees of the search, if they were recorded.
    pub search_tree: Option<TreeRecording>,
}

/// A page draws so many instants a second, screens most of which show 60, and of a long path so many in all.
const RATE_HZ: f64 = 60.0;
const MOST_SAMPLES: f64 = 2400.0;

impl PagePlan {
    /// The plan of a file, as [`Self::of_waypoints`].
    ///
    /// # Errors
    /// As [`ShownPath::of`].
    pub fn of_file(
        name: impl Into<String>,
        plan: &PlanFile,
        robot: &Robot,
        trajectory: Option<&Trajectory>,
        verification: Option<Audit>,
    ) -> Result<Self, ViewError> {
        Ok(Self {
            planner: plan.planner.clone(),
            outcome: Some(plan.outcome),
            failures: plan.failures.clone(),
            ..Self::of_waypoints(name, &plan.waypoints, robot, trajectory, verification)?
        })
    }

    /// Way points, from whoever planned them, with their time and what `verify` says of them.
    ///
    /// # Errors
    /// As [`ShownPath::of`].
    pub fn of_waypoints(
        name: impl Into<String>,
        waypoints: &[Vec<f64>],
        robot: &Robot,
        trajectory: Option<&Trajectory>,
        verification: Option<Audit>,
    ) -> Result<Self, ViewError> {
        let path_length = path_length(waypoints);
        let duration_s = trajectory.map_or(path_length, Trajectory::duration_s);
        let rate_hz = RATE_HZ.min(MOST_SAMPLES / duration_s.max(f64::MIN_POSITIVE));
        Ok(Self {
            name: name.into(),
            planner: String::new(),
            outcome: None,
            path_length,
            path: ShownPath::of(robot, waypoints, trajectory, rate_hz)?,
            verification,
            failures: Vec::new(),
            search_tree: None,
        })
    }

    /// The grasp that the path ends at: what `verify` finds, not what the file claims.
    pub fn grasp(&self) -> Option<usize> {
        self.verification.as_ref().filter(|v| v.valid).and_then(|v| v.goal).map(|goal| goal.grasp)
    }

    /// One line: what `verify` says.
    pub fn verdict(&self) -> String {
        let Some(verification) = &self.verification else {
            return format!("no path: {}", self.outcome.map_or("no way points", Outcome::sentence));
        };
        let [first, rest @ ..] = &verification.violations[..] else {
            let clearance = verification.clearance_m.map_or_else(String::new, |clearance_m| {
                format!(", {:.2} mm or more from everything, proven", clearance_m * 1000.0)
            });
            return format!("valid{clearance}");
        };
        let more = match rest.len() {
            0 => String::new(),
            count => format!(", and {count} more"),
        };
        format!("not valid: {first}{more}")
    }

    pub(crate) fn entry(&self, cell: &Cell, most_instants: usize) -> PlanEntry {
        let path = self.path.as_ref();
        let row = |pick: fn(&ShownPath) -> &Vec<f64>| {
            number_row::floats64(path.map(pick).into_iter().flatten().copied())
        };
        let configurations = path.into_iter().flat_map(|path| path.configurations.iter().flatten().copied());
        let profile = path.and_then(|path| ClearanceProfile::along(path, cell, most_instants));
        PlanEntry {
            name: self.name.clone(),
            planner: self.planner.clone(),
            outcome: self.outcome.map_or("", Outcome::sentence),
            verdict: self.verdict(),
            is_valid: self.verification.as_ref().is_some_and(|v| v.valid),
            times_s: row(|path| &path.times_s),
            configurations: number_row::floats64(configurations),
            waypoint_times_s: row(|path| &path.waypoint_times_s),
            is_timed: path.is_some_and(|path| path.is_timed),
            path_length: self.path_length,
            grasp: self.grasp(),
            clearance: profile.as_ref().map(ClearanceProfile::rows),
            blocked: self.failures.iter().map(BlockedGrasp::of).collect(),
            blocked_counts: GraspFailure::counted(&self.failures)
                .into_iter()
                .map(|(reason, count)| BlockedCount { reason, count })
                .collect(),
            search_tree: self.search_tree.as_ref().map(TreeRecording::rows),
        }
    }
}

/// A plan as a page reads it.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct PlanEntry {
    name: String,
    planner: String,
    outcome: &'static str,
    verdict: String,
    is_valid: bool,
    times_s: String,
    configurations: String,
    waypoint_times_s: String,
    is_timed: bool,
    path_length: f64,
    grasp: Option<usize>,
    clearance: Option<ClearanceRows>,
    blocked: Vec<BlockedGrasp>,
    blocked_counts: Vec<BlockedCount>,
    search_tree: Option<SearchTreeRows>,
}

#[derive(Clone, Debug, Serialize)]
struct BlockedGrasp {
    grasp: usize,
    reason: String,
}

#[derive(Clone, Debug, Serialize)]
struct BlockedCount {
    reason: String,
    count: usize,
}

impl BlockedGrasp {
    fn of(failure: &GraspFailure) -> Self {
        Self { grasp: failure.grasp, reason: failure.reason.sentence() }
    }
}
