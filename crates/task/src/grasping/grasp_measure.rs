use cranny_collision::{Body, Cell};
use cranny_grasp::{Contact, friction_needed, friction_score};
use cranny_shape::{AreaDistribution, Surface};
use cranny_spatial::{Pose, Vector};

use crate::TaskError;
use crate::grasping::closing_hand::ClosingHand;
use crate::grasping::load_model::soup_in_world;
use crate::grasping::pad_contact::PadSurfaces;

/// Measure of grasps for a problem without a set of them: surface and friction of the target, and the hand that closes on it.
#[derive(Clone, Debug)]
pub struct GraspMeasure {
    hand: ClosingHand,
    surface_in_world: Surface,
    friction: f64,
    opening_m: f64,
    closed_gap_m: f64,
    pads: PadSurfaces,
}

impl GraspMeasure {
    /// Least score of a grasp, in [0, 1]. A grasp of this score still holds with four fifths of the friction, which allows for
    /// small errors in the pose of the pads.
    pub const LEAST_SCORE: f64 = 0.2;

    /// Creates the measure for the target of a problem in its cell; `friction` is the coefficient between pads and target.
    ///
    /// # Errors
    /// [`TaskError::NoGraspMeasure`] for a problem under `paper`, without a target or with an unbounded one, of a robot whose
    /// hand cannot close, or for a friction that is not positive.
    pub fn new(cell: Option<&Cell>, target: Option<usize>, friction: f64) -> Result<Self, TaskError> {
        let lacking = |needs| TaskError::NoGraspMeasure { needs };
        let (hand, cell) = ClosingHand::new(cell, target, lacking)?;
        let body = &cell.world().bodies()[hand.target()];
        let surface_in_world = surface_in_world(body).ok_or_else(|| lacking("a target with a surface"))?;
        if !(friction > 0.0 && friction.is_finite()) {
            return Err(lacking("a positive coefficient of friction"));
        }
        let [opening_m, closed_gap_m] =
            cell.robot().hand().map_or([0.0; 2], |hand| [hand.description.opening_m, hand.closed_gap_m()]);
        if opening_m <= 0.0 {
            return Err(lacking("a hand that opens"));
        }
        let pads = PadSurfaces::of(hand.holding());
        Ok(Self { hand, surface_in_world, friction, opening_m, closed_gap_m, pads })
    }

    /// The hand that closes on the target.
    pub fn hand(&self) -> &ClosingHand {
        &self.hand
    }

    /// Triangles of the target in the planning frame, with outward normals.
    pub fn surface_in_world(&self) -> &Surface {
        &self.surface_in_world
    }

    /// Coefficient of friction between pads and target.
    pub fn friction(&self) -> f64 {
        self.friction
    }

    /// Distance between the pads of the open hand, in metres.
    pub fn opening_m(&self) -> f64 {
        self.opening_m
    }

    /// Gap that stays between the pads of the closed hand, in metres: no thinner object is held.
    pub fn closed_gap_m(&self) -> f64 {
        self.closed_gap_m
    }

    /// Returns the two points where the middles of the pads first meet the surface when they close along y of the gripper frame
    /// through its origin; `None` if they miss it. The first is that of the pad on the −y side.
    pub fn contacts_in_world(&self, world_from_gripper: &Pose) -> Option<[Contact; 2]> {
        let origin = world_from_gripper * cranny_spatial::Point::origin();
        let y = world_from_gripper.rotation * Vector::y();
        let contact = |side: f64| {
            let (pad, way) = (origin + y * (0.5 * side * self.opening_m), y * -side);
            let hits = self.surface_in_world.ray_hits(&pad, &way, self.opening_m);
            let hit = hits.first()?;
            Some(Contact { point_in_object: pad + way * hit.distance_m, normal_in_object: hit.normal })
        };
        Some([contact(-1.0)?, contact(1.0)?])
    }

    /// Returns the score of the grasp of a closed hand, in [0, 1], from the contacts of its pads; 0 if these are not in force
    /// closure ([`friction_needed`], [`friction_score`]). `None` if fewer than two fingers touch the target.
    /// `world_from_gripper` is in the planning frame; `touching` is the share of its travel that each finger has closed, one
    /// per finger, from 0 to 1.
    pub fn pad_score(&self, world_from_gripper: &Pose, touching: &[f64]) -> Option<f64> {
        let holding = self.hand.holding();
        let target = &holding.world().bodies()[self.hand.target()];
        let of_target = (target, &self.surface_in_world);
        let needed = self.pads.friction_needed(holding, of_target, world_from_gripper, touching)?;
        Some(friction_score(needed, self.friction))
    }

    /// Estimates the score of the grasp at a pose from a single line between the middles of the pads: a filter for sampled
    /// grasps that ignores the true contact positions. In [0, 1]; 0 if the contacts are not in force closure
    /// ([`friction_needed`], [`friction_score`]), `None` without contacts.
    pub fn score(&self, world_from_gripper: &Pose) -> Option<f64> {
        let [a, b] = self.contacts_in_world(world_from_gripper)?;
        Some(friction_score(friction_needed(&a, &b), self.friction))
    }
}

/// Returns the triangles of a body in the planning frame; `None` for one without triangles, or an unbounded one.
fn surface_in_world(body: &Body) -> Option<Surface> {
    let surface = Surface::new(&soup_in_world(body)?).ok()?;
    AreaDistribution::new(&surface).is_some().then_some(surface)
}
