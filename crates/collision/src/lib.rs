#![doc = include_str!("../README.md")]

mod batch;
mod body;
mod cell;
mod error;
mod lane;
mod margins;
mod pair;
mod proof;
mod released;
mod touch;

pub use body::extent::Extent;
pub use body::tool_bound::{ToolBound, ToolRegion};
pub use body::world::{Body, Part, World};
pub use cell::{Cell, Scratch};
pub use error::CollisionError;
pub use margins::Margins;
pub use pair::closest::Closest;
pub use pair::demanded_pair::{DemandedOther, DemandedPair};
pub use pair::exempt_pair::{ExemptPair, UncheckedReason};
pub use pair::pair_distance::PairDistance;
pub use pair::pair_group::PairGroup;
pub use proof::bubble::Bubble;
pub use proof::curve::Chords;
pub use proof::levers::Levers;
pub use proof::measured_motion::{MeasureOptions, MeasuredMotion, NearestPair};
pub use proof::motion::Motion;
pub use proof::reach::Reach;
pub use released::{ReleasedCheck, ReleasedScratch};
pub use touch::closing::Closing;
pub use touch::contact::{Collider, Contact};
pub use touch::resting::Resting;
pub use touch::resting_face::CONTACT_ALLOWANCE_M;
pub use touch::standing::StandingClearance;
