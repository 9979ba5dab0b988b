use std::cmp::Ordering;
use std::collections::BinaryHeap;

use cranny_robot::{DampedInverse, Jacobian, JointKind, JointLimits, LinkFrames, Mover, Robot, Twist};
use cranny_spatial::{Point, Pose, Vector};
use cranny_task::{Goal, Problem, gripper_poses};

use crate::audit_limits::START_TOLERANCE;
use crate::bounds::pose_clusters::{Cluster, PoseClusters};
use crate::bounds::pose_functional::Functional;

/// Maximum number of boxes, each with a cluster of grasps.
const MOST_BOXES: usize = 5_000;

/// Half width below which a joint of a box is not split further, in metres or radians.
const FINEST: f64 = 1e-3;

/// Damping of the pseudo-inverse that chooses a functional. Any functional gives a valid bound.
const DAMPING: f64 = 0.4;

/// Chord of the rotations of a cluster above which a bound by positions alone is evaluated too.
const MIXED: f64 = 0.2;

/// Upper bound of the rounding error of lengths.
const ROUNDING: f64 = 1e-9;

/// Returns a lower bound on the length, in the plain norm of `q` (m and rad alike), of every path from the start of a problem
/// to its goal: at most `most`, the length of a known path. Returns `None` under criteria other than `exact`, and if the
/// planner generates its own grasps.
///
/// For goal configurations, this is the straight line to the nearest one. For grasps, the distance of the nearest configuration
/// that reaches any of them, within the tolerance of `exact`, is bounded by best-first branch and bound over boxes of joint
/// values (Land & Doig 1960, "An automatic method of solving discrete programming problems", whole). In a box with centre c and
/// half widths h, a linear functional f of the pose of the tip satisfies
///
/// `f(q) ≤ f(c) + ∇f(c)·(q − c) + ½ Σ_ij min(M_ij, |∂_i∂_j f(c)| + ⅓ Σ_k T_ijk h_k) h_i h_j`,
///
/// where M and T bound its second and third derivatives. Since f must reach its value at the grasp, this is one linear
/// constraint on q. The minimum distance from the start under this constraint, within the box, is bounded by its dual.
/// Obstacles are ignored.
pub fn least_length(problem: &Problem, most: f64) -> Option<f64> {
    problem.cell()?;
    // The start and the end of a path may each be off by this tolerance.
    let tolerance = START_TOLERANCE * (problem.robot().dof() as f64).sqrt();
    match problem.goal() {
        Goal::Configurations(ends) => {
            let nearest = ends.iter().map(|end| least_distance(problem.robot(), problem.start(), end));
            let least = nearest.reduce(f64::min)?.min(most);
            Some((least - 2.0 * tolerance).max(0.0))
        }
        Goal::Grasps(grasps) if problem.grasp_measure().is_none() => {
            let poses: Vec<Pose> = grasps.grasps().iter().flat_map(gripper_poses).collect();
            if poses.is_empty() {
                return None;
            }
            let search = BoxSearch::new(problem.robot(), problem.start(), poses);
            Some((search.least_distance(most + tolerance, MOST_BOXES) - tolerance).clamp(0.0, most))
        }
        Goal::Grasps(_) | Goal::Regions(_) => None,
    }
}

/// Returns the distance between two configurations, modulo full turns for continuous joints.
fn least_distance(robot: &Robot, start: &[f64], end: &[f64]) -> f64 {
    let difference = |(joint, (a, b)): (usize, (&f64, &f64))| robot.joint_difference(joint, *a, *b);
    let squared: f64 = start.iter().zip(end).enumerate().map(difference).map(|d| d * d).sum();
    (squared.sqrt() - ROUNDING).max(0.0)
}

/// Search for the box of joint values nearest to the start that may reach one of several poses of the tip.
struct BoxSearch<'a> {
    robot: &'a Robot,
    start: &'a [f64],
    clusters: PoseClusters,
    movers: &'a [Mover],
    /// Upper bound of the distance of the tip from the axis of each mover at any joint values, in metres; 1 if prismatic.
    arms_m: Vec<f64>,
    /// Factor of the error of a functional: 1, or less in tests which show that the error is needed.
    error_factor: f64,
}

/// Joint values between `lower` and `upper` that may reach a cluster of poses, at least `bound` away from the start.
#[derive(Clone, Debug)]
struct JointBox {
    bound: f64,
    lower: Vec<f64>,
    upper: Vec<f64>,
    cluster: usize,
    split: Split,
    /// Index of the box, which orders boxes with equal bounds.
    number: usize,
}

