//! Execution of trials: workers, messages, judge, replays.

pub(crate) mod built_in_search;
pub(crate) mod campaign_run;
pub(crate) mod judge;
pub(crate) mod opened_scenario;
pub(crate) mod question;
pub(crate) mod replay;
pub(crate) mod trial_run;
pub(crate) mod worker;
pub(crate) mod worker_message;
pub(crate) mod worker_process;
pub(crate) mod worker_program;
