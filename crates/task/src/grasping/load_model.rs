use std::fmt;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use cranny_collision::{Body, Cell, Part, World};
use cranny_grasp::{ASSUMED_FRICTION, GripForces, Hand, HeldObject, LoadMeasure, Pads};
use cranny_robot::Robot;
use cranny_shape::{Outline, TriangleSoup, UnionMoments, VolumeMoments};
use cranny_spatial::Pose;

use crate::{FailureReason, robot_hand};

/// Mass, moments and rolling resistance of a body, where stated.
#[derive(Clone, Copy, Debug, Default)]
pub struct Weight {
    /// Mass, in kilograms.
    pub mass_kg: Option<f64>,
    /// Centre of mass and inertia, in the frame of the first solid of the body; `None`: uniform density.
    pub moments: Option<VolumeMoments>,
    /// Coefficient of rolling resistance: resisting torque per normal force, in metres; `None`: not stated.
    pub rolling_m: Option<f64>,
}

/// Weights of the bodies of a world and pads of the robot's hand: data for load computations besides shapes and friction.
#[derive(Clone, Debug, Default)]
pub(crate) struct Weights {
    /// By index of the body; bodies beyond the end have no stated weight.
    of_bodies: Vec<Weight>,
    /// Pads and closing force (N) of the robot's hand, computed on first use.
    pads: OnceLock<Option<(Pads, f64)>>,
    /// Load models that were created last, the newest last.
    models: Arc<Mutex<Vec<Known>>>,
}

/// Maximum number of load models that are kept.
const MOST_MODELS: usize = 8;

/// A load model with the body and the friction that it was created for.
#[derive(Clone, Debug)]
struct Known {
    index: usize,
    body: Body,
    friction: Option<f64>,
    model: Option<Arc<LoadModel>>,
}

impl Known {
    fn is_of(&self, index: usize, body: &Body, friction: Option<f64>) -> bool {
        let are_same = |(own, other): (&Part, &Part)| {
            own.world_from_solid == other.world_from_solid && own.solid.is_clone_of(&other.solid)
        };
        self.index == index
            && self.friction.map(f64::to_bits) == friction.map(f64::to_bits)
            && self.body.parts.len() == body.parts.len()
            && self.body.parts.iter().zip(&body.parts).all(are_same)
    }
}

impl Weights {
    pub fn new(of_bodies: &[Weight]) -> Self {
        Self { of_bodies: of_bodies.to_vec(), ..Self::default() }
    }

    /// Returns the weight of a body, by index.
    pub fn of_body(&self, body: usize) -> Weight {
        self.of_bodies.get(body).copied().unwrap_or_default()
    }

    fn pads(&self, robot: &Robot) -> Option<(Pads, f64)> {
        *self.pads.get_or_init(|| {
            let hand = robot_hand(robot);
            Pads::of(&hand).map(|pads| (pads, hand.closing_force_n))
        })
    }
}

/// Loads of grasps of a body by a robot's hand: the factor by which loads may grow until the body slips
/// ([`LoadMeasure`]). Poses are in the planning frame, with the body where it stands when the hand closes.
#[derive(Clone)]
pub struct LoadModel {
    measure: LoadMeasure,
    /// True if the mass is not stated, and was assumed from the volume ([`ASSUMED_DENSITY`](cranny_grasp::ASSUMED_DENSITY)).
    pub is_mass_assumed: bool,
}

impl fmt::Debug for LoadModel {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter
            .debug_struct("LoadModel")
            .field("is_mass_assumed", &self.is_mass_assumed)
            .finish_non_exhaustive()
    }
}

