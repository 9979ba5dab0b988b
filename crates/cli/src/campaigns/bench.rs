//! `cranny bench`: one module a subcommand.

use std::io::{BufReader, stdin, stdout};

use clap::{Args, Subcommand};
use cranny_plan::Registry;

use crate::Answer;
use crate::arguments::Output;
use crate::campaigns::bench_export::{self, ExportArguments};
use crate::campaigns::bench_merge::{self, MergeArguments};
use crate::campaigns::bench_problem::{self, ProblemArguments};
use crate::campaigns::bench_replay::{self, ReplayArguments};
use crate::campaigns::bench_report::{self, ReportArguments};
use crate::campaigns::bench_run::{self, RunArguments};
use crate::campaigns::bench_slurm::{self, SlurmArguments};
use crate::campaigns::bench_status::{self, StatusArguments};
use crate::failure::Failure;

#[derive(Clone, Debug, Args)]
pub struct BenchArguments {
    #[command(subcommand)]
    command: BenchCommand,
}

#[derive(Clone, Debug, Subcommand)]
enum BenchCommand {
    /// Run a campaign (scenarios × planners × seeds), or resume one
    Run(Box<RunArguments>),
    /// Submit a campaign to Slurm as an array, or resubmit its lost array tasks
    Slurm(SlurmArguments),
    /// Show the progress of the array tasks of a campaign
    Status(StatusArguments),
    /// Write the input that an external planner is given for a trial, to test it by hand
    Problem(ProblemArguments),
    /// Merge the results of several machines into one file
    Merge(MergeArguments),
    /// Report tables, curves and comparisons of results as a page, JSON, LaTeX, Markdown or CSV
    Report(ReportArguments),
    /// Export results for other programs: the benchmark log of OMPL, for Planner Arena
    Export(ExportArguments),
    /// Repeat a trial exactly
    Replay(ReplayArguments),
    /// Serve the trials of a campaign (started by `bench run`)
    #[command(hide = true)]
    Worker,
}

impl BenchArguments {
    /// Returns true for the worker of a campaign.
    pub fn is_worker(&self) -> bool {
        matches!(self.command, BenchCommand::Worker)
    }
}

pub fn run(arguments: &BenchArguments, registry: &Registry, output: Output) -> Result<Answer, Failure> {
    match &arguments.command {
        BenchCommand::Run(arguments) => bench_run::run(arguments, registry, output),
        BenchCommand::Slurm(arguments) => bench_slurm::run(arguments, registry, output),
        BenchCommand::Status(arguments) => bench_status::run(arguments, output),
        BenchCommand::Problem(arguments) => bench_problem::run(arguments, registry, output),
        BenchCommand::Merge(arguments) => bench_merge::run(arguments, output),
        BenchCommand::Report(arguments) => bench_report::run(arguments, output),
        BenchCommand::Export(arguments) => bench_export::run(arguments, output),
        BenchCommand::Replay(arguments) => bench_replay::run(arguments, output),
        BenchCommand::Worker => {
            cranny_bench::serve(registry, BufReader::new(stdin()), &mut stdout())?;
            Ok(Answer::Done)
        }
    }
}
