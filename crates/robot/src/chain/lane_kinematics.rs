use cranny_spatial::nalgebra::{Matrix3, Translation3};
use cranny_spatial::{
    LANES, LaneArray, LaneVector, MOST_TURN_IN_LANES_RAD, Pose, Rotation, SINE_ERROR_IN_LANES, Vector,
    sin_cos_lanes,
};
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};

use crate::chain::frame_error::{FrameError, MovedBy};
use crate::{FARTHEST_HELD_M, Hold, JointKind, Robot};

/// Forward kinematics of [`LANES`] configurations at once, in `f32`.
///
/// Links that are rigid with each other share one frame. Every frame but the root's is oriented with its joint's axis as z,
/// so a rotation mixes only two columns.
///
/// The error relative to [`Robot::forward_kinematics`] stays below [`position_error_m`](Self::position_error_m) everywhere
/// within the joint limits. Fused multiplication is not used, so every instruction set gives the same bits.
#[derive(Clone, Debug)]
pub struct LaneKinematics {
    /// Parents before children; element `i` has frame number `i + 1`, the root has number 0.
    steps: Vec<LaneStep>,
    /// Per link of the robot.
    placements: Vec<LanePlacement>,
    /// Frame of the tip, and pose of the tip in it; used if the robot holds an object. The loose links have the last frames.
    tip: LanePlacement,
    loose: usize,
    /// Per frame.
    errors: Vec<FrameError>,
}

/// Unit roundoff of `f32`: half the distance between two numbers at 1.
const UNIT: f64 = 0.5 * f32::EPSILON as f64;

/// Fixed pose of a link in one of the frames of a [`LaneKinematics`].
#[derive(Clone, Copy, Debug)]
pub struct LanePlacement {
    /// Number of the frame.
    pub frame: usize,
    /// Pose of the link in that frame.
    pub frame_from_link: Pose,
}

/// Pose of a frame in the root frame, for every lane.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub struct LaneFrame {
    /// Axes of the frame, each with its three coordinates.
    pub axes: [[LaneArray; 3]; 3],
    /// Origin of the frame, in metres.
    pub origin: [LaneArray; 3],
}

/// Velocity of a frame, for every lane, per unit of the path parameter.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub struct LaneTwist {
    /// Angular velocity, in radians.
    pub turn: [LaneArray; 3],
    /// Velocity of the frame's origin, in metres.
    pub velocity: [LaneArray; 3],
}

#[derive(Clone, Copy, Debug)]
struct LaneStep {
    parent: usize,
    joint: usize,
    multiplier: f32,
    kind: JointKind,
    /// Pose of the frame in its parent at value 0.
    place: LaneTransform,
}

/// Pose of a frame in another one.
#[derive(Clone, Copy, Debug)]
pub struct LaneTransform {
    /// Columns of the rotation.
    columns: [[f32; 3]; 3],
    translation: [f32; 3],
}

/// Number of roundings of a joint value: the conversion to `f32`, that of its multiplier, and their product.
const VALUE_ROUNDINGS: f64 = 3.0;

