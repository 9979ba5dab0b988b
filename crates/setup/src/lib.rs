#![doc = include_str!("../README.md")]

mod anatomy;
mod choice;
mod contact_search;
mod draft;
mod error;
mod findings;
mod hand;
mod limits;
mod near_srdf;
mod robot_folder;
mod self_contacts;
mod setup;
mod setup_options;
mod start_choice;
mod xacro;

pub use choice::Choice;
pub use contact_search::SEARCH_SAMPLES;
pub use draft::robot_name;
pub use error::SetupError;
pub use findings::{Finding, RobotFindings};
pub use self_contacts::{SELF_CONTACT_SAMPLES, SelfContact};
pub use setup::RobotSetup;
pub use setup_options::Base;
pub use setup_options::SetupOptions;
pub use xacro::has_xacro;
