use cranny_robot::between;
use cranny_spatial::{LANES, simd_level};
use fearless_simd::Level;

use crate::cell::{Cell, Scratch};
use crate::lane::lane_bits::{first_lanes, lanes_of};
use crate::lane::lanes::Interest;
use crate::proof::joint_curve::JointCurve;

impl Cell {
    /// Returns true if `q` (m, rad; one per joint) is within the joint limits, every pair keeps its distance, and the tool its
    /// bounds. The verdict is that of [`Self::is_clear`], many times as fast.
    ///
    /// The law `is_free = is_clear` within the limits is tested by `lanes_and_exact_check_agree`.
    ///
    /// # Panics
    /// If `q` has not one value per joint.
    pub fn is_free(&self, q: &[f64], scratch: &mut Scratch) -> bool {
        assert_eq!(q.len(), self.robot().dof(), "one value per joint");
        scratch.lanes.set_lane(0, q);
        let exact = |_, exact: &mut [f64]| exact.copy_from_slice(q);
        self.robot().within_limits(q)
            && self.judge_lanes(simd_level(), first_lanes(1), Interest::AllOrNothing, exact, scratch) == 1
    }

    /// Checks many configurations: the same verdicts as [`Cell::is_free`], several times as fast.
    ///
    /// `configurations` contains one row after the other, each of one value per joint (m, rad). `verdicts` is cleared, and
    /// receives one verdict per row.
    ///
    /// The law `are_free = is_clear` within the limits is tested by `lanes_and_exact_check_agree`.
    ///
    /// # Panics
    /// If `configurations` does not consist of whole rows.
    pub fn are_free(&self, configurations: &[f64], scratch: &mut Scratch, verdicts: &mut Vec<bool>) {
        self.are_free_with(simd_level(), configurations, scratch, verdicts);
    }

    /// Runs [`Self::are_free`] with the instructions of `level`, to compare these, on rows of one value per joint (m, rad).
    ///
    /// # Panics
    /// If `configurations` does not consist of whole rows.
    pub fn are_free_with(
        &self,
        level: Level,
        configurations: &[f64],
        scratch: &mut Scratch,
        verdicts: &mut Vec<bool>,
    ) {
        let dof = self.robot().dof();
        assert_eq!(configurations.len() % dof, 0, "whole rows of {dof} values");
        verdicts.clear();
        for rows in configurations.chunks(LANES * dof) {
            let mut within = 0;
            for (lane, q) in rows.chunks_exact(dof).enumerate() {
                within |= u32::from(self.robot().within_limits(q)) << lane;
                scratch.lanes.set_lane(lane, q);
            }
            let exact = |lane: usize, q: &mut [f64]| q.copy_from_slice(&rows[lane * dof..][..dof]);
            let free = self.judge_lanes(level, within, Interest::Each, exact, scratch);
            verdicts.extend((0..rows.len() / dof).map(|lane| free >> lane & 1 == 1));
        }
    }

    /// Returns the number of free configurations before the first one that is not free, of those at `places` (at most
    /// [`LANES`]) on the straight edge from `a` (at 0) to `b` (at 1), both (m, rad; one per joint). Joint limits are not
    /// checked.
    ///
    /// Extends an edge by many checks at the cost of a few (Thomason, Kingston & Kavraki 2024, "Motions in microseconds via
    /// vectorized sampling-based planning", Fig. 2, here in the order of the edge).
    ///
    /// # Panics
    /// If `places` has more than [`LANES`] values, or `a` or `b` has not one value per joint.
    pub fn free_ahead(&self, a: &[f64], b: &[f64], places: &[f64], scratch: &mut Scratch) -> usize {
        let count = places.len();
        assert!(count <= LANES, "{count} configurations, at most {LANES} at once");
        assert!(a.len() == self.robot().dof() && b.len() == a.len(), "one value per joint");
        scratch.lanes.set_lanes_along(JointCurve::Line([a, b]), places.iter().copied());
        let exact = |lane: usize, q: &mut [f64]| {
            q.iter_mut().zip(between(a, b, places[lane])).for_each(|(q, exact)| *q = exact);
        };
        let interest = Interest::UpToContact;
        let free = self.judge_lanes(simd_level(), first_lanes(count), interest, exact, scratch);
        free.trailing_ones() as usize
    }

    /// Returns the free lanes of `asked` as bits; only bits that `interest` needs are reliable. `scratch.lanes` contains the
    /// configurations, and `exact` writes the unrounded configuration of a lane.
    fn judge_lanes(
        &self,
        level: Level,
        asked: u32,
        interest: Interest,
        exact: impl Fn(usize, &mut [f64]),
        scratch: &mut Scratch,
    ) -> u32 {
        let mut asked = asked;
        if !self.bounds.is_empty() {
            for lane in lanes_of(asked) {
                let mut q = std::mem::take(&mut scratch.q);
                exact(lane, &mut q);
                asked &= !(u32::from(!self.keeps_bounds(&q, scratch)) << lane);
                scratch.q = q;
            }
        }
        let Scratch { lanes, frames, q, .. } = scratch;
        lanes.travel.clear();
        let contact = self.lanes.check(level, lanes, asked, interest);
        let mut free = asked & !contact;
        let doubtful = lanes.doubts.iter().fold(0, |all, (_, lanes)| all | lanes);
        for lane in lanes_of(doubtful & free) {
            exact(lane, q);
            self.robot().forward_kinematics(q, frames);
            let mut doubts = lanes.doubts.iter().filter(|(_, lanes)| lanes >> lane & 1 == 1);
            let is_free = doubts.all(|(pair, _)| self.keeps_distance(&self.pairs.get(*pair), frames));
            if !is_free {
                free &= !(1 << lane);
                if interest != Interest::Each {
                    break;
                }
            }
        }
        free
    }
}
