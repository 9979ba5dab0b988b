use std::sync::Arc;

use cranny_robot::Robot;
use cranny_spatial::Pose;

use crate::body::held_body::HeldBody;
use crate::body::part_tree::PartTree;
use crate::body::robot_body::RobotBody;
use crate::body::world::{Body, Part, World};
use crate::lane::lane_part::LanePart;
use crate::{CollisionError, Margins, ToolBound};

/// Constituents of a cell.
pub(crate) struct CellParts {
    pub robot: Arc<Robot>,
    pub body: Arc<RobotBody>,
    pub around: Arc<Surroundings>,
    pub margins: Margins,
    pub grasp_bodies: Arc<[usize]>,
    /// Pairs of links that are checked on request, although they are exempt.
    pub asked_for: Arc<[(usize, usize)]>,
    pub held: Option<HeldBody>,
    /// Bounds on the tool in addition to those of the world.
    pub further_bounds: Arc<[ToolBound]>,
}

impl CellParts {
    /// Creates the constituents for an empty hand with nothing to be grasped.
    ///
    /// # Errors
    /// [`CollisionError::Margin`] for a negative or infinite margin, [`CollisionError::UnknownLink`] for a bound of a link that
    /// the robot does not have, [`CollisionError::FingerBound`] for one of a finger, which moves by itself.
    pub fn new(robot: Arc<Robot>, world: World, margins: Margins) -> Result<Self, CollisionError> {
        margins.check()?;
        world.tool_bounds().iter().try_for_each(|bound| bound.check_link(&robot))?;
        Ok(Self {
            body: RobotBody::of(&robot),
            robot,
            around: Arc::new(Surroundings::new(world)),
            margins,
            grasp_bodies: Arc::default(),
            asked_for: Arc::default(),
            held: None,
            further_bounds: Arc::default(),
        })
    }
}

/// A world with the structures for its checks, independent of the robot.
#[derive(Debug)]
pub(crate) struct Surroundings {
    pub world: World,
    pub parts: Vec<(usize, Part)>,
    pub lanes: Arc<[LanePart]>,
    pub tree: PartTree,
    /// Bodies that were put down somewhere else, by index.
    put_down: Vec<usize>,
}

impl Surroundings {
    fn new(world: World) -> Self {
        let of_body = |(body, b): (usize, &Body)| {
            b.parts.iter().map(move |part| (body, part.clone())).collect::<Vec<_>>()
        };
        let parts: Vec<(usize, Part)> = world.bodies().iter().enumerate().flat_map(of_body).collect();
        let tree = PartTree::new(parts.iter().map(|(_, part)| part));
        let lanes = parts.iter().map(|(_, part)| LanePart::of(part)).collect();
        Self { world, parts, lanes, tree, put_down: Vec::new() }
    }

    /// Returns the bodies to which the grasp margin of the hand applies when it grasps or releases `body`, by index: its
    /// supports; the bodies put down before, which a touch would topple, unless all must be farther away; and last the body.
    pub fn grasp_bodies(&self, body: usize, margins: Margins) -> Arc<[usize]> {
        let mut bodies = self.world.supports_of(body);
        if margins.grasp_margin_m > margins.margin_m {
            bodies.extend(self.put_down.iter().filter(|put_down| **put_down != body));
        }
        bodies.push(body);
        bodies.into()
    }

    /// Returns these surroundings with a body put down: moved by `to`, a motion in the planning frame.
    ///
    /// # Errors
    /// As [`World::new`].
    pub fn with_body_moved(&self, moved: usize, to: &Pose) -> Result<Self, CollisionError> {
        let mut bodies = self.world.bodies().to_vec();
        for part in &mut bodies[moved].parts {
            part.world_from_solid = to * part.world_from_solid;
        }
        let mut own = bodies[moved].parts.clone().into_iter();
        let (mut parts, mut lanes) = (self.parts.clone(), self.lanes.to_vec());
        for ((body, part), lane) in parts.iter_mut().zip(&mut lanes) {
            if *body == moved
                && let Some(new) = own.next()
            {
                *lane = lane.moved(&new);
                *part = new;
            }
        }
        let tree = PartTree::new(parts.iter().map(|(_, part)| part));
        let mut put_down = self.put_down.clone();
        put_down.push(moved);
        Ok(Self { world: self.world.with_bodies(bodies)?, parts, lanes: lanes.into(), tree, put_down })
    }

    /// Returns these surroundings with further parts of its bodies, numbered after all others.
    pub fn with_parts(&self, further: &[(usize, Part)]) -> Self {
        let lanes = self.lanes.iter().cloned().chain(further.iter().map(|(_, part)| LanePart::of(part)));
        let lanes = lanes.collect();
        let parts = [&self.parts[..], further].concat();
        let tree = PartTree::new(parts.iter().map(|(_, part)| part));
        Self { world: self.world.clone(), parts, lanes, tree, put_down: self.put_down.clone() }
    }
}
