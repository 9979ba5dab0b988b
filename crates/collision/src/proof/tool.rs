use cranny_robot::{JointKind, LinkFrames, Mover, between};
use cranny_spatial::{Point, Vector};

use crate::body::tool_bound::{CellBound, ToolRegion};
use crate::cell::{Cell, Scratch};
use crate::proof::work_list::MOST_INTERVALS;
use crate::{CollisionError, ToolBound};

/// Rounding of angles and distances, in radians and metres: the reserve with which a bound must be kept.
const ROUNDING: f64 = 1e-9;

/// Change of the excess within an interval below which bisection ends, in radians and metres.
const RESOLUTION: f64 = 1e-7;

/// Tolerance of the greatest excess, in radians and metres.
pub(crate) const TOLERANCE: f64 = 1e-3;

/// Failure to prove that a bound is kept along a motion.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Excess {
    /// Parameter in [0, 1] along the motion.
    pub at: f64,
    pub bound: usize,
    /// Excess there, in radians or metres.
    pub by: f64,
}

impl Cell {
    /// Returns this cell with these additional bounds on the tool.
    ///
    /// # Errors
    /// [`CollisionError::ToolBound`] for a bound that is out of range, and the errors for its link as in [`Cell::new`].
    pub fn with_further_bounds(&self, further: &[ToolBound]) -> Result<Self, CollisionError> {
        for bound in further {
            bound.check()?;
            bound.check_link(&self.robot)?;
        }
        let mut cell = self.clone();
        cell.further_bounds = self.further_bounds.iter().chain(further).cloned().collect();
        cell.bounds = cell.all_bounds().into();
        Ok(cell)
    }

    /// Returns the bounds on the tool along every motion: those of [`World::with_tool_bounds`](crate::World::with_tool_bounds),
    /// those of [`Self::with_further_bounds`], and last the tilt of the held object, if it is limited ([`Self::tilt_bound`]).
    pub fn tool_bounds(&self) -> impl ExactSizeIterator<Item = &ToolBound> {
        self.bounds.iter().map(|bound| &bound.bound)
    }

    /// Returns the index of the bound on the tilt of the held object; `None` if nothing is held, or no tilt is limited
    /// ([`Margins::tilt_rad`](crate::Margins::tilt_rad), [`Body::tilt_rad`](crate::Body::tilt_rad)).
    pub fn tilt_bound(&self) -> Option<usize> {
        self.limits_tilt().then(|| self.bounds.len() - 1)
    }

    fn limits_tilt(&self) -> bool {
        self.bounds.len() > self.world().tool_bounds().len() + self.further_bounds.len()
    }

    /// Collects the bounds of a new cell: of its world, and of the held object.
    pub(crate) fn all_bounds(&self) -> Vec<CellBound> {
        let given = self.world().tool_bounds().iter().chain(&*self.further_bounds).cloned();
        let all = given.chain(self.bound_of_held());
        all.map(|bound| CellBound::new(bound, &self.robot)).collect()
    }

    /// Returns the bound on the angle between up and the direction in the held object that pointed up before the grasp.
    fn bound_of_held(&self) -> Option<ToolBound> {
        let held = self.held.as_ref()?;
        let body = &self.world().bodies()[held.body];
        let most_rad = self.margins.tilt_rad.into_iter().chain(body.tilt_rad).reduce(f64::min)?;
        let toward = self.world().up();
        let up_in_held = body.parts.first()?.world_from_solid.rotation.inverse() * toward;
        let axis_in_link = held.hold.tip_from_held.rotation * up_in_held;
        Some(ToolBound {
            name: "tilt".to_owned(),
            link: None,
            region: ToolRegion::Cone { axis_in_link, toward, most_rad },
        })
    }

