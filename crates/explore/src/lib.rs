#![doc = include_str!("../README.md")]

mod blockage;
mod choice;
mod error;
mod exploration;
mod fixed_view;
mod given_path;
mod hand_view;
mod next_view;
mod prediction;
mod prospect;
mod swept_cells;
mod true_scene;
mod worlds;

pub use blockage::{Blockage, Candidate, find_blockage};
pub use error::ExploreError;
pub use exploration::{ExploreSettings, Explored, ViewReport, explore};
pub use fixed_view::next_fixed_view;
pub use hand_view::next_hand_view;
pub use next_view::{CameraKind, NextView};
pub use swept_cells::{FirstMeeting, MetCell, swept_cells};
pub use true_scene::true_contact;
