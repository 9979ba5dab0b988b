use clap::{Parser, Subcommand};

use crate::arguments::{
    CertifyArguments, IkArguments, Output, PlanArguments, TaskArguments, VerifyArguments,
};
use crate::campaigns::bench::BenchArguments;
use crate::content::dataset::DatasetArguments;
use crate::content::grasps::GraspsArguments;
use crate::content::object::ObjectArguments;
use crate::content::robot::RobotArguments;
use crate::content::scenario::ScenarioArguments;
use crate::physics::simulate::SimulateArguments;
use crate::pictures::render::RenderArguments;
use crate::pictures::sense::SenseArguments;
use crate::pictures::view::ViewArguments;
use crate::planning::roadmap::RoadmapArguments;
use crate::planning::serve::ServeArguments;
use crate::program::completions::CompletionsArguments;
use crate::program::manual::ManualArguments;
use crate::program::version;

/// Plans how a mobile manipulator reaches into a confined space and grasps an object.
///
/// ID is a built-in scenario (see `cranny list`), the folder or .zip of a scenario, or a scenario folder in the layout that the
/// paper released.
///
/// Exit codes: 0 success, 1 a negative result (not solved, not valid), 2 bad input.
#[derive(Debug, Parser)]
#[command(
    name = "cranny",
    version,
    long_version = version::long(),
    max_term_width = 100,
    after_help = "Examples:
  cranny plan 021                      plan a grasp in a built-in scenario
  cranny verify 021 021.plan.json      judge the path, or way points from any source
  cranny help plan                     all options of one command"
)]
pub struct Cli {
    #[command(flatten)]
    pub output: Output,
    /// Read files of any size; the default limits are 1 GiB for a mesh or a table, 256 MiB for a packed scenario and 64 MiB for
    /// any other file
    #[arg(long, global = true)]
    pub large_files: bool,
    #[command(subcommand)]
    pub command: Command,
}

#[derive(Debug, Subcommand)]
pub enum Command {
    /// List the built-in scenarios and the planners
    List,
    /// Show the content of a scenario: robot, obstacles, target, grasps, start
    Info(TaskArguments),
    /// Plan a motion to a grasp and write it to a plan file
    Plan(Box<PlanArguments>),
    /// Verify a plan file or bare way points against a scenario
    Verify(VerifyArguments),
    /// Write a certificate of a plan, or that no motion exists, which a small program without Cranny checks
    Certify(CertifyArguments),
    /// Find free configurations at every grasp of a scenario
    Ik(IkArguments),
    /// Build a roadmap for the planner prm, to answer many queries with
    Roadmap(RoadmapArguments),
    /// Answer requests of MoveIt over HTTP on this machine, for one robot
    Serve(ServeArguments),
    /// Create, check, share and convert scenarios
    Scenario(Box<ScenarioArguments>),
    /// Sample, filter and compare grasps
    Grasps(GraspsArguments),
    /// Set up a robot of your own from its URDF, check it, and list the available robots
    Robot(RobotArguments),
    /// Create graspable objects from meshes, and show the available ones
    Object(ObjectArguments),
    /// Test grasps in physics
    Simulate(SimulateArguments),
    /// Run campaigns of trials; merge, report and replay their results
    Bench(BenchArguments),
    /// Make, check and export sets of proven demonstrations
    Dataset(DatasetArguments),
    /// Render a scenario or a plan: a picture, an animation, animated glTF, a page in one file
    Render(Box<RenderArguments>),
    /// Render what depth cameras see in a scenario, with errors within the bounds of their model
    Sense(SenseArguments),
    /// View a scenario and plans in the browser
    View(ViewArguments),
    /// Show which components are present or missing, and test plans and proofs
    Doctor,
    /// Print the script that completes commands and flags in a shell
    Completions(CompletionsArguments),
    /// Print or write the manual pages
    Man(ManualArguments),
    /// Print the licences of Cranny and of everything in this program
    Licences,
}
