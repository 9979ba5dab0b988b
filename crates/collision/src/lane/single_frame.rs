use cranny_robot::LaneFrame;
use cranny_spatial::LaneVector;
use fearless_simd::Simd;

use crate::lane::lane_bits::lanes_of;
use crate::lane::lane_solid::LaneSolid;
use crate::lane::lane_vector::dot;

/// A frame at one configuration by itself. Where two things are near each other in few lanes only, one by one
/// in plain numbers is faster than all lanes at once.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SingleFrame {
    pub axes: [[f32; 3]; 3],
    pub origin: [f32; 3],
}

impl SingleFrame {
    /// The root's own frame.
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

    /// A direction of the root frame in this one.
    #[inline(always)]
    pub fn turned_back(&self, direction: [f32; 3]) -> [f32; 3] {
        self.axes.map(|axis| dot(axis, direction))
    }

    /// A point of this frame in the root frame.
    #[inline(always)]
    pub fn point(&self, point: [f32; 3]) -> [f32; 3] {
        let [x, y, z] = self.direction(point);
        [x + self.origin[0], y + self.origin[1], z + self.origin[2]]
    }

    /// Points of this frame in the root frame.
    #[inline(always)]
    pub fn points<S: Simd>(&self, points: LaneVector<S>) -> LaneVector<S> {
        let [x, y, z] = &self.axes;
        LaneVector {
            x: points.dot([x[0], y[0], z[0]]) + self.origin[0],
            y: points.dot([x[1], y[1], z[1]]) + self.origin[1],
            z: points.dot([x[2], y[2], z[2]]) + self.origin[2],
        }
    }

    /// A solid of this frame in root coordinates.
    pub fn solid(&self, solid: &LaneSolid) -> LaneSolid {
        solid.placed(|direction| self.direction(direction), |point| self.point(point))
    }
}

/// What is certain of two things, everywhere in question.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Verdict {
    Free,
    Contact,
    Doubt,
}

impl Verdict {
    /// Those of `lanes` that are in doubt, each asked by itself; those in contact are taken out of `open`.
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

    /// The verdict on a pair of groups from those on all pairs of their members: free if all are, in contact
    /// if any is.
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

/// At `free_m` or farther two things are certainly far enough apart, below `contact_m` certainly too close.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bars {
    pub free_m: f32,
    pub contact_m: f32,
}

impl Bars {
    /// The verdict on a distance that is known from below and above.
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
