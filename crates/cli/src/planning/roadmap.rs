use std::path::PathBuf;
use std::sync::atomic::Ordering;
use std::time::Instant;

use clap::Args;
use cranny_file::counted;
use cranny_plan::Prm;
use serde::Serialize;

use crate::Answer;
use crate::arguments::{Output, TaskArguments};
use crate::failure::Failure;
use crate::file_kind::FileKind;
use crate::number_argument::whole;
use crate::output_file;
use crate::planning::task::{Demand, Task};
use crate::progress::{bar, stop_on_interrupt};
use crate::text;

#[derive(Clone, Debug, Args)]
#[command(after_help = "Examples:
  cranny roadmap 021 --nodes 2000
  cranny plan 021 --planner prm --set roadmap=021.roadmap.json

A roadmap is of a robot in a world: it serves any start and any grasps there. Its edges are proven; those of a path are
proven again, so that a roadmap of another world costs time and no truth.")]
pub struct RoadmapArguments {
    #[command(flatten)]
    task: TaskArguments,
    /// Number of configurations
    #[arg(long, value_name = "N", default_value = "1000", value_parser = whole::<usize>(1..=100_000))]
    nodes: usize,
    /// Maximum number of nearest neighbours that a configuration is connected to
    #[arg(long, value_name = "N", default_value_t = Prm::default().neighbours, value_parser = whole::<usize>(1..=1000))]
    neighbours: usize,
    /// Seed of all random numbers
    #[arg(long, value_name = "N", default_value = "0", value_parser = whole(0..=u64::MAX))]
    seed: u64,
    /// File to write [default: ID.roadmap.json in this folder]
    #[arg(long, short, value_name = "FILE")]
    output: Option<PathBuf>,
}

/// Output of `roadmap --json`; its keys are stable.
#[derive(Serialize)]
struct Answered {
    scenario: String,
    nodes: usize,
    edges: usize,
    seconds: f64,
    /// True if Ctrl-C stopped the command before all nodes were added.
    stopped: bool,
    file: PathBuf,
}

pub fn run(arguments: &RoadmapArguments, output: Output) -> Result<Answer, Failure> {
    let Task { scenario, problem, .. } = Task::open(&arguments.task, Demand::default(), output)?;
    let file = arguments.output.clone();
    let file = file.unwrap_or_else(|| PathBuf::from(format!("{}.roadmap.json", scenario.id)));
    output_file::check(&file, FileKind::Roadmap, output)?;
    let stop = stop_on_interrupt();
    let progress = bar(arguments.nodes as u64, output.quiet);
    let begin = Instant::now();
    let mut goes_on = |nodes: usize| {
        progress.set_position(nodes as u64);
        !stop.load(Ordering::Relaxed)
    };
    let prm = Prm { neighbours: arguments.neighbours, ..Prm::default() };
    let roadmap = prm.build(&problem, arguments.nodes, arguments.seed, &mut goes_on)?;
    progress.finish_and_clear();
    let text = serde_json::to_string(&roadmap).map_err(std::io::Error::other)? + "\n";
    output_file::write(&file, FileKind::Roadmap, text.as_bytes(), output)?;
    let answered = Answered {
        scenario: scenario.id,
        nodes: roadmap.len(),
        edges: roadmap.edges(),
        seconds: begin.elapsed().as_secs_f64(),
        stopped: roadmap.len() < arguments.nodes,
        file,
    };
    let page = || {
        let Answered { scenario, nodes, edges, seconds, file, stopped } = &answered;
        let (nodes, edges) = (counted(*nodes, "configuration"), counted(*edges, "proven edge"));
        let of = if *stopped { format!("stopped, of {}: ", arguments.nodes) } else { String::new() };
        format!("{scenario}: {of}{nodes}, {edges} in {seconds:.1} s → {}\n", file.display())
    };
    text::answer(&answered, page, output)?;
    Ok(if answered.stopped { Answer::No } else { Answer::Done })
}
