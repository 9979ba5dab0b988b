use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use cranny_collision::Cell;
use cranny_plan::{MotionLimits, PlanError, Problem, TimingMethod, Trajectory, Validity};
use cranny_scenario::write_trajectory_csv;

use crate::arguments::{Output, PlanArguments};
use crate::failure::Failure;
use crate::file_kind::FileKind;
use crate::output_file;

/// Whether and how a path is given its time.
pub struct Timing {
    limits: Result<MotionLimits, PlanError>,
    /// What proves cut corners, if they are asked for.
    blend_in: Option<Arc<Cell>>,
}

/// A path with its time, and how many seconds it took to find it.
pub struct Timed {
    pub trajectory: Trajectory,
    pub timing_time_s: f64,
}

impl Timing {
    /// A robot without the limits is refused where a flag asks for the trajectory; otherwise the plan has
    /// none, and says why.
    pub fn new(arguments: &PlanArguments, problem: &Problem) -> Result<Self, Failure> {
        let method =
            if arguments.jerk_limited { TimingMethod::JerkLimited } else { TimingMethod::TimeOptimal };
        let blend_in = match &problem.validity {
            _ if !arguments.blend => None,
            Validity::Exact(cell) => Some(cell.clone()),
            Validity::Paper { .. } => {
                let problem = "only under the exact criterion is a cut corner proven".to_owned();
                return Err(Failure::Flag { flag: "blend", problem });
            }
        };
        let is_demanded = arguments.rate.is_some() || arguments.jerk_limited || arguments.blend;
        match MotionLimits::of(&problem.robot, method) {
            Err(fault) if is_demanded => Err(fault.into()),
            limits => Ok(Self { limits, blend_in }),
        }
    }

    pub fn time(&self, path: &[Vec<f64>]) -> Result<Option<Timed>, Failure> {
        let Ok(limits) = &self.limits else { return Ok(None) };
        let begin = Instant::now();
        let trajectory = match &self.blend_in {
            Some(cell) => Trajectory::blended(path, limits, cell)?,
            None => Trajectory::along(path, limits)?,
        };
        Ok(Some(Timed { trajectory, timing_time_s: begin.elapsed().as_secs_f64() }))
    }

    /// Why no path can be timed.
    pub fn hindrance(&self) -> Option<String> {
        self.limits.as_ref().err().map(ToString::to_string)
    }
}

impl Timed {
    /// Writes the samples beside the plan, if a rate was asked for, and returns where.
    pub fn write(
        &self,
        arguments: &PlanArguments,
        plan_file: &Path,
        output: Output,
    ) -> Result<Option<PathBuf>, Failure> {
        let Some(rate_hz) = arguments.rate else { return Ok(None) };
        let file = trajectory_file(plan_file);
        output_file::check(&file, FileKind::Trajectory, output)?;
        write_trajectory_csv(&file, &self.trajectory, rate_hz)?;
        Ok(Some(file))
    }
}

/// Where the samples of a plan go: `021.plan.json` → `021.trajectory.csv`.
pub fn trajectory_file(plan_file: &Path) -> PathBuf {
    let name = plan_file.file_name().unwrap_or_default().to_string_lossy();
    let stem = name.strip_suffix(".json").unwrap_or(&name);
    let stem = stem.strip_suffix(".plan").unwrap_or(stem);
    plan_file.with_file_name(format!("{stem}.trajectory.csv"))
}
