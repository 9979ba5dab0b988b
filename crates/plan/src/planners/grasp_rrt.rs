use cranny_collision::{Body, Cell, Scratch};
use cranny_path::{GraspJudge, JointMetric, RELEASED_STEP_M, Stepper};
use cranny_robot::{Jacobian, LinkFrames, Robot, Twist, damped_pseudo_inverse_step};
use cranny_shape::{Solid, closest_points};
use cranny_spatial::{Point, Pose, Rotation, Vector};
use cranny_task::Problem;
use serde::{Deserialize, Serialize};

use crate::search::approach_sphere::ApproachSphere;
use crate::search::connector::Path;
use crate::search::forest::Forest;
use crate::search::search_state::Search;
use crate::wall_clock::now;
use crate::{Budget, Observer, Outcome, PlanError, PlanReport, Planner, Ranges};

/// Grasp-RRT (Vahrenkamp, Asfour & Dillmann 2012, "Simultaneous grasp and motion planning: humanoid robot ARMAR-III", IEEE
/// Robotics & Automation Magazine 19(2), whole, the planner for one arm): one tree from the start, with neither a set of grasps
/// nor inverse kinematics.
///
/// 1. With probability `1 − p_approach`, takes one step from the nearest node towards a uniform random configuration.
/// 2. Otherwise chooses a node near the target, evenly over all directions about it (the `ApproachSphere`). The goal is the
///    hand at the nearest point of the target, pointing towards it. Steps of the pseudo-inverse of the Jacobian, each a new
///    node, move the hand until it arrives, is blocked, meets a joint limit or comes no closer.
/// 3. The hand is tried at each of these nodes: if it closes on the target in a good enough grasp, the search ends.
///
/// One iteration is one pass through 1, or 2 and 3. There are four differences from the publication. Edges are proven. A random
/// extension is a single step. The score is that of two opposite contacts and the friction between them
/// ([`GraspMeasure::score`](cranny_task::GraspMeasure::score)), not that of a wrench space. The gripper moves on by `depth_m`
/// beyond the surface, and the hand is tried at every step and not only at the end, because the gripper frame of a parallel
/// hand lies between the pads, whereas the fingers of the published hand close around the object near the palm.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GraspRrt {
    /// Probability of an approach, in [0, 1]. Default 0.1. The defaults are those of the implementation by the authors (Simox),
    /// except for `step_m`, `depth_m` and `damping`.
    pub p_approach: f64,
    /// Maximum motion of the origin of any link frame in a random step, in metres. Default 0.1, as in the other planners.
    pub step_m: f64,
    /// Maximum motion of the gripper in a step of an approach, in metres. Default 0.01.
    pub approach_step_m: f64,
    /// Maximum rotation of the gripper in a step of an approach, in radians. Default π/18.
    pub approach_step_rad: f64,
    /// Maximum distance of the gripper from the middle of the target at the beginning of an approach, in metres. Default 0.6.
    pub approach_within_m: f64,
    /// Distance by which the gripper moves beyond the surface of the target, in metres. Default 0.05: the reach of the fingers
    /// of a small hand beyond its palm.
    pub depth_m: f64,
    /// Damping λ of the pseudo-inverse. Default 0.05, as in [`JPlusRrt`](crate::JPlusRrt).
    pub damping: f64,
}

impl Default for GraspRrt {
    fn default() -> Self {
        Self {
            p_approach: 0.1,
            step_m: RELEASED_STEP_M,
            approach_step_m: 0.01,
            approach_step_rad: std::f64::consts::PI / 18.0,
            approach_within_m: 0.6,
            depth_m: 0.05,
            damping: 0.05,
        }
    }
}

/// Tolerances in metres and radians within which an approach has arrived (1 mm, 3°).
const ARRIVED_M: f64 = 1e-3;
const ARRIVED_RAD: f64 = 0.052;
/// Number of steps after which an approach is abandoned.
const MOST_STEPS: u32 = 300;
/// Rotation in radians that counts as much as a metre when two poses are compared: 3° as 1 mm.
const RADIANS_PER_METRE: f64 = ARRIVED_RAD / ARRIVED_M;

