#![doc = include_str!("../README.md")]

mod betterment;
mod error;
mod file;
mod judgement;
mod moveit_planner;
mod moveit_response;
mod old_formats;
mod plan_attempt;
mod plan_options;
mod plan_pick;
mod planned_task;
mod reading;
mod speed_options;
mod statement;
mod timing;
mod trajectory;
mod trajectory_csv;
mod waypoints;

pub use betterment::{PlanOptimisation, PlanShortening};
pub use error::RecordError;
pub use file::{PlanBudget, PlanFile, PlanSource};
pub use judgement::{Demanded, Judgement};
pub use moveit_planner::{MoveItPlanner, MoveItSettings};
pub use plan_attempt::{LeftOut, PlanAttempt};
pub use plan_options::{CarryGoal, PlanOptions, TaskSelection, default_grasp_margin_m, margins_forgiving};
pub use plan_pick::PlanPick;
pub use speed_options::{SpeedOption, SpeedOptions};
pub use statement::Statement;
pub use timing::PlanTiming;
pub use trajectory_csv::write_trajectory_csv;
pub use waypoints::{read_waypoints, write_waypoints_csv};
