use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use cranny_scenario::Recipe;
use cranny_spatial::Stream;
use cranny_task::{Carrier, Problem};
use rayon::prelude::*;
use serde::Serialize;

use crate::demonstration::Demonstration;
use crate::figures::Figures;
use crate::folder::{Chunk, DatasetFolder};
use crate::generate::NO_SCENE;
use crate::pictures::{Picture, pictures};
use crate::prepared_scene::{asked, stages_of};
use crate::scene_row::SceneRow;
use crate::scene_source::{SceneSource, problem_of, target_name};
use crate::{DatasetError, DemonstrationTask};

/// Rows that a check proves again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CheckedRows {
    /// All.
    All,
    /// This many, drawn at random from a seed.
    Sample(u64, u64),
}

/// Result of a check.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct CheckReport {
    /// Number of rows that were compared.
    pub checked: u64,
    /// Number of paths that were proven again.
    pub proven: u64,
    /// Faults, by row.
    pub faults: Vec<RowFault>,
    /// True if the check was stopped before its last row.
    pub stopped: bool,
}

/// Fault of a row.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct RowFault {
    /// Index of the row.
    pub row: u64,
    /// The fault, in words.
    pub problem: String,
}

/// Proves the paths of rows again, like those of any other origin, and compares their figures, to the bit: task, seed, grasp, times,
/// length, clearance, load, and the pictures and geometry of their scenes. What would need the search again is not compared: the
/// outcome and reason of a row without a path, the factor of its hold beyond what the recipe demands, and the results at grasps.
/// `done` is called with the number of rows after each scene, from any thread.
///
/// # Errors
/// Damaged files. A false row is a [`RowFault`].
pub fn check(
    folder: &DatasetFolder,
    rows: CheckedRows,
    done: &(dyn Fn(u64) + Sync),
    stop: &AtomicBool,
) -> Result<CheckReport, DatasetError> {
    let source = SceneSource::new(&folder.recipe_at_home())?;
    let chosen = chosen_rows(folder, rows)?;
    let mut report = CheckReport::default();
    for (chunk, rows) in chosen {
        if stop.load(Ordering::Relaxed) {
            report.stopped = true;
            break;
        }
        let Chunk { scenes, demonstrations } = folder.read(chunk)?;
        let taken = folder.read_pictures(chunk)?;
        let mut asked: BTreeMap<u64, Vec<&Demonstration>> = BTreeMap::new();
        for row in
            demonstrations.iter().filter(|row| rows.as_ref().is_none_or(|rows| rows.contains(&row.row)))
        {
            asked.entry(row.scene).or_default().push(row);
        }
        let mut of_scenes: BTreeMap<u64, Vec<&Picture>> = BTreeMap::new();
        for picture in &taken {
            of_scenes.entry(picture.scene).or_default().push(picture);
        }
        let of_scene = |scene: &SceneRow| -> Result<CheckReport, DatasetError> {
            if stop.load(Ordering::Relaxed) {
                return Ok(CheckReport { stopped: true, ..CheckReport::default() });
            }
            let of = |number| asked.get(number).map_or(&[][..], Vec::as_slice);
            let taken = of_scenes.get(&scene.scene).map_or(&[][..], Vec::as_slice);
            let report = check_scene(&source, scene, of(&scene.scene), taken)?;
            done(report.checked);
            Ok(report)
        };
        let reports: Vec<CheckReport> = scenes.par_iter().map(of_scene).collect::<Result<_, _>>()?;
        for CheckReport { checked, proven, faults, stopped } in reports {
            report.stopped |= stopped;
            report.checked += checked;
            report.proven += proven;
            report.faults.extend(faults);
        }
    }
    Ok(report)
}

/// Returns the rows to be checked of each chunk; `None` for all of them.
fn chosen_rows(
    folder: &DatasetFolder,
    rows: CheckedRows,
) -> Result<BTreeMap<u64, Option<BTreeSet<u64>>>, DatasetError> {
    let there = folder.complete_chunks()?;
    if there.is_empty() {
        let problem = "the data set has no complete chunk yet".to_owned();
        return Err(DatasetError::Content { path: folder.path().to_owned(), problem });
    }
    let CheckedRows::Sample(count, seed) = rows else {
        return Ok(there.into_iter().map(|chunk| (chunk, None)).collect());
    };
    let total: u64 = there.iter().map(|chunk| folder.row_count(*chunk)).sum();
    let mut random = Stream::new(seed, 0);
    let mut chosen: BTreeMap<u64, Option<BTreeSet<u64>>> = BTreeMap::new();
    let mut left = count.min(total);
    while left > 0 {
        let chunk = there[random.index(there.len())];
        let begin = folder.rows_of(folder.scenes_of(chunk).start).start;
        let row = begin + random.index(usize::try_from(folder.row_count(chunk)).unwrap_or(usize::MAX)) as u64;
        if chosen.entry(chunk).or_default().get_or_insert_default().insert(row) {
            left -= 1;
        }
    }
    Ok(chosen)
}

