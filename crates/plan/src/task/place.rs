use std::f64::consts::PI;
use std::sync::OnceLock;

use cranny_collision::{CONTACT_ALLOWANCE_M, Collider, Extent, Part, Resting};
use cranny_spatial::nalgebra::{Quaternion, UnitQuaternion};
use cranny_spatial::{EXACT_ROTATION_RAD, Point, Pose, PoseDifference, Rotation, Stream, Vector, sin_cos};

use crate::task::placed::MOST_RETREAT_M;
use crate::task::placement::Placement;
use crate::task::rests::{rests, stable_rests};
use crate::{Carrier, FailureReason, Grip, PlaceGoal, PlaceSpot, PlanError};

/// An object is let go so far above what it is put down on, in metres: far less than matters to it, and far more than
/// the errors of inverse kinematics.
const GAP_M: f64 = 3e-4;
/// How far above it may be at most, in metres.
const MOST_ABOVE_M: f64 = 1e-3;
/// An object at a given pose is within this of a stable one, as the chord of an angle (20°): one that is round rolls a little
/// (the banana of the gate lies 12° off), on an edge it lies farther off.
const MOST_TILT_RAD: f64 = 0.35;
/// How far an object may reach over the edge of a surface, in metres: rounding.
const OVERHANG_M: f64 = 1e-6;
/// Places that are looked at for some where the object can be, and how many of these are enough.
const MOST_DRAWS: u32 = 2000;
const ENOUGH_PLACES: usize = 96;
/// Number of placements that are looked at for some after which the task may go on.
const MOST_HOPES: usize = 4000;
/// A hand that can be at none of so many places is not tried at others: what it touches is mostly what carries the object.
const ENOUGH_TO_REFUSE: usize = 16;
/// The normal of a floor is no farther from the vertical, as a chord: rounding.
const LEVEL: f64 = 1e-9;

/// Puts down what a [`Carrier`] carries.
#[derive(Clone, Debug)]
pub struct Placer {
    carrier: Carrier,
    goal: PlaceGoal,
    /// Distance of the hand from the object at the end of its retreat, in metres.
    clear_m: f64,
    extent: Extent,
    /// In which rotations it can rest, and the first solid with it, turns about the vertical aside, from a frame whose z axis
    /// is up; none where it can in any.
    rests: Vec<Rotation>,
    draws: Vec<Draw>,
}

/// A place that may be looked at.
#[derive(Clone, Debug)]
struct Draw {
    /// Which way to rest.
    rest: usize,
    /// The turn about the vertical, in radians.
    turn_rad: f64,
    /// Where between the edges of the surface, in [0, 1].
    shares: [f64; 2],
    /// What was found there, once it was looked at.
    placement: OnceLock<Option<Placement>>,
    /// Whether what follows in the task may be done then, once that was looked at.
    is_hopeful: OnceLock<bool>,
}

impl Placer {
    /// Of a carrier's object, with no placements yet.
    ///
    /// # Errors
    /// [`PlanError::Place`] for a goal that is none, [`PlanError::Collision`] for an object without bounds.
    pub fn new(carrier: &Carrier, goal: &PlaceGoal, clear_m: f64) -> Result<Self, PlanError> {
        let target = carrier.hand().target();
        let body = &carrier.hand().holding().world().bodies()[target];
        let extent = carrier.resting().extent().clone();
        let level_from_world = carrier.hand().holding().world().world_from_level().inverse();
        let rests = match &goal.spot {
            PlaceSpot::Target(_) => stable_rests(body, &extent, &level_from_world, 0.0).unwrap_or_default(),
            PlaceSpot::Surface { .. } => rests(body, &extent, &level_from_world),
        };
        let placer =
            Self { carrier: carrier.clone(), goal: goal.clone(), clear_m, extent, rests, draws: Vec::new() };
        placer.check()?;
        Ok(placer)
    }

    /// The same with places where the object may be, the same ones for the same seed.
    #[must_use]
    pub fn with_placements(self, seed: u64) -> Self {
        self.with_draws(seed, MOST_DRAWS)
    }

