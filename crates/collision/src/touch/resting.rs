use cranny_shape::{Solid, overlap};
use cranny_spatial::{CONTACT_M, Pose, Vector};

use crate::CollisionError;
use crate::body::extent::Extent;
use crate::body::link_body::group_separation;
use crate::body::world::{Body, Part};
use crate::cell::{Cell, Scratch};
use crate::proof::joint_curve::JointCurve;
use crate::proof::work_list::MOST_INTERVALS;
use crate::touch::contact_patch::{Across, PlanePoint, distance_to_hull};
use crate::touch::resting_face::{
    CONTACT_ALLOWANCE_M, Face, MOST_GAP_M, RESOLUTION_M, SupportedObject, UNEVEN_M, lip,
};

/// A body of the world on its support faces.
///
/// A part supports the body by a face below it: a plane perpendicular to a direction that is upwards to within 45°. The body
/// lies above the plane and the part below it, both to within [`CONTACT_ALLOWANCE_M`], and they meet on it. The centre of mass
/// lies, along gravity, over the convex hull of the contact regions of all support faces. Portions of a part above the plane of
/// its face, and all other parts, remain obstacles.
///
/// The separation along the direction is the height of the body's lowest point above the face. It never exceeds the distance to
/// the portion below the plane, so a positive separation excludes contact there.
#[derive(Clone, Debug)]
pub struct Resting {
    extent: Extent,
    /// Contacts with the support faces.
    contacts: Vec<RestingContact>,
    /// Other parts that are nearer than the margin of the held object.
    beside: Vec<Neighbour>,
    /// Distance of the centre of mass from the possible supports, as seen along gravity, in metres; `None` if it is over them,
    /// or if there are none.
    overhang_m: Option<f64>,
}

/// A support face of a body.
#[derive(Clone, Copy, Debug)]
struct RestingContact {
    /// Index of the part among all parts of the world.
    part: usize,
    /// Index in the world of the body with that part.
    body: usize,
    /// Outward normal, a unit vector.
    direction: Vector,
    /// Height of the face along the direction, in metres.
    top_m: f64,
    /// Height of the body's lowest point above the face at rest, along the direction, in metres.
    separation_m: f64,
    /// Least height of the body above the face in their contact region, along the direction, in metres.
    gap_m: f64,
}

/// A part near a body that does not support it.
#[derive(Clone, Copy, Debug)]
struct Neighbour {
    body: usize,
    gap_m: f64,
    depth_m: f64,
}

/// Maximum excess of the gap of a further supporting part over that of the nearest one, in metres: rounding.
const EVEN_M: f64 = CONTACT_ALLOWANCE_M;

/// A part that may support a body, with their contact region as seen along gravity.
struct Candidate {
    part: usize,
    face: Face,
    neighbour: Neighbour,
}

impl Cell {
    /// Computes the supports of a body of the world.
    ///
    /// # Errors
    /// [`CollisionError::Touches`] if the body is in contact with a part that does not support it, [`CollisionError::Topples`]
    /// if its centre of mass is not over the faces below it, [`CollisionError::Hold`] for an unbounded body.
    ///
    /// # Panics
    /// If the world has no body of that index.
    pub fn resting(&self, body: usize) -> Result<Resting, CollisionError> {
        self.resting_with(body, &Extent::of(&self.world().bodies()[body])?)
    }

    /// Computes [`Self::resting`] with a known extent of the body.
    ///
    /// # Errors
    /// As [`Self::resting`].
    ///
    /// # Panics
    /// If the world has no body of that index.
    pub fn resting_with(&self, body: usize, extent: &Extent) -> Result<Resting, CollisionError> {
        let thing: &Body = &self.world().bodies()[body];
        // Invert the pose twice, as for a hold, so that the results agree bit by bit.
        let world_from_held = thing.parts[0].world_from_solid.inverse().inverse();
        let placed: Vec<(Pose, &Solid)> =
            thing.parts.iter().map(|part| (part.world_from_solid, &part.solid)).collect();
        let resting = self.resting_of(body, extent, &world_from_held, &placed);
        let Some(met) = resting.beside.iter().find(|other| other.gap_m < CONTACT_M) else {
            return Ok(resting);
        };
        let (name, other) = (thing.name.clone(), self.world().bodies()[met.body].name.clone());
        Err(match resting.overhang_m {
            Some(off_m) if met.depth_m <= CONTACT_ALLOWANCE_M => {
                CollisionError::Topples { name, other, off_m }
            }
            _ => CollisionError::Touches { name, other, depth_m: met.depth_m },
        })
    }

    /// Computes the supports that a body of the world would have with its first solid at this pose in the planning frame.
    ///
    /// # Panics
    /// If the world has no body of that index.
    pub fn resting_at(&self, body: usize, extent: &Extent, world_from_held: &Pose) -> Resting {
        let thing: &Body = &self.world().bodies()[body];
        let moved = moved_to(thing, world_from_held);
        let placed: Vec<(Pose, &Solid)> =
            thing.parts.iter().map(|part| (moved * part.world_from_solid, &part.solid)).collect();
        self.resting_of(body, extent, world_from_held, &placed)
    }

