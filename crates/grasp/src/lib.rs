#![doc = include_str!("../README.md")]

mod contact;
mod csv_columns;
mod csv_header;
mod error;
mod file;
mod grasp;
mod hand;
mod homogeneous;
mod import;
mod load;
mod metric;
mod robust_score;
mod sampler;
mod score_kind;
mod subset;
mod too_wide;
mod twins;

pub use contact::{Contact, friction_needed, friction_score};
pub use error::GraspError;
pub use file::{check_csv, csv_text, parse_csv, read_csv};
pub use grasp::{Grasp, GraspSet};
pub use hand::{BoxHand, Finger, Hand, PadRectangle};
pub use homogeneous::{pose_of_rows, rows_of_pose};
pub use import::format::{ClosingAxis, FRANKA_PADS_M, FRANKA_TIPS_TO_PADS_M, GraspFormat, ImportSettings};
pub use import::{Imported, import_grasps};
pub use load::between::CELLS as PAD_CELLS;
pub use load::limit_surface::{LoadedPoint, limit_factor};
pub use load::load_state::LoadState;
pub use load::measure::{ASSUMED_DENSITY, ASSUMED_FRICTION, GripForces, HeldObject, Load, LoadMeasure};
pub use load::pads::Pads;
pub use load::patch::LEAST_ARM_M;
pub use load::seat::SOFT_PAD;
pub use load::shake_test::{ShakeTest, smooth_share};
pub use metric::{COVERAGE_THRESHOLD, DistanceRange, coverage, grasp_distance, nearest_distances, spread};
pub use robust_score::RobustScore;
pub use sampler::{
    FirstApproach, GraspSampler, SampledGrasp, SamplerSettings, Sampling, resume_sampling, sample_grasps,
};
pub use score_kind::ScoreKind;
pub use subset::{covering_subset, farthest_subset, random_subset};
pub use too_wide::TooWide;
