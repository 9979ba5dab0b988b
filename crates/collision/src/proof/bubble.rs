use cranny_robot::{JointKind, LinkFrames};
use cranny_spatial::{ROUNDING_M, Vector};

use crate::cell::{Cell, Scratch};
use crate::lane::lane_scratch::as_index;
use crate::pair::pairs::{Other, Pair};
use crate::proof::joint_curve::JointCurve;

/// A free configuration with the excess of each distance there over the demanded one. These bound the free length of any
/// straight motion that starts there, without another distance computation.
///
/// Sources: bubbles of free configurations (Quinlan 1994, "Real-time modification of collision-free paths", whole, of which
/// only the bubbles are used); evaluation along rays, which form a bur: Lačević, Osmanković & Ademović 2016, "Burs of free
/// C-space" (ICRA, §III). Two differences: each link and each pair of links has its own distance instead of the least of all,
/// and the motion of a link is measured at configurations on the ray and bounded between them.
#[derive(Clone, Debug)]
pub struct Bubble {
    q: Vec<f64>,
    frames: LinkFrames,
    /// Least gap between each link and the world, in metres.
    to_world_m: Vec<f64>,
    /// Gap of every pair of links whose relative pose is in no table, in metres.
    between_links_m: Vec<(Pair, f64)>,
}

/// Maximum gap that is measured, in metres; larger gaps count as equal to it.
const MEASURED_UP_TO_M: f64 = 0.5;

/// Maximum number of evaluations along one ray.
const MOST_LOOKS: usize = 12;

/// Minimum gain of an evaluation, as a fraction of the ray; below it the search ends.
const LEAST_GAIN: f64 = 0.01;

/// First step length, as a fraction of the ray. Further ones are the last gain times [`NEXT_TRY`], for sharper bounds.
const FIRST_TRY: f64 = 0.1;
const NEXT_TRY: f64 = 2.0;

impl Cell {
    /// Returns the bubble about `q` (m, rad; one per joint); `None` if a moving link is closer to the world than `critical_m`
    /// (m; at least 0) beyond the demanded distance, or if links are closer to each other than allowed. Links on either side of
    /// one or two joints are always close; their tables apply instead. Joint limits are not checked.
    ///
    /// # Panics
    /// If `q` has not one value per joint.
    pub fn bubble(&self, q: &[f64], critical_m: f64, scratch: &mut Scratch) -> Option<Bubble> {
        if !q.iter().all(|value| value.is_finite()) {
            return None;
        }
        self.robot().forward_kinematics(q, &mut scratch.frames);
        let frames = &scratch.frames;
        let near = |beyond_m: f64| {
            let pairs = self.pairs.with_parts().flat_map(move |pairs| {
                self.near_parts(pairs, frames.link(self.bodies[pairs.body].link), beyond_m)
            });
            pairs.map(|index| self.pairs.get(as_index(index))).filter(|pair| !pair.is_exempt())
        };
        // Detecting a near part is much cheaper than measuring its distance.
        let is_far = |pair: Pair| {
            let critical_m = if self.is_constant(&pair, frames) { 0.0 } else { critical_m };
            self.is_beyond(&pair, frames, pair.required_m + critical_m + ROUNDING_M)
        };
        if !near(critical_m + ROUNDING_M).all(is_far) {
            return None;
        }
        let gap_m = |pair: &Pair, up_to_m: f64| {
            let enough_m = pair.required_m + up_to_m + ROUNDING_M;
            let quick_m = self.quick_bound(pair, frames, enough_m);
            let distance_m =
                if quick_m >= enough_m { quick_m } else { self.distance(pair, frames, enough_m).lower_m };
            distance_m - pair.required_m - ROUNDING_M
        };
        let mut to_world_m = vec![MEASURED_UP_TO_M; self.bodies.len()];
        for pair in near(MEASURED_UP_TO_M).filter(|pair| !self.is_constant(pair, frames)) {
            let least_m = &mut to_world_m[pair.first];
            *least_m = least_m.min(gap_m(&pair, *least_m));
        }
        let of_links = self.lanes.untabled().map(|index| self.pairs.get(index));
        let between_links_m: Vec<(Pair, f64)> = of_links
            .filter(|pair| !pair.is_exempt())
            .map(|pair| (pair, gap_m(&pair, MEASURED_UP_TO_M)))
            .collect();
        let is_apart = |gap_m: &f64| *gap_m > 0.0;
        let mut gaps_m = to_world_m.iter().chain(between_links_m.iter().map(|(_, gap_m)| gap_m));
        if !gaps_m.all(is_apart) {
            return None;
        }
        Some(Bubble { q: q.to_vec(), frames: scratch.frames.clone(), to_world_m, between_links_m })
    }

