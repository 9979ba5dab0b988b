use cranny_robot::{LaneFrame, LaneTransform, LaneTwist};
use cranny_spatial::{LANES, LaneArray, LaneVector};
use fearless_simd::Simd;

use crate::lane::lane_vector::BoxLanes;
use crate::proof::joint_curve::JointCurve;

/// Bounds on the motion away from the checked configurations: all 0 for the configurations alone, positive for the motion
/// between them.
#[derive(Clone, Debug, Default)]
pub(crate) struct LaneTravel {
    /// Motion of each link against the world, in metres; for a motion, the check computes it.
    pub bodies: Vec<LaneArray>,
    /// The motion along which the configurations of all lanes lie.
    pub motion: LaneMotion,
    /// Relative motion of each pair of links, in metres.
    pub link_pairs: Vec<f32>,
    /// Motion of each joint, in metres or radians.
    pub joints: Vec<f32>,
}

/// A motion in which each lane represents the interval about its configuration: the velocity there bounds the travel of a link
/// within the interval (see [`Travel`](crate::proof::travel::Travel)).
#[derive(Clone, Debug, Default)]
pub(crate) struct LaneMotion {
    /// Half the width of the intervals, as a fraction of the motion; 0 if there is no motion.
    pub half_width: f32,
    /// Velocity of each joint in each lane, in metres or radians per unit of the parameter.
    pub rates: Vec<LaneArray>,
    /// Bounds on the motion of each link.
    pub link_speeds: Vec<LaneLinkSpeed>,
}

/// Bounds on the motion of a link that are valid in all intervals, in metres.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct LaneLinkSpeed {
    /// Upper bound on the motion of any of its points.
    pub most_m: f32,
    /// Amount to add to the motion that follows from the velocity in the middle of an interval.
    pub beside_m: f32,
}

#[derive(Clone, Debug, Default)]
pub(crate) struct LaneScratch {
    pub travel: LaneTravel,
    /// Velocities of the frames along the motion, if there is one.
    pub twists: Vec<LaneTwist>,
    /// Joint values of all lanes, one array per joint (m, rad).
    pub q: Vec<LaneArray>,
    /// Poses of loose links relative to the tip.
    pub places: Vec<LaneTransform>,
    pub frames: Vec<LaneFrame>,
    /// Box around each link along the axes of the root frame.
    pub boxes: Vec<LaneBox>,
    pub stack: Vec<Descent>,
    pub near: Vec<Near>,
    /// Pairs in doubt, each with its lanes as bits.
    pub doubts: Vec<(u32, u32)>,
    /// Pairs that [`Lanes::check_again`] checks, in order, each with its lanes as bits.
    ///
    /// [`Lanes::check_again`]: crate::lane::lanes::Lanes::check_again
    pub wanted: Vec<(u32, u32)>,
}

/// A box along the axes of the root frame in every lane, in metres.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LaneBox {
    pub middle: [LaneArray; 3],
    pub half_extents: [LaneArray; 3],
}

/// A node of a link's tree that is still to be compared with a range of the `near` list.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Descent {
    pub node: u32,
    pub begin: u32,
    pub end: u32,
}

/// A part that is near a node in some lanes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Near {
    /// Index among the link's pairs with parts.
    pub index: u32,
    pub lanes: u32,
}

impl LaneTravel {
    /// Restricts the check to the configurations themselves.
    pub fn clear(&mut self) {
        self.bodies.fill([0.0; LANES]);
        self.motion.half_width = 0.0;
        self.link_pairs.fill(0.0);
        self.joints.fill(0.0);
    }
}

