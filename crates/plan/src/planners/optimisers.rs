//! Planners that improve a curve of way points: one per file, with their components.

pub(crate) mod chomp;
pub(crate) mod covariant_descent;
pub(crate) mod goal_learner;
pub(crate) mod gomp;
pub(crate) mod omg;
pub(crate) mod quadratic_program;
pub(crate) mod stomp;
pub(crate) mod trajectory_program;