/// Split of a box, or of its cluster, in two.
#[derive(Clone, Copy, Debug)]
enum Split {
    Joint(usize),
    Cluster([usize; 2]),
    /// No split, because it would not pay off.
    Neither,
}

impl PartialEq for JointBox {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for JointBox {}

impl PartialOrd for JointBox {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for JointBox {
    /// Orders the nearest box as the greatest, as the max-heap requires.
    fn cmp(&self, other: &Self) -> Ordering {
        other.bound.total_cmp(&self.bound).then(other.number.cmp(&self.number))
    }
}

impl JointBox {
    /// Returns the two halves, or `None` if there is no split.
    fn halves(self) -> Option<[Self; 2]> {
        let mut halves = [self.clone(), self];
        match halves[0].split {
            Split::Joint(joint) => {
                let middle = 0.5 * (halves[0].lower[joint] + halves[0].upper[joint]);
                halves[0].upper[joint] = middle;
                halves[1].lower[joint] = middle;
            }
            Split::Cluster(clusters) => {
                halves.iter_mut().zip(clusters).for_each(|(half, cluster)| half.cluster = cluster);
            }
            Split::Neither => return None,
        }
        Some(halves)
    }
}

impl<'a> BoxSearch<'a> {
    fn new(robot: &'a Robot, start: &'a [f64], poses: Vec<Pose>) -> Self {
        let movers = robot.ancestors(robot.tip());
        let arms_m = robot
            .link_arms_m(&robot.frames(), robot.tip(), &Point::origin())
            .into_iter()
            .map(|arm_m| arm_m + ROUNDING)
            .collect();
        Self { robot, start, clusters: PoseClusters::new(poses), movers, arms_m, error_factor: 1.0 }
    }

    /// Returns a distance below which no configuration within limits reaches any of the poses, at most `most`.
    fn least_distance(&self, most: f64, most_boxes: usize) -> f64 {
        let within = |(&at, limits): (&f64, &JointLimits)| {
            let lower = (at - most).max(limits.lower);
            (lower, (at + most).min(limits.upper).max(lower))
        };
        let (lower, upper) = self.start.iter().zip(self.robot.limits()).map(within).unzip();
        let mut root = JointBox { bound: 0.0, lower, upper, cluster: 0, split: Split::Neither, number: 0 };
        let mut model = BoxModel::new(self);
        model.bound(self, &mut root);
        let mut boxes = BinaryHeap::from([root]);
        let mut count = 0;
        while let Some(nearest) = boxes.pop() {
            let bound = nearest.bound;
            let halves = nearest.halves().filter(|_| bound < most && count < most_boxes);
            let Some(halves) = halves else { return (bound.min(most) - ROUNDING).max(0.0) };
            for mut half in halves {
                count += 1;
                half.number = count;
                model.bound(self, &mut half);
                boxes.extend((half.bound < most).then_some(half));
            }
        }
        // Every box lies beyond `most`.
        (most - ROUNDING).max(0.0)
    }
}

/// Kinematics at the centre of a box, and bounds that follow from its widths.
struct BoxModel {
    frames: LinkFrames,
    jacobian: Jacobian,
    center: Vec<f64>,
    /// Half width of each mover.
    widths: Vec<f64>,
    /// Upper bound of the distance of the tip from the axis of each mover in the box, in metres.
    arms_m: Vec<f64>,
    /// Axis of each mover and `axis × (tip − origin)`; zero and the axis for a prismatic one.
    axes: Vec<[Vector; 2]>,
    gradient: Vec<f64>,
    /// Contribution of each joint to the error of the last bound.
    shares: Vec<f64>,
}

impl BoxModel {
    fn new(search: &BoxSearch<'_>) -> Self {
        let (robot, movers) = (search.robot, search.movers.len());
        Self {
            frames: robot.frames(),
            jacobian: robot.empty_jacobian(),
            center: vec![0.0; robot.dof()],
            widths: vec![0.0; movers],
            arms_m: vec![0.0; movers],
            axes: vec![[Vector::zeros(); 2]; movers],
            gradient: vec![0.0; robot.dof()],
            shares: vec![0.0; robot.dof()],
        }
    }

