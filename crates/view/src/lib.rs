#![doc = include_str!("../README.md")]

mod course;
mod drawing;
mod error;
mod gltf_buffer;
mod gltf_file;
mod gltf_json;
mod look;
mod scene;
mod task_scene;
mod viewer;

/// Licences of Cranny and of all components of its programs, its Python package and the viewer page.
pub const NOTICES: &str = include_str!("../NOTICES.txt");

pub use course::clearance_profile::ClearanceProfile;
pub use course::moving_bodies::{BodyRecording, MovingBody};
pub use course::shown_carry::{CarriedObjectMotion, ShownMode};
pub use course::shown_path::SampledPath;
pub use course::tree_recording::TreeRecording;
pub use cranny_local_server::ServerLimits;
pub use drawing::camera::{Camera, StandardView};
pub use drawing::film_file::Film;
pub use drawing::picture::{Picture, PictureSettings, SeeThrough};
pub use drawing::picture_file::Animation;
pub use error::ViewError;
pub use look::colour::Colour;
pub use look::mesh::{Mesh, MeshPiece};
pub use scene::{Material, Node, Role, Scene, SceneMotion, Track};
pub use task_scene::SceneSettings;
pub use viewer::page::{PageData, PageSettings};
pub use viewer::page_cells::PageCells;
pub use viewer::page_feed::PageFeed;
pub use viewer::page_plan::PagePlan;
pub use viewer::page_server::PageServer;
pub use viewer::page_task::{FailedAlternatives, PageStage, PageTask, StageOutcome};
pub use viewer::watched_search::WatchedSearch;
