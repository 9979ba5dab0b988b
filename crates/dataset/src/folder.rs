use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use cranny_scenario::write_whole_file;
use serde::{Deserialize, Serialize};

use crate::demonstration::Demonstration;
use crate::scene_row::SceneRow;
use crate::tables::{demonstrations_file, read_demonstrations, read_scenes, scenes_file};
use crate::{DatasetError, DatasetRecipe, DatasetShard};

/// Description of a data set in its folder, `dataset.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DatasetDescription {
    /// [`DatasetDescription::FORMAT`].
    pub format: String,
    /// Version of Cranny: with another one, the same recipe gives other rows.
    pub version: String,
    /// Recipe of the whole data set.
    pub recipe: DatasetRecipe,
    /// Number of scenes of a chunk.
    pub scenes_per_chunk: u64,
    /// Names of the joints of each robot, in the order of every configuration.
    pub joint_names: BTreeMap<String, Vec<String>>,
    /// Shard in this folder, unless it holds the whole data set.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shard: Option<DatasetShard>,
}

impl DatasetDescription {
    /// Format that this program reads and writes.
    pub const FORMAT: &str = "cranny-dataset/1";
}

/// Number of scenes of a chunk: it is the unit of work, and of what a kill loses.
pub(crate) const SCENES_PER_CHUNK: u64 = 64;

/// Names of the files.
const DESCRIPTION: &str = "dataset.json";
const DEMONSTRATIONS: &str = "demonstrations";
const SCENES: &str = "scenes";

/// Folder of a data set: `dataset.json`, and two Parquet files for each chunk of scenes.
///
/// A chunk is written when it is complete, each file as a whole or not at all, the one of its scenes last: a chunk without it
/// was interrupted, and is made again.
#[derive(Clone, Debug)]
pub struct DatasetFolder {
    path: PathBuf,
    description: DatasetDescription,
}

impl DatasetFolder {
    /// Opens the folder of a data set.
    ///
    /// # Errors
    /// [`DatasetError::Unreadable`]; [`DatasetError::Content`] for another folder, format or version.
    pub fn open(path: &Path) -> Result<Self, DatasetError> {
        let file = path.join(DESCRIPTION);
        let fault = |problem: String| DatasetError::Content { path: file.clone(), problem };
        if !cranny_file::is_there(&file).map_err(|reason| unreadable(&file, reason))? {
            let problem = "no data set: expected a folder written by `cranny dataset generate`".to_owned();
            return Err(DatasetError::Content { path: path.to_owned(), problem });
        }
        let text = cranny_file::TEXT.text(&file).map_err(|reason| unreadable(&file, reason))?;
        let description: DatasetDescription = cranny_file::json(text.as_bytes()).map_err(|fault| {
            DatasetError::Recipe { path: file.clone(), line: fault.line as u64, problem: fault.problem }
        })?;
        if description.format != DatasetDescription::FORMAT {
            let (found, known) = (&description.format, DatasetDescription::FORMAT);
            return Err(fault(format!(
                "the data set has the format '{found}', but this version reads '{known}'"
            )));
        }
        if description.scenes_per_chunk == 0 || description.recipe.queries_per_scene == 0 {
            return Err(fault("a chunk without scenes, or a scene without queries".to_owned()));
        }
        Ok(Self { path: path.to_owned(), description })
    }

    /// Opens the folder of a data set, or creates it with this description.
    ///
    /// # Errors
    /// As [`Self::open`]; [`DatasetError::OtherDataset`] if it holds another one, or anything else.
    pub fn create(path: &Path, description: DatasetDescription) -> Result<Self, DatasetError> {
        let file = path.join(DESCRIPTION);
        if cranny_file::is_there(&file).map_err(|reason| unreadable(&file, reason))? {
            let found = Self::open(path)?.description;
            if found == description {
                return Ok(Self { path: path.to_owned(), description });
            }
            let other = |of: &DatasetDescription| {
                let shard = of.shard.map_or("a whole data set".to_owned(), |shard| format!("shard {shard}"));
                format!(
                    "{shard} of {} rows, seed {}, version {}",
                    of.recipe.count, of.recipe.seed, of.version
                )
            };
            let (found, expected) = (other(&found), other(&description));
            let found = if found == expected { "one of another recipe".to_owned() } else { found };
            return Err(DatasetError::OtherDataset { path: path.to_owned(), found, expected });
        }
        cranny_scenario::check_free_folder(path)?;
        for part in [DEMONSTRATIONS, SCENES] {
            let folder = path.join(part);
            std::fs::create_dir_all(&folder).map_err(|reason| {
                cranny_scenario::ScenarioError::Unwritable { path: folder.clone(), reason }
            })?;
        }
        let mut text = serde_json::to_string_pretty(&description).unwrap_or_default();
        text.push('\n');
        write_whole_file(&file, text.as_bytes())?;
        Ok(Self { path: path.to_owned(), description })
    }

