use clap::{Parser, Subcommand};

use crate::arguments::{IkArguments, Output, PlanArguments, TaskArguments, VerifyArguments};
use crate::campaigns::bench::BenchArguments;
use crate::content::grasps::GraspsArguments;
use crate::content::object::ObjectArguments;
use crate::content::robot::RobotArguments;
use crate::content::scenario::ScenarioArguments;
use crate::physics::simulate::SimulateArguments;
use crate::pictures::render::RenderArguments;
use crate::pictures::view::ViewArguments;
use crate::planning::roadmap::RoadmapArguments;
use crate::program::completions::CompletionsArguments;
use crate::program::manual::ManualArguments;
use crate::program::version;

/// Plans how a mobile manipulator reaches into a confined space and grasps an object.
///
/// ID is a built-in scenario (see `cranny list`), the folder or .zip of a scenario, or the folder of one in
/// the layout that the paper released.
///
/// Exit codes: 0 done, 1 an honest "no" (not solved, not valid), 2 bad input.
#[derive(Debug, Parser)]
#[command(
    name = "cranny",
    version,
    long_version = version::long(),
    max_term_width = 100,
    after_help = "Examples:
  cranny plan 021                      plan a grasp in a built-in scenario
  cranny verify 021 021.plan.json      judge the path, or anybody's way points
  cranny help plan                     all options of one command"
)]
pub struct Cli {
    #[command(flatten)]
    pub output: Output,
    /// Read files of any size: without it a mesh or a table may have 1 GiB, a packed scenario 256 MiB, any other
    /// file 64 MiB
    #[arg(long, global = true)]
    pub large_files: bool,
    #[command(subcommand)]
    pub command: Command,
}

#[derive(Debug, Subcommand)]
pub enum Command {
    /// List the built-in scenarios and the planners
    List,
    /// Show what a scenario holds: robot, obstacles, target, grasps, start
    Info(TaskArguments),
    /// Plan a motion to a grasp and write it to a plan file
    Plan(Box<PlanArguments>),
    /// Judge a plan file or bare way points against a scenario
    Verify(VerifyArguments),
    /// Look for free configurations at every grasp of a scenario
    Ik(IkArguments),
    /// Make a roadmap for planner prm, to answer any number of questions with
    Roadmap(RoadmapArguments),
    /// Make, check, share and convert scenarios
    Scenario(Box<ScenarioArguments>),
    /// Sample, filter and compare grasps
    Grasps(GraspsArguments),
    /// Make a robot of your own from its URDF, check it, list those that there are
    Robot(RobotArguments),
    /// Make objects to grasp from meshes, and show those that there are
    Object(ObjectArguments),
    /// Try grasps in physics
    Simulate(SimulateArguments),
    /// Run campaigns of trials, join, report and replay their results
    Bench(BenchArguments),
    /// Draw a scenario or a plan: a picture, a moving picture, animated glTF, a page in one file
    Render(Box<RenderArguments>),
    /// Look at a scenario and at plans in the browser
    View(ViewArguments),
    /// Say what is here and what is missing, and try whether plans and proofs are what they should be
    Doctor,
    /// Print what makes a shell complete commands and flags
    Completions(CompletionsArguments),
    /// Print or write the manual pages
    Man(ManualArguments),
    /// Print the licences of Cranny and of all that is in this program
    Licences,
}
