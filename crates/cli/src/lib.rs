#![doc = include_str!("../README.md")]

mod arguments;
mod campaigns;
mod choices;
mod command;
mod content;
mod failure;
mod file_kind;
mod number_argument;
mod output_file;
mod physics;
mod pictures;
mod planning;
mod program;
mod progress;
mod start;
mod statements;
mod text;
mod unfinished;

use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;

use clap::parser::ValueSource;
use clap::{ArgAction, ArgMatches, Command, CommandFactory, FromArgMatches};
use cranny_plan::Registry;

use crate::command::{Cli, Command as Chosen};

/// Result of a command that completed its work.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Answer {
    /// Success, exit code 0.
    Done,
    /// Negative result, exit code 1.
    No,
}

/// Runs the command line with the planners of a registry: those of `cranny` ([`Registry::default`]), or also your own.
pub fn main(registry: &Registry) -> ExitCode {
    let mut command = whole_command();
    let matches = command.get_matches_mut();
    cranny_file::accept_streams(given_values(&command, &matches));
    let cli = Cli::from_arg_matches(&matches).unwrap_or_else(|fault| fault.exit());
    if cli.large_files {
        cranny_file::lift_limits();
    }
    // A worker ends with its campaign. A signal must kill it: the campaign then counts its trial as killed.
    if !matches!(&cli.command, Chosen::Bench(arguments) if arguments.is_worker()) {
        progress::end_on_interrupt();
    }
    let answer = match &cli.command {
        Chosen::List => content::list::run(registry, cli.output),
        Chosen::Info(arguments) => content::info::run(arguments, cli.output),
        Chosen::Plan(arguments) => planning::plan::run(arguments, registry, cli.output),
        Chosen::Verify(arguments) => planning::verify::run(arguments, cli.output),
        Chosen::Certify(arguments) => planning::certify::run(arguments, cli.output),
        Chosen::Ik(arguments) => planning::ik::run(arguments, cli.output),
        Chosen::Scenario(arguments) => content::scenario::run(arguments, cli.output),
        Chosen::Grasps(arguments) => content::grasps::run(arguments, cli.output),
        Chosen::Object(arguments) => content::object::run(arguments, cli.output),
        Chosen::Simulate(arguments) => physics::simulate::run(arguments, cli.output),
        Chosen::Bench(arguments) => campaigns::bench::run(arguments, registry, cli.output),
        Chosen::Dataset(arguments) => content::dataset::run(arguments, cli.output),
        Chosen::Robot(arguments) => content::robot::run(arguments, cli.output),
        Chosen::Roadmap(arguments) => planning::roadmap::run(arguments, cli.output),
        Chosen::Serve(arguments) => planning::serve::run(arguments, cli.output),
        Chosen::Sense(arguments) => pictures::sense::run(arguments, cli.output),
        Chosen::Render(arguments) if arguments.all => pictures::render_sheet::run(arguments, cli.output),
        Chosen::Render(arguments) => pictures::render::run(arguments, registry, cli.output),
        Chosen::View(arguments) => pictures::view::run(arguments, registry, cli.output),
        Chosen::Doctor => program::doctor::run(cli.output),
        Chosen::Completions(arguments) => program::completions::run(*arguments, whole_command(), cli.output),
        Chosen::Man(arguments) => program::manual::run(arguments, whole_command(), cli.output),
        Chosen::Licences => program::licences::run(cli.output),
    };
    match answer {
        Ok(Answer::Done) => ExitCode::SUCCESS,
        Ok(Answer::No) => ExitCode::from(1),
        Err(failure) => {
            // If stderr cannot be written, the exit code still reports the failure.
            let _ = writeln!(std::io::stderr(), "error: {}", cranny_file::visible(&failure.to_string()));
            ExitCode::from(2)
        }
    }
}

/// Returns the values of the command line. Those that are paths of input files may be pipes.
fn given_values(command: &Command, matches: &ArgMatches) -> Vec<PathBuf> {
    let mut values = Vec::new();
    for argument in command.get_arguments().map(|argument| argument.get_id().as_str()) {
        // A flag of another command has no value here.
        if let Ok(Some(given)) = matches.try_get_raw(argument)
            && matches.value_source(argument) == Some(ValueSource::CommandLine)
        {
            values.extend(given.map(PathBuf::from));
        }
    }
    if let Some((name, inner)) = matches.subcommand()
        && let Some(command) = command.find_subcommand(name)
    {
        values.extend(given_values(command, inner));
    }
    values
}

fn whole_command() -> Command {
    program::help::laid_out(with_negative_numbers(Cli::command()))
}

/// Allows negative numbers as values of all flags, so that `--count -1` fails with its range and not with an unknown flag `-1`.
fn with_negative_numbers(command: Command) -> Command {
    command
        .mut_args(|argument| {
            let takes_value = matches!(argument.get_action(), ArgAction::Set | ArgAction::Append);
            let is_flag = !argument.is_positional();
            if takes_value && is_flag { argument.allow_negative_numbers(true) } else { argument }
        })
        .mut_subcommands(with_negative_numbers)
}
