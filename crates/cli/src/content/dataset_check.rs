use std::fmt::Write as _;
use std::path::PathBuf;

use clap::Args;
use cranny_dataset::{CheckReport, CheckedRows, DatasetFolder, DatasetStatistics, check, statistics_lines};
use cranny_file::counted;
use serde::Serialize;

use crate::arguments::Output;
use crate::failure::Failure;
use crate::number_argument::whole;
use crate::progress::{bar, spinner, stop_on_interrupt};
use crate::{Answer, text};

#[derive(Clone, Debug, Args)]
#[command(after_help = "Examples:
  cranny dataset check demonstrations                 1000 rows, drawn at random
  cranny dataset check demonstrations --sample 10000 --seed 7
  cranny dataset check demonstrations --all --json

Each scene is made again from the values of its row, and each path is proven like one of any other origin. Its figures must be
the same to the bit. What would need the search again is not compared: outcomes and reasons of rows without a path, the factor
of a hold beyond what the recipe demands, and the results at grasps.

Exit 0: all rows are true; exit 1: a row is false, or the check was interrupted.")]
pub struct CheckArguments {
    /// Folder of a set
    #[arg(value_name = "FOLDER")]
    folder: PathBuf,
    /// Number of rows to prove again, drawn at random
    #[arg(long, value_name = "N", default_value_t = 1000, value_parser = whole::<u64>(0..=1 << 40))]
    sample: u64,
    /// Seed of the sample
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = whole(0..=u64::MAX))]
    seed: u64,
    /// Prove all rows again
    #[arg(long, conflicts_with = "sample")]
    all: bool,
}

/// Output of `dataset check --json`.
#[derive(Serialize)]
struct Answered {
    #[serde(flatten)]
    report: CheckReport,
    statistics: DatasetStatistics,
}

/// Maximum number of faults printed.
const MOST_SHOWN: usize = 100;

pub fn run(arguments: &CheckArguments, output: Output) -> Result<Answer, Failure> {
    let folder = DatasetFolder::open(&arguments.folder)?;
    let stop = stop_on_interrupt();
    let count = if arguments.all { folder.recipe().count } else { arguments.sample };
    let rows = if arguments.all { CheckedRows::All } else { CheckedRows::Sample(count, arguments.seed) };
    let progress = bar(count.min(folder.recipe().count), output.quiet);
    progress.set_message("rows");
    let report = check(&folder, rows, &|rows| progress.inc(rows), &stop);
    progress.finish_and_clear();
    let report = report?;
    let reading = spinner("reading", output.quiet);
    let statistics = DatasetStatistics::of(&folder, &mut || reading.inc(1));
    reading.finish_and_clear();
    let answered = Answered { report, statistics: statistics? };
    text::answer(&answered, || answered.page(), output)?;
    let is_true = answered.report.faults.is_empty() && !answered.report.stopped;
    Ok(if is_true { Answer::Done } else { Answer::No })
}

impl Answered {
    fn page(&self) -> String {
        let CheckReport { checked, proven, faults, stopped } = &self.report;
        let word = match (faults.len(), stopped) {
            (0, false) => "all true".to_owned(),
            (0, true) => "stopped, true so far".to_owned(),
            (count, _) => format!("{} FALSE", counted(count, "row")),
        };
        let checked = counted(usize::try_from(*checked).unwrap_or(usize::MAX), "row");
        let mut page = format!("{word}: {checked} checked, {proven} paths proven again\n");
        for fault in faults.iter().take(MOST_SHOWN) {
            let _ = writeln!(page, "  row {:<8}{}", fault.row, fault.problem);
        }
        if let Some(more) = faults.len().checked_sub(MOST_SHOWN).filter(|more| *more > 0) {
            let _ = writeln!(page, "  …           {more} more; --json lists them all");
        }
        page.push_str(&statistics_lines(&self.statistics));
        page
    }
}
