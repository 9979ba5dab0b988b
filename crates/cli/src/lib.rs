#![doc = include_str!("../README.md")]

mod arguments;
mod bench;
mod bench_export;
mod bench_merge;
mod bench_problem;
mod bench_replay;
mod bench_report;
mod bench_run;
mod bench_slurm;
mod bench_status;
mod bench_worker;
mod cluster_folder;
mod command;
mod completions;
mod doctor;
mod failure;
mod file_kind;
mod grasp_choice;
mod grasp_subject;
mod grasps;
mod grasps_import;
mod help;
mod ik;
mod info;
mod licences;
mod list;
mod manual;
mod number_argument;
mod object;
mod output_file;
mod page_task;
mod plan;
mod plan_page;
mod plan_task;
mod progress;
mod recording;
mod render;
mod render_format;
mod render_sheet;
mod report_paths;
mod report_pictures;
mod roadmap;
mod robot;
mod robot_picture;
mod scenario;
mod search_replay;
mod simulate;
mod simulate_export;
mod simulate_grasps;
mod simulate_plan;
mod simulate_results;
mod simulate_settle;
mod simulate_subject;
mod slurm;
mod start;
mod statements;
mod task;
mod text;
mod unfinished;
mod verify;
mod version;
mod view;

use std::io::Write;
use std::process::ExitCode;

use clap::{ArgAction, Command, CommandFactory, FromArgMatches};
use cranny_plan::Registry;

use crate::command::{Cli, Command as Chosen};

/// How a command ended that could do its work.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Answer {
    /// Exit 0.
    Done,
    /// Exit 1: an honest "no".
    No,
}

/// The whole command, with the planners of a registry: what the program `cranny` is with [`Registry::default`], and what a
/// program of one's own is with a planner more.
pub fn main(registry: &Registry) -> ExitCode {
    let matches = whole_command().get_matches();
    let cli = Cli::from_arg_matches(&matches).unwrap_or_else(|fault| fault.exit());
    if cli.large_files {
        cranny_file::lift_limits();
    }
    let answer = match &cli.command {
        Chosen::List => list::run(registry, cli.output),
        Chosen::Info(arguments) => info::run(arguments, cli.output),
        Chosen::Plan(arguments) => plan::run(arguments, registry, cli.output),
        Chosen::Verify(arguments) => verify::run(arguments, cli.output),
        Chosen::Ik(arguments) => ik::run(arguments, cli.output),
        Chosen::Scenario(arguments) => scenario::run(arguments, cli.output),
        Chosen::Grasps(arguments) => grasps::run(arguments, cli.output),
        Chosen::Object(arguments) => object::run(arguments, cli.output),
        Chosen::Simulate(arguments) => simulate::run(arguments, cli.output),
        Chosen::Bench(arguments) => bench::run(arguments, registry, cli.output),
        Chosen::Robot(arguments) => robot::run(arguments, cli.output),
        Chosen::Roadmap(arguments) => roadmap::run(arguments, cli.output),
        Chosen::Render(arguments) if arguments.all => render_sheet::run(arguments, cli.output),
        Chosen::Render(arguments) => render::run(arguments, registry, cli.output),
        Chosen::View(arguments) => view::run(arguments, registry, cli.output),
        Chosen::Doctor => doctor::run(cli.output),
        Chosen::Completions(arguments) => completions::run(*arguments, whole_command(), cli.output),
        Chosen::Man(arguments) => manual::run(arguments, whole_command(), cli.output),
        Chosen::Licences => licences::run(cli.output),
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

fn whole_command() -> Command {
    help::laid_out(with_negative_numbers(Cli::command()))
}

/// With every flag taking a negative number for what it is, so that `--count -1` hears of its range and not that
/// there is no flag `-1`.
fn with_negative_numbers(command: Command) -> Command {
    command
        .mut_args(|argument| {
            let takes_value = matches!(argument.get_action(), ArgAction::Set | ArgAction::Append);
            let is_flag = !argument.is_positional();
            if takes_value && is_flag { argument.allow_negative_numbers(true) } else { argument }
        })
        .mut_subcommands(with_negative_numbers)
}
