use std::fmt;
use std::sync::OnceLock;

use cranny_collision::{Body, Cell};
use cranny_grasp::{ASSUMED_DENSITY, ASSUMED_FRICTION, GripForces, HeldObject, LoadMeasure, Pads};
use cranny_robot::Robot;
use cranny_shape::{Outline, Surface, TriangleSoup, UnionMoments, VolumeMoments};
use cranny_spatial::Pose;

use crate::{FailureReason, robot_hand};

/// Masses of the bodies of a world, and the pads that hold them: what is known of loads beside shapes and friction.
#[derive(Clone, Debug, Default)]
pub(crate) struct Weights {
    /// In kilograms, by index of the body; `None`, and beyond the end: not stated.
    pub masses_kg: Vec<Option<f64>>,
    /// Pads and closing force (N) of the robot's hand, once they are asked for.
    pads: OnceLock<Option<(Pads, f64)>>,
}

impl Weights {
    pub fn new(masses_kg: &[Option<f64>]) -> Self {
        Self { masses_kg: masses_kg.to_vec(), pads: OnceLock::new() }
    }

    fn pads(&self, robot: &Robot) -> Option<(Pads, f64)> {
        *self.pads.get_or_init(|| {
            let hand = robot_hand(robot);
            Pads::of(&hand).map(|pads| (pads, hand.closing_force_n))
        })
    }
}

/// The firmness of grasps of a body by a robot's hand: the factor by which loads may grow until it slips
/// ([`LoadMeasure`]). Poses are in the planning frame, in which the body stands when the hand closes.
#[derive(Clone)]
pub struct Firmness {
    measure: LoadMeasure,
    /// True if the mass is not stated, and was assumed from the volume ([`ASSUMED_DENSITY`]).
    pub is_mass_assumed: bool,
}

impl fmt::Debug for Firmness {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter
            .debug_struct("Firmness")
            .field("is_mass_assumed", &self.is_mass_assumed)
            .finish_non_exhaustive()
    }
}

impl Firmness {
    /// Of a body of the world of a cell, with a friction that may not be known ([`ASSUMED_FRICTION`]). `None` for a hand
    /// without two flat pads, or a body that encloses no volume.
    pub(crate) fn new(cell: &Cell, body: usize, friction: Option<f64>, weights: &Weights) -> Option<Self> {
        let (pads, force_n) = weights.pads(cell.robot())?;
        let world = cell.world();
        let (soup, moments) = moments_of(&world.bodies()[body])?;
        let stated_kg = weights.masses_kg.get(body).copied().flatten();
        let mass_kg = stated_kg.unwrap_or(ASSUMED_DENSITY * moments.volume_m3);
        let object = HeldObject {
            surface: Surface::new(&soup).ok()?,
            mass_kg,
            center: moments.center,
            inertia_kg_m2: moments.inertia_per_mass_m2 * mass_kg,
            friction: friction.unwrap_or(ASSUMED_FRICTION),
        };
        let measure = LoadMeasure::new(object, pads, force_n, world.up(), Vec::new());
        Some(Self { measure, is_mass_assumed: stated_kg.is_none() })
    }

    /// The forces of a grasp with the tip at a pose; `None` if no pad bears.
    pub fn grip(&self, world_from_tip: &Pose) -> Option<GripForces> {
        self.measure.grip(world_from_tip)
    }

    /// Reason for which a grasp does not do for what follows: it slips under less than `factor` times the weight, or, where
    /// the object is put down again, it turns or shifts the object too far.
    pub fn fault_of(&self, world_from_tip: &Pose, factor: f64, is_put_down: bool) -> Option<FailureReason> {
        if !self.measure.is_firm(world_from_tip, factor) {
            return Some(FailureReason::Slips);
        }
        (is_put_down && !self.measure.is_seated(world_from_tip)).then_some(FailureReason::TurnsInHand)
    }
}

/// The triangles of a body in the planning frame; `None` for one without an end.
pub(crate) fn soup_in_world(body: &Body) -> Option<TriangleSoup> {
    let mut soup = TriangleSoup::default();
    for part in &body.parts {
        soup.append(&part.solid.tessellation()?, &part.world_from_solid);
    }
    Some(soup)
}

/// The triangles of a body in the planning frame, and the moments of its volume; `None` for one without an end.
fn moments_of(body: &Body) -> Option<(TriangleSoup, VolumeMoments)> {
    let soup = soup_in_world(body)?;
    let is_simple = body.parts.len() == 1 && !matches!(body.parts[0].solid.outline(), Outline::Other);
    let moments = if is_simple {
        VolumeMoments::of_mesh(&soup).ok()?
    } else {
        UnionMoments::of_mesh(&soup).ok()?.moments
    };
    Some((soup, moments))
}
