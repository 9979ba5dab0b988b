use cranny_spatial::{Pose, Stream, Vector};

use crate::{IkSettings, IkSolution, IkSolver, JointKind, JointUnit, Robot};

/// How [`IkSearch`] searches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IkSearchSettings {
    /// Each attempt's settings.
    pub ik: IkSettings,
    /// Two configurations are the same solution if no prismatic joint differs by more than this, in metres,
    /// and no revolute one by more than `distinct_rad`. Default 0.05 m: the base of the Panda moved by an
    /// eighth of its width.
    pub distinct_m: f64,
    /// See `distinct_m`. Default 0.1 rad, which moves an outstretched arm's hand by 0.08 m.
    pub distinct_rad: f64,
}

impl Default for IkSearchSettings {
    fn default() -> Self {
        Self { ik: IkSettings::default(), distinct_m: 0.05, distinct_rad: 0.1 }
    }
}

/// Up to `count` distinct solutions that `accept` agrees with, from at most `attempts` random starts.
///
/// Stops at whichever comes first. The order, and with one version of this crate every bit of the result, is
/// a function of the arguments.
pub fn solve_restarts(
    robot: &Robot,
    root_from_tip: &Pose,
    random: &mut Stream,
    settings: IkSearchSettings,
    count: usize,
    attempts: usize,
    accept: &mut dyn FnMut(&[f64]) -> bool,
) -> Vec<IkSolution> {
    let mut search = IkSearch::new(robot, root_from_tip, settings);
    while search.solutions().len() < count && search.attempts() < attempts {
        let left = attempts - search.attempts();
        search.next_solution(random, left, accept);
    }
    search.solutions
}

/// A search for many solutions to one target, from random starts, that can be carried on at any time.
///
/// A start is uniform within limits, but for the prismatic joints between the root and the first joint that
/// turns (a moving base): these are drawn such that the target is within the arm's reach, if they can be.
#[derive(Clone, Debug)]
pub struct IkSearch<'robot> {
    solver: IkSolver<'robot>,
    settings: IkSearchSettings,
    base: Option<Base>,
    root_from_tip: Pose,
    solutions: Vec<IkSolution>,
    attempts: usize,
}

impl<'robot> IkSearch<'robot> {
    /// A search for `root_from_tip`. This allocates; attempts do not, but for the solutions that they find.
    pub fn new(robot: &'robot Robot, root_from_tip: &Pose, settings: IkSearchSettings) -> Self {
        Self {
            solver: IkSolver::new(robot, settings.ik),
            settings,
            base: Base::of(robot),
            root_from_tip: *root_from_tip,
            solutions: Vec::new(),
            attempts: 0,
        }
    }

    /// Forgets all solutions and starts again with another target.
    pub fn retarget(&mut self, root_from_tip: &Pose) {
        self.root_from_tip = *root_from_tip;
        self.solutions.clear();
        self.attempts = 0;
    }

    /// The next solution that is distinct from those before and that `accept` agrees with; None if at most
    /// `attempts` more random starts lead to none.
    pub fn next_solution(
        &mut self,
        random: &mut Stream,
        attempts: usize,
        accept: &mut dyn FnMut(&[f64]) -> bool,
    ) -> Option<&IkSolution> {
        let end = self.attempts + attempts;
        while self.attempts < end {
            self.attempts += 1;
            let robot = self.solver.robot();
            let (base, target_in_root) = (&self.base, self.root_from_tip.translation.vector);
            let found = self.solver.solve_from_drawn(&self.root_from_tip, |q| {
                for (value, limits) in q.iter_mut().zip(robot.limits()) {
                    *value = random.uniform_between(limits.lower, limits.upper);
                }
                if let Some(base) = base {
                    base.draw_near(robot, &target_in_root, random, q);
                }
            });
            if found.as_ref().is_some_and(|found| self.is_new(&found.q) && accept(&found.q)) {
                self.solutions.extend(found);
                return self.solutions.last();
            }
        }
        None
    }

