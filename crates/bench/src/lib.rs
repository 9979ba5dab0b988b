#![doc = include_str!("../README.md")]

pub mod report;
pub mod statistics;

mod campaign;
mod campaign_file;
mod campaign_run;
mod carry_to;
mod error;
mod exports;
mod foreign_answer;
mod foreign_planner;
mod foreign_process;
mod judge;
mod manifest;
mod ompl_log;
mod opened_scenario;
mod path_demand;
mod planner_call;
mod problem_folder;
mod process_group;
mod question;
mod replay;
mod results;
mod results_file;
mod results_row;
mod run_information;
mod sandbox;
mod scenario_choice;
mod shard;
mod simulated_grasp;
mod standing;
mod stored_trial;
mod tally;
mod trial;
mod trial_run;
mod worker;
mod worker_message;
mod worker_process;
mod worker_program;

pub use campaign::{
    Campaign, CampaignPlanner, Exception, MOST_MEMORY_MB, MOST_TIME_LIMIT_S, MOST_TRIALS, Schedule,
};
pub use campaign_run::{CampaignObserver, CampaignSettings, RunSummary, Unheard, run_campaign};
pub use carry_to::CarryTo;
pub use error::BenchError;
pub use foreign_answer::{ForeignAnswer, read_output, read_released};
pub use manifest::Manifest;
pub use ompl_log::OmplLog;
pub use path_demand::PathDemand;
pub use planner_call::PlannerCall;
pub use problem_folder::write_problem;
pub use question::Question;
pub use replay::{Replay, replay, source_of};
pub use results::{Merged, Results, Run, ScenarioSource};
pub use run_information::RunInformation;
pub use sandbox::{Sandbox, Walls};
pub use scenario_choice::{ChosenScenario, choose_scenarios};
pub use shard::{MOST_SHARDS, Shard};
pub use simulated_grasp::SimulatedGrasp;
pub use standing::{Standing, StandingFile};
pub use stored_trial::StoredTrial;
pub use tally::Tally;
pub use trial::{Trial, TrialOutcome, TrialRecord};
pub use worker::serve;
pub use worker_program::WorkerProgram;
