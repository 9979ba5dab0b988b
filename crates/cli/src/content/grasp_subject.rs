use std::path::{Path, PathBuf};

use clap::Args;
use cranny_collision::{Body, World};
use cranny_grasp::{FirstApproach, Hand, HeldObject, LoadMeasure, Pads, SamplerSettings};
use cranny_scenario::{
    DEFAULT_FRICTION, ObjectType, OpenOptions, Scenario, ScenarioError, filter_around_object, is_scenario,
    panda_hand, read_gripper,
};
use cranny_shape::{Solid, Surface, TriangleSoup, UnionMoments, VolumeMoments};
use cranny_spatial::{Pose, Vector};
use cranny_task::{APPROACH_M, HandFilter, LoadModel, Weight, robot_hand};

use crate::choices::ScoreArgument;
use crate::content::grasp_choice::GraspChoice;
use crate::content::object;
use crate::failure::Failure;
use crate::number_argument::{positive, whole};

#[derive(Clone, Debug, Args)]
#[command(after_help = "Examples:
  cranny grasps sample banana
  cranny grasps sample sugar_box --pose 2 --choose farthest -o box.csv
  cranny grasps sample scan.obj --friction 0.4 --bare --json
  cranny grasps sample flat_screwdriver --gripper wide.yaml --depth -10 5
  cranny grasps sample 021 -o ball.csv          what the hand can take in a scenario
  cranny grasps sample my_shelf -o my_shelf/grasps.csv
  cranny grasps sample 031 --hold 2 -o firm.csv

Poses are written in the frame of the object, those of a scenario in its planning frame, as its grasps.csv has
them: the 16 numbers of each row by row, score, width, load (and robust score with the number of its trials, where
`cranny simulate grasps -o` wrote them). The load is the factor by which gravity may grow, in the attitude of the
grasp, before a pad slips; an object without a volume has none. The score is 1 for contacts that need no friction and 0
for those that need all there is. In a scenario, a grasp is kept if the hand is free of everything there, at
the grasp and on the way.")]
pub struct SampleArguments {
    /// Built-in object, the folder of an object, a mesh file (normals outwards; holes are allowed), or a scenario: built-in, a
    /// folder or packed
    #[arg(value_name = "OBJECT|ID")]
    pub object: String,
    /// File to write the grasps to
    #[arg(long, short, value_name = "FILE", default_value = "grasps.csv")]
    pub output: PathBuf,
    /// Number of grasps to write
    #[arg(long, value_name = "N", default_value = "200", value_parser = whole::<usize>(1..=100_000))]
    pub count: usize,
    /// Number of grasps to sample, from which those are chosen [default: ten times as many]
    #[arg(long, value_name = "N", value_parser = whole::<usize>(1..=1_000_000))]
    pub candidates: Option<usize>,
    /// Method of choosing them
    #[arg(long, value_enum, default_value = "covering")]
    pub choose: GraspChoice,
    /// Coefficient of friction [default: the object's own, 0.35 for a mesh]
    #[arg(long, value_name = "MU")]
    pub friction: Option<f64>,
    /// Gripper, as YAML [default: the hand of the scenario's robot; for an object the built-in robot's]
    #[arg(long, value_name = "FILE")]
    pub gripper: Option<PathBuf>,
    /// Approach directions about each closing axis
    #[arg(long, value_name = "N", default_value_t = SamplerSettings::default().approaches,
          value_parser = whole::<usize>(1..=3600))]
    pub approaches: usize,
    /// Rotate the approach directions of each closing axis at random, instead of starting from horizontal
    #[arg(long)]
    pub random_approaches: bool,
    /// Stable pose in which the object rests on the ground (see `cranny object show`): it is grasped from the side or from
    /// above, with the hand above the ground
    #[arg(long, value_name = "K")]
    pub pose: Option<usize>,
    /// Range of the gripper depth, in millimetres along the approach from the midpoint between the contacts
    #[arg(long, num_args = 2, value_names = ["MM", "MM"], default_values_t = [0.0, 0.0])]
    pub depth: Vec<f64>,
    /// Length of the straight approach that must be free, in millimetres
    #[arg(long, value_name = "MM", default_value_t = APPROACH_M * 1000.0)]
    pub approach: f64,
    /// Keep only grasps that hold the object at rest with at least this factor, and that hardly turn or shift it while the hand
    /// closes: the grasps that `plan --place` accepts
    #[arg(long, value_name = "FACTOR", value_parser = positive)]
    pub hold: Option<f64>,
    /// Mass of the object for its load, in kilograms [default: its own; if unknown, from 400 kg/m³]
    #[arg(long, value_name = "KG", value_parser = positive)]
    pub mass: Option<f64>,
    /// Sort the grasps by this score, highest first [default: in the order in which they are chosen]
    #[arg(long, value_enum, value_name = "KIND")]
    pub sort: Option<ScoreArgument>,
    /// Do not check whether the hand collides with the object or the ground
    #[arg(long)]
    pub bare: bool,
    /// Factor that scales the coordinates of a mesh file
    #[arg(long, value_name = "FACTOR", default_value_t = 1.0, value_parser = positive)]
    pub scale: f64,
    /// Seed of all random numbers: the same seed gives the same grasps
    #[arg(long, value_name = "N", default_value = "0", value_parser = whole(0..=u64::MAX))]
    pub seed: u64,
}

