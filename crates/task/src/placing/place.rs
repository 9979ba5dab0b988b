use std::f64::consts::{FRAC_PI_2, PI};
use std::sync::OnceLock;

use cranny_collision::{CONTACT_ALLOWANCE_M, Collider, Extent, Part, Resting};
use cranny_spatial::nalgebra::{Quaternion, UnitQuaternion};
use cranny_spatial::{EXACT_ROTATION_RAD, Point, Pose, PoseDifference, Rotation, Stream, Vector, sin_cos};

use crate::placing::place_goal::{is_lying, rolling_axis};
use crate::placing::placed::MOST_RETREAT_M;
use crate::placing::placement::Placement;
use crate::placing::rests::{rests, stable_rests};
use crate::{Carrier, FailureReason, Grip, PlaceAt, PlaceGoal, PlaceRegion, Problem, TaskError};

/// Height above its support at which an object is released, in metres: below 0.1 mm, and far more than the errors of inverse
/// kinematics.
const GAP_M: f64 = 8e-5;
/// Distance of a placement beside a body from that body, in metres.
const BESIDE_M: f64 = 3e-4;
/// Maximum height above the support at release, in metres.
const MOST_ABOVE_M: f64 = 1e-3;
/// Maximum tilt of an object at a given pose from a stable one, as the chord of an angle (20°). A round object rolls a little
/// (the banana of the gate lies 12° off); an object on an edge is farther off.
const MOST_TILT_RAD: f64 = 0.35;
/// Tolerance for an object beyond the edge of a surface, in metres: rounding.
const OVERHANG_M: f64 = 1e-6;
/// Maximum number of sampled placements, and of feasible ones after which sampling stops.
const MOST_DRAWS: u32 = 2000;
const ENOUGH_PLACES: usize = 96;
/// Number of patterns for the position of aligned draws along the two sides of a surface.
const PATTERNS: usize = 9;
/// Distance of a draw at an end from the edge of a surface, as a share of the range; above 0 because of rounding.
const END: f64 = 1e-3;
/// Number of placements after which a hand that fits at none is rejected: in most cases it touches the support itself.
const ENOUGH_TO_REFUSE: usize = 16;
/// Greatest deviation of a floor's normal from the vertical, as a chord: rounding.
const LEVEL: f64 = 1e-9;

/// Sampler of placements for the object of a [`Carrier`].
#[derive(Clone, Debug)]
pub struct Placer {
    carrier: Carrier,
    goal: PlaceGoal,
    /// Distance of the hand from the object at the end of its retreat, in metres.
    clear_m: f64,
    extent: Extent,
    /// Stable rotations of the object, from a frame with z upwards to its first solid, up to turns about the vertical; empty if
    /// every rotation is stable.
    rests: Vec<Rotation>,
    draws: Vec<Draw>,
    /// Bounds of the parts of bodies on the surface along both of its sides, in metres; empty if no draw needs them.
    neighbours: Vec<[[f64; 2]; 2]>,
}

/// Position of a draw along a side of a surface.
#[derive(Clone, Copy, Debug)]
enum At {
    /// Share of the range between the ends, in [0, 1].
    Share(f64),
    /// Beside a body on the surface; without such a body, a share as in [`Self::Share`].
    Beside(f64),
}

impl At {
    fn share(self) -> f64 {
        let (Self::Share(share) | Self::Beside(share)) = self;
        share
    }

    fn end(share: f64) -> Self {
        Self::Share(if share < 0.5 { END } else { 1.0 - END })
    }
}

/// A sampled placement, evaluated on demand.
#[derive(Clone, Debug)]
struct Draw {
    number: usize,
    /// Index of the stable rotation.
    rest: usize,
    /// Turn about the vertical, in radians.
    turn_rad: f64,
    /// Position along both sides of the surface.
    at: [At; 2],
    /// Result of the evaluation, once done.
    placement: OnceLock<Option<Placement>>,
}