    /// Path of the folder.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Its description.
    pub fn description(&self) -> &DatasetDescription {
        &self.description
    }

    /// Its recipe.
    pub fn recipe(&self) -> &DatasetRecipe {
        &self.description.recipe
    }

    /// Returns the indices of the chunks that belong in this folder.
    pub fn chunks(&self) -> impl Iterator<Item = u64> + use<> {
        let all = self.recipe().scenes().div_ceil(self.description.scenes_per_chunk);
        let shard = self.description.shard.unwrap_or(DatasetShard::WHOLE);
        (0..all).filter(move |chunk| shard.has(*chunk))
    }

    /// Returns the scenes of a chunk.
    pub fn scenes_of(&self, chunk: u64) -> std::ops::Range<u64> {
        let size = self.description.scenes_per_chunk;
        chunk * size..((chunk + 1) * size).min(self.recipe().scenes())
    }

    /// Returns the rows of a scene.
    pub fn rows_of(&self, scene: u64) -> std::ops::Range<u64> {
        let size = self.recipe().queries_per_scene;
        scene * size..((scene + 1) * size).min(self.recipe().count)
    }

    /// Returns the chunk and the scene of a row.
    pub fn place_of(&self, row: u64) -> (u64, u64) {
        let scene = row / self.recipe().queries_per_scene;
        (scene / self.description.scenes_per_chunk, scene)
    }

    /// Returns true if a chunk is complete.
    ///
    /// # Errors
    /// [`DatasetError::Unreadable`].
    pub fn has(&self, chunk: u64) -> Result<bool, DatasetError> {
        let [demonstrations, scenes] = self.files(chunk);
        let is_there = |file: &Path| cranny_file::is_there(file).map_err(|reason| unreadable(file, reason));
        Ok(is_there(&scenes)? && is_there(&demonstrations)?)
    }

    /// Returns the files of a chunk: demonstrations, and scenes.
    pub fn files(&self, chunk: u64) -> [PathBuf; 2] {
        [DEMONSTRATIONS, SCENES].map(|part| self.path.join(part).join(format!("{chunk:06}.parquet")))
    }

    /// Writes a chunk.
    ///
    /// # Errors
    /// [`ScenarioError::Unwritable`](cranny_scenario::ScenarioError::Unwritable).
    pub(crate) fn write(
        &self,
        chunk: u64,
        scenes: &[SceneRow],
        demonstrations: &[Demonstration],
    ) -> Result<(), DatasetError> {
        let [of_demonstrations, of_scenes] = self.files(chunk);
        write_whole_file(&of_demonstrations, &demonstrations_file(demonstrations))?;
        Ok(write_whole_file(&of_scenes, &scenes_file(scenes))?)
    }

    /// Reads a chunk.
    ///
    /// # Errors
    /// [`DatasetError::Content`] for a file that is missing or damaged, or of other rows.
    pub fn read(&self, chunk: u64) -> Result<Chunk, DatasetError> {
        let [of_demonstrations, of_scenes] = self.files(chunk);
        let (demonstrations, scenes) = (read_demonstrations(&of_demonstrations)?, read_scenes(&of_scenes)?);
        let expected = self.scenes_of(chunk);
        if !scenes.iter().map(|row| row.scene).eq(expected.clone()) {
            let problem =
                format!("the file does not hold the scenes from {} to {}", expected.start, expected.end - 1);
            return Err(DatasetError::Content { path: of_scenes, problem });
        }
        let rows = expected.flat_map(|scene| self.rows_of(scene).map(move |row| (row, scene)));
        if !demonstrations.iter().map(|row| (row.row, row.scene)).eq(rows) {
            let problem = "the file does not hold the rows of its scenes, each once and in order".to_owned();
            return Err(DatasetError::Content { path: of_demonstrations, problem });
        }
        Ok(Chunk { scenes, demonstrations })
    }
}

/// Rows of a chunk.
#[derive(Clone, Debug, PartialEq)]
pub struct Chunk {
    /// Its scenes, in order.
    pub scenes: Vec<SceneRow>,
    /// Their demonstrations, in order.
    pub demonstrations: Vec<Demonstration>,
}

fn unreadable(path: &Path, reason: std::io::Error) -> DatasetError {
    DatasetError::Unreadable { path: path.to_owned(), reason }
}
