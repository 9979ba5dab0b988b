//! Export in the layout of LeRobot v3.
//!
//! Source: huggingface/lerobot, `src/lerobot/datasets`, commit 7427f31, the parts on the files of a data set.

#![allow(
    clippy::cast_possible_truncation,
    clippy::cast_possible_wrap,
    clippy::cast_sign_loss,
    reason = "counts are far below 2^31, and single precision is the precision of the format"
)]

use std::collections::BTreeMap;
use std::path::Path;

use cranny_robot::Robot;
use cranny_scenario::{RecipeRobot, write_whole_file};
use cranny_solve::{TaskTrajectory, Timing};
use serde_json::{Value, json};

use crate::DatasetError;
use crate::demonstration::Demonstration;
use crate::folder::{Chunk, DatasetFolder};
use crate::parquet::column::Column;
use crate::parquet::writer::parquet_file;
use crate::scene_row::SceneRow;

/// Result of an export.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LeRobotReport {
    /// Number of episodes, one for each solved row.
    pub episodes: u64,
    /// Number of frames.
    pub frames: u64,
}

/// Frames of a file of data: about 40 MB, less than the 100 MB that the layout allows.
const FRAMES_PER_FILE: usize = 200_000;
/// Files of a folder.
const FILES_PER_CHUNK: u64 = 1000;
/// Values of a feature that are kept for quantiles.
const KEPT_VALUES: usize = 1 << 15;
/// Quantiles of the statistics.
const QUANTILES: [(&str, f64); 5] = [("q01", 0.01), ("q10", 0.1), ("q50", 0.5), ("q90", 0.9), ("q99", 0.99)];
/// Names of the features.
const STATE: &str = "observation.state";
const ACTION: &str = "action";
const ENVIRONMENT: &str = "observation.environment_state";

/// Writes the solved rows of a data set into a new folder in the layout of LeRobot v3: an episode for each, sampled at a rate.
/// The state is the joints and the distance of the fingers, the action the state of the next frame. `done` is called after
/// each chunk.
///
/// # Errors
/// [`DatasetError::Export`] for a data set of several robots, of one without limits of acceleration, or without solved rows.
pub fn export_lerobot(
    folder: &DatasetFolder,
    rate_hz: f64,
    into: &Path,
    done: &mut dyn FnMut(),
) -> Result<LeRobotReport, DatasetError> {
    let fault =
        |problem: &str| DatasetError::Export { path: folder.path().to_owned(), problem: problem.to_owned() };
    let recipe = folder.recipe_at_home();
    let [name] = &recipe.robots[..] else {
        return Err(fault("its rows are of several robots, but this layout holds those of one"));
    };
    let robot = RecipeRobot::load(Path::new(name))?.robot;
    if Timing::default().limits(&robot).is_err() {
        return Err(fault("its robot has no limits of acceleration, so its paths have no times"));
    }
    cranny_scenario::check_free_folder(into)?;
    let mut export = Export {
        into,
        robot: &robot,
        rate_hz,
        frames: Frames::default(),
        episodes: Episodes::default(),
        tasks: BTreeMap::new(),
        statistics: [STATE, ACTION, ENVIRONMENT].map(|name| (name, FeatureStatistics::default())),
        report: LeRobotReport::default(),
        file: 0,
    };
    for chunk in folder.complete_chunks()? {
        let Chunk { scenes, demonstrations } = folder.read(chunk)?;
        let scenes: BTreeMap<u64, &SceneRow> = scenes.iter().map(|scene| (scene.scene, scene)).collect();
        for row in demonstrations.iter().filter(|row| row.is_solved()) {
            if let Some(scene) = scenes.get(&row.scene) {
                export.add(row, scene)?;
            }
        }
        done();
    }
    if export.report.episodes == 0 {
        return Err(fault("it has no solved rows"));
    }
    export.finish()
}

