//! Simulated execution of plans.

pub(crate) mod arm;
pub(crate) mod lift;
pub(crate) mod plan_execution;
pub(crate) mod plan_experiment;
pub(crate) mod plan_motion;
pub(crate) mod plan_row;
pub(crate) mod plan_run;
pub(crate) mod plan_test;
pub(crate) mod replanning;
pub(crate) mod simulated_answer;
