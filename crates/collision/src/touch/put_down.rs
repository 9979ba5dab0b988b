use std::sync::Arc;

use cranny_spatial::Pose;

use crate::body::cell_parts::CellParts;
use crate::body::link_body::group_separation;
use crate::cell::{Cell, Scratch};
use crate::touch::resting::moved_to;
use crate::{CollisionError, Margins};

impl Cell {
    /// Returns this cell, with an open and empty hand, after moving a body of the world so that its first solid is at a pose in
    /// the planning frame. The grasp margin of the hand then applies to the body, to its new supports, and to all bodies moved so
    /// before.
    ///
    /// # Errors
    /// [`CollisionError::Pose`] for an invalid pose.
    ///
    /// # Panics
    /// If the world has no body of that index, or something is held.
    pub fn with_body_at(&self, body: usize, world_from_first: &Pose) -> Result<Self, CollisionError> {
        assert!(self.held.is_none(), "what is held is not put down by that");
        let moved = moved_to(&self.world().bodies()[body], world_from_first);
        let around = self.around.with_body_moved(body, &moved)?;
        let grasp_bodies = around.grasp_bodies(body, self.margins);
        Ok(Self::of(CellParts { around: Arc::new(around), grasp_bodies, ..self.parts_of() }))
    }

    /// Returns the index of the body to be grasped, if there is one.
    pub fn grasp_body(&self) -> Option<usize> {
        self.grasp_bodies.last().copied()
    }

    /// Returns this cell, with an open and empty hand, for grasping another body with other margins; `None` if nothing changes.
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
        let grasp_bodies = self.around.grasp_bodies(body, margins);
        Ok(Some(Self::of(CellParts { margins, grasp_bodies, ..self.parts_of() })))
    }

    /// Returns the distance of the hand from a body of the world at `q` (m, rad; one per joint), in metres, as a certified
    /// lower bound: at most `beyond_m` (m), because larger distances are not measured.
    ///
    /// # Panics
    /// If `q` has not one value per joint, or the world has no body of that index.
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
