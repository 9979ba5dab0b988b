//! Cranny for Python: the nouns of the Rust crates, NumPy arrays as inputs and outputs, no logic of its own.
//!
//! This crate converts between arrays and the types of the other crates. Every batch releases the GIL, distributes its rows
//! over the given number of cores, and responds to Ctrl-C. Integrations with notebooks, data frames and other middleware are
//! written in Python (`python/cranny`).
//!
//! ## Limits
//! Arrays are read without a copy: if another thread writes to one during a call, results match neither its old nor its new
//! values. A search checks for Ctrl-C between its iterations, a batch between blocks of rows.

#![allow(
    clippy::doc_markdown,
    reason = "doc comments of what is exported are help texts of Python, which show marks as they are"
)]
#![allow(
    clippy::needless_pass_by_value,
    reason = "what Python hands over is a value, whatever becomes of it"
)]

mod body;
mod campaign;
mod cell;
mod classes;
mod fingerprint;
mod grasping;
mod handover;
mod live_page;
mod moveit;
mod picture;
mod plan;
mod planning;
mod results;
mod robot;
mod scenario;
mod sensing;
mod task;
mod trajectory;
mod verification;

/// Returns the licences of Cranny and of all components of this package.
#[pyo3::pyfunction]
fn licences() -> &'static str {
    cranny_view::NOTICES
}

/// Contents of the package `cranny`.
#[pyo3::pymodule]
mod _cranny {
    #[pymodule_export]
    use super::licences;
    #[pymodule_export]
    use crate::campaign::{run_campaign, serve_trials};
    #[pymodule_export]
    use crate::classes::{PyBody, PyCell, PyMoveItProblem, PyPlan, PyRobot, PyScenario};
    #[pymodule_export]
    use crate::fingerprint::restored;
    #[pymodule_export]
    use crate::grasping::contact::{PyContact, PyMotion, restored_contact, restored_motion};
    #[pymodule_export]
    use crate::grasping::grasp_sampling::sample_grasps;
    #[pymodule_export]
    use crate::grasping::grasp_set::{PyGrasps, restored_grasps};
    #[pymodule_export]
    use crate::grasping::simulation::{grasp_experiment, plan_experiment, simulate_grasps, simulate_plan};
    #[pymodule_export]
    use crate::handover::fault::CrannyError;
    #[pymodule_export]
    use crate::handover::file_limits::lift_file_limits;
    #[pymodule_export]
    use crate::live_page::PyLivePage;
    #[pymodule_export]
    use crate::moveit::planner::PyMoveItPlanner;
    #[pymodule_export]
    use crate::picture::{moving_picture, page, picture};
    #[pymodule_export]
    use crate::plan::restored_plan;
    #[pymodule_export]
    use crate::planning::{plan, planner_names, verify_path};
    #[pymodule_export]
    use crate::results::PyResultsFile;
    #[pymodule_export]
    use crate::scenario::scenario_ids;
    #[pymodule_export]
    use crate::sensing::cloud::{filter_cloud, points_of_message};
    #[pymodule_export]
    use crate::sensing::depth_view::PyDepthView;
    #[pymodule_export]
    use crate::sensing::seen::with_views;
    #[pymodule_export]
    use crate::trajectory::{PySamples, restored_samples};
    #[pymodule_export]
    use crate::verification::PyVerification;

    /// Version of the package.
    #[pymodule_export]
    #[allow(non_upper_case_globals, reason = "python's name for it")]
    const __version__: &str = env!("CARGO_PKG_VERSION");
}
