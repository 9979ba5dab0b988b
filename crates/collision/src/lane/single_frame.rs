use cranny_robot::LaneFrame;
use cranny_spatial::LaneVector;
use fearless_simd::Simd;

use crate::lane::lane_bits::lanes_of;
use crate::lane::lane_solid::LaneSolid;
use crate::lane::lane_vector::dot;

/// A frame at a single configuration. For pairs that are near each other in few lanes, scalar computation lane by lane is
/// faster than all lanes at once.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SingleFrame {
    pub axes: [[f32; 3]; 3],
    pub origin: [f32; 3],
}

impl SingleFrame {
    /// Frame of the root itself.
    pub const ROOT: Self =
        Self { axes: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], origin: [0.0; 3] };

    pub fn of(frame: &LaneFrame, lane: usize) -> Self {
        Self {
            axes: frame.axes.each_ref().map(|axis| axis.each_ref().map(|row| row[lane])),
            origin: frame.origin.each_ref().map(|row| row[lane]),
        }
    }

    pub fn direction(&self, [x, y, z]: [f32; 3]) -> [f32; 3] {
        let [along_x, along_y, along_z] = &self.axes;
        std::array::from_fn(|row| along_x[row] * x + along_y[row] * y + along_z[row] * z)
    }

    /// Rotates a direction from the root frame to this frame.
    #[inline(always)]
    pub fn turned_back(&self, direction: [f32; 3]) -> [f32; 3] {
        self.axes.map(|axis| dot(axis, direction))
    }

    /// Transforms a point of this frame to the root frame.
    #[inline(always)]
    pub fn point(&self, point: [f32; 3]) -> [f32; 3] {
        let [x, y, z] = self.direction(point);
        [x + self.origin[0], y + self.origin[1], z + self.origin[2]]
    }

    /// Transforms points of this frame to the root frame.
    #[inline(always)]
    pub fn points<S: Simd>(&self, points: LaneVector<S>) -> LaneVector<S> {
        let [x, y, z] = &self.axes;
        LaneVector {
            x: points.dot([x[0], y[0], z[0]]) + self.origin[0],
            y: points.dot([x[1], y[1], z[1]]) + self.origin[1],
            z: points.dot([x[2], y[2], z[2]]) + self.origin[2],
        }
    }

    /// Transforms a solid of this frame to the root frame.
    pub fn solid(&self, solid: &LaneSolid) -> LaneSolid {
        solid.placed(|direction| self.direction(direction), |point| self.point(point))
    }
}

/// Verdict on a pair that is certain for all configurations in question.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Verdict {
    Free,
    Contact,
    Doubt,
}

impl Verdict {
    /// Returns those of `lanes` that are in doubt, each evaluated by itself; those in contact are removed from `open`.
    #[inline(always)]
    pub fn one_by_one(lanes: u32, verdict: impl Fn(usize) -> Self, open: &mut u32) -> u32 {
        let mut doubt = 0;
        for lane in lanes_of(lanes) {
            match verdict(lane) {
                Self::Free => {}
                Self::Contact => *open &= !(1 << lane),
                Self::Doubt => doubt |= 1 << lane,
            }
        }
        doubt
    }

    /// Combines the verdicts on all pairs of members of two groups: free if all are free, in contact if any is in contact.
    pub fn of_all(verdicts: impl Iterator<Item = Self>) -> Self {
        let mut all = Self::Free;
        for verdict in verdicts {
            match verdict {
                Self::Free => {}
                Self::Contact => return Self::Contact,
                Self::Doubt => all = Self::Doubt,
            }
        }
        all
    }
}

/// Thresholds in metres: a pair is certainly far enough apart from `free_m` on, and certainly too close below `contact_m`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bars {
    pub free_m: f32,
    pub contact_m: f32,
}

impl Bars {
    /// Returns the verdict on a distance with a known lower and upper bound (m).
    pub fn verdict(self, [low_m, high_m]: [f32; 2]) -> Verdict {
        if low_m >= self.free_m {
            Verdict::Free
        } else if high_m < self.contact_m {
            Verdict::Contact
        } else {
            Verdict::Doubt
        }
    }
}