impl Planner for GraspRrt {
    fn name(&self) -> &'static str {
        "grasp-rrt"
    }

    fn settings(&self) -> serde_json::Value {
        serde_json::json!(self)
    }

    fn check(&self) -> Result<(), PlanError> {
        Ranges::of(self.name())
            .share("p_approach", self.p_approach)?
            .positive("step_m", self.step_m)?
            .positive("approach_step_m", self.approach_step_m)?
            .positive("approach_step_rad", self.approach_step_rad)?
            .positive("approach_within_m", self.approach_within_m)?
            .positive("depth_m", self.depth_m)?
            .positive("damping", self.damping)?;
        Ok(())
    }

    fn makes_grasps(&self) -> bool {
        true
    }

    fn plan(
        &self,
        problem: &Problem,
        budget: &Budget,
        seed: u64,
        observer: &mut dyn Observer,
    ) -> Result<PlanReport, PlanError> {
        let search = Search::new(problem, budget, seed, observer);
        let measure = problem.own_grasp_measure(self.name())?;
        let cell = problem.exact_cell(self.name())?;
        let robot = problem.robot().as_ref();
        let dof = robot.dof();
        let mut approaches = Approaches {
            search,
            settings: self,
            robot,
            cell,
            target: problem.target().map(|target| &cell.world().bodies()[target]),
            middle_in_world: measure.surface_in_world().aabb().center.coords,
            judge: GraspJudge::new(measure),
            tree: Forest::new(dof, JointMetric::plain(dof)),
            sphere: ApproachSphere::default(),
            stepper: Stepper::new(robot),
            scratch: cell.scratch(),
            frames: robot.frames(),
            jacobian: robot.empty_jacobian(),
            step: vec![0.0; dof],
        };
        let ended = approaches.run();
        approaches.search.statistics.nodes = approaches.tree.len() as u64;
        Ok(approaches.search.report(ended))
    }
}

struct Approaches<'a> {
    search: Search<'a>,
    settings: &'a GraspRrt,
    robot: &'a Robot,
    cell: &'a Cell,
    target: Option<&'a Body>,
    middle_in_world: Vector,
    judge: GraspJudge<'a>,
    tree: Forest,
    sphere: ApproachSphere,
    stepper: Stepper,
    scratch: Scratch,
    frames: LinkFrames,
    jacobian: Jacobian,
    step: Vec<f64>,
}

