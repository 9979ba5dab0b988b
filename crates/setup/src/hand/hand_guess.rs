//! Detection of the hand of a robot by its structure; names only break ties.
//!
//! 1. The palm is the rigid body farthest from the root that carries two or more small moving ones other than wheels, or a
//!    single one with a name like "jaw".
//! 2. Each joint that moves them is open at the end of its range at which the fingers are farthest apart.
//! 3. The closing axis is that of the slides, or perpendicular to the hinges; the approach direction points from the palm to
//!    the tips of the fingers.
//! 4. The gripper frame lies centred between the pads, slightly behind the tips; an existing bare link at this pose is used.

use std::collections::{BTreeMap, BTreeSet};

use cranny_robot::{FingerRange, JointKind};
use cranny_shape::Solid;
use cranny_spatial::{Point, Pose, Rotation, Vector};

use crate::anatomy::{Anatomy, by_name, distance_m, middle, touch};
use crate::hand::grip_place::{Place, free_way_m, place, upright};
use crate::hand::palm::{LONGEST_FINGER_M, Palm, palm_link, palms};
use crate::hand::posture::Posture;

/// Detected hand.
#[derive(Clone, Debug)]
pub(crate) struct HandGuess {
    /// Link that carries the fingers, or is the tool.
    pub palm: usize,
    /// Gripper frame in the palm link.
    pub palm_from_frame: Pose,
    /// Existing bare link with this frame.
    pub existing: Option<usize>,
    /// Joints that close the hand; empty if it cannot close.
    pub fingers: BTreeMap<String, FingerRange>,
    pub opening_m: f64,
    pub finger_depth_m: f64,
    /// Closing force in newtons, if the drives give one.
    pub force_n: Option<f64>,
    /// Kind of hand.
    pub kind: HandKind,
    /// Palm links of other candidates.
    pub others: Vec<usize>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum HandKind {
    /// Fingers that move on both sides.
    Fingers,
    /// One jaw that moves towards a fixed one.
    Jaw,
    /// Two fixed prongs.
    Rigid,
}

/// Minimum difference of the finger spread between the ends of a joint's range that counts as opening, in metres.
const LEAST_OPENING_M: f64 = 1e-3;

/// Maximum opening of a hand with one jaw, in metres and radians: the size of an object between its tips.
const WIDEST_JAW_M: f64 = 0.08;
const WIDEST_JAW_RAD: f64 = 0.7;

/// Assumed length of the fingertips of fingers without geometry, in metres.
const FINGERTIP_M: f64 = 0.04;

/// Default force of the fingers in newtons, if the drives give none: that of a Robotiq 2F-85 at a sixth of its range.
pub(crate) const DEFAULT_FORCE_N: f64 = 40.0;

impl HandGuess {
    /// Returns the hand on the link `palm`, or else the best one found.
    pub fn of(anatomy: &Anatomy, palm: Option<usize>) -> Option<Self> {
        let wanted = |body: usize| palm.is_none_or(|link| anatomy.body_of[link] == body);
        let mut found = palms(anatomy, 2);
        if found.is_empty() {
            found = palms(anatomy, 1);
        }
        let others = found.iter().map(|palm| palm_link(anatomy, palm.fingers[0]));
        let others: Vec<usize> = others.collect();
        for (index, palm) in found.iter().enumerate().filter(|(_, palm)| wanted(palm.body)) {
            let guess =
                if palm.fingers.len() > 1 { of_fingers(anatomy, palm) } else { of_jaw(anatomy, palm) };
            if let Some(mut guess) = guess {
                guess.others = others;
                guess.others.remove(index);
                return Some(guess);
            }
        }
        rigid(anatomy, palm)
    }
}

fn drivers(anatomy: &Anatomy, palm: &Palm) -> Vec<usize> {
    let branches = palm.fingers.iter().flat_map(|&finger| anatomy.branch(finger));
    let joints: BTreeSet<usize> =
        branches.filter_map(|body| anatomy.bodies[body].above.map(|(_, mover)| mover.joint)).collect();
    joints.into_iter().collect()
}

/// Open and closed ends of the joints of fingers.
pub(crate) struct FingerEnds {
    /// Configuration (m, rad; one value per joint) with the fingers as far apart as they can be.
    pub open: Vec<f64>,
    /// Configuration with the joints of the fingers at their other ends.
    closed: Vec<f64>,
    /// Joints that close the fingers.
    pub closing: Vec<usize>,
    /// Joints that move the fingers, also sideways.
    pub drivers: Vec<usize>,
}

/// Finds the ends of the joints of fingers: open is the one at which their tips are farthest apart.
pub(crate) fn finger_ends(anatomy: &Anatomy, palm: &Palm) -> FingerEnds {
    let link = palm_link(anatomy, palm.fingers[0]);
    let limits = anatomy.robot.limits();
    let drivers = drivers(anatomy, palm);
    let middle_of = |joint: usize| 0.5 * (limits[joint].lower + limits[joint].upper);
    let mut open = anatomy.rest();
    for &joint in &drivers {
        open[joint] = middle_of(joint);
    }
    let spread_m = |q: &[f64]| {
        let posture = Posture::at(anatomy, link, q);
        let tips: Vec<Point> = palm.fingers.iter().map(|&finger| posture.tip(finger)).collect();
        let pairs = (0..tips.len()).flat_map(|a| (0..a).map(move |b| (a, b)));
        pairs.map(|(a, b)| (tips[a] - tips[b]).norm()).sum::<f64>()
    };
    let (mut ends, halfway) = (open.clone(), open.clone());
    let mut closing: Vec<usize> = Vec::new();
    for &joint in &drivers {
        let at = |value: f64| {
            let mut q = halfway.clone();
            q[joint] = value;
            spread_m(&q)
        };
        let (low, high) = (limits[joint].lower, limits[joint].upper);
        let (at_low_m, at_high_m) = (at(low), at(high));
        if (at_low_m - at_high_m).abs() < LEAST_OPENING_M {
            (open[joint], ends[joint]) = (limits[joint].clamp(0.0), limits[joint].clamp(0.0));
            continue;
        }
        (open[joint], ends[joint]) = if at_low_m > at_high_m { (low, high) } else { (high, low) };
        closing.push(joint);
    }
    FingerEnds { open, closed: ends, closing, drivers }
}

fn of_fingers(anatomy: &Anatomy, palm: &Palm) -> Option<HandGuess> {
    let link = palm_link(anatomy, palm.fingers[0]);
    // 2.
    let FingerEnds { open, closed: ends, closing, .. } = finger_ends(anatomy, palm);
    // 3.
    let posture = Posture::at(anatomy, link, &open);
    let tips: Vec<Point> = palm.fingers.iter().map(|&finger| posture.tip(finger)).collect();
    // `first` is the finger that reaches farthest, `second` the one farthest from it among those that reach about as far: the
    // knuckles of a linkage may be farther away, but not across.
    let behind = palm_origin(&posture, palm.body);
    let reach_m = |index: &usize| (tips[*index] - behind).norm();
    let first = (0..tips.len()).max_by(|a, b| reach_m(a).total_cmp(&reach_m(b)))?;
    let as_far = |index: &usize| *index != first && reach_m(index) > 0.8 * reach_m(&first);
    let from_first_m = |index: &usize| (tips[*index] - tips[first]).norm();
    let second = (0..tips.len()).filter(as_far).max_by(|a, b| from_first_m(a).total_cmp(&from_first_m(b)))?;
    let across = (tips[second] - tips[first]).try_normalize(LEAST_OPENING_M)?;
    let between: Point = ((tips[first].coords + tips[second].coords) * 0.5).into();
    let (kind, axis) = posture.axis(palm.fingers[first])?;
    let y = match kind {
        JointKind::Prismatic if axis.dot(&across).abs() > 0.7 => axis * axis.dot(&across).signum(),
        JointKind::Revolute if axis.dot(&across).abs() < 0.7 => across - axis * axis.dot(&across),
        _ => across,
    };
    let hinge = (kind == JointKind::Revolute).then_some(axis);
    let palm_from_frame = upright(&y, &(between - behind), hinge.as_ref())?;
    let y = palm_from_frame * Vector::y();
    // The fingers are divided into the two sides.
    let side = |sign: f64| -> Vec<usize> {
        let on = |index: &usize| sign * (tips[*index] - between).dot(&y) > 0.0;
        (0..tips.len()).filter(on).map(|index| palm.fingers[index]).collect()
    };
    let [low, high] = [side(-1.0), side(1.0)];
    let solids_of = |posture: &Posture, fingers: &[usize]| -> Vec<(Pose, Solid)> {
        fingers.iter().flat_map(|&finger| posture.solids(finger)).collect()
    };
    // 2. Closed is where the fingers meet, or else the other end. Knuckle hulls that always overlap also give that end.
    const STEPS: usize = 200;
    let touch_at = |share: f64| {
        let posture = Posture::at(anatomy, link, &between_of(&open, &ends, share));
        touch(&solids_of(&posture, &low), &solids_of(&posture, &high))
    };
    let share = |step: usize| step as f64 / STEPS as f64;
    let first_touch = if touch_at(0.0) { None } else { (1..=STEPS).find(|step| touch_at(share(*step))) };
    let closed = between_of(&open, &ends, first_touch.map_or(1.0, |step| share(step - 1)));
    let fingers = ranges(anatomy, &closing, &open, &closed);
    let sides = [solids_of(&posture, &low), solids_of(&posture, &high)];
    let hinge_z = palm.fingers.iter().map(|&finger| {
        posture.origin(anatomy.bodies[finger].top).coords.dot(&(palm_from_frame * Vector::z()))
    });
    let hinge_z = hinge_z.fold(f64::INFINITY, f64::min);
    let mut all = posture.palm_solids();
    all.extend(sides.iter().flatten().cloned());
    // A hand that does not close cannot hold an object, but it can be moved to grasp poses.
    let hand_kind = if closing.is_empty() { HandKind::Rigid } else { HandKind::Fingers };
    let place = place(&palm_from_frame, &sides, &all, hinge_z, &between).or_else(|| {
        // For fingers without geometry, the opening is their total travel, and their length that of assumed fingertips.
        let between = between + palm_from_frame * Vector::z() * FINGERTIP_M;
        let closed = Posture::at(anatomy, link, &closed);
        let shift = |finger: usize| {
            let top = anatomy.bodies[finger].top;
            (closed.origin(top) - posture.origin(top)).dot(&y).abs()
        };
        let opening_m = shift(palm.fingers[first]) + shift(palm.fingers[second]);
        let finger_depth_m = free_way_m(&all, &between, &-(palm_from_frame * Vector::z()));
        (opening_m > 0.0).then_some(Place { origin: between, opening_m, finger_depth_m })
    })?;
    let force_n = force_n(anatomy, &closing);
    Some(guess(anatomy, link, palm_from_frame, &place, fingers, force_n, hand_kind))
}

fn of_jaw(anatomy: &Anatomy, palm: &Palm) -> Option<HandGuess> {
    let jaw = palm.fingers[0];
    let link = palm_link(anatomy, jaw);
    let (_, mover) = anatomy.bodies[jaw].above?;
    let limits = anatomy.robot.limits()[mover.joint];
    let fixed = Posture::at(anatomy, link, &anatomy.rest()).palm_solids();
    let at = |value: f64| {
        let mut q = anatomy.rest();
        q[mover.joint] = value;
        Posture::at(anatomy, link, &q)
    };
    // Each gap is the distance from the end of the jaw to the fixed side.
    const STEPS: usize = 200;
    let value = |step: usize| limits.lower + (limits.upper - limits.lower) * step as f64 / STEPS as f64;
    let gaps: Vec<f64> = (0..=STEPS)
        .map(|step| {
            let posture = at(value(step));
            let solids = posture.solids(jaw);
            let tip = jaw_end(&posture, jaw, &solids);
            distance_m(&fixed, &tip)
        })
        .collect();
    let closed = (0..=STEPS).min_by(|a, b| gaps[*a].total_cmp(&gaps[*b]))?;
    // From the closed position, the jaw opens towards the farther end until it is wide enough.
    let towards_high = STEPS - closed >= closed;
    let steps: Vec<usize> =
        if towards_high { (closed..=STEPS).collect() } else { (0..=closed).rev().collect() };
    let (kind, axis) = at(value(closed)).axis(jaw)?;
    let is_wide = |step: &usize| {
        let turned = kind == JointKind::Revolute && (value(*step) - value(closed)).abs() >= WIDEST_JAW_RAD;
        turned || gaps[*step] - gaps[closed] >= WIDEST_JAW_M
    };
    let open = steps.iter().copied().find(is_wide).or(steps.last().copied())?;
    let posture = at(value(closed));
    let tip = jaw_end(&posture, jaw, &posture.solids(jaw));
    let hinge_at = posture.origin(anatomy.bodies[jaw].top);
    let y = match kind {
        JointKind::Prismatic => axis,
        JointKind::Revolute => axis.cross(&(tip - hinge_at)),
    };
    let y = y * if towards_high { 1.0 } else { -1.0 };
    let hinge = (kind == JointKind::Revolute).then_some(axis);
    let palm_from_frame = upright(&y, &(tip - palm_origin(&posture, palm.body)), hinge.as_ref())?;
    // The grip is centred between both, slightly behind the reach of the open jaw.
    let moved = at(value(open)).solids(jaw);
    let mut all = fixed.clone();
    all.extend(moved.iter().cloned());
    let hinge_z = hinge_at.coords.dot(&(palm_from_frame * Vector::z()));
    let place = place(&palm_from_frame, &[fixed, moved], &all, hinge_z, &tip)?;
    let range = FingerRange { open: value(open), closed: value(closed) };
    let fingers = [(anatomy.robot.joint_names()[mover.joint].clone(), range)].into();
    let force_n = force_n(anatomy, &[mover.joint]);
    Some(guess(anatomy, link, palm_from_frame, &place, fingers, force_n, HandKind::Jaw))
}

/// Returns the farthest point of a jaw from its hinge.
fn jaw_end(posture: &Posture, jaw: usize, solids: &[(Pose, Solid)]) -> Point {
    let hinge = posture.origin(posture.anatomy.bodies[jaw].top);
    let points = solids.iter().flat_map(|(pose, solid)| {
        let (points, _) = solid.bounding_points().unwrap_or_default();
        points.into_iter().map(move |point| pose * point)
    });
    let farthest = points.max_by(|a, b| (a - hinge).norm().total_cmp(&(b - hinge).norm()));
    farthest.unwrap_or(hinge)
}

/// Detects two fixed prongs on the last link of the longest chain.
fn rigid(anatomy: &Anatomy, palm: Option<usize>) -> Option<HandGuess> {
    let depth = |body: &usize| anatomy.joints_of(*body).count();
    let deepest = (0..anatomy.bodies.len()).max_by_key(depth)?;
    let body = palm.map_or(deepest, |link| anatomy.body_of[link]);
    let with_shapes = |link: &&usize| anatomy.robot.links()[**link].collisions.len() >= 2;
    let link = anatomy.bodies[body].links.iter().rev().find(with_shapes).copied()?;
    let posture = Posture::at(anatomy, link, &anatomy.rest());
    let all = posture.palm_solids();
    let own: Vec<(Pose, Solid)> = anatomy.robot.links()[link]
        .collisions
        .iter()
        .map(|shape| (shape.link_from_shape, shape.solid.clone()))
        .collect();
    let whole = middle(&all)?;
    let pairs = (0..own.len()).flat_map(|a| (0..a).map(move |b| (a, b)));
    let frames = pairs.filter_map(|(a, b)| {
        let [a, b] = [&own[a], &own[b]];
        let center = |(pose, solid): &(Pose, Solid)| pose * solid.ball().center;
        let between: Point = ((center(a).coords + center(b).coords) * 0.5).into();
        // Prongs have similar sizes, and a gap between them.
        let is_alike = (a.1.ball().radius_m / b.1.ball().radius_m - 1.0).abs() < 0.2;
        let is_apart = distance_m(&all, &between) > 5e-3;
        let palm_from_frame = upright(&(center(b) - center(a)), &(between - whole), None)?;
        let sides = [vec![a.clone()], vec![b.clone()]];
        let place = place(
            &palm_from_frame,
            &sides,
            &all,
            between.coords.dot(&(palm_from_frame * Vector::z())),
            &between,
        )?;
        (is_alike && is_apart && place.opening_m < LONGEST_FINGER_M).then_some((palm_from_frame, place))
    });
    let (palm_from_frame, place) =
        frames.max_by(|(_, a), (_, b)| a.finger_depth_m.total_cmp(&b.finger_depth_m))?;
    Some(guess(anatomy, link, palm_from_frame, &place, BTreeMap::new(), None, HandKind::Rigid))
}

/// Origin from which the fingers of a rigid body point away: that of its topmost link, which the last joint of the arm moves.
pub(crate) fn palm_origin(posture: &Posture, body: usize) -> Point {
    posture.origin(posture.anatomy.bodies[body].top)
}

fn between_of(open: &[f64], closed: &[f64], share: f64) -> Vec<f64> {
    open.iter().zip(closed).map(|(open, closed)| open + (closed - open) * share).collect()
}

fn ranges(
    anatomy: &Anatomy,
    joints: &[usize],
    open: &[f64],
    closed: &[f64],
) -> BTreeMap<String, FingerRange> {
    let (open, closed) = (by_name(&anatomy.robot, open), by_name(&anatomy.robot, closed));
    let range = |&joint: &usize| {
        let name = &anatomy.robot.joint_names()[joint];
        (name.clone(), FingerRange { open: open[name], closed: closed[name] })
    };
    joints.iter().map(range).collect()
}

/// Returns the force of the slides, if their drives give a value plausible for a gripper.
fn force_n(anatomy: &Anatomy, joints: &[usize]) -> Option<f64> {
    let named = joints.iter().map(|&joint| &anatomy.joints[&anatomy.robot.joint_names()[joint]]);
    let slides = named.filter_map(|joint| joint.motion.as_ref());
    let forces =
        slides.filter(|motion| motion.kind == JointKind::Prismatic).filter_map(|motion| motion.effort);
    forces.filter(|effort| (5.0..=500.0).contains(effort)).reduce(f64::min)
}

fn guess(
    anatomy: &Anatomy,
    palm: usize,
    rotation: Rotation,
    place: &Place,
    fingers: BTreeMap<String, FingerRange>,
    force_n: Option<f64>,
    kind: HandKind,
) -> HandGuess {
    let rounded = place.origin.coords.map(|length| (length * 1e5).round() / 1e5);
    let palm_from_frame = Pose::from_parts(rounded.into(), rotation);
    HandGuess {
        palm,
        palm_from_frame,
        existing: existing_frame(anatomy, palm, &palm_from_frame),
        fingers,
        opening_m: place.opening_m,
        finger_depth_m: place.finger_depth_m,
        force_n,
        kind,
        others: Vec::new(),
    }
}

/// Returns a bare link with the same axes, in the same plane between the pads, and about as deep, if there is one.
fn existing_frame(anatomy: &Anatomy, palm: usize, palm_from_frame: &Pose) -> Option<usize> {
    const BESIDE_M: f64 = 5e-3;
    const DEEP_M: f64 = 0.015;
    const TURNED: f64 = 0.996;
    let frames = anatomy.robot.frames_at(&anatomy.rest());
    let body = &anatomy.bodies[anatomy.body_of[palm]];
    let is_it = |&&link: &&usize| {
        let palm_from_link = frames.link(palm).inverse() * frames.link(link);
        let between = palm_from_frame.inv_mul(&palm_from_link);
        let place = between.translation.vector;
        let (y, z) = (between.rotation * Vector::y(), between.rotation * Vector::z());
        anatomy.robot.links()[link].collisions.is_empty()
            && place.x.abs().max(place.y.abs()) < BESIDE_M
            && place.z.abs() < DEEP_M
            && y.y.abs() > TURNED
            && z.z > TURNED
    };
    body.links.iter().find(is_it).copied()
}