    /// The same with at most so many places that are looked at: the first ones are those of [`Self::with_placements`].
    #[must_use]
    pub fn with_draws(self, seed: u64, most: u32) -> Self {
        let mut random = Stream::new(seed, PLACES_STREAM);
        let count = match &self.goal.spot {
            PlaceSpot::Target(_) => 1,
            PlaceSpot::Surface { .. } => most,
        };
        let draw = |draw: u32| Draw {
            // Every other time as it can rest best.
            rest: if draw.is_multiple_of(2) { 0 } else { random.index(self.rests.len().max(1)) },
            turn_rad: random.uniform_between(-PI, PI),
            shares: [random.uniform(), random.uniform()],
            placement: OnceLock::new(),
            is_hopeful: OnceLock::new(),
        };
        Self { draws: (0..count).map(draw).collect(), ..self }
    }

    /// The same places of the same object in the surroundings of another carrier, none of them looked at yet.
    #[must_use]
    pub fn amid(&self, carrier: &Carrier) -> Self {
        let draws = self.draws.iter().map(|draw| Draw {
            placement: OnceLock::new(),
            is_hopeful: OnceLock::new(),
            ..*draw
        });
        let (goal, extent, rests) = (self.goal.clone(), self.extent.clone(), self.rests.clone());
        Self { carrier: carrier.clone(), goal, extent, rests, draws: draws.collect(), ..*self }
    }

    /// True if the object can be at one of the first draws.
    pub fn has_placement(&self, most_draws: usize) -> bool {
        self.draws.iter().take(most_draws).any(|draw| self.look_at(draw).is_some())
    }

    fn check(&self) -> Result<(), PlanError> {
        let refuse = |problem: String| Err(PlanError::Place { problem });
        let Self { goal, clear_m, .. } = self;
        let name = &goal.name;
        if !(0.0..=MOST_RETREAT_M).contains(clear_m) {
            return refuse(format!("{clear_m} m is no clearance of the hand; give 0 to {MOST_RETREAT_M} m"));
        }
        let PlaceSpot::Surface { on, pose, size_m } = &goal.spot else { return Ok(()) };
        if self.carrier.hand().holding().world().body_index(on)? == self.target() {
            return refuse(format!("place '{name}' lies on what is to be put down there"));
        }
        if !size_m.iter().all(|size_m| size_m.is_finite() && *size_m > 0.0) {
            return refuse(format!("place '{name}' has no size"));
        }
        if (pose.rotation * Vector::z() - self.up()).norm() > EXACT_ROTATION_RAD {
            return refuse(format!("place '{name}' is not level"));
        }
        Ok(())
    }

    fn target(&self) -> usize {
        self.carrier.hand().target()
    }

    fn up(&self) -> Vector {
        self.carrier.hand().holding().world().up()
    }

    /// Where the object is by a draw.
    fn pose_of(&self, draw: &Draw) -> Pose {
        let (world_from_surface, size_m) = match &self.goal.spot {
            PlaceSpot::Target(pose) => return *pose,
            PlaceSpot::Surface { pose, size_m, .. } => (pose, size_m),
        };
        let (sine, cosine) = sin_cos(0.5 * draw.turn_rad);
        let turn = UnitQuaternion::new_unchecked(Quaternion::new(cosine, 0.0, 0.0, sine));
        let world_from_level = self.carrier.hand().holding().world().world_from_level();
        let turned =
            Pose::from_parts(Vector::zeros().into(), world_from_level * turn * self.rests[draw.rest]);
        let extent_m = |axis: usize| {
            let along = world_from_surface.rotation * Vector::ith(axis, 1.0);
            [self.extent.lowest_along(&turned, &along), -self.extent.lowest_along(&turned, &-along)]
        };
        let [x, y] = [0, 1].map(|axis| {
            let ([low_m, high_m], half_m) = (extent_m(axis), 0.5 * size_m[axis]);
            let [first, last] = [-half_m - low_m, half_m - high_m];
            first + draw.shares[axis] * (last - first)
        });
        let place = world_from_surface * Point::new(x, y, GAP_M - extent_m(2)[0]);
        Pose::from_parts(place.coords.into(), turned.rotation)
    }

