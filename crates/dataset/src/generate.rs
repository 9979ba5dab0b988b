use std::collections::BTreeSet;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

use cranny_record::PlanFile;

use crate::card::write_card;
use crate::demonstration::Demonstration;
use crate::folder::{DatasetDescription, DatasetFolder, SCENES_PER_CHUNK};
use crate::pictures::{Picture, pictures};
use crate::prepared_scene::PreparedScene;
use crate::scene_row::SceneRow;
use crate::scene_source::SceneSource;
use crate::{DatasetError, DatasetRecipe, DatasetShard};

/// Progress callback and stop flag.
pub struct GenerateProgress<'a> {
    /// Called with the numbers of rows and of solved rows that were made, from any thread.
    pub done: &'a (dyn Fn(u64, u64) + Sync),
    /// The run ends early when this becomes true, after the scenes that are being made.
    pub stop: &'a AtomicBool,
    /// Number of threads; 0: one for each core.
    pub threads: usize,
}

/// Result of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct GenerateReport {
    /// Number of rows that this run made.
    pub rows: u64,
    /// Number of those that are solved.
    pub solved: u64,
    /// Number of rows that an earlier run had made.
    pub known: u64,
    /// True if all rows of the shard are there.
    pub is_complete: bool,
}

/// Makes a data set, or a shard of one, in a folder; what an earlier run has finished there stays.
///
/// Row `i` is a function of recipe and version alone: scene `i / queries_per_scene` is drawn from its own random stream, and the
/// queries of a scene are answered in order by one thread. Threads take whole chunks of scenes, and each writes its chunk to two
/// files when it is complete, so that memory does not grow and a kill loses unfinished chunks only.
///
/// # Errors
/// [`DatasetError::OtherDataset`]; those of scenes, planners and files.
pub fn generate(
    recipe: &DatasetRecipe,
    shard: Option<DatasetShard>,
    folder: &Path,
    progress: &GenerateProgress,
) -> Result<GenerateReport, DatasetError> {
    let source = SceneSource::new(recipe)?;
    let description = DatasetDescription {
        format: DatasetDescription::FORMAT.to_owned(),
        version: PlanFile::VERSION.to_owned(),
        recipe: recipe.clone(),
        scenes_per_chunk: SCENES_PER_CHUNK,
        joint_names: source.joint_names().into_iter().collect(),
        shard: shard.filter(|shard| *shard != DatasetShard::WHOLE),
    };
    let folder = DatasetFolder::create(folder, description)?;
    let known: BTreeSet<u64> = folder.complete_chunks()?.into_iter().collect();
    let known_rows = known.iter().map(|chunk| folder.row_count(*chunk)).sum();
    let mut report = GenerateReport { known: known_rows, ..GenerateReport::default() };
    (progress.done)(report.known, 0);
    let left = folder.chunks().filter(|chunk| !known.contains(chunk));
    let made = Workers { folder: &folder, source: &source, left: Mutex::new(Box::new(left)), progress };
    let (rows, solved) = made.run()?;
    report.rows = rows;
    report.solved = solved;
    let is_stopped = progress.stop.load(Ordering::Relaxed);
    report.is_complete = !is_stopped || folder.complete_chunks()?.into_iter().eq(folder.chunks());
    if report.is_complete {
        write_card(&folder)?;
    }
    Ok(report)
}

/// Threads that make the chunks of a folder.
struct Workers<'a> {
    folder: &'a DatasetFolder,
    source: &'a SceneSource,
    /// Chunks that no thread has begun.
    left: Mutex<Box<dyn Iterator<Item = u64> + Send + 'a>>,
    progress: &'a GenerateProgress<'a>,
}

