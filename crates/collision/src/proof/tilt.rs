use cranny_robot::{JointKind, between};

use crate::body::tilt_limit::TiltLimit;
use crate::cell::{Cell, Scratch};

/// Angles err by less, in radians: a limit that is kept to within this is kept.
const ROUNDING_RAD: f64 = 1e-9;

/// Bisection ends where the tilt can change by no more than this within an interval, in radians.
const RESOLUTION_RAD: f64 = 1e-7;

impl Cell {
    /// The bound on the tilt of what is held; `None` where nothing is held, or no tilt is demanded
    /// ([`Margins::tilt_rad`](crate::Margins::tilt_rad), [`Body::tilt_rad`](crate::Body::tilt_rad)).
    pub fn tilt_limit(&self) -> Option<&TiltLimit> {
        self.tilt.as_ref()
    }

    /// The limit for what is held in the hand of a cell that is being made.
    pub(crate) fn tilt_limit_of_held(&self) -> Option<TiltLimit> {
        let held = self.held.as_ref()?;
        let body = &self.world().bodies()[held.body];
        let most_rad = self.margins.tilt_rad.into_iter().chain(body.tilt_rad).reduce(f64::min)?;
        let up = self.world().up();
        let up_in_held = body.parts.first()?.world_from_solid.rotation.inverse() * up;
        Some(TiltLimit { axis_in_tip: held.hold.tip_from_held.rotation * up_in_held, up, most_rad })
    }

    /// Tilt of what is held at `q` (m, rad; one per joint), in radians; 0 where no tilt is limited.
    ///
    /// # Panics
    /// If `q` has not one value per joint.
    pub fn tilt_rad(&self, q: &[f64], scratch: &mut Scratch) -> f64 {
        let Some(limit) = &self.tilt else { return 0.0 };
        self.robot.tip_kinematics(q, &mut scratch.frames);
        limit.angle_rad(&(scratch.frames.link(self.robot.tip()).rotation * limit.axis_in_tip))
    }

    /// Whether what is held is tilted no farther at `q` than it may be.
    pub(crate) fn keeps_tilt(&self, q: &[f64], scratch: &mut Scratch) -> bool {
        self.tilt.is_none_or(|limit| self.tilt_rad(q, scratch) <= limit.most_rad - ROUNDING_RAD)
    }

    /// Where the straight motion from `a` to `b`, turned by at most `beyond_rad` more, is not proven to keep the limit of the
    /// tilt: the parameter in [0, 1] and the tilt there, in radians. Nothing where all of it is proven.
    ///
    /// With `ω_j = |b_j − a_j|` for each joint j that turns the tip, the tilt changes at most at
    /// `Σ_j ω_j · min(sin ∠(a_j, up), sin ∠(a_j, axis))` per unit of the parameter, `a_j` being the axis of the joint: a turn about
    /// up, or about the axis itself, tilts nothing. Within η of a point the first angle changes by at most η times the
    /// sum of ω over the joints before j, the second over those after it. An interval whose tilt in the middle is less than the
    /// limit by η times that sum, with those changes added to each sine, keeps it; others are halved.
    pub(crate) fn tilted_at(
        &self,
        a: &[f64],
        b: &[f64],
        beyond_rad: f64,
        scratch: &mut Scratch,
    ) -> Option<(f64, f64)> {
        let limit = self.tilt?;
        let most_rad = limit.most_rad - beyond_rad - ROUNDING_RAD;
        let mut work = vec![(0.5, 0.5)];
        while let Some((middle, half_width)) = work.pop() {
            let (tilt_rad, rate) = self.tilt_and_rate(&limit, [a, b], (middle, half_width), scratch);
            if tilt_rad + half_width * rate <= most_rad {
                continue;
            }
            if tilt_rad > most_rad || half_width * rate < RESOLUTION_RAD {
                return Some((middle, tilt_rad));
            }
            let half = 0.5 * half_width;
            work.extend([(middle + half, half), (middle - half, half)]);
        }
        None
    }

