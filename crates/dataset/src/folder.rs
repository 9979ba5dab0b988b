use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use cranny_robot::RobotFiles;
use cranny_scenario::{ScenarioError, write_whole_file, write_whole_folder};
use serde::{Deserialize, Serialize};

use crate::demonstration::Demonstration;
use crate::pictures::Picture;
use crate::recipe::is_built_in;
use crate::scene_row::SceneRow;
use crate::tables::{
    demonstrations_file, pictures_file, read_demonstrations, read_pictures, read_scenes, scenes_file,
};
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

    /// Returns a sentence on the first number that is out of its range.
    fn fault(&self) -> Option<String> {
        let size = self.scenes_per_chunk;
        if !(1..=MOST_SCENES_PER_CHUNK).contains(&size) {
            return Some(format!(
                "`scenes_per_chunk` is {size}, but must be from 1 to {MOST_SCENES_PER_CHUNK}"
            ));
        }
        match self.shard {
            Some(shard) if !shard.is_valid() => Some(format!("there is no shard {shard}")),
            _ => self.recipe.fault(),
        }
    }
}

/// Number of scenes of a chunk: it is the unit of work, and of what a kill loses.
pub(crate) const SCENES_PER_CHUNK: u64 = 64;

/// Maximum number of scenes of a chunk of another version.
const MOST_SCENES_PER_CHUNK: u64 = 1 << 20;

/// Names of the files.
const DESCRIPTION: &str = "dataset.json";
const DEMONSTRATIONS: &str = "demonstrations";
const SCENES: &str = "scenes";
const PICTURES: &str = "pictures";
/// Folder of the files of robots that are not built in.
const ROBOTS: &str = "robots";

