use std::path::{Path, PathBuf};
use std::time::Duration;

use clap::Args;
use cranny_bench::{Campaign, CampaignPlanner, PlannerCall, write_problem};
use cranny_plan::Registry;
use serde::Serialize;

use crate::Answer;
use crate::arguments::Output;
use crate::choices::CriterionArgument;
use crate::failure::Failure;
use crate::number_argument::{seconds, whole};
use crate::text;

#[derive(Clone, Debug, Args)]
#[command(after_help = "Examples:
  cranny bench problem 021
  cranny bench problem can -o try --time-limit 5
  python3 plain_rrt.py < try/problem.json

The folder holds problem.json, what a program of `--planner \"exec:…\"` reads on its standard input, and the files that
it names. Nothing stands around a program that is started by hand, and nobody judges what it prints.")]
pub struct ProblemArguments {
    /// Built-in scenario, or the folder of one
    #[arg(value_name = "ID")]
    id: String,
    /// Folder to create
    #[arg(long, short, value_name = "FOLDER", default_value = "problem")]
    output: PathBuf,
    /// Criterion for solved trials
    #[arg(long, value_enum, default_value = "exact")]
    criterion: CriterionArgument,
    /// Seed that the program is given
    #[arg(long, value_name = "N", default_value = "0", value_parser = whole(0..=u64::MAX))]
    seed: u64,
    /// Time limit of the program, in seconds
    #[arg(long, value_name = "S", default_value = "120", value_parser = seconds)]
    time_limit: Duration,
}

/// Output of `bench problem --json`.
#[derive(Serialize)]
struct Written {
    problem: PathBuf,
}

pub fn run(arguments: &ProblemArguments, registry: &Registry, output: Output) -> Result<Answer, Failure> {
    // The problem is the same for all planners.
    let anybody = PlannerCall::BuiltIn {
        planner: "reach".to_owned(),
        settings: serde_json::Map::new(),
        score: cranny_grasp::ScoreKind::default(),
        min_score: None,
    };
    let campaign = Campaign {
        scenarios: vec![arguments.id.clone()],
        planners: vec![CampaignPlanner::new(anybody.checked(registry)?)],
        criteria: vec![arguments.criterion.into()],
        runs: 1,
        first_seed: arguments.seed,
        time_limit_s: arguments.time_limit.as_secs_f64(),
        ..Campaign::default()
    };
    let schedule = campaign.schedule(registry)?;
    let [question] = &schedule.questions[..] else {
        let problem = "expected exactly one scenario".to_owned();
        return Err(Failure::File { path: Path::new(&arguments.id).to_owned(), problem });
    };
    let written = Written { problem: write_problem(question, &arguments.output)? };
    text::answer(&written, || format!("written to {}\n", written.problem.display()), output)?;
    Ok(Answer::Done)
}
