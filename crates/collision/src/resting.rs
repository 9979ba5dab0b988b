use std::sync::Arc;

use cranny_shape::{Solid, closest_points, overlap};
use cranny_spatial::{Point, Pose, Vector};

use crate::CollisionError;
use crate::cell::{Cell, Scratch};
use crate::link_body::group_separation;
use crate::world::{Body, Part};

/// Where a body of the world rests on others: what it touches, and how far it is in them or off them.
///
/// The separation of two things along a unit vector is how far one must go along it to touch the other; negative for how
/// deep they are in each other. The greatest of all directions is their signed separation, and along any of them it can
/// only be less: so whoever does not come closer along that direction does not come closer at all.
#[derive(Clone, Debug)]
pub struct Resting {
    extent: Extent,
    /// A part that the body touches, each.
    contacts: Vec<RestingContact>,
}

/// One part of the world that a body rests on.
#[derive(Clone, Copy, Debug)]
struct RestingContact {
    /// Its number among all parts of the world.
    part: usize,
    /// The body of the world that it belongs to.
    body: usize,
    /// From the part to the body at rest, a unit vector.
    direction: Vector,
    /// How far the part reaches along the direction, in metres.
    top_m: f64,
    /// At rest, along the direction, in metres.
    separation_m: f64,
}

/// Which of the directions along which two things are separate is looked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Enough {
    /// That along which they are farthest apart.
    Best,
    /// Any along which they are as far apart as they are: that between their nearest points, which takes longest to find, only
    /// where no other is.
    Any,
}

/// The direction is that of the signed separation if it is less by no more than this, in metres.
const HOLLOW_M: f64 = 5e-5;

/// As in a proof of a motion, in metres.
const RESOLUTION_M: f64 = 1e-6;

impl Cell {
    /// How a body of the world rests: on every part of other bodies that is closer than `clear_m`.
    ///
    /// # Errors
    /// [`CollisionError::Hollow`] where the body is in a hollow of what it touches, so that no direction is that of their
    /// separation; [`CollisionError::Hold`] for a body that has no end.
    ///
    /// # Panics
    /// If the world has no body of that index.
    pub fn resting(&self, body: usize, clear_m: f64) -> Result<Resting, CollisionError> {
        let thing: &Body = &self.world().bodies()[body];
        let extent = Extent::of(thing)?;
        // As it is held from: so bits agree.
        let world_from_held = thing.parts[0].world_from_solid.inverse().inverse();
        let placed: Vec<(Pose, &Solid)> =
            thing.parts.iter().map(|part| (part.world_from_solid, &part.solid)).collect();
        self.resting_of(body, &extent, (&world_from_held, &placed), clear_m, Enough::Best)
    }

    /// How a body of the world would rest with its first solid elsewhere, as [`Self::resting`].
    ///
    /// # Errors
    /// [`CollisionError::Hollow`].
    ///
    /// # Panics
    /// If the world has no body of that index.
    pub fn resting_at(
        &self,
        body: usize,
        extent: &Extent,
        world_from_held: &Pose,
        clear_m: f64,
    ) -> Result<Resting, CollisionError> {
        let thing: &Body = &self.world().bodies()[body];
        let moved = moved_to(thing, world_from_held);
        let placed: Vec<(Pose, &Solid)> =
            thing.parts.iter().map(|part| (moved * part.world_from_solid, &part.solid)).collect();
        self.resting_of(body, extent, (world_from_held, &placed), clear_m, Enough::Any)
    }