impl Workers<'_> {
    /// Makes all chunks, and returns the numbers of rows and of solved rows.
    fn run(&self) -> Result<(u64, u64), DatasetError> {
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        let asked = if self.progress.threads == 0 { cores } else { self.progress.threads };
        let threads = asked.max(1);
        let results = Mutex::new(Vec::new());
        std::thread::scope(|scope| {
            for _ in 0..threads {
                scope.spawn(|| {
                    // The proof of a path must not wait for another thread that takes up a whole chunk meanwhile.
                    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
                    let result = match pool {
                        Ok(pool) => pool.install(|| self.work()),
                        Err(_) => self.work(),
                    };
                    if let Ok(mut results) = results.lock() {
                        results.push(result);
                    }
                });
            }
        });
        let results = results.into_inner().unwrap_or_default();
        results.into_iter().try_fold((0, 0), |(rows, solved), result| {
            result.map(|(more, more_solved)| (rows + more, solved + more_solved))
        })
    }

    /// Makes one chunk after another, until none is left or the run is stopped.
    fn work(&self) -> Result<(u64, u64), DatasetError> {
        let (mut rows, mut solved) = (0, 0);
        while let Some(chunk) = self.next() {
            let Some((made, made_solved)) = self.make(chunk).inspect_err(|_| {
                // The other threads end too.
                *self.left.lock().unwrap_or_else(PoisonError::into_inner) = Box::new(std::iter::empty());
            })?
            else {
                break;
            };
            rows += made;
            solved += made_solved;
        }
        Ok((rows, solved))
    }

    fn next(&self) -> Option<u64> {
        self.left.lock().unwrap_or_else(PoisonError::into_inner).next()
    }

    /// Makes a chunk; `None` if the run was stopped before.
    fn make(&self, chunk: u64) -> Result<Option<(u64, u64)>, DatasetError> {
        let (mut scenes, mut demonstrations): (Vec<SceneRow>, Vec<Demonstration>) = (Vec::new(), Vec::new());
        let mut pictures: Vec<Picture> = Vec::new();
        for scene in self.folder.scenes_of(chunk) {
            if self.progress.stop.load(Ordering::Relaxed) {
                return Ok(None);
            }
            let SceneAnswers { row, rows, pictures: of_scene } =
                answers(self.source, scene, self.folder.rows_of(scene))?;
            let solved = rows.iter().filter(|row| row.is_solved()).count() as u64;
            (self.progress.done)(rows.len() as u64, solved);
            scenes.push(row);
            demonstrations.extend(rows);
            pictures.extend(of_scene);
        }
        self.folder.write(chunk, &scenes, &demonstrations, &pictures)?;
        let solved = demonstrations.iter().filter(|row| row.is_solved()).count() as u64;
        Ok(Some((demonstrations.len() as u64, solved)))
    }
}

/// Rows of one scene.
struct SceneAnswers {
    row: SceneRow,
    rows: Vec<Demonstration>,
    pictures: Vec<Picture>,
}

/// Draws a scene, answers its queries, and takes its pictures.
fn answers(
    source: &SceneSource,
    scene: u64,
    rows: std::ops::Range<u64>,
) -> Result<SceneAnswers, DatasetError> {
    let (row, recipe) = source.draw(scene)?;
    let Some(recipe) = recipe else {
        let without =
            |row| Demonstration { row, scene, outcome: NO_SCENE.to_owned(), ..Demonstration::empty() };
        return Ok(SceneAnswers { row, rows: rows.map(without).collect(), pictures: Vec::new() });
    };
    let cameras = source.recipe().cameras.as_ref();
    let pictures = cameras.map_or(Ok(Vec::new()), |cameras| pictures(cameras, scene, &recipe))?;
    let mut prepared = PreparedScene::new(source, row, &recipe)?;
    let rows: Vec<Demonstration> = rows.map(|row| prepared.answer(row)).collect::<Result<_, _>>()?;
    Ok(SceneAnswers { row: prepared.into_row(), rows, pictures })
}

/// Outcome of the queries of a scene for which no sound draw was found.
pub(crate) const NO_SCENE: &str = "no-scene";
