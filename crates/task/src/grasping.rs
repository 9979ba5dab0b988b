//! Grasps: measures, feasibility for a hand, and reasons for failures.

pub(crate) mod closing_hand;
pub(crate) mod found_grasp;
pub(crate) mod grasp_failure;
pub(crate) mod grasp_filter;
pub(crate) mod grasp_measure;
pub(crate) mod grasp_poses;
pub(crate) mod grasp_regions;
pub(crate) mod hand_filter;
pub(crate) mod load_model;
pub(crate) mod pad_contact;