    fn resting_of(
        &self,
        body: usize,
        extent: &Extent,
        (world_from_held, placed): (&Pose, &[(Pose, &Solid)]),
        clear_m: f64,
        enough: Enough,
    ) -> Result<Resting, CollisionError> {
        let thing: &Body = &self.world().bodies()[body];
        let mut resting = Resting { extent: extent.clone(), contacts: Vec::new() };
        for (index, (other, part)) in self.parts().iter().enumerate().filter(|(_, (other, _))| *other != body)
        {
            let of_part = std::iter::once((part.world_from_solid, &part.solid));
            let gap = group_separation(placed.iter().copied(), &of_part, clear_m);
            if gap.lower_m >= clear_m {
                continue;
            }
            let depths = placed.iter().filter_map(|(pose, solid)| {
                overlap(solid, pose, &part.solid, &part.world_from_solid).map(|overlap| overlap.depth_m)
            });
            let depth_m = depths.fold(0.0, f64::max);
            let signed_m = if gap.upper_m > 0.0 { gap.lower_m } else { -depth_m };
            let along = |directions: Vec<Vector>| {
                let along = directions.into_iter().filter_map(|direction| {
                    let top_m = reach_along(part, &direction)?;
                    let separation_m = extent.lowest_along(world_from_held, &direction) - top_m;
                    Some(RestingContact { part: index, body: *other, direction, top_m, separation_m })
                });
                along.max_by(|a, b| a.separation_m.total_cmp(&b.separation_m))
            };
            let is_it = |best: &RestingContact| best.separation_m >= signed_m - HOLLOW_M;
            let first = if enough == Enough::Any { along(axes(part)).filter(is_it) } else { None };
            let best = first.or_else(|| along([axes(part), between(placed, part)].concat()));
            let hollow = || CollisionError::Hollow {
                name: thing.name.clone(),
                other: self.world().bodies()[*other].name.clone(),
            };
            let best = best.filter(is_it).ok_or_else(hollow)?;
            // Nearer than at rest is what is nearer than it is at rest, whatever the direction can show of that.
            let separation_m = best.separation_m.max(signed_m);
            resting.contacts.push(RestingContact { separation_m, ..best });
        }
        Ok(resting)
    }

    /// How far the held body has come off what it rested on, at `q`: the least separation, in metres, infinite where it
    /// rested on nothing.
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

