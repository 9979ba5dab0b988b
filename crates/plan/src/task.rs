//! What is asked: problem, goals, grasps, and what follows a grasp.

pub(crate) mod carry;
pub(crate) mod closing_hand;
pub(crate) mod configuration_fault;
pub(crate) mod grasp_failure;
pub(crate) mod grasp_filter;
pub(crate) mod grasp_measure;
pub(crate) mod grasp_poses;
pub(crate) mod hand_filter;
pub(crate) mod ik_annotation;
pub(crate) mod not_checked;
pub(crate) mod own_grasp;
pub(crate) mod pad_contact;
pub(crate) mod place;
pub(crate) mod place_goal;
pub(crate) mod placed;
pub(crate) mod placement;
pub(crate) mod problem;
pub(crate) mod rests;
