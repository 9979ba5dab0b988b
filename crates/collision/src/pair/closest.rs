use cranny_shape::closest_points;
use cranny_spatial::Point;

use crate::cell::{Cell, Scratch};
use crate::pair::pairs::{Other, Pair};
use crate::touch::contact::{Collider, Contact};

/// The closest pair of a cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Closest {
    /// A link.
    pub first: Collider,
    /// Another link, or a body of the world.
    pub second: Collider,
    /// Their distance in metres, as a certified lower bound; negative for the penetration depth.
    pub distance_m: f64,
    /// Their closest points, in the planning frame; equal if they overlap. `None` if they touch and no common point is known.
    pub points: Option<[Point; 2]>,
}

impl Cell {
    /// Returns the closest or most deeply penetrating pair at `q` (m, rad; one per joint); `None` if there is no pair. Joint
    /// limits are not checked.
    ///
    /// `closest(q).distance_m = clearance(q)` where nothing touches.
    ///
    /// # Panics
    /// If `q` has not one value per joint.
    pub fn closest(&self, q: &[f64], scratch: &mut Scratch) -> Option<Closest> {
        self.robot().forward_kinematics(q, &mut scratch.frames);
        let (mut nearest, mut least_m) = (None, f64::INFINITY);
        for pair in self.pairs.iter().filter(|pair| !pair.is_exempt()) {
            let is_farther = self.quick_bound(&pair, &scratch.frames, least_m) >= least_m;
            // NaN does not count as farther: the pair is measured, and found in contact.
            if !is_farther {
                let distance_m = self.distance(&pair, &scratch.frames, least_m).lower_m;
                if distance_m < least_m {
                    (nearest, least_m) = (Some(pair), distance_m);
                }
            }
            if least_m <= 0.0 {
                return self.deepest(q, scratch);
            }
        }
        let pair = nearest?;
        let first = Collider::Link(self.bodies[pair.first].link);
        let second = self.other(&pair);
        let points = self.nearest_points(&pair, scratch);
        Some(Closest { first, second, distance_m: least_m, points })
    }

    /// Returns the least distances at `q` (m, rad; one per joint) of the robot with the held object from the world, and between
    /// its own links, in metres, as certified lower bounds; 0 in contact, infinite if there is no such pair. Joint limits are
    /// not checked.
    ///
    /// The lesser of `clearances(q)` is `clearance(q)`.
    ///
    /// # Panics
    /// If `q` has not one value per joint.
    pub fn clearances(&self, q: &[f64], scratch: &mut Scratch) -> [f64; 2] {
        [false, true].map(|is_own| {
            let is_asked =
                |pair: &Pair| !pair.is_exempt() && matches!(pair.second, Other::Link { .. }) == is_own;
            self.nearest_where(q, f64::INFINITY, &is_asked, scratch).0.max(0.0)
        })
    }

    fn deepest(&self, q: &[f64], scratch: &mut Scratch) -> Option<Closest> {
        let contacts = self.contacts(q, scratch);
        let Contact { first, second, depth_m, point, .. } =
            contacts.into_iter().max_by(|a, b| a.depth_m.total_cmp(&b.depth_m))?;
        Some(Closest { first, second, distance_m: 0.0 - depth_m, points: point.map(|point| [point; 2]) })
    }

    fn nearest_points(&self, pair: &Pair, scratch: &Scratch) -> Option<[Point; 2]> {
        let seconds = || self.placed_other(pair, &scratch.frames);
        let firsts = self.placed(pair.first, &scratch.frames);
        let pairs = firsts.flat_map(|one| seconds().map(move |other| (one, other)));
        pairs
            .filter_map(|((pose_a, a), (pose_b, b))| closest_points(a, &pose_a, b, &pose_b))
            .min_by(|m, n| (m[1] - m[0]).norm_squared().total_cmp(&(n[1] - n[0]).norm_squared()))
    }
}