impl LaneKinematics {
    /// Returns the kinematics of all links of `robot`.
    pub fn new(robot: &Robot) -> Self {
        let rest = robot.frames();
        let mut steps: Vec<LaneStep> = Vec::new();
        // Per frame: the link right below its joint, and the frame at rest.
        let mut frames: Vec<(usize, Pose)> = vec![(robot.root(), Pose::identity())];
        let mut placements = Vec::with_capacity(robot.links().len());
        let mut errors = vec![FrameError::root(UNIT)];
        for link in 0..robot.links().len() {
            let mut frame = 0;
            for mover in robot.ancestors(link) {
                let known = frames.iter().skip(1).position(|(child, _)| *child == mover.child_link);
                let parent = frame;
                frame = known.map_or(frames.len(), |index| index + 1);
                if known.is_some() {
                    continue;
                }
                let child_from_frame =
                    Pose::from_parts(Translation3::identity(), z_onto(&mover.axis_in_child));
                let root_from_frame = rest.link(mover.child_link) * child_from_frame;
                let parent_from_frame = frames[parent].1.inv_mul(&root_from_frame);
                let limits = &robot.limits()[mover.joint];
                let most = limits.lower.abs().max(limits.upper.abs()) * mover.multiplier.abs();
                let moved_by = MovedBy {
                    kind: mover.kind,
                    most,
                    roundings: VALUE_ROUNDINGS,
                    sine: if most > MOST_TURN_IN_LANES_RAD { f64::INFINITY } else { SINE_ERROR_IN_LANES },
                };
                let way_m = parent_from_frame.translation.vector.norm();
                errors.push(errors[parent].beyond(way_m, Some(moved_by)));
                steps.push(LaneStep::new(
                    parent,
                    mover.joint,
                    mover.multiplier,
                    mover.kind,
                    &parent_from_frame,
                ));
                frames.push((mover.child_link, root_from_frame));
            }
            let frame_from_link = frames[frame].1.inv_mul(rest.link(link));
            placements.push(LanePlacement { frame, frame_from_link });
        }
        // Loose links, and the links attached to them, have frames of their own, whose poses are not yet known.
        let (tip, loose) = (placements[robot.tip()], robot.loose_links().count());
        let frame_count = steps.len() + 1;
        let way_m = tip.frame_from_link.translation.vector.norm() + FARTHEST_HELD_M;
        errors.resize(frame_count + loose, errors[tip.frame].beyond(way_m, None));
        let loose_links: Vec<usize> = robot.loose_links().collect();
        for (link, placement) in placements.iter_mut().enumerate() {
            if let Some(slot) = robot.loose_slot_of(link) {
                // The rest pose of a held object is meaningless: it has a frame of its own.
                let frame_from_link = rest.link(loose_links[slot]).inv_mul(rest.link(link));
                *placement = LanePlacement { frame: frame_count + slot, frame_from_link };
            }
        }
        Self { steps, placements, tip, loose, errors }
    }

    /// Writes the poses of the loose links of a robot that holds an object to `places`, for [`Self::forward`].
    ///
    /// # Panics
    /// If `robot` is not the one that these kinematics were made for.
    pub fn place_held(&self, robot: &Robot, hold: &Hold, places: &mut Vec<LaneTransform>) {
        places.clear();
        places.extend(
            robot
                .tip_from_loose(hold)
                .into_iter()
                .map(|place| LaneTransform::of(&(self.tip.frame_from_link * place))),
        );
        assert_eq!(places.len(), self.loose, "places of this robot");
    }

    /// Returns the number of frames, including the root's.
    pub fn frame_count(&self) -> usize {
        self.steps.len() + 1 + self.loose
    }

    /// Returns the frame that a link is fixed to, and its pose in it.
    ///
    /// # Panics
    /// If the robot has no such link.
    pub fn placement(&self, link: usize) -> &LanePlacement {
        &self.placements[link]
    }

    /// Bounds the error of any point that lies at most `from_frame_m` from the origin of the frame of this number, in
    /// metres, for all joint values within their limits (`FrameError`). Infinite beyond a joint that turns farther than
    /// [`MOST_TURN_IN_LANES_RAD`], where `f32` is not accurate enough.
    ///
    /// # Panics
    /// If there is no such frame.
    pub fn position_error_m(&self, frame: usize, from_frame_m: f64) -> f64 {
        self.errors[frame].of_point_m(from_frame_m)
    }

    /// Returns the maximum distance of the origin of a frame from the root's, in metres.
    ///
    /// # Panics
    /// If there is no such frame.
    pub fn farthest_m(&self, frame: usize) -> f64 {
        self.errors[frame].farthest_m()
    }

    /// Writes all frames at the configurations `q`, one row of lanes per joint (m, rad), with the loose links posed by
    /// [`Self::place_held`].
    ///
    /// # Panics
    /// If there are too few rows or frames.
    #[inline(always)]
    pub fn forward<S: Simd>(
        &self,
        simd: S,
        q: &[LaneArray],
        places: &[LaneTransform],
        frames: &mut [LaneFrame],
    ) {
        frames[0] = LaneFrame::IDENTITY;
        for (index, step) in self.steps.iter().enumerate() {
            let (done, rest) = frames.split_at_mut(index + 1);
            step.follow(simd, &q[step.joint], &done[step.parent], &mut rest[0]);
        }
        let (arm, loose) = frames.split_at_mut(self.steps.len() + 1);
        for (place, frame) in places.iter().zip(loose) {
            place.follow(simd, &arm[self.tip.frame], frame);
        }
    }
}