    /// Where the object can be put down, as far as it alone is concerned, each with the number of its draw: of a place that
    /// is a pose that one, if it can. Those that `is_hopeful` approves of come first, up to the last that it is asked about.
    pub fn placements<'a>(
        &'a self,
        is_hopeful: Option<&'a dyn Fn(&Placement) -> bool>,
    ) -> impl Iterator<Item = (usize, &'a Placement)> {
        let looked_at = |(number, draw): (usize, &'a Draw)| Some((number, draw, self.look_at(draw)?));
        let all = move || self.draws.iter().enumerate().filter_map(looked_at);
        let hopes = move |draw: &Draw, placement: &Placement| {
            is_hopeful.is_some_and(|is_hopeful| *draw.is_hopeful.get_or_init(|| is_hopeful(placement)))
        };
        let first = all().take_while(move |_| is_hopeful.is_some()).take(MOST_HOPES);
        let first = first.filter(move |(_, draw, placement)| hopes(draw, placement));
        // Without hope a few are enough.
        let others = all().filter(|(_, draw, _)| draw.is_hopeful.get() != Some(&true));
        first.chain(others).map(|(number, _, placement)| (number, placement)).take(ENOUGH_PLACES)
    }

    /// Where the object is by a draw, if it can be there.
    fn look_at<'a>(&self, draw: &'a Draw) -> Option<&'a Placement> {
        let look = || {
            let pose = self.pose_of(draw);
            if let PlaceSpot::Surface { pose: surface, size_m, .. } = &self.goal.spot
                && self.over_edge_m(surface, size_m, &pose) > OVERHANG_M
            {
                return None;
            }
            let placement = self.placement(&pose);
            self.fault_of(&placement).is_none().then_some(placement)
        };
        draw.placement.get_or_init(look).as_ref()
    }

    /// The object at a pose, and its supports there. The cell is that of a draw that was evaluated before, if it
    /// applies to this pose too.
    fn placement(&self, world_from_held: &Pose) -> Placement {
        let known = self.draws.iter().filter_map(|draw| draw.placement.get()?.as_ref());
        self.carrier.placement_among(known, world_from_held)
    }

    /// A fault, in words, of the object let go with its first solid at a pose; `None` if it is where it is to be.
    pub fn fault_at(&self, world_from_held: &Pose) -> Option<String> {
        self.fault_of(&self.placement(world_from_held))
    }

    /// What is wrong with an object that is let go at a pose, in words; `None` if it is where it is to be.
    pub(crate) fn fault_of(&self, Placement { world_from_held, resting, .. }: &Placement) -> Option<String> {
        let name = &self.goal.name;
        let up_in_held = world_from_held.rotation.inverse() * self.up();
        let tilt = |rest: &Rotation| (rest.inverse() * Vector::z() - up_in_held).norm();
        let tilt_rad = self.rests.iter().map(tilt).reduce(f64::min).unwrap_or(0.0);
        let tilted = |most_rad: f64| {
            (tilt_rad.is_nan() || tilt_rad > most_rad)
                .then(|| format!("it is {:.2}° from any way to rest", tilt_rad.to_degrees()))
        };
        let (on, world_from_surface, size_m) = match &self.goal.spot {
            PlaceSpot::Target(pose) => {
                let off = PoseDifference::between(pose, world_from_held);
                if !off.is_exact() {
                    let (mm, degrees) = (off.translation_m * 1e3, off.rotation_rad.to_degrees());
                    return Some(format!("it is {mm:.2} mm and {degrees:.2}° from where it is to be"));
                }
                return self.fault_of_rest(resting, None).or_else(|| tilted(MOST_TILT_RAD));
            }
            PlaceSpot::Surface { on, pose, size_m } => (on, pose, size_m),
        };
        let up = world_from_surface.rotation * Vector::z();
        let middle = world_from_surface.translation.vector;
        let above_m = self.extent.lowest_along(world_from_held, &up) - up.dot(&middle);
        if !(-CONTACT_ALLOWANCE_M..=MOST_ABOVE_M).contains(&above_m) {
            return Some(format!("it is {:.2} mm above '{name}'", above_m * 1e3));
        }
        if let Some(fault) = tilted(EXACT_ROTATION_RAD) {
            return Some(fault);
        }
        let over_m = self.over_edge_m(world_from_surface, size_m, world_from_held);
        if over_m.is_nan() || over_m > OVERHANG_M {
            return Some(format!("it reaches {:.2} mm over the edge of '{name}'", over_m * 1e3));
        }
        self.fault_of_rest(resting, Some(on))
    }

    /// Distance by which the object reaches over the edges of a rectangle, in metres; negative within them.
    fn over_edge_m(&self, world_from_surface: &Pose, size_m: &[f64; 2], world_from_held: &Pose) -> f64 {
        let middle = world_from_surface.translation.vector;
        let over_m = [0, 1].into_iter().flat_map(|axis| {
            let along = world_from_surface.rotation * Vector::ith(axis, 1.0);
            [along, -along].map(|along| {
                -0.5 * size_m[axis] - (self.extent.lowest_along(world_from_held, &along) - along.dot(&middle))
            })
        });
        over_m.fold(f64::NEG_INFINITY, f64::max)
    }

    /// Fault of a resting pose, if any: too near to or inside another body, on nothing, on a slope, above its support,
    /// or on a body other than its support.
    fn fault_of_rest(&self, resting: &Resting, on: Option<&str>) -> Option<String> {
        let body_name = |body: usize| self.carrier.body_name(body);
        let deepest = resting.beside().max_by(|a, b| a.2.total_cmp(&b.2).then(b.1.total_cmp(&a.1)));
        match (deepest, resting.overhang_m()) {
            (Some((other, _, depth_m)), _) if depth_m > CONTACT_ALLOWANCE_M => {
                return Some(format!("it is {:.2} mm deep in {}", depth_m * 1e3, body_name(other)));
            }
            (_, Some(off_m)) => {
                let mm = off_m * 1e3;
                return Some(format!("its centre of mass is {mm:.2} mm beside what is below it"));
            }
            (Some((other, gap_m, _)), None) => {
                return Some(format!("it is too near to {}, at {:.2} mm", body_name(other), gap_m * 1e3));
            }
            (None, None) => {}
        }
        let slope_rad = resting.slope_rad(&self.up());
        if slope_rad > EXACT_ROTATION_RAD {
            return Some(format!("it is on a slope of {:.2}°", slope_rad.to_degrees()));
        }
        match resting.supports().min_by(|a, b| a.1.total_cmp(&b.1)) {
            None => Some(format!("at '{}' there is nothing that it could rest on", self.goal.name)),
            Some((body, above_m)) if above_m > MOST_ABOVE_M => {
                Some(format!("it is {:.2} mm above {}", above_m * 1e3, body_name(body)))
            }
            Some(_) => {
                let mut others = resting.supports().map(|(body, _)| body_name(body));
                let other = others.find(|other| on.is_some_and(|on| other != on))?;
                Some(format!("it rests on {other}"))
            }
        }
    }

    /// Distance of the hand from the object at the end of its retreat, in metres.
    pub fn clear_m(&self) -> f64 {
        self.clear_m
    }

    /// What keeps a hand that holds the object, its tip at a pose now, from letting it go at the first placements: what it
    /// touched at the first of all. `None` if it can at one, as far as the hand alone is concerned. Where the hand is in the
    /// floor, other placements in which the object rests in the same way are passed over.
    pub fn blocked_at(&self, world_from_tip: &Pose) -> Option<FailureReason> {
        let tip_from_held = world_from_tip.inverse() * self.carrier.hand().world_from_target();
        let mut first = None;
        let mut in_floor: Vec<usize> = Vec::new();
        let mut seen = 0;
        for draw in &self.draws {
            if seen == ENOUGH_TO_REFUSE {
                break;
            }
            if in_floor.contains(&draw.rest) {
                continue;
            }
            let Some(placement) = self.look_at(draw) else { continue };
            seen += 1;
            let (contact, cell) = match placement.hand_contact(tip_from_held) {
                Ok(Some(met)) => met,
                Ok(None) => return None,
                Err(_) => continue,
            };
            let is_floor = |part: &Part| {
                let up = part.world_from_solid.rotation * Vector::z();
                part.solid.is_half_space() && (up - self.up()).norm() < LEVEL
            };
            if let Collider::Body(body) = contact.second
                && cell.world().bodies()[body].parts.iter().all(is_floor)
            {
                in_floor.push(draw.rest);
            }
            first.get_or_insert_with(|| {
                let [first, second] = contact.names(&cell);
                FailureReason::PlaceBlocked { first, second }
            });
        }
        Some(first.unwrap_or(FailureReason::NoPlace))
    }

    /// The pose of the tip at which a grip has the object at a placement, if the open hand can be there.
    ///
    /// # Errors
    /// What it touches there.
    pub fn tip_at(&self, grip: &Grip, placement: &Placement) -> Result<Pose, FailureReason> {
        let tip_from_held = grip.hold.tip_from_held;
        match placement.hand_contact(tip_from_held) {
            Ok(None) => Ok(placement.world_from_tip(&tip_from_held)),
            Ok(Some((contact, cell))) => {
                let [first, second] = contact.names(&cell);
                Err(FailureReason::PlaceBlocked { first, second })
            }
            Err(_) => Err(FailureReason::NoPlace),
        }
    }
}

/// What tells the draws of places from other draws of the same seed.
const PLACES_STREAM: u64 = 0x91ac_e000;