    /// Bounds the distance at which a box reaches its poses, and chooses its split.
    fn bound(&mut self, search: &BoxSearch<'_>, of: &mut JointBox) {
        self.place(search, of);
        let cluster = &search.clusters.clusters[of.cluster];
        of.split = Split::Neither;
        let Some(inverse) = DampedInverse::new(&self.jacobian, DAMPING) else { return };
        let mut greatest = f64::NEG_INFINITY;
        // If the rotations of the poses differ too much, positions alone may give the better bound.
        let is_mixed = cluster.chord > MIXED;
        for only_position in [false, true].into_iter().take(1 + usize::from(is_mixed)) {
            let functional = self.functional(search, &inverse, cluster, only_position);
            let (bound, error) = self.distance(search, &functional, [&of.lower, &of.upper]);
            of.bound = of.bound.max(bound);
            // The functional with the best bound determines the split.
            if bound > greatest {
                greatest = bound;
                let of_poses = functional.slack(cluster.radius_m, cluster.chord);
                let widest = |a: &usize, b: &usize| self.shares[*a].total_cmp(&self.shares[*b]);
                let joint = (0..self.shares.len()).max_by(widest);
                let joint = joint.filter(|&joint| 0.5 * (of.upper[joint] - of.lower[joint]) > FINEST);
                of.split = match (cluster.halves, joint) {
                    (Some(halves), Some(_)) if of_poses > error => Split::Cluster(halves),
                    (Some(halves), None) => Split::Cluster(halves),
                    (_, Some(joint)) => Split::Joint(joint),
                    (None, None) => Split::Neither,
                };
            }
        }
    }

    /// Computes the kinematics at the centre of a box.
    fn place(&mut self, search: &BoxSearch<'_>, of: &JointBox) {
        let robot = search.robot;
        for (center, (lower, upper)) in self.center.iter_mut().zip(of.lower.iter().zip(&of.upper)) {
            *center = 0.5 * (lower + upper);
        }
        robot.tip_kinematics(&self.center, &mut self.frames);
        robot.jacobian(&self.frames, robot.tip(), &mut self.jacobian);
        let tip = self.frames.link(robot.tip()).translation.vector;
        // The loop runs from the tip back and accumulates an upper bound of the tip motion within the box.
        let mut moves_m = 0.0;
        for (index, mover) in search.movers.iter().enumerate().rev() {
            let joint = mover.joint;
            let width = 0.5 * (of.upper[joint] - of.lower[joint]) * mover.multiplier.abs() * (1.0 + 1e-12);
            let root_from_child = self.frames.link(mover.child_link);
            let axis = root_from_child.rotation * mover.axis_in_child;
            let arm = tip - root_from_child.translation.vector;
            self.widths[index] = width;
            self.axes[index] = match mover.kind {
                JointKind::Revolute => [axis, axis.cross(&arm)],
                JointKind::Prismatic => [Vector::zeros(), axis],
            };
            self.arms_m[index] = match mover.kind {
                JointKind::Revolute => search.arms_m[index].min(arm.norm() + moves_m + ROUNDING),
                JointKind::Prismatic => 1.0,
            };
            moves_m += width * self.arms_m[index];
        }
    }

    /// Returns a functional of the tip pose that grows towards a cluster of poses: the dual of the minimum motion from the
    /// start to the cluster, linearised by the Jacobian at the centre of the box.
    fn functional(
        &self,
        search: &BoxSearch<'_>,
        inverse: &DampedInverse,
        cluster: &Cluster,
        only_position: bool,
    ) -> Functional {
        let (tip, goal) = (self.frames.link(search.robot.tip()), &cluster.middle);
        let turn = goal.rotation * tip.rotation.inverse();
        let mut twist = Twist::zeros();
        twist.fixed_rows_mut::<3>(0).copy_from(&(goal.translation.vector - tip.translation.vector));
        twist.fixed_rows_mut::<3>(3).copy_from(&(turn.imag() * (2.0 * turn.w.signum())));
        for (column, (start, center)) in
            self.jacobian.column_iter().zip(search.start.iter().zip(&self.center))
        {
            twist.axpy(center - start, &column, 1.0);
        }
        let (force, torque) = if only_position {
            // Only the direction matters.
            (twist.fixed_rows::<3>(0).into_owned(), Vector::zeros())
        } else {
            let dual = inverse.dual(&twist);
            (dual.fixed_rows::<3>(0).into_owned(), dual.fixed_rows::<3>(3).into_owned())
        };
        Functional::new(force, torque, cluster, tip)
    }