    /// Returns the excess of the tool at `q` (m, rad; one per joint) over the bound of this index (rad, m); negative within it.
    ///
    /// # Panics
    /// If `q` has not one value per joint, or there is no such bound.
    pub fn tool_excess(&self, bound: usize, q: &[f64], scratch: &mut Scratch) -> f64 {
        let bound = &self.bounds[bound];
        self.place_links(std::slice::from_ref(bound), q, &mut scratch.frames);
        bound.bound.region.excess(scratch.frames.link(bound.link))
    }

    /// Returns the name of the first bound that the tool does not keep at `q` (m, rad; one per joint).
    ///
    /// # Panics
    /// If `q` has not one value per joint.
    pub fn first_bound_exceeded(&self, q: &[f64], scratch: &mut Scratch) -> Option<String> {
        let exceeded = |bound: &usize| self.tool_excess(*bound, q, scratch) > -ROUNDING;
        let bound = (0..self.bounds.len()).find(exceeded)?;
        Some(self.bounds[bound].bound.name.clone())
    }

    /// Computes the frames of the bounded links, and of the joints that move them.
    fn place_links(&self, bounds: &[CellBound], q: &[f64], frames: &mut LinkFrames) {
        if bounds.iter().all(|bound| bound.link == self.robot.tip()) {
            self.robot.tip_kinematics(q, frames);
        } else {
            self.robot.forward_kinematics(q, frames);
        }
    }

    /// Returns true if the tool keeps all bounds at `q` (m, rad; one per joint).
    pub(crate) fn keeps_bounds(&self, q: &[f64], scratch: &mut Scratch) -> bool {
        (0..self.bounds.len()).all(|bound| self.tool_excess(bound, q, scratch) <= -ROUNDING)
    }

    /// Returns the first bound that is not proven to be kept along the straight motion from `a` to `b`, with a deviation of at
    /// most `strays` of each joint (m, rad; one per joint each). `None` if all are proven.
    ///
    /// Within η of the middle of an interval, with `ω_j = |b_j − a_j|` for each joint j that moves the link:
    ///
    /// - An angle changes at most at `Σ_j ω_j · min(sin ∠(a_j, fixed), sin ∠(a_j, axis))`, with `a_j` the axis of the joint: a
    ///   turn about the fixed direction, or about the axis of the link, changes nothing. Within the interval, the first of
    ///   these angles changes by at most η times the sum of ω over the joints before j, the second over those after it.
    /// - A point moves by its velocity in the middle times η, plus at most half of `Σ_ij ω_i ω_j r_max(i, j)` times η², where r
    ///   is its greatest distance from the axis of a joint.
    ///
    /// An interval whose excess stays negative with all these changes keeps the bound; others are bisected.
    pub(crate) fn out_of_bounds_at(
        &self,
        a: &[f64],
        b: &[f64],
        strays: &[f64],
        scratch: &mut Scratch,
    ) -> Option<Excess> {
        self.bounds.iter().enumerate().find_map(|(index, bound)| {
            let most = -bound.stray(strays) - ROUNDING;
            let (mut work, mut intervals) = (vec![(0.5, 0.5)], 0);
            while let Some((middle, half_width)) = work.pop() {
                let [by, greatest] = self.excess_within(bound, [a, b], (middle, half_width), scratch);
                if greatest <= most {
                    continue;
                }
                intervals += 1;
                let is_exhausted = intervals > MOST_INTERVALS;
                if by > most || greatest - by < RESOLUTION || greatest.is_nan() || is_exhausted {
                    return Some(Excess { at: middle, bound: index, by });
                }
                let half = 0.5 * half_width;
                work.extend([(middle + half, half), (middle - half, half)]);
            }
            None
        })
    }

