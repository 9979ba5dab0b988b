use cranny_collision::Cell;
use cranny_file::at_least;
use cranny_plan::{Audit, GraspFailure, NotChecked, Outcome, Trajectory, path_length};
use cranny_robot::Robot;
use cranny_scenario::PlanFile;
use cranny_solve::TaskTrajectory;
use serde::Serialize;

use crate::clearance_profile::ClearanceRows;
use crate::tree_recording::SearchTreeRows;
use crate::{
    ClearanceProfile, ShownCarry, ShownMode, ShownPath, StepCells, TreeRecording, ViewError, number_row,
};

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
    /// How many steps there are to be; 1 for a plan that is not one of several.
    pub step_count: usize,
    /// What `verify` says of each step, as far as they have a path.
    pub verifications: Vec<Audit>,
    /// Robot and world along each step in which something is carried away.
    pub steps: Vec<StepCells>,
    /// What stood between the robot and each grasp.
    pub failures: Vec<GraspFailure>,
    /// The trees of the search, if they were recorded.
    pub search_tree: Option<TreeRecording>,
}

/// A page draws so many instants a second, screens most of which show 60, and of a long path so many in all.
const RATE_HZ: f64 = 60.0;
const MOST_SAMPLES: f64 = 2400.0;

/// Of a motion that lasts so long.
pub(crate) fn rate_hz(duration_s: f64) -> f64 {
    RATE_HZ.min(MOST_SAMPLES / duration_s.max(f64::MIN_POSITIVE))
}

impl PagePlan {
    /// The plan of a file, with the times of [`PlanFile::trajectory`], what `verify` says of it, and what it carries away
    /// how ([`PlanFile::task_cells`]).
    ///
    /// # Errors
    /// As [`ShownPath::of`].
    pub fn of_file(
        name: impl Into<String>,
        plan: &PlanFile,
        robot: &Robot,
        timed: Option<&TaskTrajectory>,
        verification: Option<Audit>,
        cells: Option<StepCells>,
    ) -> Result<Self, ViewError> {
        let path_length = path_length(&plan.waypoints);
        let duration_s = timed.map_or(path_length, TaskTrajectory::duration_s);
        Ok(Self {
            name: name.into(),
            planner: plan.planner.clone(),
            outcome: Some(plan.outcome),
            path_length,
            path: ShownPath::of_plan(robot, plan, timed, rate_hz(duration_s))?,
            step_count: 1,
            verifications: verification.into_iter().collect(),
            steps: cells.into_iter().collect(),
            failures: plan.failures.clone(),
            search_tree: None,
        })
    }

    /// The plans of several steps, each with its time, as one motion; with what `verify` says of them and what they carry
    /// away, as far as they hold.
    ///
    /// # Errors
    /// As [`ShownPath::of`].
    pub fn of_steps(
        name: impl Into<String>,
        plans: &[(&PlanFile, Option<TaskTrajectory>)],
        robot: &Robot,
        step_count: usize,
        (verifications, steps): (Vec<Audit>, Vec<StepCells>),
    ) -> Result<Self, ViewError> {
        let path_length = plans.iter().map(|(plan, _)| path_length(&plan.waypoints)).sum();
        let durations = plans.iter().map(|(_, timed)| timed.as_ref().map(TaskTrajectory::duration_s));
        let duration_s = durations.sum::<Option<f64>>().unwrap_or(path_length);
        let last = plans.last().map(|(plan, _)| plan);
        Ok(Self {
            name: name.into(),
            planner: last.map(|plan| plan.planner.clone()).unwrap_or_default(),
            outcome: last.map(|plan| plan.outcome),
            path_length,
            path: ShownPath::of_steps(robot, plans, rate_hz(duration_s))?,
            step_count,
            verifications,
            steps,
            // Each step has grasps of its own, which a page does not show.
            failures: Vec::new(),
            search_tree: None,
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
        Ok(Self {
            name: name.into(),
            planner: String::new(),
            outcome: None,
            path_length,
            path: ShownPath::of(robot, waypoints, trajectory, rate_hz(duration_s))?,
            step_count: 1,
            verifications: verification.into_iter().collect(),
            steps: Vec::new(),
            failures: Vec::new(),
            search_tree: None,
        })
    }

    /// Whether all of it holds, by what `verify` says.
    pub fn is_valid(&self) -> bool {
        self.step_count > 0
            && self.verifications.len() == self.step_count
            && self.verifications.iter().all(|v| v.valid)
    }

    /// The grasp that the path ends at: what `verify` finds, not what the file claims. Of several steps each has its own.
    pub fn grasp(&self) -> Option<usize> {
        let is_one = self.is_valid() && self.step_count == 1;
        self.verifications.first().filter(|_| is_one)?.goal.map(|goal| goal.grasp)
    }

    /// One line: what `verify` says.
    pub fn verdict(&self) -> String {
        let of_step = |step: usize| match self.step_count {
            1 => String::new(),
            _ => format!("step {}: ", step + 1),
        };
        let judged = self.verifications.len();
        let failing = self.verifications.iter().enumerate().find(|(_, verification)| !verification.valid);
        if let Some((step, Audit { violations, .. })) = failing {
            let first = violations.first().map(ToString::to_string).unwrap_or_default();
            let more = match violations.len().saturating_sub(1) {
                0 => String::new(),
                count => format!(", and {count} more"),
            };
            return format!("{}not valid: {first}{more}", of_step(step));
        }
        if judged < self.step_count {
            let ended = match self.outcome {
                Some(Outcome::Solved) => "nobody has planned it",
                outcome => outcome.map_or("no way points", Outcome::sentence),
            };
            return format!("{}no path: {ended}", of_step(judged));
        }
        let clearances_m = self.verifications.iter().filter_map(|verification| verification.clearance_m);
        let clearance = clearances_m.reduce(f64::min).map_or_else(String::new, |clearance_m| {
            format!(", {} mm or more from everything, proven", at_least(clearance_m, 1e3, 2))
        });
        let not_checked: Vec<NotChecked> =
            self.verifications.iter().flat_map(|verification| verification.not_checked.clone()).collect();
        let but_for =
            NotChecked::summary(&not_checked).map_or_else(String::new, |pairs| format!(", but for {pairs}"));
        format!("valid{clearance}{but_for}")
    }

    pub(crate) fn entry(&self, cell: &Cell, most_instants: usize) -> PlanEntry {
        let path = self.path.as_ref();
        let row = |pick: fn(&ShownPath) -> &Vec<f64>| {
            number_row::floats64(path.map(pick).into_iter().flatten().copied())
        };
        let configurations = path.into_iter().flat_map(|path| path.configurations.iter().flatten().copied());
        let profile = path.and_then(|path| ClearanceProfile::along(path, cell, &self.steps, most_instants));
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
    carries: Vec<CarryEntry>,
    grasp: Option<usize>,
    clearance: Option<ClearanceRows>,
    blocked: Vec<BlockedGrasp>,
    blocked_counts: Vec<BlockedCount>,
    search_tree: Option<SearchTreeRows>,
}

/// What becomes of an object, as a page reads it.
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
    from_s: f64,
    until_s: f64,
}

impl CarryEntry {
    fn of(carry: &ShownCarry) -> Self {
        let mode = |&ShownMode { mode, from_s, until_s }: &ShownMode| ModeEntry {
            name: mode.name(),
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