/// Folder of a data set: `dataset.json`, and two Parquet files for each chunk of scenes, with pictures three; and the files of robots
/// that are not built in.
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
        if let Some(problem) = description.fault() {
            return Err(fault(problem));
        }
        Ok(Self { path: path.to_owned(), description })
    }

    /// Opens the folder of a data set, or creates it with this description, as a whole or not at all. The robots of its recipe are
    /// named by their paths outside of the folder, and get their place in it.
    ///
    /// # Errors
    /// As [`Self::open`]; [`DatasetError::OtherDataset`] if it holds another one, or anything else.
    pub fn create(path: &Path, description: DatasetDescription) -> Result<Self, DatasetError> {
        let robots = OwnRobots::gather(&description.recipe)?;
        let recipe = description.recipe.with_robots(|path| robots.place_of(path));
        let description = DatasetDescription { recipe, ..description };
        let file = path.join(DESCRIPTION);
        if cranny_file::is_there(&file).map_err(|reason| unreadable(&file, reason))? {
            let there = Self::open(path)?;
            let has_robots = OwnRobots::gather(&there.recipe_at_home())?.has_files_of(&robots);
            let found = &there.description;
            if has_robots && *found == description {
                return Ok(there);
            }
            let other = |of: &DatasetDescription| {
                let shard = of.shard.map_or("a whole data set".to_owned(), |shard| format!("shard {shard}"));
                format!(
                    "{shard} of {} rows, seed {}, version {}",
                    of.recipe.count, of.recipe.seed, of.version
                )
            };
            let (found, expected) = (other(found), other(&description));
            let found = if found == expected { "one of another recipe".to_owned() } else { found };
            return Err(DatasetError::OtherDataset { path: path.to_owned(), found, expected });
        }
        let mut text = serde_json::to_string_pretty(&description).unwrap_or_default();
        text.push('\n');
        write_whole_folder(path, |folder| {
            let pictures = description.recipe.cameras.as_ref().map(|_| PICTURES);
            for part in [DEMONSTRATIONS, SCENES].into_iter().chain(pictures) {
                let part = folder.join(part);
                std::fs::create_dir_all(&part)
                    .map_err(|reason| ScenarioError::Unwritable { path: part, reason })?;
            }
            robots.write(folder)?;
            write_whole_file(&folder.join(DESCRIPTION), text.as_bytes())
        })?;
        Ok(Self { path: path.to_owned(), description })
    }

    /// Returns the recipe with the robots at their places in this folder, from where they can be loaded.
    pub(crate) fn recipe_at_home(&self) -> DatasetRecipe {
        self.recipe().with_robots(|path| self.path.join(path).display().to_string())
    }

    /// Returns true if both folders hold the same files of robots.
    pub(crate) fn has_robots_of(&self, other: &Self) -> Result<bool, DatasetError> {
        let own = OwnRobots::gather(&self.recipe_at_home())?;
        Ok(own.has_files_of(&OwnRobots::gather(&other.recipe_at_home())?))
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

    /// Returns the complete chunks of the folder, by its files: a description may state far more.
    ///
    /// # Errors
    /// [`DatasetError::Unreadable`].
    pub(crate) fn complete_chunks(&self) -> Result<Vec<u64>, DatasetError> {
        let folder = self.path.join(SCENES);
        let failed = |reason| unreadable(&folder, reason);
        let all = self.recipe().scenes().div_ceil(self.description.scenes_per_chunk);
        let shard = self.description.shard.unwrap_or(DatasetShard::WHOLE);
        let mut chunks = Vec::new();
        for entry in std::fs::read_dir(&folder).map_err(failed)? {
            let name = entry.map_err(failed)?.file_name();
            let number: Option<u64> =
                name.to_str().and_then(|name| name.strip_suffix(".parquet")?.parse().ok());
            // Another spelling of the number is another file.
            let number = number.filter(|number| self.files(*number)[1].file_name() == Some(&name));
            if let Some(chunk) = number.filter(|chunk| *chunk < all && shard.has(*chunk))
                && self.has(chunk)?
            {
                chunks.push(chunk);
            }
        }
        chunks.sort_unstable();
        Ok(chunks)
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

    /// Returns the number of rows of a chunk, which are successive.
    pub(crate) fn row_count(&self, chunk: u64) -> u64 {
        let scenes = self.scenes_of(chunk);
        self.rows_of(scenes.end.max(1) - 1).end - self.rows_of(scenes.start).start
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
        for file in self.all_files(chunk) {
            if !cranny_file::is_there(&file).map_err(|reason| unreadable(&file, reason))? {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// Returns the files of a chunk: demonstrations, and scenes.
    pub fn files(&self, chunk: u64) -> [PathBuf; 2] {
        [DEMONSTRATIONS, SCENES].map(|part| self.path.join(part).join(format!("{chunk:06}.parquet")))
    }

    /// Returns the file of the pictures of a chunk; `None` for a data set without cameras.
    pub fn pictures_file(&self, chunk: u64) -> Option<PathBuf> {
        let name = self.path.join(PICTURES).join(format!("{chunk:06}.parquet"));
        self.recipe().cameras.as_ref().map(|_| name)
    }

    /// Returns all files of a chunk, in the order in which they are written.
    pub fn all_files(&self, chunk: u64) -> impl Iterator<Item = PathBuf> + use<> {
        self.pictures_file(chunk).into_iter().chain(self.files(chunk))
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
        pictures: &[Picture],
    ) -> Result<(), DatasetError> {
        let [of_demonstrations, of_scenes] = self.files(chunk);
        if let Some(of_pictures) = self.pictures_file(chunk) {
            write_whole_file(&of_pictures, &pictures_file(pictures))?;
        }
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

    /// Reads the pictures of a chunk; none for a data set without cameras.
    ///
    /// # Errors
    /// [`DatasetError::Content`] for a file that is missing or damaged.
    pub fn read_pictures(&self, chunk: u64) -> Result<Vec<Picture>, DatasetError> {
        self.pictures_file(chunk).map_or(Ok(Vec::new()), |file| read_pictures(&file))
    }
}

/// Files of the robots of a recipe that are not built in.
#[derive(Default)]
struct OwnRobots {
    /// Path of each in the recipe, and its files.
    files: Vec<(PathBuf, RobotFiles)>,
}

impl OwnRobots {
    fn gather(recipe: &DatasetRecipe) -> Result<Self, DatasetError> {
        let mut files = Vec::new();
        for robot in recipe.robots.iter().filter(|robot| !is_built_in(robot)) {
            let path = PathBuf::from(robot);
            files.push((path.clone(), RobotFiles::gather(&path, None, &[])?));
        }
        Ok(Self { files })
    }

    /// Returns the path of the URDF of a robot below the folder of the set.
    fn place_of(&self, path: &Path) -> String {
        let found = self.files.iter().enumerate().find(|(_, (known, _))| known == path);
        let place = |(number, (_, files)): (usize, &(PathBuf, RobotFiles))| {
            format!("{ROBOTS}/{}/{}", number + 1, files.urdf)
        };
        found.map(place).unwrap_or_default()
    }

    fn has_files_of(&self, other: &Self) -> bool {
        self.files.iter().map(|(_, files)| files).eq(other.files.iter().map(|(_, files)| files))
    }

    fn write(&self, folder: &Path) -> Result<(), ScenarioError> {
        for (number, (_, files)) in self.files.iter().enumerate() {
            let folder = folder.join(ROBOTS).join((number + 1).to_string());
            for (name, content) in &files.contents {
                let file = folder.join(name);
                let made = file.parent().map_or(Ok(()), std::fs::create_dir_all);
                made.map_err(|reason| ScenarioError::Unwritable { path: file.clone(), reason })?;
                write_whole_file(&file, content)?;
            }
        }
        Ok(())
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
