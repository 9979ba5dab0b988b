//! Sets of scenarios on disk: a folder for each scenario, and `index.csv`.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;
use sha2::{Digest as _, Sha256};

use crate::family::unfinished_set::{FORMAT, Finished, Line, UnfinishedSet};
use crate::layout::archive::hexadecimal;
use crate::{Rejections, ScenarioError, SetMaker, SetMember, check_free_folder};

/// Result of writing a set.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SetReport {
    /// Names of the folders that were written, in order.
    pub written: Vec<String>,
    /// Rejected draws.
    pub rejected: Rejections,
    /// Number of members that were given up because hardly any draw was sound or because the set was stopped.
    pub missing: usize,
    /// Folder of the finished members if the set was stopped; the same call resumes there.
    pub unfinished: Option<PathBuf>,
}

/// Progress callback and stop flag of a set.
pub struct SetProgress<'a> {
    /// Called once for each finished member, from any thread.
    pub done: &'a (dyn Fn() + Sync),
    /// The set ends early when this becomes true.
    pub stop: &'a AtomicBool,
}

/// Writes `count` random scenarios below the new `folder` as `<family>-<index>`, the same with any number of threads.
///
/// The set is made beside `folder`, in `<folder>.unfinished-<number>`, and renamed when it is complete; without any sound
/// scenario, nothing is written. If it is stopped or the program is killed, the finished scenarios stay there, and the same call
/// resumes from them.
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
    let member = |index: &u64| {
        let (member, rejected) = maker.member(*index)?;
        Ok((member.map(|member| (format!("{name}-{index:05}"), member)), rejected))
    };
    write_all(maker, folder, &indices, &member, progress)
}

/// Writes `steps` scenarios with parameter values (m) from `from_m` to `to_m`, both included, and with the object placed as in
/// the paper, below `folder`, which must not exist, as `<family>-<value>`. Stopped and resumed like [`write_set`].
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
    let member = |parameter_m: &f64| {
        let recipe = maker.family().at(*parameter_m)?;
        if let Some(rejection) = maker.rejection(&recipe)? {
            return Ok((None, rejection));
        }
        let placement = maker.family().paper_placement(*parameter_m);
        let member = SetMember { recipe, parameter_m: *parameter_m, placement, clutter: 0 };
        Ok((Some((format!("{}-{parameter_m:.4}", family.name()), member)), Rejections::default()))
    };
    write_all(maker, folder, &values, &member, progress)
}

/// Function that makes a member, with its name, and counts the rejected draws.
type MakeMember<'a, T> =
    dyn Fn(&T) -> Result<(Option<(String, SetMember)>, Rejections), ScenarioError> + Sync + 'a;

fn write_all<T: Sync + std::fmt::Debug>(
    maker: &SetMaker,
    place: &Path,
    what: &[T],
    member: &MakeMember<T>,
    progress: &SetProgress,
) -> Result<SetReport, ScenarioError> {
    let identity = identity(maker, what);
    check_free_folder(place).inspect_err(|_| UnfinishedSet::remove_rest(place, &identity))?;
    let set = UnfinishedSet::open(place, &identity)?;
    let one = |(number, what): (usize, &T)| -> Result<Option<Finished>, ScenarioError> {
        if let Some(finished) = set.finished(number) {
            (progress.done)();
            return Ok(Some(finished));
        }
        if progress.stop.load(Ordering::Relaxed) {
            return Ok(None);
        }
        let (member, rejected) = member(what)?;
        let line = member.map(|(id, member)| written(&set, id, member)).transpose()?;
        let finished = Finished { number, line, rejected };
        set.add(&finished)?;
        (progress.done)();
        Ok(Some(finished))
    };
    let make = || -> Result<Vec<Option<Finished>>, ScenarioError> {
        maker.write_robot(&set.content())?;
        what.par_iter().enumerate().map(one).collect()
    };
    let members = match make() {
        Ok(members) => members,
        Err(fault) => {
            set.keep();
            return Err(fault);
        }
    };
    let is_whole = members.iter().all(Option::is_some);
    let mut report = SetReport::default();
    let mut index = String::from("id,parameter_m,x_m,y_m,yaw_deg,clutter,grasps\n");
    for finished in members {
        let Finished { line, rejected, .. } = finished.unwrap_or_default();
        report.rejected = report.rejected.plus(rejected);
        let Some(Line { id, parameter_m, x_m, y_m, yaw_rad, clutter, grasps }) = line else {
            report.missing += 1;
            continue;
        };
        let yaw_deg = yaw_rad.to_degrees();
        let _ = writeln!(index, "{id},{parameter_m},{x_m},{y_m},{yaw_deg},{clutter},{grasps}");
        report.written.push(id);
    }
    if !is_whole {
        report.unfinished = set.keep();
    } else if report.written.is_empty() {
        set.remove();
    } else {
        set.complete(place, &index)?;
    }
    Ok(report)
}

fn written(set: &UnfinishedSet, id: String, member: SetMember) -> Result<Line, ScenarioError> {
    let SetMember { recipe, parameter_m, placement, clutter } = member;
    recipe.write_folder(&set.free_folder(&id)?)?;
    let (x_m, y_m, yaw_rad) = (placement.x_m, placement.y_m, placement.yaw_rad);
    Ok(Line { id, parameter_m, x_m, y_m, yaw_rad, clutter, grasps: recipe.grasps.len() })
}

/// Returns the SHA-256 of everything that a set depends on: version, family, settings, robot with its files, and its members.
fn identity<T: std::fmt::Debug>(maker: &SetMaker, members: &[T]) -> String {
    let mut sum = Sha256::new();
    let mut add = |bytes: &[u8]| {
        sum.update(bytes.len().to_le_bytes());
        sum.update(bytes);
    };
    let robot = maker.family().robot();
    let ends = [members.first(), members.last()];
    let settings = format!("{:?} {} {ends:?}", maker.settings(), members.len());
    let texts = [
        FORMAT,
        env!("CARGO_PKG_VERSION"),
        maker.family().family.name(),
        &settings,
        &robot.named,
        robot.robot.name(),
    ];
    for text in texts {
        add(text.as_bytes());
    }
    for (name, content) in maker.files().iter().flat_map(|files| &files.contents) {
        add(name.as_bytes());
        add(content);
    }
    hexadecimal(&sum.finalize())
}
