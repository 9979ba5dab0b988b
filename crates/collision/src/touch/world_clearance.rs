use crate::cell::{Cell, Scratch};
use crate::lane::lane_scratch::as_index;

impl Cell {
    /// Returns the least distance at `q` (m, rad; one per joint) between moving links and the world, in metres, as a certified
    /// lower bound; at most `up_to_m` (m). A floor above which a link always keeps its height is ignored. Other links are
    /// ignored too, because links beside a joint are always close.
    ///
    /// # Panics
    /// If `q` has not one value per joint.
    pub fn world_clearance(&self, q: &[f64], up_to_m: f64, scratch: &mut Scratch) -> f64 {
        self.robot().forward_kinematics(q, &mut scratch.frames);
        let frames = &scratch.frames;
        let mut least_m = up_to_m;
        for pairs in self.pairs.with_parts() {
            for index in self.near_parts(pairs, frames.link(self.bodies[pairs.body].link), up_to_m) {
                let pair = self.pairs.get(as_index(index));
                let is_farther = self.quick_bound(&pair, frames, least_m) >= least_m;
                // NaN does not count as farther.
                if !is_farther && !pair.is_exempt() && !self.is_constant(&pair, frames) {
                    least_m = least_m.min(self.distance(&pair, frames, least_m).lower_m);
                }
            }
        }
        least_m.max(0.0)
    }
}
