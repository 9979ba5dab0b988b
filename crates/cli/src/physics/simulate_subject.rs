use std::path::PathBuf;

use clap::Args;
use cranny_grasp::{GraspSet, Hand, read_csv};
use cranny_scenario::{OpenOptions, ScenarioError, is_scenario, panda_hand, read_gripper};
use cranny_sim::GraspTest;
use cranny_task::robot_hand;

use crate::arguments::Output;
use crate::content::object;
use crate::failure::Failure;
use crate::physics::simulate_plan::InsteadArguments;
use crate::planning::task::open_scenario;

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

/// Everything that a simulation of grasps is about.
pub struct Subject {
    pub name: String,
    pub hand: Hand,
    pub test: GraspTest,
    /// In the planning frame.
    pub grasps: GraspSet,
    /// The same as they were given: those of an object are in its frame.
    pub given: GraspSet,
}

impl Subject {
    pub fn open(arguments: &SubjectArguments, output: Output) -> Result<Self, Failure> {
        let given = arguments.gripper.as_deref().map(read_gripper).transpose()?;
        let grasps = arguments.grasps.as_deref().map(read_csv).transpose().map_err(ScenarioError::from)?;
        let instead = arguments.instead.of_target();
        let with_force = |hand: Hand| arguments.instead.of_hand(hand);
        if is_scenario(&arguments.subject) {
            if arguments.pose.is_some() {
                return Err(flag("pose", "the object stands where the scenario has it".to_owned()));
            }
            let scenario = open_scenario(&arguments.subject, &OpenOptions::default(), output)?;
            let hand = with_force(given.unwrap_or_else(|| robot_hand(&scenario.robot)));
            let test = GraspTest::of_scenario(&scenario, &hand, &instead, arguments.support_only)?;
            let grasps = grasps.unwrap_or(scenario.grasps);
            return Ok(Self { name: scenario.id, hand, test, given: grasps.clone(), grasps });
        }
        if arguments.support_only {
            return Err(flag(
                "support-only",
                "an object stands on nothing but the ground, by --pose".to_owned(),
            ));
        }
        let object = object::open(&arguments.subject)?;
        let (mass_kg, friction) =
            (instead.mass_kg.unwrap_or(object.mass_kg), instead.friction.unwrap_or(object.friction));
        let object = object.with_mass_and_friction(mass_kg, friction)?;
        let Some(file) = grasps else {
            let name = &arguments.subject;
            let problem = format!(
                "grasps of an object stand in a file; make one: cranny grasps sample {name} -o {name}.csv"
            );
            return Err(flag("grasps", problem));
        };
        let hand = with_force(given.map_or_else(|| panda_hand().map_err(ScenarioError::from), Ok)?);
        let test = GraspTest::of_object(&object, &hand, arguments.pose)?;
        let world_from_object = arguments.pose.map(|pose| object.stable_poses[pose].ground_from_body);
        let grasps = file.moved(&world_from_object.unwrap_or_default());
        Ok(Self { name: object.name, hand, test, grasps, given: file })
    }
}

pub fn flag(flag: &'static str, problem: String) -> Failure {
    Failure::Flag { flag, problem }
}
