//! The `cranny` command: joins the rooms, holds no logic of their own.
//!
//! Exit codes: 0 done, 1 an honest "no" (not solved, not valid), 2 bad input.

mod arguments;
mod bench;
mod bench_export;
mod bench_merge;
mod bench_replay;
mod bench_report;
mod bench_run;
mod failure;
mod grasp_choice;
mod grasp_subject;
mod grasps;
mod ik;
mod info;
mod list;
mod object;
mod page_task;
mod plan;
mod plan_task;
mod progress;
mod render;
mod scenario;
mod search_replay;
mod start;
mod task;
mod text;
mod timing;
mod verify;
mod view;
mod whole_file;

use std::io::Write;
use std::process::ExitCode;

use clap::Parser;

use crate::arguments::{Cli, Command};

/// How a command ended that could do its work.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Answer {
    /// Exit 0.
    Done,
    /// Exit 1: an honest "no".
    No,
}

fn main() -> ExitCode {
    let cli = Cli::parse();
    if cli.large_files {
        cranny_file::lift_limits();
    }
    let answer = match &cli.command {
        Command::List => list::run(cli.output),
        Command::Info(arguments) => info::run(arguments, cli.output),
        Command::Plan(arguments) => plan::run(arguments, cli.output),
        Command::Verify(arguments) => verify::run(arguments, cli.output),
        Command::Ik(arguments) => ik::run(arguments, cli.output),
        Command::Scenario(arguments) => scenario::run(arguments, cli.output),
        Command::Grasps(arguments) => grasps::run(arguments, cli.output),
        Command::Object(arguments) => object::run(arguments, cli.output),
        Command::Bench(arguments) => bench::run(arguments, cli.output),
        Command::Render(arguments) => render::run(arguments, cli.output),
        Command::View(arguments) => view::run(arguments, cli.output),
    };
    match answer {
        Ok(Answer::Done) => ExitCode::SUCCESS,
        Ok(Answer::No) => ExitCode::from(1),
        Err(failure) => {
            // Where not even this can be written, the exit code says it.
            let _ = writeln!(std::io::stderr(), "error: {}", cranny_file::visible(&failure.to_string()));
            ExitCode::from(2)
        }
    }
}
