use clap::{Args, Subcommand};

use crate::arguments::Output;
use crate::failure::Failure;
use crate::physics::simulate_export::SimulateExportArguments;
use crate::physics::simulate_grasps::SimulateGraspsArguments;
use crate::physics::simulate_plan::SimulatePlanArguments;
use crate::physics::simulate_results::SimulateResultsArguments;
use crate::physics::simulate_settle::SettleArguments;
use crate::{
    Answer, physics::simulate_export, physics::simulate_grasps, physics::simulate_plan,
    physics::simulate_results, physics::simulate_settle,
};

#[derive(Clone, Debug, Args)]
pub struct SimulateArguments {
    #[command(subcommand)]
    pub command: SimulateCommand,
}

#[derive(Clone, Debug, Subcommand)]
pub enum SimulateCommand {
    /// Test grasps in physics: the hand alone closes, lifts and shakes
    Grasps(Box<SimulateGraspsArguments>),
    /// Execute a plan in physics: the arm follows it, the hand closes, the arm lifts
    Plan(Box<SimulatePlanArguments>),
    /// Test the final grasps of the solved trials of a campaign
    Results(SimulateResultsArguments),
    /// Write the same tests for another engine, MuJoCo
    Export(Box<SimulateExportArguments>),
    /// Drop an object in random orientations and count its stable poses
    Settle(SettleArguments),
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
