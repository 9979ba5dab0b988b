//! Campaigns: scenarios, planners and demands.

pub(crate) mod campaign;
pub(crate) mod campaign_file;
pub(crate) mod carry_to;
pub(crate) mod path_demand;
pub(crate) mod planner_call;
pub(crate) mod scenario_choice;
pub(crate) mod trial;
