use cranny_spatial::LANES;
use fearless_simd::{Level, dispatch};

use crate::cell::{Cell, Scratch};
use crate::lanes::Interest;

impl Cell {
    /// Whether each of many configurations is free: the same verdicts as [`Cell::is_free`], many times as
    /// fast.
    ///
    /// `configurations` holds one row of dof values (m, rad) after the other; one verdict for each row is
    /// written to `verdicts`, which is emptied first.
    ///
    /// The law `are_free = is_free` is tested by `lanes_and_exact_check_agree`.
    ///
    /// # Panics
    /// If `configurations` does not consist of whole rows.
    pub fn are_free(&self, configurations: &[f64], scratch: &mut Scratch, verdicts: &mut Vec<bool>) {
        let dof = self.robot().dof();
        assert_eq!(configurations.len() % dof, 0, "whole rows of {dof} values");
        verdicts.clear();
        for rows in configurations.chunks(LANES * dof) {
            let mut within = 0;
            for (lane, q) in rows.chunks_exact(dof).enumerate() {
                within |= u32::from(self.robot().within_limits(q)) << lane;
            }
            let value =
                |lane: usize, joint: usize| rows.get(lane * dof + joint).copied().unwrap_or(rows[joint]);
            let free = self.judge_lanes(Level::new(), within, Interest::Each, value, scratch);
            verdicts.extend((0..rows.len() / dof).map(|lane| free >> lane & 1 == 1));
        }
    }

    /// How many of up to [`LANES`] configurations in a row are free, counted up to the first that is not:
    /// `value(index, joint)` is a joint of one of them (m, rad). Joint limits do not enter.
    ///
    /// This is what growing along an edge asks: all looks on the way at the price of few (Thomason, Kingston
    /// & Kavraki 2024).
    ///
    /// # Panics
    /// If there are more than [`LANES`] configurations.
    pub fn free_ahead(
        &self,
        count: usize,
        value: impl Fn(usize, usize) -> f64,
        scratch: &mut Scratch,
    ) -> usize {
        assert!(count <= LANES, "{count} configurations, at most {LANES} at once");
        let last = count.saturating_sub(1);
        let value = |lane: usize, joint: usize| value(lane.min(last), joint);
        let asked = first_lanes(count);
        self.judge_lanes(Level::new(), asked, Interest::UpToContact, value, scratch).trailing_ones() as usize
    }

    /// Bits of those lanes of `asked` that are free, or at least of those of `interest`.
    pub(crate) fn judge_lanes(
        &self,
        level: Level,
        asked: u32,
        interest: Interest,
        value: impl Fn(usize, usize) -> f64,
        scratch: &mut Scratch,
    ) -> u32 {
        scratch.lanes.travel.clear();
        scratch.lanes.set_q(&value);
        let contact = dispatch!(level, simd => self.lanes.look(simd, &mut scratch.lanes, asked, interest));
        let mut free = asked & !contact;
        let doubts = std::mem::take(&mut scratch.lanes.doubts);
        let doubtful = doubts.iter().fold(0, |all, (_, lanes)| all | lanes);
        for lane in lanes_of(doubtful & free) {
            for (joint, q) in scratch.q.iter_mut().enumerate() {
                *q = value(lane, joint);
            }
            self.robot().forward_kinematics(&scratch.q, &mut scratch.frames);
            let frames = &scratch.frames;
            let is_free = doubts
                .iter()
                .filter(|(_, lanes)| lanes >> lane & 1 == 1)
                .all(|(pair, _)| self.keeps_distance(&self.pairs[*pair as usize], frames));
            if !is_free {
                free &= !(1 << lane);
                if interest != Interest::Each {
                    break;
                }
            }
        }
        scratch.lanes.doubts = doubts;
        free
    }
}

/// The bits of the first so many lanes.
pub(crate) fn first_lanes(count: usize) -> u32 {
    (1 << count) - 1
}

/// The lanes whose bits are set, in order.
pub(crate) fn lanes_of(mut bits: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        (bits != 0).then(|| {
            let lane = bits.trailing_zeros() as usize;
            bits &= bits - 1;
            lane
        })
    })
}
