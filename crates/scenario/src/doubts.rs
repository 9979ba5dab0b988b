use cranny_collision::{Body, Part, World};
use cranny_file::counted;
use cranny_grasp::{GraspSet, SamplerSettings, TooWide};
use cranny_robot::{Link, Robot};
use cranny_shape::{Solid, Surface, separation};
use cranny_spatial::{Point, Pose, Vector};
use cranny_task::{PlaceGoal, PlaceRegion};

use crate::object::mesh_repairs::{body_repairs, link_repairs};
use crate::{DEFAULT_FRICTION, Scenario, measured_opening_m};

/// Maximum distance from the gripper frame at a grasp to the target, in metres: half the opening of the widest hands.
const FARTHEST_GRASP_M: f64 = 0.1;

/// Returns the links that have a visual but no collision geometry in the URDF.
pub fn seen_only_links(robot: &Robot) -> impl Iterator<Item = &str> {
    let is_seen_only = |link: &&Link| link.collisions.is_empty() && !link.visuals.is_empty();
    robot.links().iter().filter(is_seen_only).map(|link| link.name.as_str())
}

/// Returns notes on a robot and the bodies around it: unread URDF and SRDF, mesh repairs, [`seen_only_links`],
/// [`wide_opening`].
pub fn model_notes(robot: &Robot, world: &World) -> Vec<String> {
    let unread = robot.notes().iter().cloned();
    let repaired = link_repairs(robot).into_iter().chain(body_repairs(world));
    unread.chain(repaired).chain(unseen_notes(robot)).chain(wide_opening(robot)).collect()
}

/// Returns [`model_notes`], with several notes of one kind summarized in one line.
pub fn brief_model_notes(robot: &Robot, world: &World) -> Vec<String> {
    let name = robot.name();
    let brief = |notes: Vec<String>, all: &dyn Fn(usize) -> String| match notes.len() {
        0 | 1 => notes,
        count => vec![all(count)],
    };
    let see = format!("`cranny robot check` with the files of robot '{name}' lists them");
    let unread = brief(robot.notes().to_vec(), &|count| {
        format!("{count} kinds of content of the robot's model are not read, or not as they stand: {see}")
    });
    let links =
        brief(link_repairs(robot), &|count| format!("the meshes of {count} links were repaired: {see}"));
    let bodies = brief(body_repairs(world), &|count| {
        format!("the meshes of {count} bodies were repaired: `cranny scenario check` lists them")
    });
    let unseen = brief(unseen_notes(robot), &|count| {
        let names = seen_only_links(robot).map(|link| format!("'{link}'")).collect::<Vec<_>>().join(", ");
        format!("{count} links have a <visual> and no <collision>: collisions of {names} are not checked")
    });
    [unread, links, bodies, unseen, wide_opening(robot).into_iter().collect()].concat()
}

fn unseen_notes(robot: &Robot) -> Vec<String> {
    let note =
        |link| format!("link '{link}' has a <visual> and no <collision>: its collisions are not checked");
    seen_only_links(robot).map(note).collect()
}

/// Maximum excess of a stated opening over the measured one, in metres: meshes are that inaccurate.
const OPENING_OFF_M: f64 = 1e-3;

/// Returns a note if the stated opening of a robot's hand exceeds the measured distance between its fingers.
pub fn wide_opening(robot: &Robot) -> Option<String> {
    let hand = &robot.hand()?.description;
    let measured_m = measured_opening_m(robot)?;
    (hand.opening_m > measured_m + OPENING_OFF_M).then(|| {
        let [said_mm, measured_mm] = [hand.opening_m, measured_m].map(|metres| metres * 1e3);
        format!(
            "the opening_m of hand '{}' is {said_mm:.1} mm, but its open fingers are {measured_mm:.1} mm \
             apart: a wider object does not fit between them",
            hand.name
        )
    })
}

/// Tolerance of a stated load, as a share of the load (at least of a load of 1): digits in a file.
const LOAD_OFF_SHARE: f64 = 0.01;

/// Tolerance of penetration, and of the gap between a target and its support, in metres: objects settle a few tenths of a
/// millimetre off.
const LOOSE_M: f64 = 2e-3;

impl Scenario {
    /// Returns why a planner that samples its own grasps will find none for the target; `None` if grasps are given or possible.
    pub fn too_wide_target(&self) -> Option<String> {
        let hand = self.robot.hand().filter(|_| self.grasps.is_empty())?;
        let surface = Surface::new(&self.target_mesh().ok()??).ok()?;
        let friction = self.target_physics().least_friction().unwrap_or(DEFAULT_FRICTION);
        let opening_m = hand.description.opening_m;
        let too_wide = TooWide::of(
            &surface,
            &SamplerSettings { friction, opening_m, ..SamplerSettings::default() },
            0.0,
        )?;
        Some(format!("{}: {too_wide}", self.world.bodies()[self.target?].name))
    }

