use std::fmt;

use cranny_spatial::{EXACT_ROTATION_RAD, EXACT_TRANSLATION_M, Point, Pose, PoseDifference, Stream};
use serde::{Deserialize, Serialize};

use crate::PoseBounds;

/// Task space region: a set of poses of the hand, or of the object in it (Berenson, Srinivasa & Kuffner 2011, §4).
///
/// A region of one frame is `{pose · b · end : b ∈ bounds}`. One of two frames, such as those of a hinge and of a handle beyond
/// it, is the product of both sets, first times second. A pose counts as in the region within 1 mm and 1°.
#[derive(Clone, Debug, PartialEq)]
pub struct Region {
    /// The frame that is moved into the region.
    pub moved: Moved,
    /// Frames in series; the pose of the first is in the planning frame.
    pub frames: Vec<RegionFrame>,
}

/// Frame of a region, with the bounds on poses relative to it.
#[derive(Clone, Debug, PartialEq)]
pub struct RegionFrame {
    /// Pose of the frame, `T⁰_w`: in the planning frame, or in the end of the frame before.
    pub pose: Pose,
    /// Bounds `B_w` on poses in it.
    pub bounds: PoseBounds,
    /// Pose of its end in a pose within the bounds, `T^w_e`: that of the moved frame, or of the origin of the next frame.
    pub end: Pose,
}

/// Frame that a motion brings to a pose.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Moved {
    /// The gripper frame.
    Hand,
    /// The first solid of the object in the hand.
    Object,
}

impl Region {
    /// Greatest number of frames in series.
    pub const MOST_FRAMES: usize = 2;

    /// Returns true if another region contains the same poses, up to rounding.
    pub(crate) fn is_like(&self, other: &Self) -> bool {
        let is_near = |a: &Pose, b: &Pose| {
            let PoseDifference { translation_m, rotation_rad } = PoseDifference::between(a, b);
            translation_m < 1e-9 && rotation_rad < 1e-9
        };
        let is_same = |(a, b): (&RegionFrame, &RegionFrame)| {
            a.bounds == b.bounds && is_near(&a.pose, &b.pose) && is_near(&a.end, &b.end)
        };
        self.moved == other.moved
            && self.frames.len() == other.frames.len()
            && self.frames.iter().zip(&other.frames).all(is_same)
    }

    /// Returns this region in a new frame; `new_from_old` is the pose of the present frame in it.
    #[must_use]
    pub fn in_frame(&self, new_from_old: &Pose) -> Self {
        let mut moved = self.clone();
        if let Some(first) = moved.frames.first_mut() {
            first.pose = new_from_old * first.pose;
        }
        moved
    }

    /// Returns the deviation of a pose in the planning frame from the region: 0 within it. The distance and the angle belong to
    /// one pose of the region. For two frames, that pose is the best of several local searches over the bounds of the first, so
    /// that a pose near the region may count as off it, but none off it as near.
    pub fn off(&self, pose: &Pose) -> PoseDifference {
        match &self.frames[..] {
            [] => PoseDifference { translation_m: f64::INFINITY, rotation_rad: f64::INFINITY },
            [only] => only.off(pose),
            [first, second, ..] => off_series([first, second], pose),
        }
    }

    /// Returns the deviation, in words, from the nearest of several regions, with the pose of each moved frame in the planning
    /// frame; `None` in any of them. A pose of an empty hand's object is in none.
    pub fn fault_of_all(regions: &[Self], pose_of: impl Fn(Moved) -> Option<Pose>) -> Option<String> {
        let rank = |off: &PoseDifference| {
            off.translation_m / EXACT_TRANSLATION_M + off.rotation_rad / EXACT_ROTATION_RAD
        };
        let off = |region: &Self| Some((region.moved, region.off(&pose_of(region.moved)?)));
        let nearest = regions.iter().filter_map(off).min_by(|a, b| rank(&a.1).total_cmp(&rank(&b.1)));
        let Some((moved, off)) = nearest else { return Some("nothing is in the hand".to_owned()) };
        // The nearest by rank is not within both tolerances where another may be.
        let is_in = |region: &Self| pose_of(region.moved).is_some_and(|pose| region.off(&pose).is_exact());
        if off.is_exact() || regions.iter().any(is_in) {
            return None;
        }
        let (mm, degrees) = (off.translation_m * 1e3, off.rotation_rad.to_degrees());
        Some(format!("{moved} is {mm:.2} mm and {degrees:.2}° from its goal region"))
    }

    /// Draws a random pose of the moved frame in the planning frame, uniform within the bounds of each frame
    /// ([`PoseBounds::draw`]).
    pub fn draw(&self, random: &mut Stream) -> Pose {
        let frames = self.frames.iter();
        frames.fold(Pose::identity(), |at, frame| at * frame.pose * frame.bounds.draw(random) * frame.end)
    }

    /// Returns the centres of regions first, then random poses as [`Self::draw`] of regions as [`Self::choose`], each with the
    /// frame that is moved.
    pub fn draws(regions: &[Self], mut random: Stream) -> impl Iterator<Item = (Moved, Pose)> {
        let next = |at: Pose, frame: &RegionFrame| at * frame.pose * frame.bounds.middle() * frame.end;
        let middle = move |region: &Self| (region.moved, region.frames.iter().fold(Pose::identity(), next));
        let drawn = std::iter::repeat_with(move || {
            let region = regions.get(Self::choose(regions, &mut random))?;
            Some((region.moved, region.draw(&mut random)))
        });
        regions.iter().map(middle).chain(drawn.map_while(|drawn| drawn))
    }

