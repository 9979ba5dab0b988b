//! Is a path good, what does it cost, and can it be shorter: whoever found it.

pub(crate) mod audit;
pub(crate) mod clearance_limit;
pub(crate) mod corner_audit;
pub(crate) mod grasp_judge;
pub(crate) mod joint_metric;
pub(crate) mod path_cost;
pub(crate) mod pick_audit;
pub(crate) mod shortcut;
pub(crate) mod step;
pub(crate) mod task_audit;
pub(crate) mod violation;
