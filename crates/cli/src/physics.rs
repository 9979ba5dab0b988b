//! `cranny simulate`: grasps and plans in physics.

pub(crate) mod load_prediction;
pub(crate) mod recording;
pub(crate) mod simulate;
pub(crate) mod simulate_export;
pub(crate) mod simulate_grasps;
pub(crate) mod simulate_plan;
pub(crate) mod simulate_results;
pub(crate) mod simulate_settle;
pub(crate) mod simulate_subject;
