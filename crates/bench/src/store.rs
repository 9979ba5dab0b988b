//! Results: rows, files, shards of a campaign, exports.

pub(crate) mod campaign_progress;
pub(crate) mod exports;
pub(crate) mod hidden_results;
pub(crate) mod manifest;
pub(crate) mod ompl_log;
pub(crate) mod results;
pub(crate) mod results_claim;
pub(crate) mod results_file;
pub(crate) mod results_row;
pub(crate) mod run_information;
pub(crate) mod shard;
pub(crate) mod simulated_grasp;
pub(crate) mod stored_paths;
pub(crate) mod stored_trial;