impl LaneKinematics {
    /// Writes the velocities of all `frames` while joint j moves at `rates[j]` (m or rad per unit of the path parameter).
    ///
    /// # Panics
    /// If there are too few rates, frames or twists.
    #[inline(always)]
    pub fn twists<S: Simd>(
        &self,
        simd: S,
        rates: &[LaneArray],
        frames: &[LaneFrame],
        twists: &mut [LaneTwist],
    ) {
        twists[0] = LaneTwist::STILL;
        for (index, step) in self.steps.iter().enumerate() {
            let (frame, rates) = (&frames[index + 1], &rates[step.joint]);
            let (done, rest) = twists.split_at_mut(index + 1);
            let (mut turn, mut velocity) =
                done[step.parent].at(simd, &frames[step.parent], LaneVector::load(simd, &frame.origin));
            if rates.iter().any(|rate| *rate != 0.0) {
                let rate = f32x16::from_slice(simd, rates) * f32x16::splat(simd, step.multiplier);
                let moved = LaneVector::load(simd, &frame.axes[2]).times(rate);
                match step.kind {
                    JointKind::Prismatic => velocity = velocity.plus(moved),
                    JointKind::Revolute => turn = turn.plus(moved),
                }
            }
            rest[0].store(turn, velocity);
        }
        let (arm, loose) = twists.split_at_mut(self.steps.len() + 1);
        for (twist, frame) in loose.iter_mut().zip(&frames[self.steps.len() + 1..]) {
            let origin = LaneVector::load(simd, &frame.origin);
            let (turn, velocity) = arm[self.tip.frame].at(simd, &frames[self.tip.frame], origin);
            twist.store(turn, velocity);
        }
    }
}

impl LaneTwist {
    /// Twist of a frame that does not move.
    pub const STILL: Self = Self { turn: [[0.0; LANES]; 3], velocity: [[0.0; LANES]; 3] };

    /// Returns the angular velocity of `frame` under this twist and the velocity of a point fixed to it, in root coordinates.
    #[inline(always)]
    pub fn at<S: Simd>(
        &self,
        simd: S,
        frame: &LaneFrame,
        point: LaneVector<S>,
    ) -> (LaneVector<S>, LaneVector<S>) {
        let turn = LaneVector::load(simd, &self.turn);
        let arm = point.minus(LaneVector::load(simd, &frame.origin));
        (turn, LaneVector::load(simd, &self.velocity).plus(turn.cross(arm)))
    }

    #[inline(always)]
    fn store<S: Simd>(&mut self, turn: LaneVector<S>, velocity: LaneVector<S>) {
        turn.store(&mut self.turn);
        velocity.store(&mut self.velocity);
    }
}

impl LaneFrame {
    /// Root frame.
    pub const IDENTITY: Self = {
        let (one, zero) = ([1.0; LANES], [0.0; LANES]);
        Self { axes: [[one, zero, zero], [zero, one, zero], [zero, zero, one]], origin: [zero; 3] }
    };

    /// Transforms a point of the frame to root coordinates, for every lane.
    #[inline(always)]
    pub fn point<S: Simd>(&self, simd: S, point: [f32; 3]) -> LaneVector<S> {
        let [x, y, z] = &self.axes;
        let x = LaneVector::load(simd, x).times(f32x16::splat(simd, point[0]));
        let y = LaneVector::load(simd, y).times(f32x16::splat(simd, point[1]));
        let z = LaneVector::load(simd, z).times(f32x16::splat(simd, point[2]));
        x.plus(y).plus(z).plus(LaneVector::load(simd, &self.origin))
    }

    /// Returns the half extents along the root's axes of the bounding box of a box along this frame's axes.
    #[inline(always)]
    pub fn box_around<S: Simd>(&self, simd: S, half_extents: [f32; 3]) -> LaneVector<S> {
        let [x, y, z] = &self.axes;
        let x = LaneVector::load(simd, x).abs().times(f32x16::splat(simd, half_extents[0]));
        let y = LaneVector::load(simd, y).abs().times(f32x16::splat(simd, half_extents[1]));
        let z = LaneVector::load(simd, z).abs().times(f32x16::splat(simd, half_extents[2]));
        x.plus(y).plus(z)
    }

