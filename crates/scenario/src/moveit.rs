//! Problems of MoveIt and `MotionBenchMaker`: scene, request and robot.

pub(crate) mod error;
pub(crate) mod export;
pub(crate) mod file;
pub(crate) mod problem;
pub(crate) mod request;
pub(crate) mod robot;
pub(crate) mod world;
