//! Grasps: where a gripper would be, how good that is, how far one grasp is from another, how they are
//! sampled on a bare object, and the files that hold sets of them.
//!
//! The **gripper frame** has its origin between the finger pads, y along the axis on which the fingers close,
//! z out of the palm, the approach direction. A parallel gripper turned by 180° about z is the same grasp.
//!
//! ## Limits
//! Parallel grippers only, two point contacts with friction; torque about the line between the contacts is
//! not resisted. Contacts are those of one triangle each; pads do not bend around an edge. Whether hand and
//! fingers fit around the object is asked in `plan`.

mod contact;
mod error;
mod file;
mod grasp;
mod hand;
mod homogeneous;
mod metric;
mod robust_score;
mod sampler;
mod score_kind;
mod subset;
mod twins;

pub use contact::{Contact, friction_needed, friction_score};
pub use error::GraspError;
pub use file::{check_csv, csv_text, parse_csv, read_csv, write_csv};
pub use grasp::{Grasp, GraspSet};
pub use hand::{BoxHand, Finger, Hand};
pub use homogeneous::{pose_of_rows, rows_of_pose};
pub use metric::{COVERAGE_THRESHOLD, Spread, coverage, grasp_distance, nearest_distances, spread};
pub use robust_score::RobustScore;
pub use sampler::{FirstApproach, GraspSampler, SampledGrasp, SamplerSettings, Sampling, sample_grasps};
pub use score_kind::ScoreKind;
pub use subset::{covering_subset, farthest_subset, random_subset};