    /// Returns the greatest excess over the bound of this index along the straight motion from `a` to `b` (m, rad; one per
    /// joint), in radians or metres, as an upper bound: to within a thousandth, or more for a motion of thousands of turns.
    ///
    /// # Panics
    /// If `a` or `b` has not one value per joint, or there is no such bound.
    pub fn greatest_excess(&self, bound: usize, a: &[f64], b: &[f64], scratch: &mut Scratch) -> f64 {
        let bound = &self.bounds[bound];
        let (mut seen, mut most) = (f64::NEG_INFINITY, f64::NEG_INFINITY);
        let (mut work, mut intervals) = (vec![(0.5, 0.5)], 0);
        while let Some((middle, half_width)) = work.pop() {
            let [by, greatest] = self.excess_within(bound, [a, b], (middle, half_width), scratch);
            seen = seen.max(by);
            intervals += 1;
            if greatest <= seen + TOLERANCE || greatest.is_nan() || intervals > MOST_INTERVALS {
                most = most.max(greatest);
            } else {
                let half = 0.5 * half_width;
                work.extend([(middle + half, half), (middle - half, half)]);
            }
        }
        most + ROUNDING
    }

    /// Returns the excess in the middle of an interval, and an upper bound within the interval.
    fn excess_within(
        &self,
        bound: &CellBound,
        [a, b]: [&[f64]; 2],
        (middle, half_width): (f64, f64),
        scratch: &mut Scratch,
    ) -> [f64; 2] {
        scratch.q.iter_mut().zip(between(a, b, middle)).for_each(|(q, value)| *q = value);
        self.place_links(std::slice::from_ref(bound), &scratch.q, &mut scratch.frames);
        let frames = &scratch.frames;
        let link = frames.link(bound.link);
        let movers = self.robot.ancestors(bound.link);
        let rate = |mover: &Mover| (b[mover.joint] - a[mover.joint]) * mover.multiplier;
        let is_turning = |mover: &&Mover| mover.kind == JointKind::Revolute;
        let turn = |mover: &Mover| if is_turning(&mover) { rate(mover).abs() } else { 0.0 };
        let by = bound.bound.region.excess(link);
        let axis_of = |mover: &Mover| frames.link(mover.child_link).rotation * mover.axis_in_child;
        if let ToolRegion::Cone { axis_in_link, toward, .. } = &bound.bound.region {
            let axis = link.rotation * axis_in_link;
            let mut after: f64 = movers.iter().map(turn).sum();
            let (mut before, mut all) = (0.0, 0.0);
            for mover in movers.iter().filter(|mover| turn(mover) > 0.0) {
                let of_joint = axis_of(mover);
                after -= turn(mover);
                let to_fixed = of_joint.cross(toward).norm() + half_width * before;
                let to_axis = of_joint.cross(&axis).norm() + half_width * after.max(0.0);
                all += turn(mover) * to_fixed.min(to_axis).min(1.0);
                before += turn(mover);
            }
            return [by, by + half_width * (all * (1.0 + 1e-9) + 1e-12)];
        }
        let point = link * bound.bound.region.point_in_link();
        let (mut velocity, mut bend, mut before) = (Vector::zeros(), 0.0, 0.0);
        for (mover, arm_m) in movers.iter().zip(&bound.arms_m) {
            let rate = rate(mover);
            velocity += motion_of_point(mover, frames, &point) * rate;
            bend += rate.abs() * arm_m * (turn(mover) + 2.0 * before);
            before += turn(mover);
        }
        let bend = 0.5 * half_width * half_width * bend * (1.0 + 1e-9);
        let most = match &bound.bound.region {
            ToolRegion::Box { world_from_box, half_m, .. } => {
                let in_box = world_from_box.inverse_transform_point(&point).coords.abs();
                let velocity = world_from_box.inverse_transform_vector(&velocity).abs();
                (in_box + velocity * half_width - half_m).max()
            }
            _ => by + velocity.norm() * half_width,
        };
        [by, most + bend]
    }

