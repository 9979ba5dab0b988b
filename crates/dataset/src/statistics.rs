use std::collections::BTreeMap;
use std::path::PathBuf;

use serde::Serialize;

use crate::DatasetError;
use crate::demonstration::Demonstration;
use crate::folder::{Chunk, DatasetFolder};
use crate::prepared_scene::GRASP_RESULTS;

/// Statistics of a data set.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct DatasetStatistics {
    /// Number of scenes.
    pub scenes: u64,
    /// Number of rows.
    pub rows: u64,
    /// Number of rows with a proven path.
    pub solved: u64,
    /// Numbers of rows, and of solved ones, by family and task.
    pub kinds: BTreeMap<String, BTreeMap<String, Solved>>,
    /// Numbers of rows by outcome.
    pub outcomes: BTreeMap<String, u64>,
    /// Numbers of grasps of all scenes by result ([`GRASP_RESULTS`]).
    pub grasps: BTreeMap<String, u64>,
    /// Way points of solved rows.
    pub way_points: Spread,
    /// Length of their paths (m and rad alike).
    pub path_length: Spread,
    /// Duration of their trajectories, in seconds.
    pub duration_s: Spread,
    /// Clearance along their paths, in metres.
    pub clearance_m: Spread,
    /// Size of all rows on disk, in bytes, without pictures.
    pub bytes: u64,
    /// Size of all pictures on disk, in bytes.
    pub picture_bytes: u64,
}

/// Number of rows, and of those with a proven path.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Solved {
    /// Number of rows.
    pub rows: u64,
    /// Number of rows with a proven path.
    pub solved: u64,
}

/// Least, mean and greatest of finite values.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Spread {
    /// Number of values.
    pub count: u64,
    /// Least value.
    pub least: f64,
    /// Mean value.
    pub mean: f64,
    /// Greatest value.
    pub greatest: f64,
}

impl Spread {
    fn add(&mut self, value: f64) {
        if !value.is_finite() {
            return;
        }
        self.count += 1;
        self.mean += (value - self.mean) / self.count as f64;
        self.least = if self.count == 1 { value } else { self.least.min(value) };
        self.greatest = if self.count == 1 { value } else { self.greatest.max(value) };
    }
}

impl DatasetStatistics {
    /// Reads all chunks of a data set that are there; `done` is called after each.
    ///
    /// # Errors
    /// As [`DatasetFolder::read`].
    pub fn of(folder: &DatasetFolder, done: &mut dyn FnMut()) -> Result<Self, DatasetError> {
        let mut statistics = Self::default();
        for chunk in folder.complete_chunks()? {
            statistics.add(folder, &folder.read(chunk)?);
            let size = |file: &PathBuf| {
                let found = std::fs::metadata(file);
                let found = found.map_err(|reason| DatasetError::Unreadable { path: file.clone(), reason });
                Ok::<u64, DatasetError>(found?.len())
            };
            for file in folder.files(chunk) {
                statistics.bytes += size(&file)?;
            }
            if let Some(file) = folder.pictures_file(chunk) {
                statistics.picture_bytes += size(&file)?;
            }
            done();
        }
        Ok(statistics)
    }

    fn add(&mut self, folder: &DatasetFolder, Chunk { scenes, demonstrations }: &Chunk) {
        let mut families = BTreeMap::new();
        for scene in scenes {
            self.scenes += 1;
            families.insert(scene.scene, scene.family.clone());
            for result in &scene.grasp_results {
                let name = GRASP_RESULTS.get(usize::from(*result)).copied().unwrap_or("other");
                *self.grasps.entry(name.to_owned()).or_default() += 1;
            }
        }
        let dof = |row: &Demonstration| row.start.len().max(1) as f64;
        for row in demonstrations {
            self.rows += 1;
            *self.outcomes.entry(row.outcome.clone()).or_default() += 1;
            let family = families.get(&folder.place_of(row.row).1).cloned().unwrap_or_default();
            let kind = self.kinds.entry(family).or_default().entry(row.task.clone()).or_default();
            kind.rows += 1;
            if row.is_solved() {
                kind.solved += 1;
                self.solved += 1;
                self.way_points.add(row.waypoints.len() as f64 / dof(row));
                self.path_length.add(row.path_length);
                self.duration_s.add(row.duration_s);
                self.clearance_m.add(row.clearance_m);
            }
        }
    }
}
