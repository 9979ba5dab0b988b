use std::sync::Arc;

use cranny_spatial::Pose;

use crate::body::cell_parts::CellParts;
use crate::body::link_body::group_separation;
use crate::cell::{Cell, Scratch};
use crate::touch::resting::moved_to;
use crate::{CollisionError, Margins};

impl Cell {
    /// The same cell, of the open and empty hand, with a body of the world elsewhere: its first solid at a pose. The hand may
    /// come as near to it, and to what it then rests on, as to what is to be grasped.
    ///
    /// # Errors
    /// [`CollisionError::Pose`] for a pose that is none.
    ///
    /// # Panics
    /// If the world has no body of that index, or something is held.
    pub fn with_body_at(&self, body: usize, world_from_first: &Pose) -> Result<Self, CollisionError> {
        assert!(self.held.is_none(), "what is held is not put down by that");
        let moved = moved_to(&self.world().bodies()[body], world_from_first);
        let around = self.around.with_body_moved(body, &moved)?;
        let mut grasp_bodies = around.world.supports_of(body);
        grasp_bodies.push(body);
        Ok(Self::of(CellParts {
            around: Arc::new(around),
            grasp_bodies: grasp_bodies.into(),
            ..self.parts_of()
        }))
    }

    /// The body to be grasped, by index, if there is one.
    pub fn grasp_body(&self) -> Option<usize> {
        self.grasp_bodies.last().copied()
    }

    /// The same cell, of the open and empty hand, with another body to be grasped, and other margins; `None` if it is that.
    ///
    /// # Errors
    /// [`CollisionError::Margin`] for a negative or infinite margin.
    ///
    /// # Panics
    /// If the world has no body of that index.
    pub fn to_grasp(&self, body: usize, margins: Margins) -> Result<Option<Self>, CollisionError> {
        margins.check()?;
        if self.grasp_body() == Some(body) && self.margins == margins {
            return Ok(None);
        }
        let mut grasp_bodies = self.world().supports_of(body);
        grasp_bodies.push(body);
        Ok(Some(Self::of(CellParts { grasp_bodies: grasp_bodies.into(), margins, ..self.parts_of() })))
    }

    /// Distance of the hand from a body of the world at `q` (m, rad; one per joint), in metres, certified from below:
    /// at most `beyond_m`, for what is farther is not measured.
    ///
    /// # Panics
    /// If `q` has not one value per joint, or the world no body of that index.
    pub fn hand_clearance(&self, q: &[f64], body: usize, beyond_m: f64, scratch: &mut Scratch) -> f64 {
        self.robot.forward_kinematics(q, &mut scratch.frames);
        let parts = &self.world().bodies()[body].parts;
        let placed = parts.iter().map(|part| (part.world_from_solid, &part.solid));
        let is_of_hand = |index: &usize| self.robot.hand_links().contains(&self.bodies[*index].link);
        let of_hand = (0..self.bodies.len()).filter(is_of_hand);
        of_hand.fold(beyond_m, |least_m, index| {
            group_separation(self.placed(index, &scratch.frames), &placed, least_m).lower_m.min(least_m)
        })
    }
}