    /// Draws the index of one of several regions, with probability in proportion to the sum of the widths of its bounds (m,
    /// rad); among regions without width, each with the same (Berenson, Srinivasa & Kuffner 2011, §4.3).
    /// Returns 0 for a single one, or none, without a draw.
    pub fn choose(regions: &[Self], random: &mut Stream) -> usize {
        if regions.len() < 2 {
            return 0;
        }
        let width = |region: &Self| region.frames.iter().map(|frame| frame.bounds.width()).sum::<f64>();
        let total: f64 = regions.iter().map(width).sum();
        if total <= 0.0 {
            return random.index(regions.len());
        }
        let mut left = random.uniform() * total;
        let is_chosen = |region: &Self| {
            left -= width(region);
            left < 0.0
        };
        regions.iter().position(is_chosen).unwrap_or(regions.len() - 1)
    }

    /// Returns a ball that contains the positions of all poses: its centre in the planning frame, and its radius in metres.
    pub fn ball(&self) -> (Point, f64) {
        let Some((first, others)) = self.frames.split_first() else { return (Point::origin(), 0.0) };
        let (middle, half_m) = first.bounds.box_ball();
        let of_others = others.iter().map(|frame| {
            let (middle, half_m) = frame.bounds.box_ball();
            (frame.pose * Point::from(middle)).coords.norm() + half_m + frame.end.translation.vector.norm()
        });
        let radius_m = half_m + first.end.translation.vector.norm() + of_others.sum::<f64>();
        (first.pose * Point::from(middle), radius_m)
    }

    /// Returns the fault, in words, of an invalid region.
    pub(crate) fn fault(&self) -> Option<String> {
        let is_intervals = |frame: &RegionFrame| matches!(frame.bounds, PoseBounds::Intervals { .. });
        if self.frames.is_empty() || self.frames.len() > Self::MOST_FRAMES {
            return Some(format!("a region has 1 to {} `frames`", Self::MOST_FRAMES));
        }
        if self.frames.len() > 1 && !self.frames.iter().all(is_intervals) {
            return Some("two frames in series need bounds of x, y, z, roll, pitch and yaw".to_owned());
        }
        self.frames.iter().find_map(|frame| frame.bounds.fault())
    }
}

impl RegionFrame {
    /// Returns the deviation of the end from the poses within the bounds.
    fn off(&self, pose: &Pose) -> PoseDifference {
        self.bounds.off(&(self.pose.inverse() * pose * self.end.inverse()))
    }
}

/// Searches the bounds of the first of two frames for the pose from which the second is nearest to a pose.
///
/// 1. Starts at the centre of the bounds and at random points of them.
/// 2. From each, steps along one interval at a time while that reduces the deviation, by steps that are halved otherwise.
/// 3. Ends at a deviation that counts as none.
fn off_series([first, second]: [&RegionFrame; 2], pose: &Pose) -> PoseDifference {
    const STARTS: usize = 24;
    const LEAST_STEP: f64 = 1e-7;
    let here = first.pose.inverse() * pose;
    let off_at = |shares: &[f64; 6]| second.off(&((first.bounds.at(shares) * first.end).inverse() * here));
    let cost = |off: &PoseDifference| {
        (off.translation_m / EXACT_TRANSLATION_M).powi(2) + (off.rotation_rad / EXACT_ROTATION_RAD).powi(2)
    };
    let is_free = first.bounds.is_free();
    let mut random = Stream::new(0, 0);
    let mut best = off_at(&[0.5; 6]);
    for start in 0..STARTS {
        let mut shares = if start == 0 { [0.5; 6] } else { std::array::from_fn(|_| random.uniform()) };
        let (mut off, mut step) = (off_at(&shares), 0.25);
        while step > LEAST_STEP && cost(&off) > 1e-12 {
            let mut is_better = false;
            for (axis, sign) in
                (0..6).filter(|axis| is_free[*axis]).flat_map(|axis| [(axis, 1.0), (axis, -1.0)])
            {
                let mut next = shares;
                next[axis] = (next[axis] + sign * step).clamp(0.0, 1.0);
                let found = off_at(&next);
                if cost(&found) < cost(&off) {
                    (shares, off, is_better) = (next, found, true);
                }
            }
            if !is_better {
                step *= 0.5;
            }
        }
        if cost(&off) < cost(&best) {
            best = off;
        }
        if best.is_exact() {
            break;
        }
    }
    best
}

impl fmt::Display for Moved {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Hand => "the hand",
            Self::Object => "the object in the hand",
        })
    }
}

impl fmt::Display for Region {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} to ", self.moved)?;
        for (index, RegionFrame { pose, bounds, .. }) in self.frames.iter().enumerate() {
            if index > 0 {
                f.write_str(", then ")?;
            }
            let [x, y, z] = pose.translation.vector.into();
            write!(f, "({x:.3}, {y:.3}, {z:.3}) m")?;
            match bounds {
                PoseBounds::Within { within_m, within_deg } => {
                    if within_m.iter().any(|side_m| *side_m > 0.0) || *within_deg > 0.0 {
                        let [x, y, z] = within_m;
                        write!(f, " within ({x:.3}, {y:.3}, {z:.3}) m, {within_deg:.1}°")?;
                    }
                }
                PoseBounds::Intervals { position_m, rpy_deg } => {
                    let metres = ["x", "y", "z"].into_iter().zip(position_m).map(|row| (row, " m"));
                    let degrees = ["roll", "pitch", "yaw"].into_iter().zip(rpy_deg).map(|row| (row, "°"));
                    for ((axis, [lower, upper]), unit) in metres.chain(degrees) {
                        if upper > lower {
                            write!(f, ", {axis} {lower} to {upper}{unit}")?;
                        }
                    }
                }
            }
        }
        Ok(())
    }
}
