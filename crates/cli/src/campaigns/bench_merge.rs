use std::fmt::Write as _;
use std::path::PathBuf;

use clap::Args;
use cranny_bench::{Merged, Results, Shard};
use cranny_file::counted;
use serde::Serialize;

use crate::Answer;
use crate::arguments::Output;
use crate::failure::Failure;
use crate::output_file;
use crate::text;

#[derive(Clone, Debug, Args)]
#[command(after_help = "Examples:
  cranny bench merge A.db B.db               A.db takes up what B.db has and A.db has not
  cranny bench merge A.db B.db -o all.db     A.db stays as it is

  cranny bench merge part-*.db -o all.db     the parts of a campaign

A trial is never there twice. One that is in several files, and went differently there, was run twice: then nothing is
joined, unless you say that the first is to stay (--keep-first). A trial whose run is missing is kept, as that of an
unknown machine.")]
pub struct MergeArguments {
    /// Files of results; the others are merged into the first
    #[arg(value_name = "RESULTS", required = true, num_args = 1..)]
    results: Vec<PathBuf>,
    /// Keep the trial of the first file if a trial was run more than once
    #[arg(long)]
    keep_first: bool,
    /// Merge into another file, which may exist, and leave all inputs unchanged
    #[arg(long, short, value_name = "FILE")]
    output: Option<PathBuf>,
}

/// Output of `bench merge --json`.
#[derive(Serialize)]
struct Answered {
    file: PathBuf,
    trials: usize,
    merged: Vec<Taken>,
    /// Sentence about shards of the campaign of which there is no run.
    missing: Option<String>,
}

#[derive(Serialize)]
struct Taken {
    file: PathBuf,
    added: u64,
    known: u64,
}

pub fn run(arguments: &MergeArguments, output: Output) -> Result<Answer, Failure> {
    let too_few = || Failure::Flag {
        flag: "output",
        problem: "required, unless at least two results files are given".to_owned(),
    };
    let (first, rest) = arguments.results.split_first().ok_or_else(too_few)?;
    if rest.is_empty() && arguments.output.is_none() {
        return Err(too_few());
    }
    // Every file is opened before any is changed.
    for file in &arguments.results {
        Results::open(file)?;
    }
    let (into, others) = match &arguments.output {
        Some(file) => (file, &arguments.results[..]),
        None => (first, rest),
    };
    output_file::check_folder(into)?;
    let (into, taken) = Results::merged(into, others, arguments.keep_first)?;
    let taken = others.iter().zip(taken);
    let merged =
        taken.map(|(file, Merged { added, known })| Taken { file: file.clone(), added, known }).collect();
    let runs = into.runs()?;
    let missing = Shard::missing_among(runs.iter().map(|run| run.information.command.as_str()));
    let answered = Answered { file: into.path().to_owned(), trials: into.count()?, merged, missing };
    text::answer(&answered, || answered.page(), output)?;
    Ok(Answer::Done)
}

impl Answered {
    fn page(&self) -> String {
        let mut page = format!("{}: {}\n", self.file.display(), counted(self.trials, "trial"));
        for Taken { file, added, known } in &self.merged {
            let _ = writeln!(page, "  {}: {added} added, {known} there already", file.display());
        }
        if let Some(missing) = &self.missing {
            let _ = writeln!(page, "  {missing}");
        }
        page
    }
}