impl Placer {
    /// Creates the placer of a carrier's object in a stage of a problem, without draws.
    ///
    /// # Errors
    /// [`TaskError::UnknownPlace`]; [`TaskError::Place`] for an invalid goal, or one at which a round object without resistance to
    /// rolling can only lie; [`TaskError::Collision`] for an object without bounds.
    pub fn new(problem: &Problem, carrier: &Carrier, place: &PlaceAt) -> Result<Self, TaskError> {
        let (goal, clear_m) = (problem.place(&place.place)?, place.clear_m);
        let target = carrier.hand().target();
        let body = &carrier.hand().holding().world().bodies()[target];
        let extent = carrier.resting().extent().clone();
        let level_from_world = carrier.hand().holding().world().world_from_level().inverse();
        let rests = match &goal.spot {
            PlaceRegion::Target(_) => {
                stable_rests(body, &extent, &level_from_world, [0.0; 2]).unwrap_or_default()
            }
            PlaceRegion::Surface { .. } => {
                let all = rests(body, &extent, &level_from_world);
                let rolling_m = problem.weights.of_body(target).rolling_m;
                let steady: Vec<Rotation> = match rolling_axis(body, rolling_m) {
                    Some(axis) => all.into_iter().filter(|rest| !is_lying(&(rest * axis))).collect(),
                    None => all,
                };
                if steady.is_empty() {
                    return Err(TaskError::Place { problem: goal.rolls_away_text(&body.name) });
                }
                steady
            }
        };
        let placer = Self {
            carrier: carrier.clone(),
            goal: goal.clone(),
            clear_m,
            extent,
            rests,
            draws: Vec::new(),
            neighbours: Vec::new(),
        };
        placer.check()?;
        Ok(placer)
    }

    /// Returns this placer with draws of placements; equal seeds give equal draws.
    #[must_use]
    pub fn with_placements(self, seed: u64) -> Self {
        self.with_draws(seed, MOST_DRAWS)
    }

    fn with_draws(self, seed: u64, most: u32) -> Self {
        let mut random = Stream::new(seed, PLACES_STREAM);
        let count = match &self.goal.spot {
            PlaceRegion::Target(_) => 1,
            PlaceRegion::Surface { .. } => most,
        };
        let draw = |draw: u32| Draw {
            number: draw as usize,
            // Every other draw uses the best stable rotation.
            rest: if draw.is_multiple_of(2) { 0 } else { random.index(self.rests.len().max(1)) },
            turn_rad: random.uniform_between(-PI, PI),
            at: [At::Share(random.uniform()), At::Share(random.uniform())],
            placement: OnceLock::new(),
        };
        Self { draws: (0..count).map(draw).collect(), ..self }
    }

    /// Returns this placer with at most `most` draws. Most of them align the object with the sides of the surface, at an end of
    /// it or beside a body that stands on it, which leaves space for other objects.
    #[must_use]
    pub fn with_aligned_draws(self, seed: u64, most: u32) -> Self {
        let mut placer = self.with_draws(seed, most).with_neighbours();
        let PlaceRegion::Surface { pose, .. } = &placer.goal.spot else { return placer };
        let x = placer.carrier.hand().holding().world().world_from_level().inverse()
            * (pose.rotation * Vector::x());
        let along_rad = libm::atan2(x.y, x.x);
        for draw in &mut placer.draws {
            let [x, y] = draw.at.map(At::share);
            draw.at = match draw.number % PATTERNS {
                0 => continue,
                1 => [At::Share(x), At::Share(y)],
                2 => [At::end(x), At::Share(y)],
                3 => [At::Share(x), At::end(y)],
                4 => [At::end(x), At::end(y)],
                5 => [At::Beside(x), At::Share(y)],
                6 => [At::Share(x), At::Beside(y)],
                7 => [At::Beside(x), At::end(y)],
                _ => [At::end(x), At::Beside(y)],
            };
            draw.turn_rad = along_rad + (draw.turn_rad / FRAC_PI_2).round() * FRAC_PI_2;
        }
        placer
    }

    /// Returns this placer with the bounds of the bodies that stand on the surface in the carrier's world.
    fn with_neighbours(self) -> Self {
        let PlaceRegion::Surface { on, pose, size_m } = &self.goal.spot else { return self };
        let surface_from_world = pose.inverse();
        let world = self.carrier.hand().holding().world();
        let others = world.bodies().iter().enumerate();
        let others = others.filter(|(body, other)| *body != self.target() && other.name != *on);
        let parts = others.flat_map(|(_, other)| &other.parts).filter(|part| !part.solid.is_half_space());
        let neighbours = parts.filter_map(|part| {
            let aabb = part.solid.aabb().transformed(&(surface_from_world * part.world_from_solid));
            let bounds = |axis: usize| {
                let (middle, half) = (aabb.center[axis], aabb.half_extents[axis]);
                [middle - half, middle + half]
            };
            let is_over =
                |axis: usize| bounds(axis)[0] < 0.5 * size_m[axis] && bounds(axis)[1] > -0.5 * size_m[axis];
            (is_over(0) && is_over(1) && bounds(2)[1] > MOST_ABOVE_M).then(|| [bounds(0), bounds(1)])
        });
        Self { neighbours: neighbours.collect(), ..self }
    }

