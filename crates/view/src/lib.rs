//! What a task looks like: one scene, from which pictures, animations and glTF files are made without a
//! graphics card or a browser, and a page that shows it in one ([`PageData`], [`PageServer`]).
//!
//! ```
//! use cranny_scenario::{OpenOptions, Scenario};
//! use cranny_view::{Picture, PictureSettings, Scene, SceneSettings, StandardView};
//!
//! let scenario = Scenario::open("021", &OpenOptions::default())?;
//! let scene = Scene::of_task(&scenario, None, &SceneSettings::default())?;
//! let settings = PictureSettings { width: 160, height: 120, ..PictureSettings::default() };
//! let picture = Picture::of(&scene, StandardView::Side, &settings)?;
//! assert_eq!(picture.pixels().len(), 160 * 120);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! A [`Scene`] is plain data in the planning frame. Pictures have the same bytes on every machine.
//!
//! The page itself is built from `web/` and embedded by `build.rs`; what it is told stands in
//! `web/src/page_data.ts`.
//!
//! ## Limits
//! Textures of mesh files are not shown, their diffuse colours are. Light is a sun and a sky: no mirrors, no
//! light from thing to thing. What can be seen through casts no shadow; several such things are laid over each
//! other from the farthest to the nearest by where they stand, which is wrong where they pass through each other.
//! The clearance that a page plots is measured at instants; what lies between them only the verdict says. Fingers
//! close evenly and together, and a hand that carries nothing away stays open. Recordings have one colour a body.

mod camera;
mod clearance_profile;
mod colour;
mod contact_sheet;
mod draw_list;
mod error;
mod framing;
mod gltf_buffer;
mod gltf_file;
mod ground;
mod light;
mod melted_body;
mod mesh;
mod moving_bodies;
mod number_row;
mod page;
mod page_answer;
mod page_bundle;
mod page_cells;
mod page_file;
mod page_grasps;
mod page_plan;
mod page_recording;
mod page_robot;
mod page_scene;
mod page_server;
mod page_token;
mod paint;
mod painter;
mod picture;
mod picture_file;
mod recording_file;
mod robot_look;
mod rounded;
mod sample_buffer;
mod scan;
mod scene;
mod shown_carry;
mod shown_path;
mod stance;
mod stroke;
mod task_scene;
mod tree_recording;
mod verdict;
mod welding;

pub use camera::{Camera, StandardView};
pub use clearance_profile::ClearanceProfile;
pub use colour::Colour;
pub use error::ViewError;
pub use mesh::{Mesh, MeshPiece};
pub use moving_bodies::{BodyRecording, MovingBody};
pub use page::{PageData, PageSettings};
pub use page_cells::PageCells;
pub use page_plan::PagePlan;
pub use page_server::{PageLimits, PageServer, interrupted};
pub use picture::{Picture, PictureSettings, SeeThrough};
pub use picture_file::Animation;
pub use scene::{Material, Node, Role, Scene, SceneMotion, Track};
pub use shown_carry::{ShownCarry, ShownMode};
pub use shown_path::ShownPath;
pub use task_scene::SceneSettings;
pub use tree_recording::TreeRecording;