    /// Returns a lower bound of the distance from the start to any configuration in the box at which the functional reaches its
    /// value at the goal (infinite if there is none), and the error of the functional in the box.
    fn distance(
        &mut self,
        search: &BoxSearch<'_>,
        of: &Functional,
        [lower, upper]: [&[f64]; 2],
    ) -> (f64, f64) {
        let force_norm = of.force.norm();
        self.gradient.fill(0.0);
        self.shares.fill(0.0);
        let is_turning = |i: &usize| search.movers[*i].kind == JointKind::Revolute;
        let torque_norm = |i: usize| if is_turning(&i) { of.torque_norm } else { 0.0 };
        let mut error = 0.0;
        for (j, mover) in search.movers.iter().enumerate() {
            let [axis, moves] = &self.axes[j];
            self.gradient[mover.joint] += mover.multiplier * (of.force.dot(moves) + of.turn.dot(axis));
            // Bound of the second derivatives with `j` as the later joint.
            let most = force_norm * self.arms_m[j] + torque_norm(j);
            let later = |k: usize| (force_norm * self.arms_m[k] + torque_norm(k)) * self.widths[k];
            let later: f64 = (j + 1..search.movers.len()).filter(|_| is_turning(&j)).map(later).sum();
            let before: f64 = (0..=j).filter(is_turning).map(|i| self.widths[i]).sum();
            let third = most * before + later;
            // A prismatic joint does not rotate the joints after it.
            for i in (0..=j).filter(is_turning) {
                let first = &self.axes[i][0];
                let here = of.force.dot(&first.cross(moves)) + of.second(first, axis);
                let second = most.min(here.abs() + third / 3.0);
                let share = second * self.widths[i] * self.widths[j] * if i == j { 0.5 } else { 1.0 };
                error += share;
                self.shares[search.movers[i].joint] += share;
                self.shares[mover.joint] += share;
            }
        }
        let needed = of.rise - search.error_factor * error * (1.0 + 1e-9) - ROUNDING;
        let bound = least_distance_above(&self.gradient, needed, &self.center, search.start, [lower, upper]);
        (bound, error)
    }
}

/// Returns a lower bound of `min ‖q − start‖` over q between `lower` and `upper` with `gradient · (q − center) ≥ needed`, by
/// weak duality; infinite if no such q exists.
fn least_distance_above(
    gradient: &[f64],
    needed: f64,
    center: &[f64],
    start: &[f64],
    [lower, upper]: [&[f64]; 2],
) -> f64 {
    const ROUNDS: usize = 12;
    let joints = || 0..gradient.len();
    let most: f64 = joints().map(|j| gradient[j].abs() * 0.5 * (upper[j] - lower[j])).sum();
    if most * (1.0 + 1e-12) < needed {
        return f64::INFINITY;
    }
    let squared: f64 = gradient.iter().map(|g| g * g).sum();
    let at = |multiplier: f64| {
        let (mut reached, mut squares) = (0.0, 0.0);
        for j in joints() {
            let q = (start[j] + 0.5 * multiplier * gradient[j]).clamp(lower[j], upper[j]);
            reached += gradient[j] * (q - center[j]);
            squares += (q - start[j]).powi(2);
        }
        (needed - reached, squares)
    };
    let (mut multiplier, mut best) = (0.0, 0.0_f64);
    for _ in 0..ROUNDS {
        let (missing, squares) = at(multiplier);
        best = best.max(squares + multiplier * missing);
        if missing <= 1e-6 || squared <= 0.0 {
            break;
        }
        // Joints that are not at a bound contribute at most this. The dual is concave, so the ascent never passes its maximum.
        multiplier += 2.0 * missing / squared;
    }
    best.max(0.0).sqrt()
}

#[cfg(test)]
mod tests {
    use std::fmt::Write as _;

    use cranny_robot::RobotOptions;
    use cranny_spatial::{EXACT_ROTATION_RAD, EXACT_TRANSLATION_M, Rotation, Stream};

    use super::*;

    /// Returns a robot with a base that slides along x and y, and six or seven joints on random axes, one of them prismatic.
    fn arm(stream: &mut Stream) -> Robot {
        let turning = 6 + usize::from(stream.uniform() < 0.5);
        let mut urdf = String::from("<robot name=\"arm\"><link name=\"l0\"/>");
        let kinds = ["prismatic", "prismatic"].into_iter().chain(std::iter::repeat_n("revolute", turning));
        let slide = 5;
        for (index, kind) in kinds.enumerate() {
            let kind = if index == slide { "prismatic" } else { kind };
            let mut coordinate = |most: f64| stream.uniform_between(-most, most);
            let axis = match index {
                0 => [1.0, 0.0, 0.0],
                1 => [0.0, 1.0, 0.0],
                _ => [0; 3].map(|_| coordinate(1.0)),
            };
            let axis = axis.map(|value: f64| value.to_string()).join(" ");
            let origin = [0; 3].map(|_| coordinate(0.3).to_string()).join(" ");
            let most = if index == slide { 0.2 } else { 2.5 };
            let next = index + 1;
            let _ = write!(
                urdf,
                "<link name=\"l{next}\"/><joint name=\"j{index}\" type=\"{kind}\"><parent link=\"l{index}\"/>
                 <child link=\"l{next}\"/><origin xyz=\"{origin}\"/><axis xyz=\"{axis}\"/>
                 <limit lower=\"-{most}\" upper=\"{most}\" velocity=\"1\" effort=\"1\"/></joint>"
            );
        }
        urdf.push_str("</robot>");
        Robot::from_urdf_text(&urdf, "arm.urdf", None, &RobotOptions::default()).expect("a URDF")
    }