    /// Returns true if no joint changes the height of a link above a plane, as for a mobile base close to the floor.
    pub(crate) fn is_constant(&self, pair: &Pair, frames: &LinkFrames) -> bool {
        /// Rounding of a component of a unit vector.
        const NOTHING: f64 = 1e-12;
        let Other::Part(index) = pair.second else { return false };
        let part = &self.parts()[index].1;
        let normal = part.world_from_solid.rotation * Vector::z_axis();
        let ancestors = self.robot().ancestors(self.bodies[pair.first].link);
        part.solid.is_half_space()
            && ancestors.iter().all(|ancestor| {
                let axis = frames.link(ancestor.child_link).rotation * ancestor.axis_in_child;
                match ancestor.kind {
                    JointKind::Prismatic => axis.dot(&normal).abs() < NOTHING,
                    JointKind::Revolute => axis.cross(&normal).norm() < NOTHING,
                }
            })
    }

    /// Returns the fraction, from 0 to 1, of the straight motion from the centre of `bubble` to `target` (m, rad; one per
    /// joint) on which certainly no link moves by more than its gaps. Joint limits are not checked.
    ///
    /// 1. Measure the motion of each link up to a free configuration on the ray, and the remainder of each gap.
    /// 2. Bound all motions beyond it by joints and levers, which certifies another fraction of the ray.
    ///
    /// # Panics
    /// If `target` has not one value per joint.
    pub fn free_share(&self, bubble: &Bubble, target: &[f64], scratch: &mut Scratch) -> f64 {
        assert_eq!(target.len(), self.robot().dof(), "one value per joint");
        let curve = JointCurve::Line([&bubble.q, target]);
        scratch.rates.set(curve);
        if !scratch.rates.now.iter().all(|slope| slope.is_finite()) {
            return 0.0;
        }
        let mut free = 0.0;
        let mut ahead = FIRST_TRY;
        for _ in 0..MOST_LOOKS {
            // 1.
            curve.place(free, &mut scratch.q);
            self.robot().forward_kinematics(&scratch.q, &mut scratch.frames);
            // 2.
            let Scratch { travel, rates, frames, .. } = &mut *scratch;
            travel.update(self.robot(), &self.bodies, frames, rates, ahead, 1.0);
            let ease = self.ease(bubble, scratch);
            // Travel grows at least in proportion, so the proportional fraction is free.
            let gain = if ease >= 1.0 { ahead } else { ease * ahead * SAFE };
            let gain = gain * self.tabled_share(&bubble.q, target, free, gain);
            free += gain;
            if free >= 1.0 || gain < LEAST_GAIN {
                break;
            }
            ahead = (NEXT_TRY * gain).min(1.0 - free);
        }
        free
    }

    /// Returns the fraction of the ray from `free` to `free + gain` that the tables certify.
    fn tabled_share(&self, a: &[f64], b: &[f64], free: f64, gain: f64) -> f64 {
        let at = |joint: usize, share: f64| a[joint] + (b[joint] - a[joint]) * share;
        let limits = self.robot().limits();
        self.lanes.tables().iter().fold(1.0, |share, table| {
            let ends = [free, free + gain * share].map(|share| table.joints.map(|joint| at(joint, share)));
            share * table.free_share(table.joints.map(|joint| &limits[joint]), ends)
        })
    }

    /// Returns the least ratio, over all pairs, of the remaining gap at the frames of `scratch` to the travel; at most 1.
    fn ease(&self, bubble: &Bubble, scratch: &mut Scratch) -> f64 {
        let Scratch { travel, frames, moved_m, .. } = scratch;
        let ease = |gap_m: f64, moved_m: f64, travel_m: f64| {
            let left_m = (gap_m - moved_m - ROUNDING_M).max(0.0);
            // A link that does not move keeps its distance.
            if travel_m > 0.0 { left_m / travel_m } else { f64::INFINITY }
        };
        let mut least = 1.0_f64;
        moved_m.clear();
        for (index, (body, gap_m)) in self.bodies.iter().zip(&bubble.to_world_m).enumerate() {
            let moved = body.moved_m(bubble.frames.link(body.link), frames.link(body.link));
            least = least.min(ease(*gap_m, moved, travel.of(index)));
            moved_m.push(moved);
        }
        for (pair, gap_m) in &bubble.between_links_m {
            let Other::Link { body, shared_joints } = pair.second else { continue };
            let travel_m = travel.between(pair.first, body, shared_joints);
            // Two bounds are valid: the sum of both motions, and the relative motion of the two links, which takes longer to
            // compute.
            if ease(*gap_m, moved_m[pair.first] + moved_m[body], travel_m) >= least {
                continue;
            }
            let [first, second] = [pair.first, body].map(|body| &self.bodies[body]);
            let seen = |frames: &LinkFrames| frames.link(second.link).inv_mul(frames.link(first.link));
            least = least.min(ease(*gap_m, first.moved_m(&seen(&bubble.frames), &seen(frames)), travel_m));
        }
        least
    }
}

/// Reserve for rounding of a proportion.
const SAFE: f64 = 1.0 - 1e-9;
