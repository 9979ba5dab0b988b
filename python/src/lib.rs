//! Cranny for Python: the same nouns as in Rust, NumPy in and out, no logic of its own.
//!
//! This crate turns arrays into what the rooms below take, and what they give into arrays. Every batch leaves the
//! interpreter to others, shares its rows among as many cores as it is told, and hears Ctrl-C. What a notebook, a
//! data frame or another middleware wants is made of that in Python (`python/cranny`).
//!
//! ## Limits
//! Arrays are read where they lie: one that another thread writes to during a call gives answers about neither
//! its old nor its new values. A search looks for Ctrl-C between its iterations, a batch between blocks of rows.

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
mod moveit_problem;
mod picture;
mod plan;
mod planning;
mod results;
mod robot;
mod scenario;
mod task;
mod trajectory;
mod verification;

/// The licences of Cranny and of all that this package is made of.
#[pyo3::pyfunction]
fn licences() -> &'static str {
    cranny_view::NOTICES
}

/// What the package `cranny` is made of.
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
    use crate::trajectory::{PySamples, restored_samples};
    #[pymodule_export]
    use crate::verification::PyVerification;

    /// The version.
    #[pymodule_export]
    #[allow(non_upper_case_globals, reason = "python's name for it")]
    const __version__: &str = env!("CARGO_PKG_VERSION");
}
