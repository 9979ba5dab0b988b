//! The files and recipes that describe a task, and the files that hold an answer: scenarios of the built-in
//! catalogue, of Cranny's own layout and of the paper's released layout; plans and bare way points.
//!
//! ```
//! use cranny_scenario::{Demands, OpenOptions, Scenario};
//!
//! let scenario = Scenario::open("021", &OpenOptions::default())?;
//! assert_eq!(scenario.grasps.len(), 200);
//! let problem = scenario.problem(&Demands::default())?;
//! # Ok::<(), cranny_scenario::ScenarioError>(())
//! ```
//!
//! Files may place things in a frame of their own, the *scene*; a [`Scenario`] holds everything in the
//! planning frame, the root frame of the robot.
//!
//! ## Limits
//! Of the catalogue, only environment 02 (a ball under a table) is built in. Scenarios in a zip file and
//! `MoveIt` scenes are not read. Meshes of obstacles must be closed; point clouds are no obstacles yet.

mod atomic_file;
mod builtin_robot;
mod catalogue;
mod error;
mod hand;
mod number_table;
mod object_library;
mod own_layout;
mod plan_file;
mod released;
mod robot_file;
mod scenario;
mod scenario_file;
mod waypoints;
mod yaml;

pub use builtin_robot::panda_mobile;
pub use catalogue::{CatalogueEntry, catalogue};
pub use error::ScenarioError;
pub use plan_file::{PlanBudget, PlanFile, PlanMargins};
pub use scenario::{Demands, Geometry, OpenOptions, Scenario};
pub use waypoints::{read_waypoints, write_waypoints_csv};