impl Approaches<'_> {
    fn run(&mut self) -> Result<Path, Outcome> {
        let start = self.search.problem.start();
        if !self.cell.is_free(start, &mut self.scratch) {
            return Err(Outcome::StartInvalid);
        }
        let root = self.add(start, None);
        if let Some(path) = self.grasp_at(root) {
            return Ok(path);
        }
        loop {
            self.search.begin_iteration()?;
            if self.search.random.uniform() < self.settings.p_approach {
                if let Some(path) = self.approach() {
                    return Ok(path);
                }
                continue;
            }
            // 1.
            let sample = self.search.sample();
            let begin = now();
            let nearest = self.tree.nearest(&sample).unwrap_or(root);
            self.search.statistics.nearest_time_s += begin.elapsed().as_secs_f64();
            let size_m = self.settings.step_m;
            let (q, _) = self.stepper.towards(self.robot, self.tree.q(nearest), &sample, size_m);
            let q = q.to_vec();
            self.grow(nearest, &q);
        }
    }

    /// Runs 2 and 3 of [`GraspRrt`]; returns a path if that ends the search.
    fn approach(&mut self) -> Option<Path> {
        let mut node = self.sphere.take(&mut self.search.random)?;
        self.search.statistics.goals_tried += 1;
        self.robot.forward_kinematics(self.tree.q(node), &mut self.frames);
        let gripper = *self.frames.link(self.robot.tip());
        let wanted = self.wanted(&gripper)?;
        let mut last = f64::INFINITY;
        for _ in 0..MOST_STEPS {
            self.robot.forward_kinematics(self.tree.q(node), &mut self.frames);
            let gripper = self.frames.link(self.robot.tip());
            let translation = wanted.translation.vector - gripper.translation.vector;
            let rotation = (wanted.rotation * gripper.rotation.inverse()).scaled_axis();
            let (off_m, off_rad) = (translation.norm(), rotation.norm());
            if off_m <= ARRIVED_M && off_rad <= ARRIVED_RAD {
                return None;
            }
            let off = off_m + off_rad / RADIANS_PER_METRE;
            // An approach may increase the distance by this much before it counts as trapped.
            if off > last + 2.0 * self.settings.approach_step_m {
                return None;
            }
            last = off;
            let GraspRrt { approach_step_m, approach_step_rad, damping, .. } = *self.settings;
            let share = (approach_step_m / off_m).min(approach_step_rad / off_rad).min(1.0);
            let mut twist = Twist::zeros();
            twist.fixed_rows_mut::<3>(0).copy_from(&(translation * share));
            twist.fixed_rows_mut::<3>(3).copy_from(&(rotation * share));
            self.robot.jacobian(&self.frames, self.robot.tip(), &mut self.jacobian);
            if !damped_pseudo_inverse_step(&self.jacobian, &twist, damping, &mut self.step) {
                return None;
            }
            let next: Vec<f64> = self.tree.q(node).iter().zip(&self.step).map(|(q, step)| q + step).collect();
            if !self.robot.within_limits(&next) {
                return None;
            }
            node = self.grow(node, &next)?;
            // 3.
            let path = self.grasp_at(node);
            if path.is_some() {
                return path;
            }
        }
        None
    }

    /// Returns the target pose of the gripper from a pose: its approach direction towards the nearest point of the target, and
    /// its position slightly beyond that point.
    fn wanted(&self, world_from_gripper: &Pose) -> Option<Pose> {
        /// Radius of a sphere that serves as a point, in metres.
        const POINT_M: f64 = 1e-6;
        let point = Solid::sphere(POINT_M).ok()?;
        let origin = Point::from(world_from_gripper.translation.vector);
        let to_part = |part: &cranny_collision::Part| {
            let [_, on_target] =
                closest_points(&point, world_from_gripper, &part.solid, &part.world_from_solid)?;
            Some(on_target - origin)
        };
        let ways = self.target?.parts.iter().filter_map(to_part);
        let way = ways.min_by(|a, b| a.norm_squared().total_cmp(&b.norm_squared()))?;
        let approach_in_world = world_from_gripper.rotation * Vector::z();
        let direction = way.try_normalize(POINT_M)?;
        // For a hand that points in the opposite direction, no shortest rotation is unique: the approach is abandoned.
        let turn = Rotation::rotation_between(&approach_in_world, &direction)?;
        let at = origin.coords + way + direction * self.settings.depth_m;
        Some(Pose::from_parts(at.into(), turn * world_from_gripper.rotation))
    }

    /// Adds a node at the end of an edge from `parent`, if the edge is proven.
    fn grow(&mut self, parent: usize, q: &[f64]) -> Option<usize> {
        let begin = now();
        self.search.statistics.collision_checks += 1;
        let is_free = self.cell.is_free(q, &mut self.scratch)
            && self.cell.motion_is_free(self.tree.q(parent), q, &mut self.scratch).is_proven();
        self.search.statistics.collision_time_s += begin.elapsed().as_secs_f64();
        if !is_free {
            return None;
        }
        Some(self.add(q, Some(parent)))
    }

    /// Adds a node, and records it as the beginning of an approach if it is near the target.
    fn add(&mut self, q: &[f64], parent: Option<usize>) -> usize {
        self.search.observer.node_added(0, q, parent);
        let node = self.tree.add(q, parent);
        self.robot.forward_kinematics(q, &mut self.frames);
        let gripper = self.frames.link(self.robot.tip());
        let from_middle = gripper.translation.vector - self.middle_in_world;
        if from_middle.norm() < self.settings.approach_within_m {
            self.sphere.add(&from_middle, node);
        }
        node
    }

    /// Returns the path to a node, if the hand holds the target there.
    fn grasp_at(&mut self, node: usize) -> Option<Path> {
        self.judge.grasp_at(self.tree.q(node)).ok()?;
        Some(self.tree.path_to(node))
    }
}
