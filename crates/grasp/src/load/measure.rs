use std::f64::consts::PI;
use std::fmt;

use cranny_shape::{ShapeError, Surface, TriangleSoup, VolumeMoments};
use cranny_spatial::nalgebra::{Matrix3, Rotation3, Unit, Vector3};
use cranny_spatial::{Point, Pose, Vector};
use serde::{Deserialize, Serialize};

use crate::load::between::Between;
use crate::load::limit_surface::limit_factor;
use crate::load::patch::Patch;
use crate::load::seat::{HARD_PAD, SOFT_PAD, Seat};
use crate::{LoadState, Pads};

/// Object to hold, in the frame of the grasp poses.
#[derive(Clone, Debug)]
pub struct HeldObject {
    /// Surface, normals outwards.
    pub surface: Surface,
    /// Mass, in kilograms.
    pub mass_kg: f64,
    /// Centre of mass, in metres.
    pub center: Point,
    /// Inertia about the centre of mass, in kg m².
    pub inertia_kg_m2: Matrix3<f64>,
    /// Coefficient of friction between the object and the pads.
    pub friction: f64,
}

impl HeldObject {
    /// Object of uniform density, from its surface (m, normals outwards), the moments of its volume, its mass (kg; by
    /// default from [`ASSUMED_DENSITY`]) and its coefficient of friction.
    ///
    /// # Errors
    /// [`ShapeError`] for a mesh without a surface.
    pub fn new(
        mesh: &TriangleSoup,
        moments: &VolumeMoments,
        mass_kg: Option<f64>,
        friction: f64,
    ) -> Result<Self, ShapeError> {
        let mass_kg = mass_kg.unwrap_or(ASSUMED_DENSITY * moments.volume_m3);
        Ok(Self {
            surface: Surface::new(mesh)?,
            mass_kg,
            center: moments.center,
            inertia_kg_m2: moments.inertia_per_mass_m2 * mass_kg,
            friction,
        })
    }
}

/// Load of a grasp: the factor by which the loads may grow until a pad slips. Below 1 a pad slips under the loads.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Load {
    /// Factor under gravity alone, in the attitude of the grasp (λ₀).
    pub at_rest: f64,
    /// Least factor along the given motions; `at_rest` without any.
    pub in_motion: f64,
    /// Rotation of the object while the hand closes, in radians.
    pub turn_rad: f64,
    /// Displacement of the object along the closing axis while the hand closes, in metres.
    pub shift_m: f64,
    /// Width of the object between the pads, in metres.
    pub width_m: f64,
}

impl Load {
    /// Load of a hand that closes on nothing.
    const NOTHING: Self = Self { at_rest: 0.0, in_motion: 0.0, turn_rad: 0.0, shift_m: 0.0, width_m: 0.0 };
}

/// Load factors of grasps of one object by one hand: two flat soft pads, pressed together.
///
/// 1. Samples the sides of the object between the pads, over 24 cells.
/// 2. Computes its rest position between them (least energy), and the pressure on each cell.
/// 3. Computes the required force and moment about the point midway between the centres of pressure.
/// 4. Computes the force and the moment with which the pads push it where they press on slopes: pressure times slope.
/// 5. A shift of pressure bears the moments about x and z first, as far as the pads yield to a turn of 3°, a couple of friction
///    forces the rest. The pads share the forces in their plane and the moment about the closing axis equally.
/// 6. At rest, the factor follows from the limit surface of each pad (Goyal, Ruina & Papadopoulos 1991, §2); in motion, from
///    the ellipsoid of Howe & Cutkosky 1996, whole, which is up to 7 % too large for a face, 13 % for an edge.
#[derive(Clone)]
pub struct LoadMeasure {
    object: HeldObject,
    pads: Pads,
    force_n: f64,
    up: Vector,
    states: Vec<LoadState>,
}

impl fmt::Debug for LoadMeasure {
    /// Writes the name alone, because object and hand are large.
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("LoadMeasure")
    }
}

