#![doc = include_str!("../README.md")]

mod card;
mod check;
mod demonstration;
mod error;
mod extract;
mod figures;
mod folder;
mod generate;
mod lerobot;
mod merge;
mod parquet;
mod prepared_scene;
mod recipe;
mod recipe_file;
mod scene_row;
mod scene_source;
mod shard;
mod statistics;
mod tables;

pub use card::statistics_lines;
pub use check::{CheckReport, CheckedRows, RowFault, check};
pub use demonstration::{Demonstration, MODES};
pub use error::DatasetError;
pub use extract::{PLAN_FILE, extract};
pub use figures::KEPT_SHARE;
pub use folder::{Chunk, DatasetDescription, DatasetFolder};
pub use generate::{GenerateProgress, GenerateReport, generate};
pub use lerobot::{LeRobotReport, export_lerobot};
pub use merge::merge;
pub use prepared_scene::GRASP_RESULTS;
pub use recipe::{DatasetRecipe, DemonstrationTask, FamilyRange};
pub use scene_row::SceneRow;
pub use scene_source::SceneSource;
pub use shard::DatasetShard;
pub use statistics::{DatasetStatistics, Solved, Spread};