/// Object to grasp, its surroundings and the hand.
#[derive(Debug)]
pub struct Subject {
    pub name: String,
    /// Mesh of the object, in the frame that grasps are written in.
    pub mesh: TriangleSoup,
    friction: f64,
    mass_kg: Option<f64>,
    /// Volume moments of the object in its own frame, if a file states them.
    moments: Option<VolumeMoments>,
    place: Place,
    hand: Hand,
}

/// Surroundings of the object.
#[derive(Debug)]
enum Place {
    /// No surroundings.
    Nowhere,
    /// Ground that the object rests on.
    Ground { ground_from_object: Pose },
    /// World of a scenario, with the object's index in it.
    Scene { world: World, target: usize },
}

impl Subject {
    pub fn open(arguments: &SampleArguments) -> Result<Self, Failure> {
        let path = Path::new(&arguments.object);
        let given = arguments.gripper.as_deref().map(read_gripper).transpose()?;
        if is_scenario(&arguments.object) {
            return Self::of_scenario(arguments, given);
        }
        let hand = given.map_or_else(|| panda_hand().map_err(ScenarioError::from), Ok)?;
        if path.is_file() {
            if arguments.pose.is_some() {
                let problem = "a bare mesh has no stable poses (make it an object: cranny object add)".into();
                return Err(Failure::Flag { flag: "pose", problem });
            }
            let scale = Vector::repeat(arguments.scale);
            let mesh = TriangleSoup::load(path, scale).map_err(ScenarioError::from)?;
            let (name, friction) = (arguments.object.clone(), DEFAULT_FRICTION);
            return Ok(Self {
                name,
                mesh,
                friction,
                mass_kg: None,
                moments: None,
                place: Place::Nowhere,
                hand,
            });
        }
        let object = object::open(&arguments.object)?;
        let moments = Some(object.mass_moments());
        let ObjectType { name, mesh, friction, mass_kg, stable_poses, .. } = object;
        let place = match arguments.pose {
            None => Place::Nowhere,
            Some(index) => {
                let stable = stable_poses.get(index).ok_or_else(|| Failure::Flag {
                    flag: "pose",
                    problem: format!("{name} has {} stable poses, counted from 0", stable_poses.len()),
                })?;
                Place::Ground { ground_from_object: stable.ground_from_body }
            }
        };
        Ok(Self { name, mesh, friction: friction.low, mass_kg: Some(mass_kg), moments, place, hand })
    }

    /// Opens the target of a scenario at its pose, with its surroundings and the hand of the scenario's robot.
    fn of_scenario(arguments: &SampleArguments, given: Option<Hand>) -> Result<Self, Failure> {
        if arguments.pose.is_some() {
            let problem = "not valid for a scenario, which defines the pose of its object".into();
            return Err(Failure::Flag { flag: "pose", problem });
        }
        let scenario = Scenario::open(&arguments.object, &OpenOptions::default())?;
        let Some(mesh) = scenario.target_mesh()? else {
            return Err(Failure::NoTarget { id: scenario.id });
        };
        let hand = match given {
            Some(given) => given,
            None if scenario.robot.hand().is_some() => robot_hand(&scenario.robot),
            None => {
                if scenario.robot.tool().is_some() {
                    scenario.robot.hand_with_pads().map_err(ScenarioError::from)?;
                }
                let problem = format!(
                    "no file of the scenario states the opening of the gripper of {}: give the gripper as \
                     YAML, or write a robot.yaml beside the URDF",
                    scenario.robot.name()
                );
                return Err(Failure::Flag { flag: "gripper", problem });
            }
        };
        let physics = scenario.target_physics();
        let (mass_kg, friction) = (physics.mass_kg, physics.least_friction());
        let moments = scenario.target_weight().and_then(|weight| weight.moments);
        let Some(target) = scenario.target else { return Err(Failure::NoTarget { id: scenario.id }) };
        let (name, place) = (scenario.id, Place::Scene { world: scenario.world, target });
        let friction = friction.unwrap_or(DEFAULT_FRICTION);
        Ok(Self { name, mesh, friction, mass_kg, moments, place, hand })
    }

