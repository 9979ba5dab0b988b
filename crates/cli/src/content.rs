//! `cranny scenario`, `object`, `robot`, `grasps`, `info` and `list`: the inputs of planning.

pub(crate) mod dataset;
pub(crate) mod dataset_check;
pub(crate) mod dataset_export;
pub(crate) mod dataset_generate;
pub(crate) mod grasp_choice;
pub(crate) mod grasp_loads;
pub(crate) mod grasp_subject;
pub(crate) mod grasps;
pub(crate) mod grasps_import;
pub(crate) mod info;
pub(crate) mod list;
pub(crate) mod object;
pub(crate) mod robot;
pub(crate) mod scenario;
pub(crate) mod scenario_check;
pub(crate) mod scenario_from;