/// Coefficient of friction of an object without a stated one: the lower end of the range from 0.35 to 0.6 of rubber pads
/// on cardboard, plastics and painted wood.
pub const ASSUMED_FRICTION: f64 = 0.35;
/// Density of an object without a stated mass, in kg/m³: of a filled carton, or of a mug with its hollow.
pub const ASSUMED_DENSITY: f64 = 400.0;

/// Acceleration of gravity, in m/s².
const GRAVITY: f64 = 9.81;
/// Minimum arm of the couple between the pads, in metres.
const LEAST_WIDTH_M: f64 = 0.002;
/// Maximum rotation of a firmly held object while the hand closes, in radians (8°).
const MOST_FIRM_TURN_RAD: f64 = 0.139_63;
/// Maximum rotation of a seated object while the hand closes, and of a held one under its load, in radians (3°).
const MOST_TURN_RAD: f64 = 0.052_36;
/// Maximum displacement of a seated object while the hand closes, in metres.
const MOST_SHIFT_M: f64 = 0.003;
/// Maximum firmness, that of a grasp that no load moves.
const FIRMEST: f64 = 1e6;

impl LoadMeasure {
    /// Measure of an object that a hand presses with `force_n` newtons on each pad. `up` is the direction against
    /// gravity, a unit vector in the frame of the object.
    pub fn new(object: HeldObject, pads: Pads, force_n: f64, up: Vector, states: Vec<LoadState>) -> Self {
        Self { object, pads, force_n, up, states }
    }

    /// Load of a grasp whose gripper frame is at a pose in the frame of the object.
    pub fn of(&self, object_from_gripper: &Pose) -> Load {
        let between = Between::new(&self.object.surface, object_from_gripper, &self.pads);
        let seat = Seat::of(&between, SOFT_PAD, self.force_n, self.object.friction);
        let Some(seat) = seat else { return Load::NOTHING };
        let Some(held) = self.held(object_from_gripper, &between, &seat) else {
            return Load { shift_m: seat.shift_m, width_m: seat.width_m, ..Load::NOTHING };
        };
        let at_rest = held.exact_factor(&LoadState::GRAVITY);
        let least = self.states.iter().fold(FIRMEST, |least, state| held.least_factor(state, 1.0, least));
        let in_motion = if self.states.is_empty() { at_rest } else { least };
        Load { at_rest, in_motion, turn_rad: seat.turn(), shift_m: seat.shift_m, width_m: seat.width_m }
    }

    /// Forces of a grasp whose gripper frame is at a pose in the frame of the object; `None` unless both pads bear.
    pub fn grip(&self, object_from_gripper: &Pose) -> Option<GripForces> {
        let between = Between::new(&self.object.surface, object_from_gripper, &self.pads);
        let held = |hardness: f64| {
            let seat = Seat::of(&between, hardness, self.force_n, self.object.friction)?;
            Some((self.held(object_from_gripper, &between, &seat)?, seat.turn()))
        };
        let ((soft, turn_rad), (hard, _)) = (held(SOFT_PAD)?, held(HARD_PAD)?);
        Some(GripForces { held: [soft, hard], turn_rad })
    }

    /// Returns true if the hand holds the object at rest by at least this factor, for soft and hard pads, and rotates it
    /// by at most 8° while it closes. Objects that rotate farther, such as a rim, settle otherwise than computed.
    pub fn is_firm(&self, object_from_gripper: &Pose, factor: f64) -> bool {
        let is_firm = |grip: GripForces| {
            grip.turn_rad <= MOST_FIRM_TURN_RAD && grip.factor(&LoadState::GRAVITY) >= factor
        };
        self.grip(object_from_gripper).is_some_and(is_firm)
    }

    /// Returns true if the closing hand rotates the object by at most 3° and shifts it by at most 3 mm, even without
    /// friction: it is then set down as it was picked up.
    pub fn is_seated(&self, object_from_gripper: &Pose) -> bool {
        let between = Between::new(&self.object.surface, object_from_gripper, &self.pads);
        let free = Seat::of(&between, SOFT_PAD, self.force_n, 0.0);
        free.is_some_and(|seat| seat.turn() <= MOST_TURN_RAD && seat.shift_m.abs() <= MOST_SHIFT_M)
    }

