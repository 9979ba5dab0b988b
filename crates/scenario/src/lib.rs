//! The files and recipes that describe a task, and the files that hold an answer: scenarios of the built-in
//! catalogue, of Cranny's own layout and of the paper's released layout, and recipes that make them; `MoveIt` scenes and requests; plans and
//! bare way points.
//!
//! ```
//! use cranny_collision::Margins;
//! use cranny_scenario::{OpenOptions, Scenario};
//!
//! let scenario = Scenario::open("021", &OpenOptions::default())?;
//! assert_eq!(scenario.grasps.len(), 200);
//! let problem = scenario.problem(Margins::default())?;
//! # Ok::<(), cranny_scenario::ScenarioError>(())
//! ```
//!
//! Files may place things in a frame of their own, the *scene*; a [`Scenario`] holds everything in the
//! planning frame, the root frame of the robot.
//!
//! ## Limits
//! Under `paper`, the start of 044 and 045 touches the gate: the boxes around the built-in robot's links are larger
//! than the released ones (`--robot` takes those). Meshes of obstacles must be
//! closed; point clouds are no obstacles yet. Of `MoveIt` requests, goals in
//! joint space alone are read, and a scene's allowed collision matrix lifts no check that the SRDF does not. What
//! overlapping shapes of a target share counts for each of them where it is weighed.

mod alteration;
mod archive;
mod archive_contents;
mod atomic_file;
mod builtin_object;
mod builtin_robot;
mod catalogue;
mod error;
mod error_words;
mod family;
mod family_scenario;
mod given_grasps;
mod grasp_array;
mod gripper_file;
mod hand;
mod identity;
mod inspection;
mod mesh_repairs;
mod moveit;
mod moveit_export;
mod moveit_file;
mod moveit_request;
mod moveit_robot;
mod moveit_world;
mod number_table;
mod object;
mod object_filter;
mod object_folder;
mod object_library;
mod object_source;
mod obstacle;
mod own_export;
mod own_layout;
mod plan_betterment;
mod plan_file;
mod plan_segment;
mod plan_trajectory;
mod recipe;
mod recipe_file;
mod recipe_robot;
mod released;
mod released_export;
mod robot_file;
mod robot_in_folder;
mod scenario;
mod scenario_file;
mod scenario_set;
mod scenario_set_file;
mod scene_scale;
mod schema;
mod short_arm;
mod sizes;
mod target_object;
mod template;
mod trajectory_file;
mod waypoints;
mod yaml;

pub use archive::{Credits, pack, unpack};
pub use atomic_file::{check_free_folder, check_writable, write_whole_file, write_whole_folder};
pub use builtin_object::{builtin_object, builtin_object_names};
pub use builtin_robot::{BUILTIN_ROBOTS, BuiltinRobot, MountedGripper, panda_hand, panda_mobile};
pub use catalogue::{CatalogueEntry, catalogue};
pub use error::ScenarioError;
pub use family::{Family, Placement};
pub use family_scenario::{FamilyMaker, GraspChoice};
pub use given_grasps::GivenGrasps;
pub use gripper_file::read_gripper;
pub use hand::FilledHand;
pub use identity::Identity;
pub use inspection::{check, check_folder};
pub use mesh_repairs::mesh_repairs;
pub use moveit::{MoveItDeviation, MoveItOptions, MoveItProblem};
pub use moveit_export::{moveit_scene_text, read_moveit_scene, write_moveit_scene};
pub use object::{DEFAULT_FRICTION, ObjectSettings, ObjectType};
pub use object_filter::filter_around_object;
pub use object_folder::{OBJECT_FILE, RestingPose};
pub use object_source::ObjectSource;
pub use obstacle::Obstacle;
pub use plan_betterment::{PlanOptimisation, PlanShortening};
pub use plan_file::{PlanBudget, PlanFile, PlanSource};
pub use plan_segment::PlanSegment;
pub use plan_trajectory::PlanTiming;
pub use recipe::{Recipe, RecipeBody, RecipeShape};
pub use recipe_robot::{RecipeRobot, RobotSource};
pub use scenario::{Geometry, OpenOptions, Scenario, is_scenario};
pub use scenario_set::{Rejections, SetMaker, SetMember, SetSettings};
pub use scenario_set_file::{SetProgress, SetReport, write_set, write_sweep};
pub use scene_scale::SceneScale;
pub use schema::SchemaFile;
pub use target_object::{TargetObject, TargetPhysics};
pub use template::{TemplateRobot, write_template};
pub use trajectory_file::write_trajectory_csv;
pub use waypoints::{read_waypoints, write_waypoints_csv};
