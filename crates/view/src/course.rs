//! Motions: paths, carried objects and recordings.

pub(crate) mod clearance_profile;
pub(crate) mod moving_bodies;
pub(crate) mod recording_file;
pub(crate) mod shown_carry;
pub(crate) mod shown_path;
pub(crate) mod stance;
pub(crate) mod tree_recording;