fn check_scene(
    source: &SceneSource,
    scene: &SceneRow,
    rows: &[&Demonstration],
    taken: &[&Picture],
) -> Result<CheckReport, DatasetError> {
    let mut report = CheckReport { checked: rows.len() as u64, ..CheckReport::default() };
    if rows.is_empty() {
        return Ok(report);
    }
    let fault = |row: &Demonstration, problem: String| RowFault { row: row.row, problem };
    let rebuilt = source.rebuild(scene).unwrap_or_default();
    let Some(recipe) = rebuilt else {
        let is_sound =
            |row: &&&Demonstration| !scene.is_drawn() && row.outcome == NO_SCENE && row.waypoints.is_empty();
        let false_rows = rows.iter().filter(|row| !is_sound(row));
        report.faults.extend(
            false_rows.map(|row| fault(row, format!("its scene {} cannot be made again", scene.scene))),
        );
        return Ok(report);
    };
    if !scene_figures(scene, &recipe).has_geometry_of(scene) {
        report.faults.extend(rows.iter().map(|row| {
            fault(row, format!("the geometry of its scene {} is not that of its values", scene.scene))
        }));
        return Ok(report);
    }
    let again = source.recipe().cameras.as_ref();
    let again = again.map_or(Ok(Vec::new()), |cameras| pictures(cameras, scene.scene, &recipe))?;
    if !again.iter().eq(taken.iter().copied()) {
        report.faults.extend(rows.iter().map(|row| {
            fault(row, format!("the pictures of its scene {} are not those of its cameras", scene.scene))
        }));
        return Ok(report);
    }
    let mut proof = RowProof {
        source,
        scene: scene.scene,
        problem: problem_of(&recipe, source.recipe().margins())?,
        carrier: None,
    };
    for row in rows {
        let (task, seed, _) = asked(source.recipe(), row.row);
        if row.task != task.name() || row.seed != seed {
            let (task, stated) = (task.name(), &row.task);
            let problem = format!(
                "states task {stated} and seed {}, but the recipe demands {task} and {seed}",
                row.seed
            );
            report.faults.push(fault(row, problem));
            continue;
        }
        match proof.fault_of(row)? {
            Some(problem) => report.faults.push(fault(row, problem)),
            None => report.proven += u64::from(row.is_solved()),
        }
    }
    Ok(report)
}

/// Returns the row of a scene that was made again.
fn scene_figures(scene: &SceneRow, recipe: &Recipe) -> SceneRow {
    let member = cranny_scenario::SetMember {
        recipe: recipe.clone(),
        parameter_m: scene.parameter_m,
        placement: scene.place().unwrap_or(cranny_scenario::Placement { x_m: 0.0, y_m: 0.0, yaw_rad: 0.0 }),
        clutter: scene.clutter_bodies().map_or(0, |bodies| bodies.len()),
    };
    SceneRow::of(scene.scene, &scene.family, &member)
}

/// Proof of the rows of one scene.
pub(crate) struct RowProof<'a> {
    pub source: &'a SceneSource,
    pub scene: u64,
    pub problem: Problem,
    pub carrier: Option<Arc<Carrier>>,
}

impl RowProof<'_> {
    /// Returns the fault of a row; `None` for a true one.
    pub fn fault_of(&mut self, row: &Demonstration) -> Result<Option<String>, DatasetError> {
        if !row.is_solved() {
            let is_bare = row.waypoints.is_empty() && row.grasp == -1;
            return Ok((!is_bare).then(|| "it has a path, but is not solved".to_owned()));
        }
        let Some(task) = DemonstrationTask::of_name(&row.task) else {
            return Ok(Some(format!("'{}' is not a task", row.task)));
        };
        let object = target_name(&self.problem);
        let Some(segments) = row.read_segments(self.problem.robot().dof(), &object) else {
            return Ok(Some("its segments do not fit its way points".to_owned()));
        };
        let Ok(problem) = self.problem.with_start(&row.start) else {
            return Ok(Some("its start is no configuration of the robot".to_owned()));
        };
        let stages = stages_of(task);
        if stages.len() > 1 && self.carrier.is_none() {
            self.carrier = self.source.carrier(self.scene, &problem)?;
        }
        let cell = problem.exact_cell("dataset")?.clone();
        let mut scratch = cell.scratch();
        let figures = match Figures::of(&problem, &stages, &segments, self.carrier.as_ref(), &mut scratch) {
            Ok(Some(figures)) => figures,
            Ok(None) => return Ok(Some("it cannot be proven".to_owned())),
            Err(fault) => return Ok(Some(fault.to_string())),
        };
        if let Some(violation) = figures.audit.violations.first() {
            return Ok(Some(format!("not valid: {violation}")));
        }
        let mut measured = row.clone();
        figures.write(&mut measured);
        if let (true, Some(least)) = (row.hold_checked, self.source.recipe().hold)
            && (row.hold_factor < least || row.hold_factor.is_nan())
        {
            return Ok(Some(format!("its hold has a factor of {}, below {least}", row.hold_factor)));
        }
        Ok(differing(row, &measured)
            .map(|(name, stated, found)| format!("states {name} {stated}, but {found} is measured")))
    }
}

/// Returns the first figure that differs, stated and measured.
fn differing(stated: &Demonstration, measured: &Demonstration) -> Option<(&'static str, String, String)> {
    let same = |a: f64, b: f64| a.total_cmp(&b).is_eq() || (a.is_nan() && b.is_nan());
    let numbers = [
        ("path_length", stated.path_length, measured.path_length),
        ("clearance_m", stated.clearance_m, measured.clearance_m),
        ("duration_s", stated.duration_s, measured.duration_s),
        ("load", stated.load, measured.load),
    ];
    let number = numbers.into_iter().find(|(_, a, b)| !same(*a, *b));
    let number = number.map(|(name, a, b)| (name, a.to_string(), b.to_string()));
    let grasp = (stated.grasp != measured.grasp)
        .then(|| ("grasp", stated.grasp.to_string(), measured.grasp.to_string()));
    let lists = [
        ("times_s", &stated.times_s, &measured.times_s),
        ("grasp_pose", &stated.grasp_pose, &measured.grasp_pose),
    ];
    let list = lists
        .into_iter()
        .find(|(_, a, b)| a.len() != b.len() || a.iter().zip(*b).any(|(a, b)| !same(*a, *b)));
    let list = list.map(|(name, a, b)| (name, format!("{a:?}"), format!("{b:?}")));
    number.or(grasp).or(list)
}
