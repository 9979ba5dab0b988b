use cranny_collision::Cell;
use cranny_file::at_least;
use cranny_path::{Audit, Trajectory, path_length};
use cranny_plan::{Outcome, Statistics};
use cranny_record::PlanFile;
use cranny_robot::Robot;
use cranny_solve::TaskTrajectory;
use cranny_task::{GraspFailure, NotChecked, State};
use serde::Serialize;

use crate::course::clearance_profile::ClearanceRows;
use crate::course::tree_recording::SearchTreeRows;
use crate::{
    CarriedObjectMotion, ClearanceProfile, PageTask, SampledPath, ShownMode, TreeRecording, ViewError,
    viewer::number_row,
};

/// Plan on a page: the timed path with the verdict of `verify`, or the reason why there is none.
#[derive(Clone, Debug)]
pub struct PagePlan {
    /// Name of the plan: that of its file.
    pub name: String,
    /// Name of the planner; empty for bare way points.
    pub planner: String,
    /// Outcome of the search; `None` for bare way points.
    pub outcome: Option<Outcome>,
    /// Length of the path by [`cranny_path::path_length`].
    pub path_length: f64,
    /// Timed path; `None` for a plan without a path.
    pub path: Option<SampledPath>,
    /// Verdict of `verify`; `None` for a plan without a path.
    pub verification: Option<Audit>,
    /// States along the segments of a plan with several segments.
    pub states: Vec<State>,
    /// Failure of each grasp without a path.
    pub failures: Vec<GraspFailure>,
    /// Stages of the task; `None` for a plan without a list of stages.
    pub task: Option<PageTask>,
    /// Statistics of the search; `None` for bare way points.
    pub statistics: Option<Statistics>,
    /// Trees of the search, if they were recorded.
    pub search_tree: Option<TreeRecording>,
}

/// Sample rate of a path in Hz, that of most screens, and maximum number of samples of a long path.
const RATE_HZ: f64 = 60.0;
const MOST_SAMPLES: f64 = 2400.0;

/// Returns the sample rate of a motion of this duration, in Hz.
pub(crate) fn rate_hz(duration_s: f64) -> f64 {
    RATE_HZ.min(MOST_SAMPLES / duration_s.max(f64::MIN_POSITIVE))
}

impl PagePlan {
    /// Creates the plan of a file, with the times of [`PlanFile::trajectory`], the verdict of `verify` and
    /// [`PlanFile::states`].
    ///
    /// # Errors
    /// See [`SampledPath::of`].
    pub fn of_file(
        name: impl Into<String>,
        plan: &PlanFile,
        robot: &Robot,
        timed: Option<&TaskTrajectory>,
        verification: Option<Audit>,
        states: Vec<State>,
    ) -> Result<Self, ViewError> {
        let path_length = path_length(&plan.waypoints);
        let duration_s = timed.map_or(path_length, TaskTrajectory::duration_s);
        let path = SampledPath::of_plan(robot, plan, timed, rate_hz(duration_s))?;
        Ok(Self {
            name: name.into(),
            planner: plan.planner.clone(),
            outcome: Some(plan.outcome),
            path_length,
            task: PageTask::of(plan, path.as_ref()),
            path,
            verification,
            states,
            failures: plan.failures.clone(),
            statistics: Some(plan.statistics),
            search_tree: None,
        })
    }

    /// Creates a plan of way points of any origin (m, rad; one value per joint), with their times and the verdict of `verify`.
    ///
    /// # Errors
    /// See [`SampledPath::of`].
    pub fn of_waypoints(
        name: impl Into<String>,
        waypoints: &[Vec<f64>],
        robot: &Robot,
        trajectory: Option<&Trajectory>,
        verification: Option<Audit>,
    ) -> Result<Self, ViewError> {
        let path_length = path_length(waypoints);
        let duration_s = trajectory.map_or(path_length, Trajectory::duration_s);
        Ok(Self {
            name: name.into(),
            planner: String::new(),
            outcome: None,
            path_length,
            path: SampledPath::of(robot, waypoints, trajectory, rate_hz(duration_s))?,
            verification,
            states: Vec::new(),
            failures: Vec::new(),
            task: None,
            statistics: None,
            search_tree: None,
        })
    }

    /// Returns true if `verify` finds no violation.
    pub fn is_valid(&self) -> bool {
        self.verification.as_ref().is_some_and(|verification| verification.valid)
    }

    /// Grasp at which the path ends, as found by `verify`, not as stated in the file. `None` for several picks.
    pub fn grasp(&self) -> Option<usize> {
        let one = self.verification.as_ref().filter(|audit| audit.valid && audit.picks.len() < 2)?;
        one.goal.map(|goal| goal.grasp)
    }

