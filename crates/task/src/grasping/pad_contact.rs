use cranny_collision::{Body, Cell};
use cranny_grasp::{Contact, friction_needed};
use cranny_shape::{Aabb, Surface, TriangleSoup, closest_points};
use cranny_spatial::{Point, Pose, Vector};

/// Surfaces of the finger links of a hand, for contacts with the target at their true positions.
///
/// 1. Close each finger until it touches the target, and take the nearest point.
/// 2. Lay a grid of lines along the closing direction, across these points and the origin of the gripper frame. A line that
///    leads from one finger to the other through the target is a pair of contacts if a pad presses on the target's face there:
///    the plane of the face passes within [`PRESSED_M`] of the nearest point, and the finger lies beyond it. A pad turned
///    slightly against a face first touches an edge of it, and then settles on the face under pressure; it never touches
///    recessed faces.
///
/// A grasp needs as much friction as the best of these pairs, or infinite friction if no line meets both fingers, for example
/// if each pad meets a rib of its own.
#[derive(Clone, Debug)]
pub(crate) struct PadSurfaces {
    /// By index of the link, in its frame.
    of_links: Vec<(usize, Surface)>,
}

/// Compliance of the pads, in metres.
const PRESSED_M: f64 = 1e-4;

/// Distance before contact at which the nearest points are computed, in metres: large enough to define a direction.
const APPROACH_M: f64 = 5e-4;

/// Greatest tangent of the angle between a pad and a face: beyond it no friction holds.
const STEEPEST: f64 = 0.6;

/// Rounding tolerance on the distance between the nearest point and the plane of a face, in metres.
const ROUNDING_M: f64 = 1e-9;

/// Distance below which two lines count as one, in metres.
const SAME_LINE_M: f64 = 1e-9;

/// Number of lines along each side of the grid.
const LINES: u32 = 15;

/// Extent of the grid beyond the nearest points, in metres: about half of a small pad.
const BEYOND_M: f64 = 5e-3;

impl PadSurfaces {
    /// Collects the pad surfaces of a cell in which the hand holds something; links without a surface are left out.
    pub fn of(holding: &Cell) -> Self {
        let robot = holding.robot();
        let of_link = |link: usize| {
            let mut soup = TriangleSoup::default();
            for shape in &robot.links()[link].collisions {
                soup.append(&shape.solid.tessellation()?, &shape.link_from_shape);
            }
            Some((link, Surface::new(&soup).ok()?))
        };
        let links = (0..robot.links().len()).filter(|&link| robot.is_of_finger(link));
        Self { of_links: links.filter_map(of_link).collect() }
    }

    /// Returns the friction coefficient that a grasp needs, with the tip at a pose in the planning frame and each finger closed
    /// by the share of its travel at which it touches (`touching`, one per finger, from 0 to 1): infinite if no friction holds
    /// the target, `None` if fewer than two fingers touch it.
    pub fn friction_needed(
        &self,
        holding: &Cell,
        (target, surface): (&Body, &Surface),
        world_from_tip: &Pose,
        touching: &[f64],
    ) -> Option<f64> {
        if touching.len() < 2 {
            return None;
        }
        // 1.
        let nearest = |finger: usize| {
            let way_m = holding.finger_travel_m(finger);
            let before = (touching[finger] - APPROACH_M / way_m.max(APPROACH_M)).max(0.0);
            let links = holding.finger_at(finger, before);
            let pairs = links.iter().flat_map(|(link, tip_from_link)| {
                let shapes = holding.robot().links()[*link].collisions.iter();
                shapes.flat_map(move |shape| {
                    let at = world_from_tip * tip_from_link * shape.link_from_shape;
                    target.parts.iter().map(move |part| (&shape.solid, at, part))
                })
            });
            let found = pairs.filter_map(|(solid, at, part)| {
                closest_points(solid, &at, &part.solid, &part.world_from_solid)
            });
            let [on_finger, on_target] =
                found.min_by(|a, b| (a[1] - a[0]).norm().total_cmp(&(b[1] - b[0]).norm()))?;
            let normal_in_object = (on_finger - on_target).try_normalize(f64::MIN_POSITIVE)?;
            Some(Contact { point_in_object: on_target, normal_in_object })
        };
        let nearest = [nearest(0)?, nearest(1)?];
        // 2.
        let tip_from_world = world_from_tip.inverse();
        let corners = nearest.map(|contact| tip_from_world * contact.point_in_object);
        let along = |of: fn(&Point) -> f64| {
            let [a, b] = [of(&corners[0]), of(&corners[1])];
            let (low, high) = (a.min(b).min(0.0) - BEYOND_M, a.max(b).max(0.0) + BEYOND_M);
            let grid =
                (0..LINES).map(move |line| low + (high - low) * f64::from(line) / f64::from(LINES - 1));
            grid.chain([a, b, 0.0])
        };
        let fingers = [0, 1].map(|finger| {
            let tip_from_links = holding.finger_at(finger, touching[finger]);
            let nearest = nearest[finger];
            // Side from which the finger comes.
            let side = (tip_from_world * nearest.normal_in_object).y.signum();
            let outwards = world_from_tip.rotation * (Vector::y() * side);
            let faces = surface.filtered(|corner, normal| {
                normal.dot(&outwards) > 0.0
                    && (corner - nearest.point_in_object).dot(normal).abs() <= PRESSED_M + ROUNDING_M
            });
            let window =
                faces.as_ref().map(|faces| faces.aabb().transformed(&tip_from_world).grown(ROUNDING_M));
            Pressing {
                pads: self,
                tip_from_links,
                nearest,
                outwards,
                faces,
                window,
                touched_in_tip: corners[finger],
            }
        });
        let needed = |x: f64, z: f64| {
            if !fingers.iter().all(|finger| finger.may_meet(x, z)) {
                return f64::INFINITY;
            }
            let middle = world_from_tip * Point::new(x, 0.0, z);
            let of_first = fingers[0].on_line(surface, world_from_tip, &middle);
            if of_first.is_empty() {
                return f64::INFINITY;
            }
            let of_second = fingers[1].on_line(surface, world_from_tip, &middle);
            let pairs = of_first.iter().flat_map(|a| of_second.iter().map(|b| friction_needed(a, b)));
            pairs.fold(f64::INFINITY, f64::min)
        };
        let lines = along(|point| point.x).flat_map(|x| along(|point| point.z).map(move |z| [x, z]));
        Some(lines.map(|[x, z]| needed(x, z)).fold(f64::INFINITY, f64::min))
    }
}