    /// 1. Find the parts near the body, and the possible supports among them.
    /// 2. Take the highest of these, then lower ones until the centre of mass is over the contact regions.
    fn resting_of(
        &self,
        body: usize,
        extent: &Extent,
        world_from_held: &Pose,
        placed: &[(Pose, &Solid)],
    ) -> Resting {
        // 1.
        let required_m = self.margins().of_held_m();
        let near_m = required_m.max(MOST_GAP_M);
        let up = self.world().up();
        let supported = SupportedObject { extent, world_from_held, placed };
        let (mut candidates, mut beside) = (Vec::new(), Vec::new());
        for (index, (other, part)) in self.parts().iter().enumerate().filter(|(_, (other, _))| *other != body)
        {
            let of_part = std::iter::once((part.world_from_solid, &part.solid));
            let gap = group_separation(placed.iter().copied(), &of_part, near_m);
            if gap.lower_m >= near_m {
                continue;
            }
            let depths = placed.iter().filter_map(|(pose, solid)| {
                overlap(solid, pose, &part.solid, &part.world_from_solid).map(|overlap| overlap.depth_m)
            });
            let depth_m = if gap.upper_m > 0.0 { 0.0 } else { depths.fold(0.0, f64::max) };
            let neighbour = Neighbour { body: *other, gap_m: gap.lower_m, depth_m };
            let is_near = neighbour.gap_m < MOST_GAP_M && depth_m <= CONTACT_ALLOWANCE_M + RESOLUTION_M;
            let face = || Face::below(supported, part, &up).filter(|face| face.gap_m <= MOST_GAP_M);
            match is_near.then(face).flatten() {
                Some(face) => candidates.push(Candidate { part: index, face, neighbour }),
                None => beside.push(neighbour),
            }
        }
        // 2.
        candidates.sort_by(|a, b| a.face.gap_m.total_cmp(&b.face.gap_m));
        let gravity = Across::new(&up);
        let center = gravity.seen(&(world_from_held * extent.center_of_mass()));
        let nearest_m = candidates.first().map_or(0.0, |first| first.face.gap_m);
        let is_within = |candidate: &Candidate, most_m: f64| candidate.face.gap_m <= nearest_m + most_m;
        let even = candidates.iter().filter(|candidate| is_within(candidate, EVEN_M)).count();
        let uneven = candidates.iter().filter(|candidate| is_within(candidate, UNEVEN_M)).count();
        let off_m = |places: &[PlanePoint]| distance_to_hull(places, center) + extent.center_error_m();
        let of = candidates[..even].iter();
        let places: Vec<_> = of.flat_map(|other| other.face.places(&gravity, nearest_m + EVEN_M)).collect();
        let mut least_m = off_m(&places);
        let mut found = (least_m <= CONTACT_ALLOWANCE_M).then_some(even);
        if found.is_none() {
            let most_m = nearest_m + UNEVEN_M;
            let mut places = Vec::new();
            for (index, candidate) in candidates[..uneven].iter().enumerate() {
                places.extend(candidate.face.places_on_hull(supported, &gravity, most_m));
                least_m = off_m(&places).min(least_m);
                if least_m <= CONTACT_ALLOWANCE_M {
                    found = Some(index + 1);
                    break;
                }
            }
        }
        let is_near_any = !candidates.is_empty();
        let others = candidates.split_off(found.unwrap_or(0));
        beside.extend(others.iter().map(|other| other.neighbour));
        beside.retain(|other| other.gap_m < required_m);
        let contact = |Candidate { part, face, neighbour }: &Candidate| RestingContact {
            part: *part,
            body: neighbour.body,
            direction: face.direction,
            top_m: face.top_m,
            separation_m: face.separation_m,
            gap_m: face.gap_m,
        };
        Resting {
            extent: extent.clone(),
            contacts: candidates.iter().map(contact).collect(),
            beside,
            overhang_m: (found.is_none() && is_near_any).then_some(least_m),
        }
    }

    /// Returns the least height of the held object above its former support faces, at `q` (m, rad; one per joint), in metres;
    /// infinite without supports.
    ///
    /// # Panics
    /// If `q` has not one value per joint, or nothing is held.
    pub fn lifted_m(&self, resting: &Resting, q: &[f64], scratch: &mut Scratch) -> f64 {
        self.robot().forward_kinematics(q, &mut scratch.frames);
        let world_from_held = self.world_from_held(scratch);
        let separations =
            resting.contacts.iter().map(|contact| resting.separation_m(contact, &world_from_held));
        separations.fold(f64::INFINITY, f64::min)
    }

