//! A robot of one's own: from a URDF to its hand, limits, unchecked pairs and start, and the folder that keeps them.
//!
//! [`RobotSetup::of`] never asks: it chooses, and says what, why, and how to choose otherwise ([`Choice`]).
//!
//! ## Limits
//! Hands that close towards a middle: two fingers or more that come together, or one jaw that closes on a part that stands.
//! Suction cups and tools have no grasps here. What is measured, is measured on collision geometry; a mesh counts as its
//! hull.

mod anatomy;
mod choice;
mod draft;
mod error;
mod findings;
mod grip_place;
mod hand_guess;
mod limits;
mod near_srdf;
mod palm;
mod posture;
mod robot_folder;
mod self_contacts;
mod setup;
mod start_choice;
mod xacro;

pub use choice::Choice;
pub use error::SetupError;
pub use findings::{Finding, RobotFindings};
pub use self_contacts::{SELF_CONTACT_SAMPLES, SelfContact};
pub use setup::{Base, RobotSetup, SetupOptions};