struct Export<'a> {
    into: &'a Path,
    robot: &'a Robot,
    rate_hz: f64,
    frames: Frames,
    episodes: Episodes,
    tasks: BTreeMap<String, i64>,
    statistics: [(&'static str, FeatureStatistics); 3],
    report: LeRobotReport,
    file: u64,
}

/// Rows of a file of data that is not yet written.
#[derive(Default)]
struct Frames {
    state: Vec<Vec<f32>>,
    action: Vec<Vec<f32>>,
    environment: Vec<Vec<f32>>,
    timestamp: Vec<f32>,
    frame: Vec<i64>,
    episode: Vec<i64>,
    index: Vec<i64>,
    task: Vec<i64>,
}

/// Rows of the file of episodes.
#[derive(Default)]
struct Episodes {
    tasks: Vec<Vec<String>>,
    length: Vec<i64>,
    file: Vec<u64>,
    from: Vec<i64>,
    to: Vec<i64>,
    row: Vec<i64>,
}

/// Maximum number of frames of an episode: more than any motion has, which a row with false speeds could demand.
const MOST_FRAMES: usize = 1_000_000;

impl Export<'_> {
    fn add(&mut self, row: &Demonstration, scene: &SceneRow) -> Result<(), DatasetError> {
        let fault = |problem: &str| DatasetError::Row {
            path: self.into.to_owned(),
            row: row.row,
            problem: problem.to_owned(),
        };
        let segments =
            row.read_segments(self.robot.dof(), "object").ok_or_else(|| fault("has damaged segments"))?;
        let timing = Timing { stops: true, ..Timing::default() };
        let trajectory = TaskTrajectory::of(timing, self.robot, &segments)?;
        let trajectory = trajectory.ok_or_else(|| fault("has no trajectory"))?;
        let open_m = self.robot.hand().map_or(0.0, |hand| hand.description.opening_m);
        let duration_s = trajectory.duration_s();
        let last = (duration_s * self.rate_hz).ceil().max(0.0) as usize;
        if last > MOST_FRAMES {
            return Err(fault("has more than a million frames"));
        }
        let state = |frame: usize| -> Vec<f32> {
            let time_s = (frame as f64 / self.rate_hz).min(duration_s);
            let opening_m = trajectory.opening_m(time_s).unwrap_or(open_m);
            let values = trajectory.sample(time_s).position.into_iter().chain([opening_m]);
            values.map(|value| value as f32).collect()
        };
        let states: Vec<Vec<f32>> = (0..=last).map(state).collect();
        let environment: Vec<f32> = scene.target_pose.iter().map(|value| *value as f32).collect();
        let sentence = sentence(&row.task, &scene.family);
        let next = self.tasks.len() as i64;
        let task = *self.tasks.entry(sentence.clone()).or_insert(next);
        let episode = self.report.episodes.cast_signed();
        let first = self.report.frames.cast_signed();
        for (frame, state) in states.iter().enumerate() {
            let action = states.get(frame + 1).unwrap_or(state);
            for ((_, statistics), values) in self.statistics.iter_mut().zip([state, action, &environment]) {
                statistics.add(values);
            }
            self.frames.state.push(state.clone());
            self.frames.action.push(action.clone());
            self.frames.environment.push(environment.clone());
            self.frames.timestamp.push((frame as f64 / self.rate_hz) as f32);
            self.frames.frame.push(frame as i64);
            self.frames.episode.push(episode);
            self.frames.index.push(first + frame as i64);
            self.frames.task.push(task);
        }
        self.report.frames += states.len() as u64;
        self.report.episodes += 1;
        self.episodes.tasks.push(vec![sentence]);
        self.episodes.length.push(states.len() as i64);
        self.episodes.file.push(self.file);
        self.episodes.from.push(first);
        self.episodes.to.push(first + states.len() as i64);
        self.episodes.row.push(row.row.cast_signed());
        if self.frames.index.len() >= FRAMES_PER_FILE {
            self.write_frames()?;
        }
        Ok(())
    }

    fn write_frames(&mut self) -> Result<(), DatasetError> {
        let Frames { state, action, environment, timestamp, frame, episode, index, task } =
            std::mem::take(&mut self.frames);
        let columns = [
            (STATE, Column::Floats(state)),
            (ACTION, Column::Floats(action)),
            (ENVIRONMENT, Column::Floats(environment)),
            ("timestamp", Column::Float(timestamp)),
            ("frame_index", Column::Int64(frame)),
            ("episode_index", Column::Int64(episode)),
            ("index", Column::Int64(index)),
            ("task_index", Column::Int64(task)),
        ];
        let [chunk, file] = [self.file / FILES_PER_CHUNK, self.file % FILES_PER_CHUNK];
        self.write(&format!("data/chunk-{chunk:03}/file-{file:03}.parquet"), &parquet_file(&columns, &[]))?;
        self.file += 1;
        Ok(())
    }

    fn write(&self, name: &str, content: &[u8]) -> Result<(), DatasetError> {
        let path = self.into.join(name);
        if let Some(parent) = path.parent() {
            std::fs::create_dir_all(parent).map_err(|reason| cranny_scenario::ScenarioError::Unwritable {
                path: parent.to_owned(),
                reason,
            })?;
        }
        Ok(write_whole_file(&path, content)?)
    }

    fn finish(mut self) -> Result<LeRobotReport, DatasetError> {
        if !self.frames.index.is_empty() {
            self.write_frames()?;
        }
        let Episodes { tasks, length, file, from, to, row } = std::mem::take(&mut self.episodes);
        let count = length.len();
        let part = |of: fn(u64) -> u64| file.iter().map(|file| of(*file).cast_signed()).collect();
        let columns = [
            ("episode_index", Column::Int64((0..count as i64).collect())),
            ("tasks", Column::Texts(tasks)),
            ("length", Column::Int64(length)),
            ("data/chunk_index", Column::Int64(part(|file| file / FILES_PER_CHUNK))),
            ("data/file_index", Column::Int64(part(|file| file % FILES_PER_CHUNK))),
            ("dataset_from_index", Column::Int64(from)),
            ("dataset_to_index", Column::Int64(to)),
            ("meta/episodes/chunk_index", Column::Int64(vec![0; count])),
            ("meta/episodes/file_index", Column::Int64(vec![0; count])),
            ("cranny/row", Column::Int64(row)),
        ];
        self.write("meta/episodes/chunk-000/file-000.parquet", &parquet_file(&columns, &[]))?;
        let mut tasks: Vec<(&String, &i64)> = self.tasks.iter().collect();
        tasks.sort_by_key(|(_, index)| **index);
        let columns = [
            ("task_index", Column::Int64(tasks.iter().map(|(_, index)| **index).collect())),
            ("task", Column::Text(tasks.iter().map(|(task, _)| (*task).clone()).collect())),
        ];
        // The loader takes the text of a task from the index of a data frame.
        let pandas = json!({"index_columns": ["task"], "column_indexes": [], "columns": [
            {"name": "task_index", "field_name": "task_index", "pandas_type": "int64", "numpy_type": "int64", "metadata": null},
            {"name": "task", "field_name": "task", "pandas_type": "unicode", "numpy_type": "object", "metadata": null}
        ], "pandas_version": "2.0.0"});
        self.write("meta/tasks.parquet", &parquet_file(&columns, &[("pandas", &pandas.to_string())]))?;
        let info = self.info();
        self.write("meta/info.json", text(&info).as_bytes())?;
        let statistics: serde_json::Map<String, Value> =
            self.statistics.iter().map(|(name, of)| ((*name).to_owned(), of.value())).collect();
        self.write("meta/stats.json", text(&Value::Object(statistics)).as_bytes())?;
        Ok(self.report)
    }

    fn info(&self) -> Value {
        let joints: Vec<String> =
            self.robot.joint_names().iter().cloned().chain(["finger_distance_m".to_owned()]).collect();
        let list = |names: Value, count: usize| json!({"dtype": "float32", "shape": [count], "names": names});
        let single = |dtype: &str| json!({"dtype": dtype, "shape": [1], "names": null});
        let pose = json!(["x", "y", "z", "qw", "qx", "qy", "qz"]);
        json!({
            "codebase_version": "v3.0",
            "robot_type": self.robot.name(),
            "total_episodes": self.report.episodes,
            "total_frames": self.report.frames,
            "total_tasks": self.tasks.len(),
            "chunks_size": FILES_PER_CHUNK,
            "data_files_size_in_mb": 100,
            "video_files_size_in_mb": 200,
            "fps": if self.rate_hz.fract().total_cmp(&0.0).is_eq() { json!(self.rate_hz as u64) } else { json!(self.rate_hz) },
            "splits": {"train": format!("0:{}", self.report.episodes)},
            "data_path": "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet",
            "video_path": null,
            "features": {
                STATE: list(json!(joints), joints.len()),
                ACTION: list(json!(joints), joints.len()),
                ENVIRONMENT: list(pose, 7),
                "timestamp": single("float32"),
                "frame_index": single("int64"),
                "episode_index": single("int64"),
                "index": single("int64"),
                "task_index": single("int64"),
            },
        })
    }
}

