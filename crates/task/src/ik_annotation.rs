use std::sync::atomic::{AtomicBool, Ordering};

use cranny_collision::{Cell, Scratch};
use cranny_grasp::Grasp;
use cranny_robot::{IK_BATCH, IkSearch, IkSearchSettings, IkSettings, IkSolution, IkSolver};
use cranny_spatial::{EXACT_ROTATION_RAD, EXACT_TRANSLATION_M, Point, Pose, Stream};
use rayon::prelude::*;
use serde::Serialize;
use strum::IntoStaticStr;

use crate::grasping::grasp_poses::{gripper_poses, open_poses};
use crate::{Problem, TaskError};

/// Settings of the search for configurations at the grasps of a problem.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IkAnnotationSettings {
    /// Start configurations of the attempts. Default [`IkMethod::Restarts`].
    pub method: IkMethod,
    /// Maximum number of distinct solutions for each grasp. Default 1.
    pub solutions: usize,
    /// Maximum number of attempts for each grasp with [`IkMethod::Restarts`]. Default 5000: in the tightest released scenario
    /// one attempt in some hundreds gives a free configuration, at some grasps one in thousands.
    pub attempts: usize,
    /// The seed; grasp k draws from stream k, so the number of threads does not matter.
    pub seed: u64,
}

impl IkAnnotationSettings {
    /// The default settings.
    pub const DEFAULT: Self = Self { method: IkMethod::Restarts, solutions: 1, attempts: 5000, seed: 0 };
}

impl Default for IkAnnotationSettings {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// Start configurations of the attempts of an annotation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum IkMethod {
    /// One attempt for the grasp and one for its twin, from the start configuration and attracted to it: damped least squares
    /// with null-space control (Rudorfer et al. 2024, §V).
    SingleShot,
    /// As [`IkMethod::SingleShot`] first, then from random configurations.
    Restarts,
}

/// IK result for one grasp.
#[derive(Clone, Debug, PartialEq)]
pub struct IkAnnotation {
    /// Index of the grasp.
    pub grasp: usize,
    /// Outcome: solved, stopped, or the reason for the failure.
    pub status: IkStatus,
    /// Free configurations at the grasp, each within the `exact` tolerance.
    pub solutions: Vec<AnnotatedSolution>,
    /// Number of attempts made.
    pub attempts: usize,
}

/// Outcome of the IK search for a grasp.
#[derive(Clone, Debug, PartialEq, IntoStaticStr)]
#[strum(serialize_all = "kebab-case")]
pub enum IkStatus {
    /// At least one free configuration was found.
    Solved,
    /// The hand, or the link that carries it, collides at the grasp and at its twin, whatever the arm does; contact at the grasp
    /// itself:
    HandCollides {
        /// Name of the link.
        link: String,
        /// Name of the body of the world.
        body: String,
        /// True if it is proven that the hand touches the world wherever it is within the tolerance of the grasp or of its twin.
        is_proven: bool,
    },
    /// The grasp is beyond the reach of the arm, for every position of its base.
    OutOfReach {
        /// Lower bound of the distance beyond reach, in metres.
        beyond_m: f64,
    },
    /// No attempt found a free configuration; one may exist.
    NoSolution {
        /// Number of attempts that reached the pose, but in collision.
        blocked: usize,
        /// Contact of the last such attempt: a link, and a body or another link.
        contact: Option<(String, String)>,
    },
    /// The search was stopped before this grasp was finished.
    Stopped,
}

impl IkStatus {
    /// Returns true if it is proven that no free configuration exists at the grasp, within the tolerance of `exact`.
    pub fn is_proven_impossible(&self) -> bool {
        matches!(self, Self::OutOfReach { .. } | Self::HandCollides { is_proven: true, .. })
    }

    /// Name in the output of `--json`.
    pub fn name(&self) -> &'static str {
        self.into()
    }
}

/// A free configuration at a grasp.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AnnotatedSolution {
    /// Configuration (m, rad).
    pub q: Vec<f64>,
    /// Distance of the gripper from the grasp, in metres.
    pub translation_error_m: f64,
    /// Angle between the gripper and the grasp, in radians.
    pub rotation_error_rad: f64,
    /// Least distance over all collision pairs, in metres.
    pub clearance_m: f64,
}

/// Searches for free configurations at every grasp of an `exact` problem or its twin, on all cores; the result depends on
/// problem and settings alone. `done` is called once for each finished grasp, from any thread; once `stop` becomes true, the
/// remaining grasps are returned as [`IkStatus::Stopped`].
///
/// # Errors
/// [`TaskError::Annotation`] if the problem has no grasps or is under the `paper` criterion.
pub fn annotate_ik(
    problem: &Problem,
    settings: &IkAnnotationSettings,
    done: &(dyn Fn() + Sync),
    stop: &AtomicBool,
) -> Result<Vec<IkAnnotation>, TaskError> {
    let (Some(grasps), Some(cell)) = (problem.grasps(), problem.cell()) else {
        return Err(TaskError::Annotation);
    };
    let reach = cell.robot().reach_bound();
    let annotate = |(grasp, g): (usize, &Grasp)| {
        let at = Point::from(g.world_from_gripper.translation.vector);
        let beyond_m = reach.beyond_m(&at) - EXACT_TRANSLATION_M;
        let annotation = if beyond_m > 0.0 {
            let status = IkStatus::OutOfReach { beyond_m };
            IkAnnotation { grasp, status, solutions: Vec::new(), attempts: 0 }
        } else {
            annotate_one(cell, problem.start(), (grasp, g), settings, stop)
        };
        done();
        annotation
    };
    Ok(grasps.grasps().par_iter().enumerate().map(annotate).collect())
}

