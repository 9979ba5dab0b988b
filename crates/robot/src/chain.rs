//! Kinematics and dynamics of joint chains: forward kinematics, Jacobians, limits, bounds on errors and reach.

pub(crate) mod coupled_limits;
pub(crate) mod derived;
pub(crate) mod dynamics;
pub(crate) mod frame_error;
pub(crate) mod full_turn;
pub(crate) mod jacobian;
pub(crate) mod joint_group;
pub(crate) mod joint_reach;
pub(crate) mod joint_space;
pub(crate) mod joint_step;
pub(crate) mod kinematics;
pub(crate) mod lane_chain;
pub(crate) mod lane_kinematics;
pub(crate) mod limits;
pub(crate) mod link_arms;
pub(crate) mod link_motion;
pub(crate) mod moving_base;
pub(crate) mod reach_bound;
pub(crate) mod steadiness;