    #[inline(always)]
    fn store<S: Simd>(&mut self, axes: [LaneVector<S>; 3], origin: LaneVector<S>) {
        for (axis, lanes) in axes.into_iter().zip(&mut self.axes) {
            axis.store(lanes);
        }
        origin.store(&mut self.origin);
    }

    /// Returns the linear combination of the axes with these weights; for most arms, most weights are 0.
    #[inline(always)]
    fn mixed<S: Simd>(&self, simd: S, weights: [f32; 3]) -> LaneVector<S> {
        let mut sum = LaneVector::splat(simd, [0.0; 3]);
        for (axis, weight) in self.axes.iter().zip(weights) {
            if weight != 0.0 {
                sum = sum.plus(LaneVector::load(simd, axis).times(f32x16::splat(simd, weight)));
            }
        }
        sum
    }
}

impl LaneStep {
    #[allow(
        clippy::cast_possible_truncation,
        reason = "lanes are `f32` by design; their error is bounded by `position_error_m`"
    )]
    fn new(parent: usize, joint: usize, multiplier: f64, kind: JointKind, parent_from_frame: &Pose) -> Self {
        Self {
            parent,
            joint,
            multiplier: multiplier as f32,
            kind,
            place: LaneTransform::of(parent_from_frame),
        }
    }

    #[inline(always)]
    fn follow<S: Simd>(&self, simd: S, q: &LaneArray, parent: &LaneFrame, frame: &mut LaneFrame) {
        let value = f32x16::from_slice(simd, q) * self.multiplier;
        let ([mut x, mut y, z], mut origin) = self.place.within(simd, parent);
        match self.kind {
            JointKind::Prismatic => origin = origin.plus(z.times(value)),
            JointKind::Revolute => {
                let (sine, cosine) = sin_cos_lanes(simd, value);
                let turned = x.times(cosine).plus(y.times(sine));
                y = y.times(cosine).minus(x.times(sine));
                x = turned;
            }
        }
        frame.store([x, y, z], origin);
    }
}

impl LaneTransform {
    #[allow(
        clippy::cast_possible_truncation,
        reason = "lanes are `f32` by design; their error is bounded by `position_error_m`"
    )]
    fn of(parent_from_frame: &Pose) -> Self {
        let rotation: Matrix3<f64> = parent_from_frame.rotation.to_rotation_matrix().into_inner();
        /// Entries below this are set to 0: the computed cosine of a right angle is at most this far from 0.
        const NOTHING: f64 = 1e-12;
        let lane = |x: f64| if x.abs() < NOTHING { 0.0 } else { x as f32 };
        Self {
            columns: std::array::from_fn(|column| std::array::from_fn(|row| lane(rotation[(row, column)]))),
            translation: std::array::from_fn(|row| lane(parent_from_frame.translation.vector[row])),
        }
    }

    /// Returns axes and origin of the frame, given its parent.
    #[inline(always)]
    fn within<S: Simd>(&self, simd: S, parent: &LaneFrame) -> ([LaneVector<S>; 3], LaneVector<S>) {
        // No closure is used here: it would be compiled without the SIMD instructions of its lanes.
        let [x, y, z] = self.columns;
        let axes = [parent.mixed(simd, x), parent.mixed(simd, y), parent.mixed(simd, z)];
        (axes, parent.mixed(simd, self.translation).plus(LaneVector::load(simd, &parent.origin)))
    }

    #[inline(always)]
    fn follow<S: Simd>(&self, simd: S, parent: &LaneFrame, frame: &mut LaneFrame) {
        let (axes, origin) = self.within(simd, parent);
        frame.store(axes, origin);
    }
}

/// Returns a rotation that takes z onto `axis`.
fn z_onto(axis: &Vector) -> Rotation {
    // If the two are opposite, a half turn about any perpendicular axis is valid.
    Rotation::rotation_between(&Vector::z(), axis)
        .unwrap_or_else(|| Rotation::from_axis_angle(&Vector::x_axis(), std::f64::consts::PI))
}
