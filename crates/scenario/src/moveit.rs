//! Problems of MoveIt and `MotionBenchMaker`: scene, request and robot.

pub(crate) mod base;
pub(crate) mod deviation;
pub(crate) mod error;
pub(crate) mod export;
pub(crate) mod file;
pub(crate) mod form;
pub(crate) mod frames;
pub(crate) mod matrix;
pub(crate) mod message_file;
pub(crate) mod octomap;
pub(crate) mod path_constraints;
pub(crate) mod problem;
pub(crate) mod request;
pub(crate) mod robot;
pub(crate) mod robot_model;
pub(crate) mod scene_text;
pub(crate) mod world;
