use std::fmt::Write;
use std::sync::atomic::Ordering;

use clap::Args;
use cranny_file::counted;
use cranny_sim::{ChiSquared, SettledPose, Settling, settle};
use serde::Serialize;

use crate::arguments::Output;
use crate::failure::Failure;
use crate::number_argument::whole;
use crate::progress::{bar, stop_on_interrupt};
use crate::{Answer, content::object, text};

#[derive(Clone, Debug, Args)]
#[command(after_help = "Examples:
  cranny simulate settle sugar_box
  cranny simulate settle banana --count 1000 --seed 3 --json

The object falls from 20 mm above level ground, turned at random.")]
pub struct SettleArguments {
    /// Built-in object, or the folder of one
    #[arg(value_name = "OBJECT")]
    pub object: String,
    /// Number of drops
    #[arg(long, value_name = "N", default_value = "400", value_parser = whole::<usize>(1..=1_000_000))]
    pub count: usize,
    /// Seed of the initial orientations
    #[arg(long, value_name = "N", default_value = "0", value_parser = whole(0..=u64::MAX))]
    pub seed: u64,
}

/// Output of `simulate settle --json`; its keys are stable.
#[derive(Serialize)]
struct Settled {
    object: String,
    #[serde(flatten)]
    settling: Settling,
    /// True if Ctrl-C stopped the command before all drops.
    stopped: bool,
}

pub fn run(arguments: &SettleArguments, output: Output) -> Result<Answer, Failure> {
    let object = object::open(&arguments.object)?;
    let stop = stop_on_interrupt();
    let progress = bar(arguments.count as u64, output.quiet);
    let is_stopped = || stop.load(Ordering::Relaxed);
    let settling = settle(&object, arguments.count, arguments.seed, &|| progress.inc(1), &is_stopped)?;
    progress.finish_and_clear();
    let settled = Settled { object: object.name, settling, stopped: is_stopped() };
    text::answer(&settled, || settled.page(), output.aloud())?;
    Ok(if settled.stopped { Answer::No } else { Answer::Done })
}

impl Settled {
    fn page(&self) -> String {
        let Settling { drops, poses, elsewhere, still_moving, chi_squared } = &self.settling;
        let mut page = format!("{}: dropped {}\n", self.object, counted(*drops, "time"));
        for SettledPose { pose, probability, count } in poses {
            let share = *count as f64 / (*drops).max(1) as f64;
            let _ =
                writeln!(page, "  pose {pose:>3}: {count:>6}  share {share:.3}, computed {probability:.3}");
        }
        let _ = writeln!(page, "  elsewhere {elsewhere}, still moving {still_moving}");
        if let Some(ChiSquared { statistic, degrees_of_freedom, p_value }) = chi_squared {
            let degrees = if *degrees_of_freedom == 1 { "degree" } else { "degrees" };
            let _ = writeln!(
                page,
                "  χ² = {statistic:.1} with {degrees_of_freedom} {degrees} of freedom, p = {p_value:.3}"
            );
        }
        page
    }
}