fn text(value: &Value) -> String {
    let mut text = serde_json::to_string_pretty(value).unwrap_or_default();
    text.push('\n');
    text
}

fn sentence(task: &str, family: &str) -> String {
    let place = match family {
        "shelf" => "in the shelf",
        "table" => "under the table",
        "gap" => "behind the gap",
        "gate" => "behind the gate",
        other => other,
    };
    match task {
        "carry" => format!("grasp the object {place} and carry it back"),
        "place" => format!("grasp the object {place} and put it down outside"),
        _ => format!("reach a grasp of the object {place}"),
    }
}

/// Statistics of a feature, per element.
#[derive(Default)]
struct FeatureStatistics {
    count: u64,
    mean: Vec<f64>,
    /// Sums of squared differences from the mean.
    squares: Vec<f64>,
    least: Vec<f64>,
    greatest: Vec<f64>,
    /// Every `2ⁿ`-th row, for quantiles.
    kept: Vec<Vec<f32>>,
    halvings: u32,
}

impl FeatureStatistics {
    /// Adds a row, by Welford's update.
    fn add(&mut self, values: &[f32]) {
        if self.count == 0 {
            let values: Vec<f64> = values.iter().map(|value| f64::from(*value)).collect();
            (self.mean, self.squares) = (vec![0.0; values.len()], vec![0.0; values.len()]);
            (self.least, self.greatest) = (values.clone(), values);
        }
        if self.count.trailing_zeros() >= self.halvings {
            self.kept.push(values.to_vec());
            if self.kept.len() > KEPT_VALUES {
                let mut at = 0;
                self.kept.retain(|_| {
                    at += 1;
                    at % 2 == 1
                });
                self.halvings += 1;
            }
        }
        self.count += 1;
        for (element, value) in values.iter().enumerate().take(self.mean.len()) {
            let value = f64::from(*value);
            let before = value - self.mean[element];
            self.mean[element] += before / self.count as f64;
            self.squares[element] += before * (value - self.mean[element]);
            self.least[element] = self.least[element].min(value);
            self.greatest[element] = self.greatest[element].max(value);
        }
    }

    fn value(&self) -> Value {
        let deviation: Vec<f64> =
            self.squares.iter().map(|squares| (squares / self.count.max(1) as f64).sqrt()).collect();
        let mut value = json!({
            "min": self.least, "max": self.greatest, "mean": self.mean, "std": deviation, "count": [self.count],
        });
        for (name, share) in QUANTILES {
            let of_element = |element: usize| {
                let mut values: Vec<f32> =
                    self.kept.iter().filter_map(|row| row.get(element).copied()).collect();
                values.sort_by(f32::total_cmp);
                let place = (share * values.len().saturating_sub(1) as f64).round() as usize;
                values.get(place).copied().unwrap_or(f32::NAN)
            };
            value[name] = json!((0..self.mean.len()).map(of_element).collect::<Vec<f32>>());
        }
        value
    }
}
