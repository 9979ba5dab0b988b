use std::path::PathBuf;

use clap::{Args, ValueEnum};
use cranny_bench::report::SummarySource;
use cranny_bench::{OmplLog, Results};
use cranny_file::counted;
use serde::Serialize;

use crate::Answer;
use crate::arguments::Output;
use crate::failure::Failure;
use crate::file_kind::FileKind;
use crate::output_file::{self, NamedFile};
use crate::text;

#[derive(Clone, Debug, Args)]
#[command(after_help = "Examples:
  cranny bench export results.db -o results.log      all trials as one experiment
  cranny bench export results.db -o logs/            one experiment for each scenario and criterion
  ompl_benchmark_statistics -d arena.db logs/*.log   the database that Planner Arena shows

`ompl_benchmark_statistics` comes with the Python package ompl. Memory in the log is in MB of 2^20 bytes, as in OMPL's
own logs.")]
pub struct ExportArguments {
    /// Results of campaigns, as `cranny bench run` wrote them
    #[arg(value_name = "RESULTS")]
    results: PathBuf,
    /// Format to write
    #[arg(long, value_enum, default_value_t = ExportFormat::Ompl)]
    format: ExportFormat,
    /// File to write, or a folder (existing, or with / at the end) for one file per experiment
    #[arg(long, short, value_name = "FILE")]
    output: PathBuf,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum ExportFormat {
    /// The benchmark log of OMPL
    Ompl,
}

/// Output of `bench export --json`.
#[derive(Serialize)]
struct Exported {
    files: Vec<PathBuf>,
    trials: usize,
}

pub fn run(arguments: &ExportArguments, output: Output) -> Result<Answer, Failure> {
    let results = Results::open(&arguments.results)?;
    let (trials, runs, scenarios) = (results.trials()?, results.runs()?, results.scenarios()?);
    let name = arguments.results.display().to_string();
    let source = SummarySource { results: &name, trials: &trials, runs: &runs, scenarios: &scenarios };
    let ExportFormat::Ompl = arguments.format;
    let kind = FileKind::OmplLog;
    let files = if output_file::is_folder(&arguments.output) {
        let file = |log: OmplLog| NamedFile {
            name: format!("{}.log", log.name),
            kind,
            content: log.text.into_bytes(),
        };
        let logs: Vec<NamedFile> = OmplLog::of_each(&source)?.into_iter().map(file).collect();
        output_file::write_all(&arguments.output, &logs, output)?
    } else {
        let log = OmplLog::of_all(&source)?;
        output_file::write(&arguments.output, kind, log.text.as_bytes(), output)?;
        vec![arguments.output.clone()]
    };
    let exported = Exported { files, trials: trials.len() };
    let lines =
        || exported.files.iter().map(|file| format!("  {}\n", file.display())).collect::<Vec<_>>().concat();
    text::answer(&exported, || format!("{}:\n{}", counted(exported.trials, "trial"), lines()), output)?;
    Ok(Answer::Done)
}