    /// Returns the filter of the hand against the object and its surroundings; an object with holes is only a surface.
    pub fn filter(&self, surface: &Surface, approach_m: f64) -> Result<HandFilter, Failure> {
        let mut bodies = Vec::new();
        match &self.place {
            Place::Scene { world, .. } => {
                let filter = HandFilter::new(&self.hand, world.clone(), approach_m);
                return Ok(filter.map_err(ScenarioError::from)?);
            }
            Place::Ground { ground_from_object } => {
                bodies.push(Body::new("floor", ground_from_object.inverse(), Solid::half_space()));
            }
            Place::Nowhere => {}
        }
        Ok(filter_around_object(&self.hand, &self.mesh, surface, bodies, approach_m)?)
    }

    /// Returns the load measure, and true if the mass is assumed; an error if there is none and firm grasps are required.
    pub fn load_measure(&self, arguments: &SampleArguments) -> Result<Option<(LoadMeasure, bool)>, Failure> {
        let lacking = |problem: String| match arguments.hold {
            Some(_) => Err(Failure::Flag { flag: "hold", problem }),
            None => Ok(None),
        };
        let Some(pads) = Pads::of(&self.hand) else {
            return lacking(format!(
                "hand '{}' does not have two flat pads that close on each other",
                self.hand.name
            ));
        };
        let mass_kg = arguments.mass.or(self.mass_kg);
        let friction = arguments.friction.unwrap_or(self.friction);
        if let Place::Scene { world, target } = &self.place {
            let weight = Weight { mass_kg, moments: self.moments, rolling_m: None };
            let load_model = LoadModel::by_hand(world, *target, &self.hand, (Some(friction), weight));
            return match load_model {
                Some(load_model) => Ok(Some((load_model.measure().clone(), load_model.is_mass_assumed))),
                None => lacking("the object encloses no volume".to_owned()),
            };
        }
        let even = || UnionMoments::of_mesh(&self.mesh).map(|union| union.moments);
        let held = self
            .moments
            .map_or_else(even, Ok)
            .and_then(|moments| HeldObject::new(&self.mesh, &moments, mass_kg, friction));
        let object = match held {
            Ok(object) => object,
            Err(fault) => return lacking(format!("the object has no mass: {fault}")),
        };
        let up = match &self.place {
            Place::Ground { ground_from_object } => ground_from_object.rotation.inverse() * Vector::z(),
            Place::Nowhere | Place::Scene { .. } => Vector::z(),
        };
        let measure = LoadMeasure::new(object, pads, self.hand.closing_force_n, up, Vec::new());
        Ok(Some((measure, mass_kg.is_none())))
    }

    pub fn settings(&self, arguments: &SampleArguments) -> SamplerSettings {
        let mut settings = SamplerSettings {
            count: arguments.candidates.unwrap_or(10 * arguments.count).max(arguments.count),
            friction: arguments.friction.unwrap_or(self.friction),
            opening_m: self.hand.opening_m,
            closed_gap_m: self.hand.closed_gap_m(),
            approaches: arguments.approaches,
            depth_m: [arguments.depth[0] / 1000.0, arguments.depth[1] / 1000.0],
            // Rejects early what the filter of the hand would reject anyway.
            finger_depth_m: Some(self.hand.finger_depth_m)
                .filter(|depth_m| !arguments.bare && *depth_m > 0.0),
            seed: arguments.seed,
            ..SamplerSettings::default()
        };
        if arguments.random_approaches {
            settings.first_approach = FirstApproach::Random;
        }
        if let Place::Ground { ground_from_object } = &self.place {
            settings.up = ground_from_object.rotation.inverse() * Vector::z();
            settings.steepest_rise_rad = 0.0;
            settings.ground_m = Some(-ground_from_object.translation.z);
        }
        settings
    }
}
