use std::sync::Arc;

use cranny_robot::{FARTHEST_HELD_M, Hold};

use crate::body::held_body::{HeldBody, Spared};
use crate::{CollisionError, Resting};

use crate::body::cell_parts::CellParts;
use crate::body::link_body::{LinkBody, group_separation};
use crate::cell::{Cell, Scratch};

impl Cell {
    /// Returns the cell with a body of the world in the hand ([`Hold`]): the held object moves with the robot, is checked
    /// against the world, the floor and all links with relative motion, and is no obstacle any more. For another hold of the
    /// same object see [`Self::with_hold`]; for its allowed contacts see [`Self::with_allowed_contacts`].
    ///
    /// # Errors
    /// [`CollisionError::Hold`] for an invalid hold, or an unbounded body.
    ///
    /// # Panics
    /// If the world has no body of that index.
    pub fn holding(&self, body: usize, hold: Hold) -> Result<Self, CollisionError> {
        let thing = &self.world().bodies()[body];
        let unusable = || CollisionError::Hold { name: thing.name.clone() };
        if self.held.is_some() || !check_hold(&hold) {
            return Err(unusable());
        }
        let robot = self.robot.holding(&thing.name);
        let held_from_world = thing.parts.first().ok_or_else(unusable)?.world_from_solid.inverse();
        let shapes =
            thing.parts.iter().map(|part| (held_from_world * part.world_from_solid, part.solid.clone()));
        let link = robot.held_link().ok_or_else(unusable)?;
        let held = LinkBody::of_shapes(link, shapes.collect()).ok_or_else(unusable)?;
        Ok(Self::of(CellParts {
            body: Arc::new(self.body.holding(&robot, held)),
            robot: Arc::new(robot),
            held: Some(HeldBody { body, spared: Arc::default(), hold }),
            ..self.parts_of()
        }))
    }

    /// Returns this robot, with its held object, in the surroundings and with the margins of another cell.
    #[must_use]
    pub fn with_surroundings_of(&self, other: &Self) -> Self {
        let (robot, body, held) = (self.robot.clone(), self.body.clone(), self.held.clone());
        Self::of(CellParts { robot, body, held, ..other.parts_of() })
    }

    /// Returns the distance of the held object from the bodies of the world at `q` (m, rad; one per joint), without floors, in
    /// metres, as a certified lower bound: at most `beyond_m` (m), because larger distances are not measured.
    ///
    /// # Panics
    /// If `q` has not one value per joint, or nothing is held.
    pub fn held_clearance(&self, q: &[f64], beyond_m: f64, scratch: &mut Scratch) -> f64 {
        self.robot.forward_kinematics(q, &mut scratch.frames);
        let (held, link) = self.held.as_ref().zip(self.robot.held_link()).expect("something is held");
        let own = self.bodies.iter().position(|body| body.link == link).expect("it has a shape");
        let others =
            self.parts().iter().filter(|(body, part)| *body != held.body && !part.solid.is_half_space());
        others.fold(beyond_m, |least_m, (_, part)| {
            let bound_m = self.bodies[own].quick_bound_to(scratch.frames.link(link), part, least_m);
            if bound_m >= least_m {
                return least_m;
            }
            let placed = std::iter::once((part.world_from_solid, &part.solid));
            group_separation(self.placed(own, &scratch.frames), &placed, least_m).lower_m.min(least_m)
        })
    }

    /// Returns this cell with the held object allowed to touch its support faces, and nothing else. Of the parts with these
    /// faces, only the portions above the faces are checked. [`Self::first_support_violation`] proves that the object stays
    /// above the faces; [`Self::unchecked`] lists the allowed contacts.
    #[must_use]
    pub fn with_allowed_contacts(&self, resting: &Resting) -> Self {
        let (mut spared, mut higher) = (Vec::new(), Vec::new());
        for (part, depth_m, lip) in resting.spared(self.parts()) {
            spared.push(Spared { part, depth_m });
            higher.extend(lip);
        }
        let held = self.held.clone().map(|held| HeldBody { spared: spared.into(), ..held });
        let around =
            if higher.is_empty() { self.around.clone() } else { Arc::new(self.around.with_parts(&higher)) };
        Self::of(CellParts { around, held, ..self.parts_of() })
    }

    /// Returns this cell with another pose of the held object in the hand, or another closing.
    ///
    /// # Errors
    /// [`CollisionError::Hold`] for an invalid hold.
    pub fn with_hold(&self, hold: Hold) -> Result<Self, CollisionError> {
        let mut cell = self.clone();
        if let Some(held) = &mut cell.held {
            if !check_hold(&hold) {
                return Err(CollisionError::Hold { name: self.world().bodies()[held.body].name.clone() });
            }
            held.hold = hold;
        }
        cell.bounds = cell.all_bounds().into();
        Ok(cell)
    }
}

/// Returns true if a hold is within the allowed ranges.
fn check_hold(hold: &Hold) -> bool {
    let Hold { tip_from_held, closing } = hold;
    tip_from_held.translation.vector.norm() <= FARTHEST_HELD_M
        && tip_from_held.rotation.coords.iter().all(|x| x.is_finite())
        && (0.0..=1.0).contains(closing)
}
