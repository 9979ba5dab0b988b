#![doc = include_str!("../README.md")]

#[doc(inline)]
pub use cranny_collision::{Cell, Margins, World};
#[doc(inline)]
pub use cranny_grasp::{Grasp, GraspSet};
#[doc(inline)]
pub use cranny_path::{Audit, Trajectory, audit};
pub use cranny_plan::{Budget, Observer, Outcome, PlanError, PlanReport, Planner, Registry, Unobserved};
#[doc(inline)]
pub use cranny_record::PlanFile;
#[doc(inline)]
pub use cranny_robot::Robot;
pub use cranny_scenario::{OpenOptions, Scenario};
#[doc(inline)]
pub use cranny_solve::{Answer, Request, Timing, solve};
#[doc(inline)]
pub use cranny_spatial::{Pose, Stream};
pub use cranny_task::{Goal, Problem};

#[cfg(feature = "bench")]
pub use cranny_bench as bench;
pub use cranny_certify as certify;
#[cfg(feature = "command")]
pub use cranny_cli as command;
pub use cranny_collision as collision;
pub use cranny_explore as explore;
pub use cranny_grasp as grasp;
pub use cranny_path as path;
pub use cranny_plan as plan;
pub use cranny_record as record;
pub use cranny_robot as robot;
pub use cranny_scenario as scenario;
pub use cranny_sense as sense;
#[cfg(feature = "setup")]
pub use cranny_setup as setup;
pub use cranny_shape as shape;
#[cfg(feature = "sim")]
pub use cranny_sim as sim;
pub use cranny_solve as solve;
pub use cranny_spatial as spatial;
pub use cranny_task as task;
#[cfg(feature = "view")]
pub use cranny_view as view;
