//! Sets of scenarios on disk: a folder for each scenario, and `index.csv`.

use std::fmt::Write as _;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;

use crate::{
    Placement, Rejections, ScenarioError, SetMaker, SetMember, write_whole_file, write_whole_folder,
};

/// Result of writing a set.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SetReport {
    /// Names of the folders that were written, in order.
    pub written: Vec<String>,
    /// Rejected draws.
    pub rejected: Rejections,
    /// Number of members that were given up because hardly any draw was sound or because the set was stopped.
    pub missing: usize,
}

/// Progress callback and stop flag of a set.
pub struct SetProgress<'a> {
    /// Called once for each finished member, from any thread.
    pub done: &'a (dyn Fn() + Sync),
    /// The set ends early when this becomes true.
    pub stop: &'a AtomicBool,
}

/// Line of the index.
struct Line {
    id: String,
    parameter_m: f64,
    placement: Placement,
    clutter: usize,
    grasps: usize,
}

/// Writes `count` random scenarios below the new `folder` as `<family>-<index>`, the same with any number of threads.
///
/// # Errors
/// [`ScenarioError::Exists`], [`ScenarioError::Unwritable`].
pub fn write_set(
    maker: &SetMaker,
    folder: &Path,
    count: u64,
    progress: &SetProgress,
) -> Result<SetReport, ScenarioError> {
    let name = maker.family().family.name();
    let indices: Vec<u64> = (0..count).collect();
    let member = |folder: &Path, index: &u64| -> Result<(Option<Line>, Rejections), ScenarioError> {
        let (member, rejected) = maker.member(*index)?;
        let line = member.map(|member| written(folder, format!("{name}-{index:05}"), member)).transpose()?;
        Ok((line, rejected))
    };
    write_whole_folder(folder, |folder| {
        maker.write_robot(folder)?;
        write_all(folder, &indices, member, progress)
    })
}

/// Writes `steps` scenarios with parameter values (m) from `from_m` to `to_m`, both included, and with the object placed as in
/// the paper, below `folder`, which must not exist, as `<family>-<value>`.
///
/// # Errors
/// [`FamilyError::Parameter`](crate::FamilyError::Parameter) for a value outside the range of the parameter,
/// [`ScenarioError::Exists`], [`ScenarioError::Unwritable`].
pub fn write_sweep(
    maker: &SetMaker,
    folder: &Path,
    [from_m, to_m]: [f64; 2],
    steps: usize,
    progress: &SetProgress,
) -> Result<SetReport, ScenarioError> {
    let family = maker.family().family;
    let scale = maker.family().scale();
    family.checked(from_m, &scale)?;
    family.checked(to_m, &scale)?;
    let share = |step: usize| if steps > 1 { step as f64 / (steps - 1) as f64 } else { 0.0 };
    let values: Vec<f64> = (0..steps).map(|step| from_m + (to_m - from_m) * share(step)).collect();
    let member = |folder: &Path, parameter_m: &f64| -> Result<(Option<Line>, Rejections), ScenarioError> {
        let recipe = maker.family().at(*parameter_m)?;
        if let Some(rejection) = maker.rejection(&recipe)? {
            return Ok((None, rejection));
        }
        let placement = maker.family().paper_placement(*parameter_m);
        let member = SetMember { recipe, parameter_m: *parameter_m, placement, clutter: 0 };
        Ok((
            Some(written(folder, format!("{}-{parameter_m:.4}", family.name()), member)?),
            Rejections::default(),
        ))
    };
    write_whole_folder(folder, |folder| {
        maker.write_robot(folder)?;
        write_all(folder, &values, member, progress)
    })
}

fn written(folder: &Path, id: String, member: SetMember) -> Result<Line, ScenarioError> {
    let SetMember { recipe, parameter_m, placement, clutter } = member;
    recipe.write_folder(&folder.join(&id))?;
    Ok(Line { id, parameter_m, placement, clutter, grasps: recipe.grasps.len() })
}

fn write_all<T: Sync>(
    folder: &Path,
    what: &[T],
    member: impl Fn(&Path, &T) -> Result<(Option<Line>, Rejections), ScenarioError> + Sync,
    progress: &SetProgress,
) -> Result<SetReport, ScenarioError> {
    let one = |what: &T| {
        if progress.stop.load(Ordering::Relaxed) {
            return Ok((None, Rejections::default()));
        }
        let done = member(folder, what);
        (progress.done)();
        done
    };
    let members: Vec<(Option<Line>, Rejections)> = what.par_iter().map(one).collect::<Result<_, _>>()?;
    let mut report = SetReport::default();
    let mut index = String::from("id,parameter_m,x_m,y_m,yaw_deg,clutter,grasps\n");
    for (line, rejected) in members {
        report.rejected = report.rejected.plus(rejected);
        let Some(Line { id, parameter_m, placement, clutter, grasps }) = line else {
            report.missing += 1;
            continue;
        };
        let Placement { x_m, y_m, yaw_rad } = placement;
        let yaw_deg = yaw_rad.to_degrees();
        let _ = writeln!(index, "{id},{parameter_m},{x_m},{y_m},{yaw_deg},{clutter},{grasps}");
        report.written.push(id);
    }
    write_whole_file(&folder.join("index.csv"), index.as_bytes())?;
    Ok(report)
}
