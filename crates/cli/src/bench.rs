//! `cranny bench`: one module a subcommand.

use clap::{Args, Subcommand};

use crate::Answer;
use crate::arguments::Output;
use crate::bench_merge::{self, MergeArguments};
use crate::failure::Failure;

#[derive(Clone, Debug, Args)]
pub struct BenchArguments {
    #[command(subcommand)]
    command: BenchCommand,
}

#[derive(Clone, Debug, Subcommand)]
enum BenchCommand {
    /// Join the results of several machines in one file
    Merge(MergeArguments),
}

pub fn run(arguments: &BenchArguments, output: Output) -> Result<Answer, Failure> {
    match &arguments.command {
        BenchCommand::Merge(arguments) => bench_merge::run(arguments, output),
    }
}