    /// Returns this placer with the first draws that `is_hopeful` accepts, up to `most`, moved to the front in their order.
    #[must_use]
    pub fn with_first(self, most: usize, mut is_hopeful: impl FnMut(&Placement) -> bool) -> Self {
        let mut count = 0;
        let mut hopes = |draw: &Draw| {
            let is_first = count < most && self.look_at(draw).is_some_and(&mut is_hopeful);
            count += usize::from(is_first);
            is_first
        };
        let hopeful: Vec<bool> = self.draws.iter().map(&mut hopes).collect();
        let of = |wanted: bool| {
            let chosen = self.draws.iter().zip(&hopeful).filter(move |(_, is_first)| **is_first == wanted);
            chosen.map(|(draw, _)| draw.clone())
        };
        Self { draws: of(true).chain(of(false)).collect(), ..self }
    }

    /// Returns this placer in the surroundings of another carrier of the same object, with no draw evaluated yet.
    #[must_use]
    pub fn with_surroundings_of(&self, carrier: &Carrier) -> Self {
        let draws = self.draws.iter().map(|draw| Draw { placement: OnceLock::new(), ..*draw });
        let (goal, extent, rests) = (self.goal.clone(), self.extent.clone(), self.rests.clone());
        let moved = Self {
            carrier: carrier.clone(),
            goal,
            extent,
            rests,
            draws: draws.collect(),
            neighbours: Vec::new(),
            ..*self
        };
        moved.with_neighbours()
    }