impl LoadModel {
    /// Returns the measure for a body of the world of a cell, which is created if it is not known; without a stated friction it
    /// assumes [`ASSUMED_FRICTION`]. `None` for a hand without two flat pads, or a body that encloses no volume.
    pub(crate) fn new(
        cell: &Cell,
        index: usize,
        friction: Option<f64>,
        weights: &Weights,
    ) -> Option<Arc<Self>> {
        let mut models = weights.models.lock().unwrap_or_else(PoisonError::into_inner);
        let body = &cell.world().bodies()[index];
        if let Some(known) = models.iter().find(|known| known.is_of(index, body, friction)) {
            return known.model.clone();
        }
        let weight = weights.of_body(index);
        let model = weights
            .pads(cell.robot())
            .and_then(|pads| Self::in_world(cell.world(), index, pads, (friction, weight)).map(Arc::new));
        if models.len() == MOST_MODELS {
            models.remove(0);
        }
        models.push(Known { index, body: body.clone(), friction, model: model.clone() });
        model
    }

    /// Creates the measure for grasps of a body by a hand. Friction and mass that are not stated are assumed:
    /// [`ASSUMED_FRICTION`], [`ASSUMED_DENSITY`](cranny_grasp::ASSUMED_DENSITY). `None` without two flat pads or volume.
    pub fn by_hand(
        world: &World,
        body: usize,
        hand: &Hand,
        (friction, weight): (Option<f64>, Weight),
    ) -> Option<Self> {
        Self::in_world(world, body, (Pads::of(hand)?, hand.closing_force_n), (friction, weight))
    }

    fn in_world(
        world: &World,
        body: usize,
        (pads, force_n): (Pads, f64),
        (friction, weight): (Option<f64>, Weight),
    ) -> Option<Self> {
        let body = &world.bodies()[body];
        let soup = soup_in_world(body)?;
        let moments = stated_moments(body, &weight).or_else(|| even_moments(body, &soup))?;
        let friction = friction.unwrap_or(ASSUMED_FRICTION);
        let object = HeldObject::new(&soup, &moments, weight.mass_kg, friction).ok()?;
        let measure = LoadMeasure::new(object, pads, force_n, world.up(), Vec::new());
        Some(Self { measure, is_mass_assumed: weight.mass_kg.is_none() })
    }

    /// Load measure of the grasps, whose poses are in the planning frame.
    pub fn measure(&self) -> &LoadMeasure {
        &self.measure
    }

    /// Computes the contact forces of a grasp with the tip at a pose in the planning frame; `None` if no pad bears load.
    pub fn grip(&self, world_from_tip: &Pose) -> Option<GripForces> {
        self.measure.grip(world_from_tip)
    }

    /// Returns the reason for rejecting a grasp: it slips under less than `factor` times the weight, or, if the object is put
    /// down again, closing turns or shifts the object too far.
    pub fn fault_of(&self, world_from_tip: &Pose, factor: f64, is_put_down: bool) -> Option<FailureReason> {
        if !self.measure.is_firm(world_from_tip, factor) {
            return Some(FailureReason::Slips);
        }
        (is_put_down && !self.measure.is_seated(world_from_tip)).then_some(FailureReason::TurnsInHand)
    }
}

/// Returns the moments of a body of 1 kg in the planning frame; `None` if none are stated and it encloses no volume.
pub(crate) fn moments_of(body: &Body, weight: &Weight) -> Option<VolumeMoments> {
    stated_moments(body, weight).or_else(|| even_moments(body, &soup_in_world(body)?))
}

fn stated_moments(body: &Body, weight: &Weight) -> Option<VolumeMoments> {
    Some(weight.moments?.moved(&body.parts.first()?.world_from_solid))
}

/// Returns the triangles of a body in the planning frame; `None` for an unbounded body.
pub(crate) fn soup_in_world(body: &Body) -> Option<TriangleSoup> {
    let mut soup = TriangleSoup::default();
    for part in &body.parts {
        soup.append(&part.solid.tessellation()?, &part.world_from_solid);
    }
    Some(soup)
}

/// Returns the moments of a body of uniform density with these triangles; `None` if it encloses no volume.
fn even_moments(body: &Body, soup: &TriangleSoup) -> Option<VolumeMoments> {
    let is_simple = body.parts.len() == 1 && !matches!(body.parts[0].solid.outline(), Outline::Other);
    if is_simple {
        return VolumeMoments::of_mesh(soup).ok();
    }
    Some(UnionMoments::of_mesh(soup).ok()?.moments)
}