    fn held(&self, object_from_gripper: &Pose, between: &Between, seat: &Seat) -> Option<Held> {
        let [first, second] = [0, 1].map(|pad| Patch::of(between, seat, pad));
        Some(Held::new(self, object_from_gripper, seat, [first?, second?]))
    }
}

/// Forces with which two pads, soft or hard, hold an object, prepared for many load cases.
#[derive(Clone, Debug)]
pub struct GripForces {
    held: [Held; 2],
    /// Rotation of the object while the hand closes, in radians.
    turn_rad: f64,
}

/// Share of the ellipsoid's factor that is safe: an edge slips at 0.87 of it, a face at 0.93.
const SAFE_SHARE: f64 = 0.87;

impl GripForces {
    /// Factor by which the loads of a motion may grow until a soft or a hard pad slips: from the ellipsoid, on the safe side.
    pub fn factor(&self, state: &LoadState) -> f64 {
        self.held.iter().fold(FIRMEST, |least, held| held.least_factor(state, SAFE_SHARE, least))
    }

    /// Factor by which gravity may grow until a pad slips in the worst of 26 attitudes: those with an axis, an edge or a
    /// corner of a cube about the hand pointing upwards.
    pub fn factor_in_any_attitude(&self) -> f64 {
        let steps = || [-1.0, 0.0, 1.0].into_iter();
        let attitudes =
            steps().flat_map(|x| steps().flat_map(move |y| steps().map(move |z| Vector::new(x, y, z))));
        let up = self.held[0].up;
        let turns = attitudes.filter_map(|other| {
            let other = other.try_normalize(0.0)?;
            Some(
                Rotation3::rotation_between(&other, &up)
                    .unwrap_or_else(|| Rotation3::from_axis_angle(&across(&up), PI)),
            )
        });
        turns.map(|turn| self.factor(&LoadState { turn, ..LoadState::GRAVITY })).fold(f64::INFINITY, f64::min)
    }
}

/// Direction at right angles to another.
fn across(direction: &Vector) -> Unit<Vector> {
    let mut helper = Vector::zeros();
    helper[direction.iamin()] = 1.0;
    Unit::new_normalize(direction.cross(&helper))
}

/// An object between the pads, in the gripper frame.
#[derive(Clone, Debug)]
struct Held {
    mass_kg: f64,
    /// Centre of mass relative to the point midway between the centres of pressure, in metres.
    center: Vector,
    /// Centre of mass, in metres.
    center_in_gripper: Vector,
    inertia: Matrix3<f64>,
    up: Vector,
    /// Coefficient of friction.
    friction: f64,
    /// Force along x and z and moment about y (m) with which the pads push the object, per pressing force. Opposite pushes of
    /// the two pads rotate it instead, which the seat considers.
    push: Vector3<f64>,
    force_n: f64,
    /// Moments about x and z that a shift of pressure bears, in N m.
    borne: [f64; 2],
    width_m: f64,
    pads: [HeldPad; 2],
}

/// Pad with the patch on which it bears.
#[derive(Clone, Debug)]
struct HeldPad {
    patch: Patch,
    /// Factor by which forces along x and z and moments about y (N, N m), per normal force, become those of an ellipsoid of
    /// radius 1.
    to_sphere: Vector3<f64>,
    /// Push of the pads (see [`Held::push`]) on that sphere.
    push: Vector3<f64>,
}