    /// Returns the minimum distance from `start`, by descent in the null space, to a configuration with the pose of `end`.
    fn relaxed(robot: &Robot, start: &[f64], end: &[f64]) -> f64 {
        let (mut frames, mut jacobian) = (robot.frames(), robot.empty_jacobian());
        let goal = *robot.frames_at(end).link(robot.tip());
        let distance = |q: &[f64]| q.iter().zip(start).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
        let (mut q, mut best) = (end.to_vec(), distance(end));
        for _ in 0..200 {
            robot.tip_kinematics(&q, &mut frames);
            let tip = frames.link(robot.tip());
            robot.jacobian(&frames, robot.tip(), &mut jacobian);
            let mut twist = Twist::zeros();
            twist.fixed_rows_mut::<3>(0).copy_from(&(goal.translation.vector - tip.translation.vector));
            let turn = (goal.rotation * tip.rotation.inverse()).scaled_axis();
            twist.fixed_rows_mut::<3>(3).copy_from(&turn);
            let inverse = DampedInverse::new(&jacobian, 1e-6).expect("damped");
            let (mut step, mut back) = (vec![0.0; q.len()], vec![0.0; q.len()]);
            inverse.step(&jacobian, &twist, &mut step);
            back.iter_mut().zip(start.iter().zip(&q)).for_each(|(back, (a, b))| *back = 0.2 * (a - b));
            inverse.project_to_null_space(&jacobian, &mut back);
            for ((q, (step, back)), limits) in q.iter_mut().zip(step.iter().zip(&back)).zip(robot.limits()) {
                *q = (*q + step + back).clamp(limits.lower, limits.upper);
            }
            if twist.norm() < 1e-4 {
                best = best.min(distance(&q));
            }
        }
        best
    }

    /// Checks on random arms that no configuration that reaches one of several poses, within the tolerance, is nearer than the
    /// bound. A search that omits the error of its functionals must fail.
    #[test]
    fn no_configuration_at_a_goal_is_nearer_than_the_bound() {
        let mut stream = Stream::new(5, 0);
        let (mut ratios, mut false_bounds) = (Vec::new(), 0);
        for round in 0..40 {
            let robot = arm(&mut stream);
            let mut draw = |share: f64| -> Vec<f64> {
                robot
                    .limits()
                    .iter()
                    .map(|l| stream.uniform_between(share * l.lower, share * l.upper))
                    .collect()
            };
            let start = draw(0.5);
            let ends: Vec<Vec<f64>> =
                (0..3).map(|_| start.iter().zip(draw(0.4)).map(|(at, by)| at + by).collect()).collect();
            let mut off = || stream.uniform_between(-1.0, 1.0);
            let poses: Vec<Pose> = ends
                .iter()
                .map(|end| {
                    let by = Vector::new(off(), off(), off()).normalize() * (0.99 * EXACT_TRANSLATION_M);
                    let turn = Vector::new(off(), off(), off()).normalize() * (0.99 * EXACT_ROTATION_RAD);
                    let tip = robot.frames_at(end).link(robot.tip()).to_owned();
                    Pose::from_parts((tip.translation.vector + by).into(), Rotation::new(turn) * tip.rotation)
                })
                .collect();
            let nearest = ends.iter().map(|end| relaxed(&robot, &start, end)).fold(f64::INFINITY, f64::min);
            let mut search = BoxSearch::new(&robot, &start, poses);
            let bound = search.least_distance(10.0, MOST_BOXES);
            assert!(bound <= nearest, "round {round}: {bound} above {nearest}");
            ratios.push(bound / nearest);
            search.error_factor = 0.0;
            false_bounds += u32::from(search.least_distance(10.0, 300) > nearest + 0.02);
        }
        ratios.sort_by(f64::total_cmp);
        println!("{ratios:?} {false_bounds}");
        assert!(ratios[20] > 0.5 && false_bounds > 0, "{ratios:?} {false_bounds}");
    }
}
