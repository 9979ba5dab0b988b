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

/// Grasps to test, with their object, surroundings and hand.
#[derive(Clone, Debug, Args)]
pub struct SubjectArguments {
    /// Scenario: built-in, a folder or packed; or an object: built-in or a folder
    #[arg(value_name = "ID|OBJECT")]
    pub subject: String,
    /// File of grasps: in the planning frame of a scenario, in the frame of an object [default: the scenario's own]
    #[arg(long, value_name = "FILE")]
    pub grasps: Option<PathBuf>,
    /// For a scenario, simulate only the support of the target; the hand may then overlap obstacles
    #[arg(long)]
    pub support_only: bool,
    /// Stable pose in which an object rests on the ground; without it, the object floats until the hand has closed
    #[arg(long, value_name = "K")]
    pub pose: Option<usize>,
    #[command(flatten)]
    pub instead: InsteadArguments,
    /// Gripper, as YAML [default: the hand of the scenario's robot; for an object the built-in robot's]
    #[arg(long, value_name = "FILE")]
    pub gripper: Option<PathBuf>,
}

/// Inputs of a simulation of grasps.
pub struct Subject {
    pub name: String,
    pub hand: Hand,
    pub test: GraspTest,
    /// Grasps in the planning frame.
    pub grasps: GraspSet,
    /// Grasps as given: those of an object are in its frame.
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
                return Err(flag(
                    "pose",
                    "not valid for a scenario, which defines the pose of its object".to_owned(),
                ));
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
                "not valid for an object: its only support is the ground (see --pose)".to_owned(),
            ));
        }
        let object = object::open(&arguments.subject)?;
        let (mass_kg, friction) =
            (instead.mass_kg.unwrap_or(object.mass_kg), instead.friction.unwrap_or(object.friction));
        let object = object.with_mass_and_friction(mass_kg, friction)?;
        let Some(file) = grasps else {
            let name = &arguments.subject;
            let problem =
                format!("required for an object; create a file: cranny grasps sample {name} -o {name}.csv");
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
