//! Plan files, way points and trajectories.

pub(crate) mod betterment;
pub(crate) mod error;
pub(crate) mod file;
pub(crate) mod judgement;
pub(crate) mod old_formats;
pub(crate) mod planned_task;
pub(crate) mod reading;
pub(crate) mod statement;
pub(crate) mod timing;
pub(crate) mod trajectory;
pub(crate) mod trajectory_csv;
pub(crate) mod waypoints;