    /// The greatest tilt of what is held along the straight motion from `a` to `b` (m, rad; one per joint), in radians, from
    /// above and to within a thousandth; 0 where no tilt is limited.
    ///
    /// # Panics
    /// If `a` or `b` has not one value per joint.
    pub fn greatest_tilt_rad(&self, a: &[f64], b: &[f64], scratch: &mut Scratch) -> f64 {
        const TOLERANCE_RAD: f64 = 1e-3;
        let Some(limit) = self.tilt else { return 0.0 };
        let (mut seen_rad, mut greatest_rad) = (0.0_f64, 0.0_f64);
        let mut work = vec![(0.5, 0.5)];
        while let Some((middle, half_width)) = work.pop() {
            let (tilt_rad, rate) = self.tilt_and_rate(&limit, [a, b], (middle, half_width), scratch);
            seen_rad = seen_rad.max(tilt_rad);
            let most_rad = tilt_rad + half_width * rate;
            if most_rad <= seen_rad + TOLERANCE_RAD {
                greatest_rad = greatest_rad.max(most_rad);
            } else {
                let half = 0.5 * half_width;
                work.extend([(middle + half, half), (middle - half, half)]);
            }
        }
        greatest_rad + ROUNDING_RAD
    }

    /// The tilt in the middle of an interval, and a bound on its rate within it.
    fn tilt_and_rate(
        &self,
        limit: &TiltLimit,
        [a, b]: [&[f64]; 2],
        (middle, half_width): (f64, f64),
        scratch: &mut Scratch,
    ) -> (f64, f64) {
        scratch.q.iter_mut().zip(between(a, b, middle)).for_each(|(q, value)| *q = value);
        self.robot.tip_kinematics(&scratch.q, &mut scratch.frames);
        let frames = &scratch.frames;
        let axis = frames.link(self.robot.tip()).rotation * limit.axis_in_tip;
        let turning = || {
            let ancestors = self.robot.ancestors(self.robot.tip()).iter();
            ancestors.filter(|mover| mover.kind == JointKind::Revolute).map(|mover| {
                let rate = (b[mover.joint] - a[mover.joint]).abs() * mover.multiplier.abs();
                (mover, rate)
            })
        };
        let mut after: f64 = turning().map(|(_, rate)| rate).sum();
        let (mut before, mut all) = (0.0, 0.0);
        for (mover, rate) in turning().filter(|(_, rate)| *rate > 0.0) {
            after -= rate;
            let of_joint = frames.link(mover.child_link).rotation * mover.axis_in_child;
            let to_up = of_joint.cross(&limit.up).norm() + half_width * before;
            let to_axis = of_joint.cross(&axis).norm() + half_width * after.max(0.0);
            all += rate * to_up.min(to_axis).min(1.0);
            before += rate;
        }
        (limit.angle_rad(&axis), all * (1.0 + 1e-9) + 1e-12)
    }

    /// Moves a configuration (m, rad; one per joint) at which what is held is tilted too far to one near it at which it keeps
    /// nine tenths of the limit, by at most eight steps of Newton's method in the least joint motion; false if it does not
    /// come to one.
    ///
    /// # Panics
    /// If `q` has not one value per joint.
    pub fn project_to_tilt(&self, q: &mut [f64], scratch: &mut Scratch) -> bool {
        const STEPS: usize = 8;
        const RESERVE: f64 = 0.9;
        let Some(limit) = self.tilt else { return true };
        if self.keeps_tilt(q, scratch) {
            return true;
        }
        for _ in 0..STEPS {
            self.robot.tip_kinematics(q, &mut scratch.frames);
            let axis = scratch.frames.link(self.robot.tip()).rotation * limit.axis_in_tip;
            let tilt_rad = limit.angle_rad(&axis);
            if tilt_rad <= limit.most_rad * RESERVE {
                return true;
            }
            // The tilt changes at the rate of the turn about the normal of up and axis.
            let Some(normal) = limit.up.cross(&axis).try_normalize(1e-12) else { return false };
            let mut gradient = vec![0.0; q.len()];
            for mover in self.robot.ancestors(self.robot.tip()) {
                if mover.kind == JointKind::Revolute {
                    let of_joint = scratch.frames.link(mover.child_link).rotation * mover.axis_in_child;
                    gradient[mover.joint] += mover.multiplier * of_joint.dot(&normal);
                }
            }
            let squared: f64 = gradient.iter().map(|rate| rate * rate).sum();
            if squared < 1e-9 {
                return false;
            }
            let excess_rad = tilt_rad - limit.most_rad * RESERVE * 0.99;
            for ((value, rate), limits) in q.iter_mut().zip(&gradient).zip(self.robot.limits()) {
                *value = (*value - excess_rad * rate / squared).clamp(limits.lower, limits.upper);
            }
        }
        self.keeps_tilt(q, scratch)
    }
}