    /// Returns notes on an implausible target pose: penetrating another body, or floating.
    pub fn implausible_target_poses(&self) -> Vec<String> {
        let Some(index) = self.target else { return Vec::new() };
        let bodies = self.world.bodies();
        let target = &bodies[index];
        let lift = Pose::translation(0.0, 0.0, LOOSE_M);
        let gap_m = |lift: &Pose, other: &Body| {
            let pairs = target.parts.iter().flat_map(|own| other.parts.iter().map(move |part| (own, part)));
            let upper_m = pairs.map(|(own, part)| {
                let (a, b) = (lift * own.world_from_solid, part.world_from_solid);
                separation(&own.solid, &a, &part.solid, &b, f64::INFINITY).upper_m
            });
            upper_m.fold(f64::INFINITY, f64::min)
        };
        let others = || bodies.iter().enumerate().filter(|(other, _)| *other != index).map(|(_, body)| body);
        let deep = others().filter(|other| gap_m(&lift, other) <= 0.0);
        let mut odd: Vec<String> =
            deep.map(|other| format!("{} reaches into {}", target.name, other.name)).collect();
        let nearest_m = others().map(|other| gap_m(&Pose::identity(), other)).fold(f64::INFINITY, f64::min);
        if nearest_m.is_finite() && nearest_m > LOOSE_M {
            odd.push(format!(
                "{} rests on nothing: the nearest body is {:.0} mm away",
                target.name,
                nearest_m * 1e3
            ));
        }
        odd
    }

    /// Returns a message on each place whose rectangle is above the body that it is stated to lie on: nothing can be put down there.
    pub fn hovering_places(&self) -> Vec<String> {
        /// Greatest height above a support at which an object is still put down, in metres.
        const RESTING_M: f64 = 1e-3;
        let above = |place: &PlaceGoal| {
            let PlaceRegion::Surface { on, pose, size_m: [x, y] } = &place.spot else { return None };
            let support = self.world.bodies().iter().find(|body| body.name == *on)?;
            let rectangle = Solid::cuboid(Vector::new(0.5 * x, 0.5 * y, 1e-6)).ok()?;
            let gap_m = |part: &Part| {
                separation(&rectangle, pose, &part.solid, &part.world_from_solid, f64::INFINITY).lower_m
            };
            let gap_m = support.parts.iter().map(gap_m).fold(f64::INFINITY, f64::min);
            let name = &place.name;
            let stated = format!(
                "place '{name}' is {:.1} mm away from '{on}', on which it is stated to lie",
                1e3 * gap_m
            );
            (gap_m > RESTING_M).then_some(stated)
        };
        self.places.iter().filter_map(above).collect()
    }

    /// Returns a message on grasps whose stated and computed loads differ: their number and the first; `None` if all agree.
    ///
    /// # Errors
    /// Reason why stated loads were not compared, as a message.
    pub fn mismatched_loads(&self) -> Result<Option<String>, String> {
        let stated: Vec<usize> =
            (0..self.grasps.len()).filter(|index| self.grasps.grasps()[*index].load.is_some()).collect();
        if stated.is_empty() {
            return Ok(None);
        }
        let load_model = self.load_model().ok_or_else(|| {
            "stated loads of grasps were not compared: they are computed for a hand with two flat pads and a target that \
             encloses a volume"
                .to_owned()
        })?;
        let chosen = self.grasps.chosen(&stated);
        let computed = chosen.with_loads(load_model.measure());
        let loads = |set: &GraspSet| set.grasps().iter().filter_map(|grasp| grasp.load).collect::<Vec<f64>>();
        let pairs = stated.into_iter().zip(loads(&chosen).into_iter().zip(loads(&computed)));
        let is_false = |(_, (stated, computed)): &(usize, (f64, f64))| {
            (stated - computed).abs() > LOAD_OFF_SHARE * computed.max(1.0)
        };
        let wrong: Vec<_> = pairs.filter(is_false).collect();
        Ok(wrong.first().map(|(grasp, (stated, computed))| {
            format!(
                "{} with a false load: grasp {grasp} states {stated:.2}, computed from mass, friction and pads it is \
                 {computed:.2} (`cranny grasps filter` writes computed ones)",
                counted(wrong.len(), "grasp")
            )
        }))
    }

    /// Returns a message if the grasps do not belong to the target pose: no grasp has any of the target between the pads.
    pub fn misplaced_grasps(&self) -> Option<String> {
        let target = &self.world.bodies()[self.target?];
        let distance_m = |grasp: &cranny_grasp::Grasp| {
            let point = Point::from(grasp.world_from_gripper.translation.vector);
            let to_part = |part: &Part| {
                let world_from_solid = &part.world_from_solid;
                part.solid.aabb().distance_to(&world_from_solid.inverse_transform_point(&point))
            };
            target.parts.iter().map(to_part).fold(f64::INFINITY, f64::min)
        };
        let nearest_m = self.grasps.grasps().iter().map(distance_m).reduce(f64::min)?;
        (nearest_m > FARTHEST_GRASP_M).then(|| {
            let millimetres = nearest_m * 1e3;
            format!(
                "none of the {} is at {}, the nearest is {millimetres:.0} mm away: they belong to another \
                 pose of the target; `cranny grasps sample` makes new ones",
                counted(self.grasps.len(), "grasp"),
                target.name
            )
        })
    }
}
