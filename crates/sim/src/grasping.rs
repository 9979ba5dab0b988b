//! Simulated tests of grasps.

pub(crate) mod disturbance;
pub(crate) mod experiment;
pub(crate) mod grasp_rows;
pub(crate) mod grasp_run;
pub(crate) mod grasp_test;
pub(crate) mod grasp_trial;
pub(crate) mod mjcf;
pub(crate) mod shake_test_check;
