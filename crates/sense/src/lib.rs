#![doc = include_str!("../README.md")]

mod camera;
mod cloud;
mod default_cameras;
mod depth_image;
mod error;
mod files;
mod filter;
mod noise;
mod octree;
mod rendering;
mod scene;
mod seen;
mod sensor_model;
mod view;

pub use camera::{Camera, MOST_SIDE_PX};
pub use cloud::message::{CloudField, CloudMessage};
pub use cloud::point_cloud::PointCloud;
pub use cloud::read_cloud::ReadCloud;
pub use cloud::surface_samples::sample_surfaces;
pub use default_cameras::{DefaultCameras, default_cameras};
pub use depth_image::DepthImage;
pub use error::SenseError;
pub use files::camera_file::{CameraFile, PlacedCamera};
pub use files::camera_frame::CameraFrame;
pub use files::depth_format::DepthFormat;
pub use files::views::{NamedFile, StoredView, VIEWS_FILE, Views};
pub use filter::near_solids::{Cleared, robot_solids};
pub use noise::{Noise, noisy};
pub use octree::Octree;
pub use rendering::render::Render;
pub use scene::{Segment, SegmentKind, SensedScene};
pub use seen::known_solids::KnownBody;
pub use seen::occupancy_grid::{Content, OccupancyGrid};
pub use seen::seen_map::{SeenMap, SeenSettings, Unseen};
pub use sensor_model::SensorModel;
pub use view::{View, check_configuration};
