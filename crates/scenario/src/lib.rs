#![doc = include_str!("../README.md")]

mod alteration;
mod catalogue;
mod doubts;
mod error;
mod family;
mod files;
mod given_grasps;
mod layout;
mod moveit;
mod named_task;
mod object;
mod obstacle;
mod robot;
mod scenario;
mod schema;
mod sensing;
mod stated_speed;

pub use catalogue::{BuiltInTask, CatalogueEntry, built_in, catalogue, insertions, sequences};
pub use doubts::{brief_model_notes, model_notes, seen_only_links, wide_opening};
pub use error::ScenarioError;
pub use family::error::FamilyError;
pub use family::kind::{Family, Placement};
pub use family::maker::{FamilyMaker, GraspChoice};
pub use family::scene_scale::SceneScale;
pub use family::set::{ArmDemand, ReachTest, Rejections, SetMaker, SetMember, SetSettings};
pub use family::set_file::{SetProgress, SetReport, write_set, write_sweep};
pub use files::atomic_file::{
    check_free_folder, check_writable, put_in_place, write_whole_file, write_whole_file_by,
    write_whole_folder,
};
pub use files::number_table::read_configurations;
pub use files::staging_folder::StagingFolder;
pub use files::temporary::{Temporary, exit_without_temporaries};
pub use given_grasps::GivenGrasps;
pub use layout::archive::{Credits, pack, unpack};
pub use layout::identity::Identity;
pub use layout::inspection::{check, check_folder};
pub use layout::model_world::WorldConversion;
pub use layout::open::is_scenario;
pub use layout::recipe::{Recipe, RecipeBody, RecipeShape};
pub use layout::recipe_file::configurations_text;
pub use layout::template::{TemplateRobot, write_template};
pub use moveit::deviation::MoveItDeviation;
pub use moveit::error::MoveItError;
pub use moveit::export::{moveit_scene_text, read_moveit_scene, write_moveit_scene};
pub use moveit::problem::{MoveItOptions, MoveItProblem, moveit_document};
pub use moveit::robot_model::MoveItRobot;
pub use named_task::{NamedTask, STEPS};
pub use object::builtin::{builtin_object, builtin_object_names};
pub use object::error::ObjectError;
pub use object::filter::filter_around_object;
pub use object::folder::{OBJECT_FILE, RestingPose};
pub use object::mesh_repairs::{link_repairs, mesh_repairs};
pub use object::object_type::{DEFAULT_FRICTION, ObjectSettings, ObjectType, PAPER_FRICTION};
pub use object::physics::TargetPhysics;
pub use object::source::ObjectSource;
pub use object::target::TargetObject;
pub use obstacle::Obstacle;
pub use robot::builtin::{BUILTIN_ROBOTS, BuiltinRobot, MountedGripper, panda_hand, panda_mobile};
pub use robot::gripper_file::read_gripper;
pub use robot::hand::BlockedGripperFrame;
pub use robot::opening::measured_opening_m;
pub use robot::source::{RecipeRobot, RobotSource};
pub use scenario::{BodyColours, Geometry, OpenOptions, Scenario};
pub use schema::SchemaFile;
pub use stated_speed::StatedSpeed;
