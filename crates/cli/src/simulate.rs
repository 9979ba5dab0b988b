use std::path::PathBuf;

use clap::{Args, Subcommand};
use cranny_grasp::Hand;
use cranny_scenario::TargetPhysics;

use crate::Answer;
use crate::arguments::Output;
use crate::failure::Failure;
use crate::number_argument::{positive, whole};
use crate::simulate_plan::SimulatePlanArguments;
use crate::{simulate_export, simulate_grasps, simulate_plan, simulate_results, simulate_settle};

#[derive(Clone, Debug, Args)]
pub struct SimulateArguments {
    #[command(subcommand)]
    pub command: SimulateCommand,
}

#[derive(Clone, Debug, Subcommand)]
pub enum SimulateCommand {
    /// Try grasps in physics: the hand alone closes, lifts and shakes
    Grasps(Box<SimulateGraspsArguments>),
    /// Execute a plan in physics: the arm follows it, the hand closes, the arm lifts
    Plan(Box<SimulatePlanArguments>),
    /// Try the grasps at which the solved trials of a campaign end
    Results(SimulateResultsArguments),
    /// Write the same tests for another engine, MuJoCo
    Export(Box<SimulateExportArguments>),
    /// Drop an object at random: how often does it come to rest in which of its stable poses?
    Settle(SettleArguments),
}

#[derive(Clone, Debug, Args)]
#[command(after_help = "Examples:
  cranny simulate grasps 021
  cranny simulate grasps 031 --support-only --friction 0.5 --json
  cranny simulate grasps 041 --grasp 7 --record grasp7.glb    or .gif, to be looked at
  cranny simulate grasps 041 --grasp 7 --record grasp7.json   for `cranny view grasp7.json`, or `render`
  cranny simulate grasps 011 --trials 32                       a robust score: slightly wrong grasps too
  cranny simulate grasps 011 --trials 32 -o scored.csv         the grasps with it, beside the geometric score
  cranny simulate grasps mug --grasps mug.csv --pose 0         an object on the ground

The object comes to rest; the open hand stands at the grasp, closes with its closing force, lifts 100 mm and shakes
along and about each axis (10 mm, 10°, 5 Hz). held: the object is then within 10 mm and 15° of where it was in the
hand; slipped: elsewhere in it; dropped: no longer touched; never-closed: the fingers found nothing; knocked-away: and
pushed it off. An open hand that stands in the object (knocked-away) or with a finger in what is around (never-closed) by
more than 1 mm begins nothing. What simulators say of real grasps is right for about 85 in 100.")]
pub struct SimulateGraspsArguments {
    #[command(flatten)]
    pub subject: SubjectArguments,
    /// Only this grasp, from 0
    #[arg(long, value_name = "K")]
    pub grasp: Option<usize>,
    /// Try each grasp so many times more, with the hand, friction, mass and force a little wrong (3 mm and 3° on each
    /// axis, 25 %, 10 %, 10 %), the same for every grasp: the share that is held is the robust score
    #[arg(long, value_name = "N", default_value = "0", value_parser = whole::<usize>(0..=10_000))]
    pub trials: usize,
    /// Seed of the trials
    #[arg(long, value_name = "N", default_value = "0", value_parser = whole(0..=u64::MAX))]
    pub seed: u64,
    /// Write the grasps as a file of grasps, with their robust scores and the number of trials (with --trials)
    #[arg(long, short, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Write what moved where (with --grasp): .glb, .gif, or .json for `cranny render`
    #[arg(long, value_name = "FILE", requires = "grasp")]
    pub record: Option<PathBuf>,
}

/// What is grasped, by what, and how.
#[derive(Clone, Debug, Args)]
pub struct SubjectArguments {
    /// Scenario: built-in, a folder or packed; or an object: built-in or a folder
    #[arg(value_name = "ID|OBJECT")]
    pub subject: String,
    /// File of grasps: in the planning frame of a scenario, in the frame of an object [default: the scenario's own]
    #[arg(long, value_name = "FILE")]
    pub grasps: Option<PathBuf>,
    /// Of a scenario, only what the target stands on; the hand may then be where obstacles are
    #[arg(long)]
    pub support_only: bool,
    /// An object rests on the ground in this one of its stable poses; without it, it floats until the hand has closed
    #[arg(long, value_name = "K")]
    pub pose: Option<usize>,
    #[command(flatten)]
    pub instead: InsteadArguments,
    /// Gripper, as YAML [default: the hand of the scenario's robot; for an object the built-in robot's]
    #[arg(long, value_name = "FILE")]
    pub gripper: Option<PathBuf>,
}