    fn check(&self) -> Result<(), TaskError> {
        let refuse = |problem: String| Err(TaskError::Place { problem });
        let Self { goal, clear_m, .. } = self;
        let name = &goal.name;
        if !(0.0..=MOST_RETREAT_M).contains(clear_m) {
            return refuse(format!(
                "{clear_m} m is not a valid clearance of the hand: expected 0 to {MOST_RETREAT_M} m"
            ));
        }
        let PlaceRegion::Surface { on, pose, size_m } = &goal.spot else { return Ok(()) };
        if self.carrier.hand().holding().world().body_index(on)? == self.target() {
            return refuse(format!("place '{name}' lies on the object that is to be put down there"));
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

    /// Returns the pose of the object at a draw.
    fn pose_of(&self, draw: &Draw) -> Pose {
        let (world_from_surface, size_m) = match &self.goal.spot {
            PlaceRegion::Target(pose) => return *pose,
            PlaceRegion::Surface { pose, size_m, .. } => (pose, size_m),
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
            match draw.at[axis] {
                At::Beside(_) if !self.neighbours.is_empty() => {
                    let chosen = draw.number / PATTERNS % (2 * self.neighbours.len());
                    let [low, high] = self.neighbours[chosen / 2][axis];
                    if chosen.is_multiple_of(2) { high + BESIDE_M - low_m } else { low - BESIDE_M - high_m }
                }
                At::Share(share) | At::Beside(share) => first + share * (last - first),
            }
        });
        let place = world_from_surface * Point::new(x, y, GAP_M - extent_m(2)[0]);
        Pose::from_parts(place.coords.into(), turned.rotation)
    }

    /// Returns the placements feasible for the object alone, each with the number of its draw; for a goal pose at most one.
    pub fn placements(&self) -> impl Iterator<Item = (usize, &Placement)> {
        self.draws.iter().filter_map(|draw| Some((draw.number, self.look_at(draw)?))).take(ENOUGH_PLACES)
    }

    /// Returns the placement at a draw if it is feasible; evaluates it on first use.
    fn look_at<'a>(&self, draw: &'a Draw) -> Option<&'a Placement> {
        let look = || {
            let pose = self.pose_of(draw);
            if let PlaceRegion::Surface { pose: surface, size_m, .. } = &self.goal.spot
                && self.over_edge_m(surface, size_m, &pose) > OVERHANG_M
            {
                return None;
            }
            let placement = self.placement(&pose);
            self.fault_of(&placement).is_none().then_some(placement)
        };
        draw.placement.get_or_init(look).as_ref()
    }

    /// Returns the placement of the object at a pose; it shares the cell of an evaluated draw with the same supports, if any.
    fn placement(&self, world_from_held: &Pose) -> Placement {
        let known = self.draws.iter().filter_map(|draw| draw.placement.get()?.as_ref());
        self.carrier.placement_among(known, world_from_held)
    }

    /// Returns the fault, in words, of a release with the first solid at a pose in the planning frame; `None` at the goal.
    pub fn fault_at(&self, world_from_held: &Pose) -> Option<String> {
        self.fault_of(&self.placement(world_from_held))
    }

    /// Returns the fault, in words, of an object released at a placement; `None` if it is at the goal.
    pub(crate) fn fault_of(&self, Placement { world_from_held, resting, .. }: &Placement) -> Option<String> {
        let name = &self.goal.name;
        let up_in_held = world_from_held.rotation.inverse() * self.up();
        let tilt = |rest: &Rotation| (rest.inverse() * Vector::z() - up_in_held).norm();
        let tilt_rad = self.rests.iter().map(tilt).reduce(f64::min).unwrap_or(0.0);
        let tilted = |most_rad: f64, among: &str| {
            (tilt_rad.is_nan() || tilt_rad > most_rad)
                .then(|| format!("it is {:.2}° from any resting pose{among}", tilt_rad.to_degrees()))
        };
        let (on, world_from_surface, size_m) = match &self.goal.spot {
            PlaceRegion::Target(pose) => {
                let off = PoseDifference::between(pose, world_from_held);
                if !off.is_exact() {
                    let (mm, degrees) = (off.translation_m * 1e3, off.rotation_rad.to_degrees());
                    return Some(format!("it is {mm:.2} mm and {degrees:.2}° from its goal pose"));
                }
                return self.fault_of_rest(resting, None).or_else(|| tilted(MOST_TILT_RAD, ""));
            }
            PlaceRegion::Surface { on, pose, size_m } => (on, pose, size_m),
        };
        let up = world_from_surface.rotation * Vector::z();
        let middle = world_from_surface.translation.vector;
        let above_m = self.extent.lowest_along(world_from_held, &up) - up.dot(&middle);
        if !(-CONTACT_ALLOWANCE_M..=MOST_ABOVE_M).contains(&above_m) {
            return Some(format!("it is {:.2} mm above '{name}'", above_m * 1e3));
        }
        if let Some(fault) = tilted(EXACT_ROTATION_RAD, " that is likely and stable under a tilt of 5°") {
            return Some(fault);
        }
        let over_m = self.over_edge_m(world_from_surface, size_m, world_from_held);
        if over_m.is_nan() || over_m > OVERHANG_M {
            return Some(format!("it reaches {:.2} mm over the edge of '{name}'", over_m * 1e3));
        }
        self.fault_of_rest(resting, Some(on))
    }

    /// Returns the distance by which the object extends beyond the edges of a rectangle, in metres; negative within them.
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

    /// Returns the fault of a resting pose, if any: too near to or inside another body, on nothing, on a slope, above its
    /// support, or on a body other than its support.
    fn fault_of_rest(&self, resting: &Resting, on: Option<&str>) -> Option<String> {
        let body_name = |body: usize| self.carrier.body_name(body);
        let deepest = resting.beside().max_by(|a, b| a.2.total_cmp(&b.2).then(b.1.total_cmp(&a.1)));
        match (deepest, resting.overhang_m()) {
            (Some((other, _, depth_m)), _) if depth_m > CONTACT_ALLOWANCE_M => {
                return Some(format!("it is {:.2} mm deep in {}", depth_m * 1e3, body_name(other)));
            }
            (_, Some(off_m)) => {
                let mm = off_m * 1e3;
                return Some(format!("its centre of mass is {mm:.2} mm outside its support"));
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

    /// Returns `None` if the open hand alone, with its tip now at a pose in the planning frame, is free at one of the first
    /// placements; otherwise the first contact found, or [`FailureReason::NoPlace`] without one. If the hand is in the floor,
    /// other placements with the same stable rotation are skipped.
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

    /// Returns the pose `world_from_tip` that brings the object of a grip to a placement, if the open hand is free there.
    ///
    /// # Errors
    /// The first contact of the hand there.
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

/// Random stream of placements, distinct from other streams of the same seed.
const PLACES_STREAM: u64 = 0x91ac_e000;