impl Held {
    fn new(measure: &LoadMeasure, object_from_gripper: &Pose, seat: &Seat, patches: [Patch; 2]) -> Self {
        let gripper_from_object = object_from_gripper.inverse();
        let rotation = gripper_from_object.rotation.to_rotation_matrix();
        let object = &measure.object;
        let center_in_gripper =
            (gripper_from_object * object.center).coords + Vector::new(0.0, seat.shift_m, 0.0);
        let [a, b] = &patches;
        let about =
            Vector::new(0.5 * (a.center_m[0] + b.center_m[0]), 0.0, 0.5 * (a.center_m[1] + b.center_m[1]));
        let borne = [1, 0].map(|axis: usize| {
            let yielding = MOST_TURN_RAD * (a.turning_stiffness[axis] + b.turning_stiffness[axis]);
            (0.5 * measure.force_n * (a.half_m[axis] + b.half_m[axis])).min(yielding)
        });
        let push = 0.5 * (a.push + b.push);
        let pads = patches.map(|patch| {
            let to_sphere = Vector3::new(1.0, 1.0, 1.0 / patch.arm_m) / object.friction;
            HeldPad { push: push.component_mul(&to_sphere), to_sphere, patch }
        });
        Self {
            mass_kg: object.mass_kg,
            center: center_in_gripper - about,
            center_in_gripper,
            inertia: rotation.matrix() * object.inertia_kg_m2 * rotation.matrix().transpose(),
            up: rotation * measure.up,
            friction: object.friction,
            push,
            force_n: measure.force_n,
            borne,
            width_m: seat.width_m.max(LEAST_WIDTH_M),
            pads,
        }
    }

    /// Forces required of each pad: normal force, then force along x and z and moment about y, in N and N m.
    fn demands(&self, state: &LoadState) -> [(f64, Vector3<f64>); 2] {
        let c = &self.center_in_gripper;
        let acceleration = state.turn.inverse() * (self.up * (GRAVITY + state.lift) + state.acceleration)
            + state.rate_acceleration.cross(c)
            + state.rate.cross(&state.rate.cross(c));
        let force = acceleration * self.mass_kg;
        let spin = self.inertia * state.rate;
        let moment =
            self.center.cross(&force) + self.inertia * state.rate_acceleration + state.rate.cross(&spin);
        let beyond =
            |moment: f64, borne: f64| moment.signum() * (moment.abs() - borne).max(0.0) / self.width_m;
        let (couple_z, couple_x) = (beyond(moment.x, self.borne[0]), beyond(moment.z, self.borne[1]));
        [1.0, -1.0].map(|side| {
            let pull = Vector3::new(
                0.5 * force.x - side * couple_x,
                0.5 * force.z + side * couple_z,
                // A turn from x to z is opposite to the turn about y.
                -0.5 * moment.y,
            );
            (self.force_n - side * 0.5 * force.y, pull)
        })
    }

    /// Factor by which the loads may grow until the more loaded pad reaches this share of its ellipsoid, at most `least`; 0 if a
    /// pad lifts off.
    fn least_factor(&self, state: &LoadState, share: f64, least: f64) -> f64 {
        self.demands(state).into_iter().zip(&self.pads).fold(least, |least, ((normal_n, pull), pad)| {
            let spare = share * share - pad.push.norm_squared();
            if normal_n <= 0.0 || self.friction <= 0.0 || spare <= 0.0 {
                return 0.0;
            }
            let pull = pull.component_mul(&pad.to_sphere);
            let (square, along) = (pull.norm_squared(), pull.dot(&pad.push) * normal_n);
            let spare = spare * normal_n * normal_n;
            // |factor · pull / normal − push| ≤ share: the loads may grow by more than `least`.
            if least * (least * square - 2.0 * along) <= spare {
                return least;
            }
            // The greater root of |factor · pull / normal − push| = share.
            let root = (along * along + square * spare).sqrt();
            if along > 0.0 { (along + root) / square } else { spare / (root - along) }
        })
    }

    /// Factor by which the loads may grow until the more loaded pad reaches its limit surface; 0 if a pad lifts off.
    fn exact_factor(&self, state: &LoadState) -> f64 {
        let factors = self.demands(state).into_iter().zip(&self.pads).map(|((normal_n, pull), pad)| {
            let patch = &pad.patch;
            let borne: f64 = patch.points.iter().map(|(_, load)| load).sum();
            if normal_n <= 0.0 || self.friction <= 0.0 {
                return 0.0;
            }
            if pad.push.norm_squared() >= 1.0 {
                return 0.0;
            }
            if pull.norm_squared() <= 0.0 {
                return FIRMEST;
            }
            let push = self.push * (borne / self.friction);
            let factor = limit_factor(&patch.points, pull, push, patch.point_arm_m);
            self.friction * normal_n * factor / borne
        });
        factors.fold(FIRMEST, f64::min)
    }
}