    /// One attempt from `start`, pulled towards it; counts as an attempt, and its solution as one of this
    /// search, if it is new and `accept` agrees.
    ///
    /// # Panics
    /// If `start` does not hold one value for each joint of the group.
    pub fn next_from(
        &mut self,
        start: &[f64],
        accept: &mut dyn FnMut(&[f64]) -> bool,
    ) -> Option<&IkSolution> {
        self.attempts += 1;
        let found = self.solver.solve_from(&self.root_from_tip, start)?;
        if !self.is_new(&found.q) || !accept(&found.q) {
            return None;
        }
        self.solutions.push(found);
        self.solutions.last()
    }

    /// The solutions so far, in the order in which they were found.
    pub fn solutions(&self) -> &[IkSolution] {
        &self.solutions
    }

    /// The attempts so far.
    pub fn attempts(&self) -> usize {
        self.attempts
    }

    fn is_new(&self, q: &[f64]) -> bool {
        let limits = self.solver.robot().limits();
        let differs = |known: &IkSolution| {
            known.q.iter().zip(q).zip(limits).any(|((a, b), limits)| {
                let least = match limits.unit {
                    JointUnit::Metre => self.settings.distinct_m,
                    JointUnit::Radian => self.settings.distinct_rad,
                };
                (a - b).abs() > least
            })
        };
        self.solutions.iter().all(differs)
    }
}

/// How often a base position is drawn before the nearest one so far is taken: a target at the edge of what
/// the base can serve leaves about a tenth of all positions.
const BASE_DRAWS: usize = 32;

/// More slides than this in a row are drawn like any other joint: three already reach every point.
const MOST_SLIDES: usize = 6;

/// The prismatic joints between the root and the first joint that turns: they shift the arm without turning
/// it.
#[derive(Clone, Debug)]
struct Base {
    /// Index in `q`, and the shift in the root frame per metre.
    slides: Vec<(usize, Vector)>,
    /// Where the arm starts while all slides stand at 0.
    arm_in_root: Vector,
    /// No configuration of the arm brings the tip further away from where the arm starts, in metres.
    reach_m: f64,
}

impl Base {
    fn of(robot: &Robot) -> Option<Self> {
        let movers = robot.ancestors(robot.tip());
        let count = movers.iter().take_while(|mover| mover.kind == JointKind::Prismatic).count();
        let arm = movers.get(count).filter(|_| (1..=MOST_SLIDES).contains(&count))?.child_link;
        let mut frames = robot.frames();
        robot.forward_kinematics(&vec![0.0; robot.dof()], &mut frames);
        let origin = |link: usize| frames.link(link).translation.vector;
        let slides = movers[..count].iter().map(|mover| {
            let axis_in_root = frames.link(mover.child_link).rotation * mover.axis_in_child;
            (mover.joint, axis_in_root * mover.multiplier)
        });
        // Joint by joint, the distance between neighbouring axes' origins does not depend on how they turn.
        let mut reach_m = 0.0;
        let mut previous = arm;
        for mover in &movers[count + 1..] {
            reach_m += (origin(mover.child_link) - origin(previous)).norm();
            if mover.kind == JointKind::Prismatic {
                let limits = robot.limits()[mover.joint];
                reach_m += mover.multiplier.abs() * limits.lower.abs().max(limits.upper.abs());
            }
            previous = mover.child_link;
        }
        reach_m += (origin(robot.tip()) - origin(previous)).norm();
        Some(Self { slides: slides.collect(), arm_in_root: origin(arm), reach_m })
    }

    /// Redraws the slides of `q` until the target is within reach, or leaves the nearest of many draws.
    fn draw_near(&self, robot: &Robot, target_in_root: &Vector, random: &mut Stream, q: &mut [f64]) {
        let mut nearest_m = f64::INFINITY;
        for _ in 0..BASE_DRAWS {
            let mut candidate = [0.0; MOST_SLIDES];
            let mut arm_in_root = self.arm_in_root;
            for (value, (joint, axis)) in candidate.iter_mut().zip(&self.slides) {
                let limits = robot.limits()[*joint];
                *value = random.uniform_between(limits.lower, limits.upper);
                arm_in_root += axis * *value;
            }
            let distance_m = (target_in_root - arm_in_root).norm();
            if distance_m < nearest_m {
                nearest_m = distance_m;
                for (value, (joint, _)) in candidate.iter().zip(&self.slides) {
                    q[*joint] = *value;
                }
            }
            if distance_m <= self.reach_m {
                return;
            }
        }
    }
}