/// A finger that touches the target.
struct Pressing<'a> {
    pads: &'a PadSurfaces,
    tip_from_links: Vec<(usize, Pose)>,
    nearest: Contact,
    /// Closing direction, away from the target.
    outwards: Vector,
    /// Triangles of the target on which the finger may press: their planes pass near the nearest point.
    faces: Option<Surface>,
    /// Bounds of these triangles, in the frame of the tip.
    window: Option<Aabb>,
    /// Nearest point, in the frame of the tip.
    touched_in_tip: Point,
}

impl Pressing<'_> {
    /// Returns true if a line along y of the frame of the tip may have a contact.
    fn may_meet(&self, x: f64, z: f64) -> bool {
        let is_in = |window: &Aabb| {
            let (low, high) = (window.low(), window.high());
            (low.x..=high.x).contains(&x) && (low.z..=high.z).contains(&z)
        };
        let off_m = [x - self.touched_in_tip.x, z - self.touched_in_tip.z];
        self.window.as_ref().is_some_and(is_in) || off_m.iter().all(|off| off.abs() <= ROUNDING_M)
    }

    /// Returns the contacts on a line along the closing direction through a point.
    fn on_line(&self, surface: &Surface, world_from_tip: &Pose, middle: &Point) -> Vec<Contact> {
        let (outwards, touched) = (self.outwards, self.nearest.point_in_object);
        let all = surface.aabb();
        let reach_m = all.distance_to(middle) + 2.0 * all.half_extents.norm();
        let begin = middle - outwards * reach_m;
        let hits = self
            .faces
            .as_ref()
            .map_or_else(Vec::new, |faces| faces.ray_hits(&begin, &outwards, 2.0 * reach_m));
        // A finger may stand in a gap of the target, so each exit point of the line counts.
        let leaves = hits.iter().filter(|hit| hit.normal.dot(&outwards) > 0.0);
        let faces = leaves.map(|hit| Contact {
            point_in_object: middle + outwards * (hit.distance_m - reach_m),
            normal_in_object: hit.normal,
        });
        let is_pressed = |contact: &Contact| {
            let off = contact.point_in_object - touched;
            off.dot(&contact.normal_in_object).abs() <= PRESSED_M
                && self.is_beyond(world_from_tip, &contact.point_in_object, off.norm())
        };
        let mut contacts: Vec<Contact> = faces.filter(is_pressed).collect();
        let off = touched - middle;
        if (off - outwards * off.dot(&outwards)).norm() < SAME_LINE_M {
            contacts.push(self.nearest);
        }
        contacts
    }

    /// Returns true if the finger lies beyond a point at distance `off_m` from its nearest point, in metres.
    fn is_beyond(&self, world_from_tip: &Pose, point: &Point, off_m: f64) -> bool {
        let begin = point - self.outwards * PRESSED_M;
        let reach_m = 2.0 * PRESSED_M + STEEPEST * off_m;
        self.tip_from_links.iter().any(|(link, tip_from_link)| {
            let finger = self.pads.of_links.iter().find(|(known, _)| known == link);
            let link_from_world = (world_from_tip * tip_from_link).inverse();
            let (begin, way) = (link_from_world * begin, link_from_world * self.outwards);
            finger.is_some_and(|(_, finger)| !finger.ray_hits(&begin, &way, reach_m).is_empty())
        })
    }
}