    /// Moves a configuration (m, rad; one per joint) at which the tool exceeds its bounds to a nearby one with some reserve
    /// within them, by steps of Newton's method in the least joint motion, the bound with the greatest excess first. Returns
    /// false on failure.
    ///
    /// # Panics
    /// If `q` has not one value per joint.
    pub fn project_to_bounds(&self, q: &mut [f64], scratch: &mut Scratch) -> bool {
        const STEPS_PER_BOUND: usize = 8;
        if self.keeps_bounds(q, scratch) {
            return true;
        }
        for _ in 0..STEPS_PER_BOUND * self.bounds.len() {
            self.place_links(&self.bounds, q, &mut scratch.frames);
            let excess = |bound: &&CellBound| {
                let region = &bound.bound.region;
                region.excess(scratch.frames.link(bound.link)) + reserve(region)
            };
            let farthest = self.bounds.iter().max_by(|a, b| excess(a).total_cmp(&excess(b)));
            let Some(bound) = farthest.filter(|bound| excess(bound) > 0.0) else { break };
            let Some(gradient) = self.gradient(bound, q.len(), scratch) else { return false };
            let squared: f64 = gradient.iter().map(|rate| rate * rate).sum();
            if squared < 1e-9 {
                return false;
            }
            let excess = excess(&bound) + 0.1 * reserve(&bound.bound.region);
            for ((value, rate), limits) in q.iter_mut().zip(&gradient).zip(self.robot.limits()) {
                *value = (*value - excess * rate / squared).clamp(limits.lower, limits.upper);
            }
        }
        self.keeps_bounds(q, scratch)
    }

    /// Returns the change of the excess over a bound per unit of each joint, with the frames of its link in `scratch`.
    fn gradient(&self, bound: &CellBound, dof: usize, scratch: &Scratch) -> Option<Vec<f64>> {
        let frames = &scratch.frames;
        let link = frames.link(bound.link);
        let point = link * bound.bound.region.point_in_link();
        // The excess grows with a motion of the point along this direction, or a rotation about it.
        let direction = match &bound.bound.region {
            ToolRegion::Cone { axis_in_link, toward, .. } => {
                toward.cross(&(link.rotation * axis_in_link)).try_normalize(1e-12)?
            }
            ToolRegion::Box { world_from_box, half_m, .. } => {
                let in_box = world_from_box.inverse_transform_point(&point).coords;
                let face = (in_box.abs() - half_m).imax();
                let mut normal = Vector::zeros();
                normal[face] = in_box[face].signum();
                world_from_box.rotation * normal
            }
            ToolRegion::Ball { center, .. } => (point - center).try_normalize(1e-12)?,
        };
        let mut gradient = vec![0.0; dof];
        for mover in self.robot.ancestors(bound.link) {
            let motion = match (bound.bound.region.is_of_angle(), mover.kind) {
                (true, JointKind::Revolute) => frames.link(mover.child_link).rotation * mover.axis_in_child,
                (true, JointKind::Prismatic) => continue,
                (false, _) => motion_of_point(mover, frames, &point),
            };
            gradient[mover.joint] += mover.multiplier * motion.dot(&direction);
        }
        Some(gradient)
    }
}

/// Returns the motion of a point per unit of a joint that moves it, in the root frame.
fn motion_of_point(mover: &Mover, frames: &LinkFrames, point: &Point) -> Vector {
    let root_from_child = frames.link(mover.child_link);
    let axis = root_from_child.rotation * mover.axis_in_child;
    match mover.kind {
        JointKind::Revolute => axis.cross(&(point.coords - root_from_child.translation.vector)),
        JointKind::Prismatic => axis,
    }
}

/// Returns the reserve within a bound to which a configuration is moved, in radians or metres.
fn reserve(region: &ToolRegion) -> f64 {
    const SHARE: f64 = 0.1;
    match region {
        ToolRegion::Cone { most_rad, .. } => SHARE * most_rad,
        ToolRegion::Box { half_m, .. } => SHARE * half_m.min(),
        ToolRegion::Ball { radius_m, .. } => SHARE * radius_m,
    }
}