    /// Returns the verdict of `verify` in one line.
    pub fn verdict(&self) -> String {
        let Some(audit) = &self.verification else {
            return format!("no path: {}", self.outcome.map_or("no way points", Outcome::sentence));
        };
        if !audit.valid {
            let first = audit.violations.first().map(ToString::to_string).unwrap_or_default();
            let more = match audit.violations.len().saturating_sub(1) {
                0 => String::new(),
                count => format!(", and {count} more"),
            };
            return format!("not valid: {first}{more}");
        }
        let clearance = audit.clearance_m.map_or_else(String::new, |clearance_m| {
            format!(", {} mm or more from everything, proven", at_least(clearance_m, 1e3, 2))
        });
        let but_for = NotChecked::summary(&audit.not_checked);
        let but_for = but_for.map_or_else(String::new, |pairs| format!(", but for {pairs}"));
        format!("valid{clearance}{but_for}")
    }

    pub(crate) fn entry(&self, cell: &Cell, most_instants: usize) -> PlanEntry {
        let path = self.path.as_ref();
        let row = |pick: fn(&SampledPath) -> &Vec<f64>| {
            number_row::floats64(path.map(pick).into_iter().flatten().copied())
        };
        let configurations = path.into_iter().flat_map(|path| path.configurations.iter().flatten().copied());
        let profile = path.and_then(|path| ClearanceProfile::along(path, cell, &self.states, most_instants));
        PlanEntry {
            name: self.name.clone(),
            planner: self.planner.clone(),
            outcome: self.outcome.map_or("", Outcome::sentence),
            verdict: self.verdict(),
            is_valid: self.is_valid(),
            times_s: row(|path| &path.times_s),
            configurations: number_row::floats64(configurations),
            waypoint_times_s: row(|path| &path.waypoint_times_s),
            is_timed: path.is_some_and(|path| path.is_timed),
            path_length: self.path_length,
            carries: path.into_iter().flat_map(|path| &path.carries).map(CarryEntry::of).collect(),
            grasp: self.grasp(),
            clearance: profile.as_ref().map(ClearanceProfile::rows),
            blocked: self.failures.iter().map(BlockedGrasp::of).collect(),
            blocked_counts: GraspFailure::counted(&self.failures)
                .into_iter()
                .map(|(reason, count)| BlockedCount { reason, count })
                .collect(),
            task: self.task.clone(),
            search: self.statistics.as_ref().map(SearchEntry::of),
            search_tree: self.search_tree.as_ref().map(TreeRecording::rows),
        }
    }
}

/// Plan in the encoding of the page.
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
    carries: Vec<CarryEntry>,
    grasp: Option<usize>,
    clearance: Option<ClearanceRows>,
    blocked: Vec<BlockedGrasp>,
    blocked_counts: Vec<BlockedCount>,
    task: Option<PageTask>,
    search: Option<SearchEntry>,
    search_tree: Option<SearchTreeRows>,
}

/// Effort of the search over all stages.
#[derive(Clone, Copy, Debug, Serialize)]
struct SearchEntry {
    goals_tried: u64,
    ik_attempts: u64,
    planning_time_s: f64,
}

impl SearchEntry {
    fn of(statistics: &Statistics) -> Self {
        let &Statistics { goals_tried, ik_attempts, planning_time_s, .. } = statistics;
        Self { goals_tried, ik_attempts, planning_time_s }
    }
}

/// Carried object in the encoding of the page.
#[derive(Clone, Debug, Serialize)]
struct CarryEntry {
    object: String,
    grasp: Vec<f64>,
    closing: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    placed: Option<Vec<f64>>,
    modes: Vec<ModeEntry>,
}

#[derive(Clone, Debug, Serialize)]
struct ModeEntry {
    name: &'static str,
    holds: bool,
    touches: bool,
    leaves: bool,
    segment: usize,
    from_s: f64,
    until_s: f64,
}

impl CarryEntry {
    fn of(carry: &CarriedObjectMotion) -> Self {
        let mode = |&ShownMode { mode, segment, from_s, until_s }: &ShownMode| ModeEntry {
            name: mode.name,
            holds: mode.holds,
            touches: mode.rests_at.is_some(),
            leaves: mode.leaves,
            segment,
            from_s,
            until_s,
        };
        Self {
            object: carry.object.clone(),
            grasp: carry.grasp.clone(),
            closing: carry.closing,
            placed: carry.placed.clone(),
            modes: carry.modes.iter().map(mode).collect(),
        }
    }
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
