use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use clap::Args;
use cranny_dataset::{DatasetRecipe, DatasetShard, GenerateProgress, GenerateReport, generate};
use cranny_plan::Registry;
use serde::Serialize;

use crate::arguments::Output;
use crate::failure::Failure;
use crate::number_argument::whole;
use crate::progress::{bar, spinner, stop_on_interrupt};
use crate::{Answer, text};

#[derive(Clone, Debug, Args)]
#[command(after_help = "Examples:
  cranny dataset generate recipe.yaml -o demonstrations
  cranny dataset generate recipe.yaml -o trial --count 100 --seed 7
  cranny dataset generate recipe.yaml -o part_3 --shard 3/8     the third of eight shards, on any machine

A recipe, in which everything but `count` has a default:
  count: 100000
  families: [shelf, table, gap, gate]
  ranges: {shelf: [0.1, 0.45]}
  tasks: {reach: 8, carry: 1, place: 1}

Each row is a function of recipe and version alone. The same command again continues after an interruption or a kill.
Exit 0: all rows are there, those without a path included; exit 1: interrupted.")]
pub struct GenerateArguments {
    /// Recipe (YAML)
    #[arg(value_name = "RECIPE")]
    recipe: PathBuf,
    /// Folder of the set, which is created or continued
    #[arg(long, short, value_name = "FOLDER")]
    output: PathBuf,
    /// Make only a shard: its number, from 1, and the number of shards
    #[arg(long, value_name = "K/N")]
    shard: Option<DatasetShard>,
    /// Number of rows, instead of that of the recipe
    #[arg(long, value_name = "N", value_parser = whole::<u64>(1..=1 << 40))]
    count: Option<u64>,
    /// Seed of all random numbers, instead of that of the recipe
    #[arg(long, value_name = "N", value_parser = whole(0..=u64::MAX))]
    seed: Option<u64>,
    /// Number of threads [default: one for each core]
    #[arg(long, value_name = "N", value_parser = whole::<usize>(1..=4096))]
    threads: Option<usize>,
}

#[derive(Clone, Debug, Args)]
#[command(after_help = "Examples:
  cranny dataset merge part_* -o demonstrations

The merged set is the same, byte for byte, as if one process had made it.")]
pub struct MergeArguments {
    /// Folders of all shards
    #[arg(value_name = "FOLDER", required = true, num_args = 1..)]
    shards: Vec<PathBuf>,
    /// Folder to create
    #[arg(long, short, value_name = "FOLDER")]
    output: PathBuf,
}

/// Output of `dataset generate --json`.
#[derive(Serialize)]
struct Answered {
    folder: PathBuf,
    rows: u64,
    solved: u64,
    /// Number of rows that an earlier run had made.
    known: u64,
    complete: bool,
    time_s: f64,
    solved_per_s: f64,
}

pub fn run(arguments: &GenerateArguments, output: Output) -> Result<Answer, Failure> {
    let mut recipe = DatasetRecipe::read(&arguments.recipe, &Registry::default())?;
    recipe.count = arguments.count.unwrap_or(recipe.count);
    recipe.seed = arguments.seed.unwrap_or(recipe.seed);
    let stop = stop_on_interrupt();
    let shard = arguments.shard.unwrap_or(DatasetShard::WHOLE);
    let progress = bar(recipe.count.div_ceil(shard.of), output.quiet);
    let begin = Instant::now();
    let all_solved = AtomicU64::new(0);
    let done = |rows: u64, solved: u64| {
        progress.inc(rows);
        let solved = all_solved.fetch_add(solved, Ordering::Relaxed) + solved;
        let rate = solved as f64 / begin.elapsed().as_secs_f64().max(1e-9);
        progress.set_message(format!("rows, {rate:.0} demonstrations/s,"));
    };
    let settings = GenerateProgress { done: &done, stop: &stop, threads: arguments.threads.unwrap_or(0) };
    let report = generate(&recipe, arguments.shard, &arguments.output, &settings);
    progress.finish_and_clear();
    let GenerateReport { rows, solved, known, is_complete } = report?;
    let time_s = begin.elapsed().as_secs_f64();
    let folder = arguments.output.clone();
    let solved_per_s = solved as f64 / time_s.max(1e-9);
    let answered = Answered { folder, rows, solved, known, complete: is_complete, time_s, solved_per_s };
    text::answer(&answered, || answered.page(), output)?;
    Ok(if is_complete { Answer::Done } else { Answer::No })
}

impl Answered {
    fn page(&self) -> String {
        let Self { folder, rows, solved, known, complete, time_s, solved_per_s } = self;
        let before =
            if *known > 0 { format!(", besides {known} rows of an earlier run") } else { String::new() };
        let end = if *complete { "" } else { "\nstopped; the same command continues" };
        format!(
            "{}: {rows} rows, {solved} with a proven path, in {time_s:.1} s ({solved_per_s:.0} a second){before}{end}\n",
            folder.display()
        )
    }
}

/// Output of `dataset merge --json`.
#[derive(Serialize)]
struct Merged {
    folder: PathBuf,
    rows: u64,
}

pub fn merge(arguments: &MergeArguments, output: Output) -> Result<Answer, Failure> {
    let spinner = spinner("merging", output.quiet);
    let merged = cranny_dataset::merge(&arguments.shards, &arguments.output, &mut || spinner.inc(1));
    spinner.finish_and_clear();
    let merged = Merged { rows: merged?.recipe().count, folder: arguments.output.clone() };
    text::answer(&merged, || format!("{}: {} rows\n", merged.folder.display(), merged.rows), output)?;
    Ok(Answer::Done)
}