/// What goes before what files say of object and hand.
#[derive(Clone, Debug, Args)]
pub struct InsteadArguments {
    /// Mass of the object, in kilograms [default: its own]
    #[arg(long, value_name = "KG", value_parser = positive)]
    mass: Option<f64>,
    /// Coefficient of friction between the object and all that touches it [default: its own]
    #[arg(long, value_name = "MU", value_parser = positive)]
    friction: Option<f64>,
    /// With what the fingers press, in newtons [default: the hand's own]
    #[arg(long, value_name = "N", value_parser = positive)]
    closing_force: Option<f64>,
}

impl InsteadArguments {
    pub fn of_target(&self) -> TargetPhysics {
        TargetPhysics { mass_kg: self.mass, friction: self.friction }
    }

    pub fn of_hand(&self, hand: Hand) -> Hand {
        Hand { closing_force_n: self.closing_force.unwrap_or(hand.closing_force_n), ..hand }
    }
}

#[derive(Clone, Debug, Args)]
#[command(after_help = "Examples:
  cranny simulate results results.db
  cranny simulate results results.db --trials 32 --json

Each grasp at which a solved trial ends is tried once, as `cranny simulate grasps` does it: the hand alone, in the
scenario of the trial. What came of it is kept in the same file, in a table simulated_grasps, in the place of what was
kept there under the same settings; trials stay as they are.")]
pub struct SimulateResultsArguments {
    /// Results of campaigns, as `cranny bench run` wrote them
    #[arg(value_name = "RESULTS")]
    pub results: PathBuf,
    /// Only what the target stands on, not all that stands around; the hand may then be where obstacles are
    #[arg(long)]
    pub support_only: bool,
    /// Try each grasp so many times more, everything a little wrong, for its robust score
    #[arg(long, value_name = "N", default_value = "0", value_parser = whole::<usize>(0..=10_000))]
    pub trials: usize,
    /// Seed of these trials
    #[arg(long, value_name = "N", default_value = "0", value_parser = whole(0..=u64::MAX))]
    pub seed: u64,
}

#[derive(Clone, Debug, Args)]
#[command(after_help = "Examples:
  cranny simulate export 031 --support-only -o box.json
  cranny simulate export 021 --mjcf -o ball.xml

The document holds the model as MJCF, what the hand does, what counts as held, and all grasps; in Python,
cranny.mujoco_grasps runs it in MuJoCo and answers by the same rules.")]
pub struct SimulateExportArguments {
    #[command(flatten)]
    pub subject: SubjectArguments,
    /// Write the model alone, as MuJoCo's XML
    #[arg(long)]
    pub mjcf: bool,
    /// Where to write
    #[arg(long, short, value_name = "FILE", default_value = "experiment.json")]
    pub output: PathBuf,
}

#[derive(Clone, Debug, Args)]
#[command(after_help = "Examples:
  cranny simulate settle sugar_box
  cranny simulate settle banana --count 1000 --seed 3 --json

The object falls from 20 mm above level ground, turned at random.")]
pub struct SettleArguments {
    /// Built-in object, or the folder of one
    #[arg(value_name = "OBJECT")]
    pub object: String,
    /// How often it is dropped
    #[arg(long, value_name = "N", default_value = "400", value_parser = whole::<usize>(1..=1_000_000))]
    pub count: usize,
    /// Seed of the turns
    #[arg(long, value_name = "N", default_value = "0", value_parser = whole(0..=u64::MAX))]
    pub seed: u64,
}

pub fn run(arguments: &SimulateArguments, output: Output) -> Result<Answer, Failure> {
    match &arguments.command {
        SimulateCommand::Grasps(arguments) => simulate_grasps::run(arguments, output),
        SimulateCommand::Plan(arguments) => simulate_plan::run(arguments, output),
        SimulateCommand::Results(arguments) => simulate_results::run(arguments, output),
        SimulateCommand::Export(arguments) => simulate_export::run(arguments, output),
        SimulateCommand::Settle(arguments) => simulate_settle::run(arguments, output),
    }
}