    /// Returns the parameter in [0, 1] on the straight motion from `a` to `b` (m, rad; one per joint) at which the held object
    /// may be nearer to a former support face than at rest by more than `slack_m` (m), or deeper in it than
    /// [`CONTACT_ALLOWANCE_M`], and the index of the body with that face; `None` if it is proven to stay off all faces.
    ///
    /// # Panics
    /// If `a` or `b` has not one value per joint, or nothing is held.
    pub fn first_support_violation(
        &self,
        resting: &Resting,
        slack_m: f64,
        a: &[f64],
        b: &[f64],
        scratch: &mut Scratch,
    ) -> Option<(f64, usize)> {
        assert!(a.len() == self.robot().dof() && b.len() == a.len(), "one value per joint");
        let held = self.bodies.iter().rposition(|body| Some(body.link) == self.robot().held_link());
        let held = held.expect("something is held");
        let curve = JointCurve::Line([a, b]);
        scratch.rates.set(curve);
        let deepest_m = -CONTACT_ALLOWANCE_M - 2.0 * RESOLUTION_M;
        let (mut open, mut intervals) = (vec![(0.5, 0.5)], 0);
        while let Some((middle, half_width)) = open.pop() {
            intervals += 1;
            self.check_at(curve, middle, half_width, scratch, 1.0);
            let travel_m = scratch.travel.of(held);
            let world_from_held = self.world_from_held(scratch);
            for contact in &resting.contacts {
                let least_m = (contact.separation_m - slack_m).max(deepest_m);
                let over_m = resting.separation_m(contact, &world_from_held) - least_m;
                if over_m >= travel_m {
                    continue;
                }
                if over_m < 0.0 || travel_m < RESOLUTION_M || intervals > MOST_INTERVALS {
                    return Some((middle, contact.body));
                }
                open.push((middle + 0.5 * half_width, 0.5 * half_width));
                open.push((middle - 0.5 * half_width, 0.5 * half_width));
                break;
            }
        }
        None
    }

    fn world_from_held(&self, scratch: &Scratch) -> Pose {
        *scratch.frames.link(self.robot().held_link().expect("something is held"))
    }
}

impl Resting {
    /// Returns the extent of the body.
    pub fn extent(&self) -> &Extent {
        &self.extent
    }

    /// Returns the supporting bodies, with the height above the face of each, in metres, negative for the penetration depth.
    pub fn supports(&self) -> impl Iterator<Item = (usize, f64)> {
        self.contacts.iter().map(|contact| (contact.body, contact.gap_m))
    }

    /// Returns other bodies nearer than the margin of the held object, with distance and penetration depth, in metres.
    pub fn beside(&self) -> impl Iterator<Item = (usize, f64, f64)> {
        self.beside.iter().map(|other| (other.body, other.gap_m, other.depth_m))
    }

    /// Returns the distance (m) of the centre of mass from the possible supports, as seen along gravity, if it is off them.
    pub fn overhang_m(&self) -> Option<f64> {
        self.overhang_m
    }

    /// Returns the greatest angle between the normal of a support face and a direction (unit vector), in radians.
    pub fn slope_rad(&self, up: &Vector) -> f64 {
        self.contacts.iter().map(|contact| contact.direction.angle(up)).fold(0.0, f64::max)
    }

    /// Returns true if a cell that allows these contacts ([`Cell::with_allowed_contacts`]) also allows those of `other`.
    pub fn is_spared_alike(&self, other: &Self) -> bool {
        let is_alike = |(a, b): (&RestingContact, &RestingContact)| {
            a.part == b.part
                && (a.direction - b.direction).norm() < 1e-9
                && (a.top_m - b.top_m).abs() < 1e-9
                && (a.depth_m() - b.depth_m()).abs() < RESOLUTION_M
        };
        self.contacts.len() == other.contacts.len() && self.contacts.iter().zip(&other.contacts).all(is_alike)
    }

    /// Returns lift-off directions, unit vectors, in the order to try them: up, then away from all faces.
    pub fn lift_off_directions(&self, up: Vector) -> Vec<Vector> {
        let away: Vector = self.contacts.iter().map(|contact| contact.direction).sum();
        let mixed = (up + away).try_normalize(1e-6);
        std::iter::once(up).chain(mixed.filter(|way| (way - up).norm() > 1e-6)).collect()
    }

    /// Returns for each support face the index of its part, the depth in it (m), and the portion of the part above the face.
    pub(crate) fn spared<'a>(
        &'a self,
        parts: &'a [(usize, Part)],
    ) -> impl Iterator<Item = (usize, f64, Option<(usize, Part)>)> + use<'a> {
        self.contacts.iter().map(|contact| {
            let lip = lip(&parts[contact.part].1, &contact.direction, contact.top_m);
            (contact.part, contact.depth_m(), lip.map(|lip| (contact.body, lip)))
        })
    }

    fn separation_m(&self, contact: &RestingContact, world_from_held: &Pose) -> f64 {
        self.extent.lowest_along(world_from_held, &contact.direction) - contact.top_m
    }
}

impl RestingContact {
    fn depth_m(&self) -> f64 {
        (-self.separation_m).max(0.0)
    }
}

/// Returns the motion, in the planning frame, that moves the first solid of a body to a pose.
pub(crate) fn moved_to(body: &Body, world_from_held: &Pose) -> Pose {
    let now = body.parts.first().map_or_else(Pose::identity, |part| part.world_from_solid);
    world_from_held * now.inverse()
}