fn annotate_one(
    cell: &Cell,
    start: &[f64],
    (grasp, goal): (usize, &Grasp),
    settings: &IkAnnotationSettings,
    stop: &AtomicBool,
) -> IkAnnotation {
    let mut scratch = cell.scratch();
    let poses = match open_poses(cell, goal, &mut scratch) {
        Ok(poses) => poses,
        Err(contact) => {
            let [link, body] = contact.names(cell);
            let is_blocked = |pose: &Pose| {
                /// Maximum number of boxes of poses, each of some 30 µs. Of 154 grasps of five released scenarios, 12 needed more
                /// than one box, at most 346, and 4000 proved no further one.
                const MOST_BOXES: usize = 500;
                let tolerance = (EXACT_TRANSLATION_M, EXACT_ROTATION_RAD);
                cell.hand_is_blocked_near(pose, tolerance, MOST_BOXES, &mut scratch)
            };
            let is_proven = gripper_poses(goal).iter().all(is_blocked);
            let status = IkStatus::HandCollides { link, body, is_proven };
            return IkAnnotation { grasp, status, solutions: Vec::new(), attempts: 0 };
        }
    };
    let mut sight = Sight { cell, scratch, blocked: 0, last: Vec::new() };
    let (found, attempts) = match settings.method {
        IkMethod::SingleShot => single_shot(cell, start, &poses, settings.solutions, &mut sight, stop),
        IkMethod::Restarts => restarts(cell, start, (grasp, &poses), settings, &mut sight, stop),
    };
    let annotated = |solution: IkSolution| AnnotatedSolution {
        clearance_m: cell.clearance(&solution.q, &mut sight.scratch),
        q: solution.q,
        translation_error_m: solution.translation_error_m,
        rotation_error_rad: solution.rotation_error_rad,
    };
    let solutions: Vec<AnnotatedSolution> = found.into_iter().map(annotated).collect();
    let status = if !solutions.is_empty() {
        IkStatus::Solved
    } else if stop.load(Ordering::Relaxed) {
        IkStatus::Stopped
    } else {
        IkStatus::NoSolution { blocked: sight.blocked, contact: sight.last_contact() }
    };
    IkAnnotation { grasp, status, solutions, attempts }
}

/// Collision check of IK solutions that counts the blocked ones.
struct Sight<'a> {
    cell: &'a Cell,
    scratch: Scratch,
    blocked: usize,
    /// The last configuration that was not free.
    last: Vec<f64>,
}

impl Sight<'_> {
    fn is_free(&mut self, q: &[f64]) -> bool {
        let is_free = self.cell.is_free(q, &mut self.scratch);
        if !is_free {
            self.blocked += 1;
            self.last.clear();
            self.last.extend_from_slice(q);
        }
        is_free
    }

    fn last_contact(&mut self) -> Option<(String, String)> {
        if self.blocked == 0 {
            return None;
        }
        Some(self.cell.first_contact(&self.last, &mut self.scratch)?.names(self.cell).into())
    }
}

/// Makes one attempt at each pose, from the start; returns the free solutions and the number of attempts.
fn single_shot(
    cell: &Cell,
    start: &[f64],
    poses: &[Pose],
    most: usize,
    sight: &mut Sight,
    stop: &AtomicBool,
) -> (Vec<IkSolution>, usize) {
    /// The single attempt at a pose gets a large iteration limit.
    const MAX_ITERATIONS: usize = 100;
    let settings = IkSettings { max_iterations: MAX_ITERATIONS, ..IkSettings::default() };
    let mut solver = IkSolver::new(cell.robot(), settings);
    let (mut found, mut attempts) = (Vec::new(), 0);
    for pose in poses {
        if found.len() >= most || stop.load(Ordering::Relaxed) {
            break;
        }
        attempts += 1;
        found.extend(solver.solve_from(pose, start).filter(|solution| sight.is_free(&solution.q)));
    }
    (found, attempts)
}

/// Makes one attempt at each pose from the start, then attempts from random configurations at the poses in turn; returns the
/// distinct free solutions and the number of attempts.
fn restarts(
    cell: &Cell,
    start: &[f64],
    (grasp, poses): (usize, &[Pose]),
    settings: &IkAnnotationSettings,
    sight: &mut Sight,
    stop: &AtomicBool,
) -> (Vec<IkSolution>, usize) {
    let mut random = Stream::new(settings.seed, grasp as u64);
    let new_search = |pose| IkSearch::new(cell.robot(), pose, IkSearchSettings::default());
    let mut searches: Vec<IkSearch> = poses.iter().map(new_search).collect();
    let (mut attempts, mut found) = (0, 0);
    for turn in 0.. {
        if attempts >= settings.attempts || found >= settings.solutions || stop.load(Ordering::Relaxed) {
            break;
        }
        let turns = searches.len();
        let search = &mut searches[turn % turns];
        let before = search.attempts();
        let solution = if before == 0 {
            search.next_from(start, &mut |q| sight.is_free(q))
        } else {
            /// Number of attempts in one turn: a few batches.
            const TURN: usize = 3 * IK_BATCH;
            let count = TURN.min(settings.attempts - attempts);
            search.next_solution(&mut random, count, &mut |q| sight.is_free(q))
        };
        found += usize::from(solution.is_some());
        attempts += search.attempts() - before;
    }
    (searches.iter().flat_map(IkSearch::solutions).cloned().collect(), attempts)
}
