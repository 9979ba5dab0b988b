#![doc = include_str!("../README.md")]

mod asked;
mod foreign;
pub mod report;
mod running;
pub mod statistics;
mod store;

mod error;
mod tally;

pub use asked::campaign::{
    Campaign, CampaignPlanner, Exception, MEGABYTE, MOST_MEMORY_MB, MOST_TIME_LIMIT_S, MOST_TRIALS, Schedule,
};
pub use asked::carry_to::CarryTo;
pub use asked::path_demand::PathDemand;
pub use asked::planner_call::PlannerCall;
pub use asked::scenario_choice::{ChosenScenario, choose_scenarios};
pub use asked::trial::{Trial, TrialOutcome, TrialRecord};
pub use error::BenchError;
pub use foreign::foreign_answer::{ForeignAnswer, read_output, read_released};
pub use foreign::problem_folder::write_problem;
pub use foreign::sandbox::{Isolation, Sandbox};
pub use running::campaign_run::{CampaignObserver, CampaignSettings, NoObserver, RunSummary, run_campaign};
pub use running::question::Question;
pub use running::replay::{Replay, replay, source_of};
pub use running::worker::serve;
pub use running::worker_program::WorkerProgram;
pub use store::campaign_progress::{CampaignProgress, ProgressFile};
pub use store::manifest::Manifest;
pub use store::ompl_log::OmplLog;
pub use store::results::{Merged, Results, Run, ScenarioSource};
pub use store::run_information::RunInformation;
pub use store::shard::{MOST_SHARDS, Shard};
pub use store::simulated_grasp::SimulatedGrasp;
pub use store::stored_trial::StoredTrial;
pub use tally::Tally;
