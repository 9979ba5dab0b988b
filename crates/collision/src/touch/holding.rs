use std::sync::Arc;

use cranny_robot::{FARTHEST_HELD_M, Hold};

use crate::body::held_body::{HeldBody, Spared};
use crate::{CollisionError, Resting};

use crate::body::cell_parts::CellParts;
use crate::body::link_body::{LinkBody, group_separation};
use crate::cell::{Cell, Scratch};

impl Cell {
    /// The cell in the mode in which the hand holds a body of the world ([`Hold`]): the body is part of the robot then,
    /// checked against world, floor and all links that move against it, and no obstacle any more. Another hold of the same
    /// body is [`Self::with_hold`]; what it may touch yet, [`Self::sparing`].
    ///
    /// # Errors
    /// [`CollisionError::Hold`] for a hold that is none, or a body without bounds.
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

    /// The same robot, with what it holds, in the surroundings of another cell, with the margins of that.
    #[must_use]
    pub fn amid(&self, other: &Self) -> Self {
        let (robot, body, held) = (self.robot.clone(), self.body.clone(), self.held.clone());
        Self::of(CellParts { robot, body, held, ..other.parts_of() })
    }

    /// Distance of what is held from the bodies of the world at `q` (m, rad; one per joint), floors aside, in metres,
    /// certified from below: at most `beyond_m`, for what is farther is not measured.
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

    /// The same cell with what is held free to touch the faces that carry it, and nothing else: it is not checked against the
    /// parts that have them, but against what of these is higher. [`Self::stays_off`] proves that it stays above the faces;
    /// [`Self::unchecked`] names them.
    #[must_use]
    pub fn sparing(&self, resting: &Resting) -> Self {
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

    /// The same cell with the body that is held in another place of the hand, or the hand closed otherwise.
    ///
    /// # Errors
    /// [`CollisionError::Hold`] for a hold that is none.
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

/// Whether a hand can hold something like that.
fn check_hold(hold: &Hold) -> bool {
    let Hold { tip_from_held, closing } = hold;
    tip_from_held.translation.vector.norm() <= FARTHEST_HELD_M
        && tip_from_held.rotation.coords.iter().all(|x| x.is_finite())
        && (0.0..=1.0).contains(closing)
}