    /// Where on the straight motion from `a` to `b`, in [0, 1], the held body comes nearer to what it rested on than at rest,
    /// by more than `slack_m`, or that cannot be excluded, and to which body of the world; `None` if it is proven to stay
    /// off all of it.
    ///
    /// # Panics
    /// If `a` or `b` has not one value per joint, or nothing is held.
    pub fn stays_off(
        &self,
        resting: &Resting,
        slack_m: f64,
        a: &[f64],
        b: &[f64],
        scratch: &mut Scratch,
    ) -> Option<(f64, usize)> {
        let held = self.bodies.iter().rposition(|body| Some(body.link) == self.robot().held_link());
        let held = held.expect("something is held");
        for (slope, (a, b)) in scratch.slope.iter_mut().zip(a.iter().zip(b)) {
            *slope = b - a;
        }
        let mut open = vec![(0.5, 0.5)];
        while let Some((middle, half_width)) = open.pop() {
            self.check_at(a, b, middle, half_width, scratch, 1.0);
            let travel_m = scratch.travel.of(held);
            let world_from_held = self.world_from_held(scratch);
            for contact in &resting.contacts {
                let over_m =
                    resting.separation_m(contact, &world_from_held) - (contact.separation_m - slack_m);
                if over_m >= travel_m {
                    continue;
                }
                if over_m < 0.0 || travel_m < RESOLUTION_M {
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
    /// The parts of the world that the body touches, by their number among all.
    pub fn parts(&self) -> Vec<usize> {
        self.contacts.iter().map(|contact| contact.part).collect()
    }

    /// The bodies that it touches, and how far it is off each, in metres, negative for how deep in it.
    pub fn bodies(&self) -> impl Iterator<Item = (usize, f64)> {
        self.contacts.iter().map(|contact| (contact.body, contact.separation_m))
    }

    /// Ways off what the body touches, unit vectors, the first to be tried first: up, and away from all of it.
    pub fn ways_off(&self) -> Vec<Vector> {
        let up = Vector::z();
        let away: Vector = self.contacts.iter().map(|contact| contact.direction).sum();
        let mixed = (up + away).try_normalize(1e-6);
        std::iter::once(up).chain(mixed.filter(|way| (way - up).norm() > 1e-6)).collect()
    }

    fn separation_m(&self, contact: &RestingContact, world_from_held: &Pose) -> f64 {
        self.extent.lowest_along(world_from_held, &contact.direction) - contact.top_m
    }
}

/// How far a body of the world reaches along any direction (its support mapping), in the frame of its first solid.
#[derive(Clone, Debug)]
pub struct Extent {
    /// Its convex solids.
    solids: Vec<(Pose, Solid)>,
    /// The corners of its meshes.
    corners: Arc<[Point]>,
}

impl Extent {
    /// Of a body.
    ///
    /// # Errors
    /// [`CollisionError::Hold`] for one that has no end.
    pub fn of(body: &Body) -> Result<Self, CollisionError> {
        let unusable = || CollisionError::Hold { name: body.name.clone() };
        let held_from_world = body.parts.first().ok_or_else(unusable)?.world_from_solid.inverse();
        let (mut solids, mut corners) = (Vec::new(), Vec::new());
        for part in &body.parts {
            let held_from_part = held_from_world * part.world_from_solid;
            if part.solid.support_point(&Vector::x()).is_some() {
                solids.push((held_from_part, part.solid.clone()));
            } else {
                let (points, _) = part.solid.bounding_points().ok_or_else(unusable)?;
                corners.extend(points.iter().map(|point| held_from_part * point));
            }
        }
        Ok(Self { solids, corners: corners.into() })
    }

    /// How far the body, its first solid at a pose, reaches back along a direction, a unit vector: the least value of any of
    /// its points along it, in metres.
    pub fn lowest_along(&self, world_from_held: &Pose, direction: &Vector) -> f64 {
        let own = world_from_held.rotation.inverse() * direction;
        let of_corners = self.corners.iter().map(|corner| own.dot(&corner.coords));
        let of_solids = self.solids.iter().filter_map(|(held_from_solid, solid)| {
            let farthest = solid.support_point(&(held_from_solid.rotation.inverse() * -own))?;
            Some(own.dot(&(held_from_solid * farthest).coords))
        });
        let lowest = of_corners.chain(of_solids).fold(f64::INFINITY, f64::min);
        lowest + direction.dot(&world_from_held.translation.vector)
    }
}

/// What moves a body so that its first solid comes to a pose.
pub(crate) fn moved_to(body: &Body, world_from_held: &Pose) -> Pose {
    let now = body.parts.first().map_or_else(Pose::identity, |part| part.world_from_solid);
    world_from_held * now.inverse()
}

/// How far a part reaches along a direction, in metres; `None` where it has no end.
fn reach_along(part: &Part, direction: &Vector) -> Option<f64> {
    let Part { world_from_solid, solid } = part;
    if solid.is_half_space() {
        let normal = world_from_solid.rotation * Vector::z();
        return ((normal - direction).norm() < 1e-9)
            .then(|| direction.dot(&world_from_solid.translation.vector));
    }
    let own = world_from_solid.rotation.inverse() * direction;
    let of_meshes = || {
        let (points, _) = solid.bounding_points()?;
        points.iter().map(|point| own.dot(&point.coords)).reduce(f64::max)
    };
    let farthest = solid.support_point(&own).map(|point| own.dot(&point.coords)).or_else(of_meshes)?;
    Some(farthest + direction.dot(&world_from_solid.translation.vector))
}

/// Directions along which a part and a body may be separate: the axes of the part, and upwards …
fn axes(part: &Part) -> Vec<Vector> {
    let axes = [Vector::x(), Vector::y(), Vector::z()].map(|axis| part.world_from_solid.rotation * axis);
    let mut directions: Vec<Vector> = axes.iter().flat_map(|axis| [*axis, -axis]).collect();
    directions.push(Vector::z());
    directions
}

/// … and between their nearest points.
fn between(placed: &[(Pose, &Solid)], part: &Part) -> Vec<Vector> {
    let nearest = placed
        .iter()
        .filter_map(|(pose, solid)| closest_points(&part.solid, &part.world_from_solid, solid, pose));
    nearest.filter_map(|[from, to]| (to - from).try_normalize(1e-9)).collect()
}