impl LaneScratch {
    /// Allocates a scratch for these numbers of joints, frames, links with geometry, and pairs of links.
    pub fn new(dof: usize, frames: usize, bodies: usize, link_pairs: usize) -> Self {
        let nowhere = LaneBox { middle: [[0.0; LANES]; 3], half_extents: [[0.0; LANES]; 3] };
        Self {
            q: vec![[0.0; LANES]; dof],
            frames: vec![LaneFrame::IDENTITY; frames],
            twists: vec![LaneTwist::STILL; frames],
            boxes: vec![nowhere; bodies],
            travel: LaneTravel {
                bodies: vec![[0.0; LANES]; bodies],
                motion: LaneMotion::default(),
                link_pairs: vec![0.0; link_pairs],
                joints: vec![0.0; dof],
            },
            ..Self::default()
        }
    }

    /// Sets the configuration (m, rad; one per joint) of a lane.
    #[allow(
        clippy::cast_possible_truncation,
        reason = "lanes are `f32` by design; the slack of every comparison covers it"
    )]
    pub fn set_lane(&mut self, lane: usize, q: &[f64]) {
        for (lanes, value) in self.q.iter_mut().zip(q) {
            lanes[lane] = *value as f32;
        }
    }

    /// Sets the lanes to the configurations and rates of a motion at `places`, and further lanes to its start.
    #[allow(
        clippy::cast_possible_truncation,
        reason = "lanes are `f32` by design; the slack of every comparison covers it"
    )]
    pub fn set_lanes_along(&mut self, curve: JointCurve<'_>, places: impl Iterator<Item = f64>) {
        let mut all = [0.0; LANES];
        all.iter_mut().zip(places).for_each(|(known, place)| *known = place);
        let rates = &mut self.travel.motion.rates;
        rates.resize(self.q.len(), [0.0; LANES]);
        match curve {
            JointCurve::Line([a, b]) => {
                for ((lanes, rates), (a, b)) in self.q.iter_mut().zip(rates).zip(a.iter().zip(b)) {
                    *lanes = all.map(|place| (a + (b - a) * place) as f32);
                    *rates = [(b - a) as f32; LANES];
                }
            }
            JointCurve::Curve(_) => {
                let mut values = vec![0.0; self.q.len()];
                for (lane, place) in all.into_iter().enumerate() {
                    curve.place(place, &mut values);
                    self.q.iter_mut().zip(&values).for_each(|(lanes, value)| lanes[lane] = *value as f32);
                    curve.slope(place, &mut values);
                    rates.iter_mut().zip(&values).for_each(|(lanes, value)| lanes[lane] = *value as f32);
                }
            }
        }
    }

    /// Adds a lane in which a pair is to be checked again.
    pub fn want(&mut self, pair: u32, lane: usize) {
        match self.wanted.iter_mut().find(|(known, _)| *known == pair) {
            Some((_, lanes)) => *lanes |= 1 << lane,
            None => self.wanted.push((pair, 1 << lane)),
        }
    }

    pub fn push_children(&mut self, children: [u32; 2], begin: usize, end: usize) {
        if children != [0; 2] {
            let (begin, end) = (as_index(begin), as_index(end));
            self.stack.extend(children.map(|node| Descent { node, begin, end }));
        }
    }

    /// Returns the lanes in which the pair is already in doubt; the doubts of the pair's link start at `first`.
    pub fn doubt(&self, first: usize, pair: u32) -> u32 {
        self.doubts[first..].iter().find(|(doubtful, _)| *doubtful == pair).map_or(0, |(_, lanes)| *lanes)
    }

    pub fn add_doubt(&mut self, first: usize, pair: u32, lanes: u32) {
        match self.doubts[first..].iter_mut().find(|(doubtful, _)| *doubtful == pair) {
            Some((_, known)) => *known |= lanes,
            None => self.doubts.push((pair, lanes)),
        }
    }
}

impl LaneBox {
    #[inline(always)]
    pub fn load<S: Simd>(&self, simd: S) -> BoxLanes<S> {
        let half_extents = LaneVector::load(simd, &self.half_extents);
        BoxLanes { middle: LaneVector::load(simd, &self.middle), half_extents }
    }
}

/// Converts an index: there are far fewer links, parts and balls than `u32` can count.
pub(crate) fn as_index(index: usize) -> u32 {
    u32::try_from(index).unwrap_or(u32::MAX)
}
