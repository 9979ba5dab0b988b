use std::sync::atomic::{AtomicBool, Ordering};

use cranny_collision::{Cell, Collider};
use cranny_grasp::Grasp;
use cranny_robot::{IkSearch, IkSearchSettings};
use cranny_spatial::Stream;
use rayon::prelude::*;

use crate::grasp_poses::open_poses;
use crate::{Goal, PlanError, Problem, Validity};

/// How hard to look for configurations at the grasps of a problem.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IkAnnotationSettings {
    /// At most so many distinct solutions for each grasp. Default 1.
    pub solutions: usize,
    /// At most so many attempts for each grasp. Default 2000: in the tightest released scenario one attempt
    /// in some hundreds gives a free configuration.
    pub attempts: usize,
    /// The seed; grasp k draws from stream k, so the number of threads does not matter.
    pub seed: u64,
}

impl Default for IkAnnotationSettings {
    fn default() -> Self {
        Self { solutions: 1, attempts: 2000, seed: 0 }
    }
}

/// What became of one grasp.
#[derive(Clone, Debug, PartialEq)]
pub struct IkAnnotation {
    /// Index of the grasp.
    pub grasp: usize,
    /// Whether it can be held, and if not, why.
    pub status: IkStatus,
    /// Free configurations that hold it, each exact.
    pub solutions: Vec<AnnotatedSolution>,
    /// How many attempts were made.
    pub attempts: usize,
}

/// Why a grasp can or cannot be held.
#[derive(Clone, Debug, PartialEq)]
pub enum IkStatus {
    /// At least one free configuration was found.
    Solved,
    /// The hand alone collides there and at the twin, whatever the arm does; at the grasp itself:
    HandCollides {
        /// Which link of the hand.
        link: String,
        /// Which body of the world.
        body: String,
    },
    /// No free configuration was found in the attempts; there may be one.
    NoSolution {
        /// Attempts that reached the pose but not freely.
        blocked: usize,
    },
    /// The search was stopped before this grasp was done.
    Stopped,
}

impl IkStatus {
    /// What `--json` calls it.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Solved => "solved",
            Self::HandCollides { .. } => "hand-collides",
            Self::NoSolution { .. } => "no-solution",
            Self::Stopped => "stopped",
        }
    }
}

/// A free configuration at a grasp.
#[derive(Clone, Debug, PartialEq)]
pub struct AnnotatedSolution {
    /// The configuration (m, rad).
    pub q: Vec<f64>,
    /// Distance of the gripper from the grasp, in metres.
    pub translation_error_m: f64,
    /// Angle between the gripper and the grasp, in radians.
    pub rotation_error_rad: f64,
    /// Least distance over all pairs, in metres.
    pub clearance_m: f64,
}

/// Looks for free configurations at every grasp of an `exact` problem or its twin, on all cores: first from
/// the start with a pull towards it (the paper's annotation), then from random configurations; the answer depends on
/// problem and settings alone. `done` is called once for each grasp that is finished, from any thread;
/// where `stop` becomes true the grasps left over come back as [`IkStatus::Stopped`].
///
/// # Errors
/// [`PlanError::Annotation`] if the problem has no grasps or is under the `paper` criterion.
pub fn annotate_ik(
    problem: &Problem,
    settings: &IkAnnotationSettings,
    done: &(dyn Fn() + Sync),
    stop: &AtomicBool,
) -> Result<Vec<IkAnnotation>, PlanError> {
    let (Goal::Grasps(grasps), Validity::Exact(cell)) = (&problem.goal, &problem.validity) else {
        return Err(PlanError::Annotation);
    };
    let annotate = |(grasp, g): (usize, &Grasp)| {
        let annotation = annotate_one(cell, &problem.start, (grasp, g), settings, stop);
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
            let name = |collider: Collider| cell.name(collider).to_owned();
            let status = IkStatus::HandCollides { link: name(contact.first), body: name(contact.second) };
            return IkAnnotation { grasp, status, solutions: Vec::new(), attempts: 0 };
        }
    };
    let mut random = Stream::new(settings.seed, grasp as u64);
    let new_search = |pose| IkSearch::new(cell.robot(), pose, IkSearchSettings::default());
    let mut searches: Vec<IkSearch> = poses.iter().map(new_search).collect();
    let (mut attempts, mut found, mut blocked) = (0, 0, 0);
    // The grasp and its twin in turns.
    for turn in 0.. {
        if attempts >= settings.attempts || found >= settings.solutions || stop.load(Ordering::Relaxed) {
            break;
        }
        let turns = searches.len();
        let search = &mut searches[turn % turns];
        let before = search.attempts();
        let mut is_free = |q: &[f64]| {
            let is_free = cell.is_free(q, &mut scratch);
            blocked += usize::from(!is_free);
            is_free
        };
        let solution = if before == 0 {
            search.next_from(start, &mut is_free)
        } else {
            /// Attempts in one turn.
            const TURN: usize = 50;
            search.next_solution(&mut random, TURN.min(settings.attempts - attempts), &mut is_free)
        };
        found += usize::from(solution.is_some());
        attempts += search.attempts() - before;
    }
    let solutions: Vec<AnnotatedSolution> = searches
        .iter()
        .flat_map(IkSearch::solutions)
        .map(|solution| AnnotatedSolution {
            q: solution.q.clone(),
            translation_error_m: solution.translation_error_m,
            rotation_error_rad: solution.rotation_error_rad,
            clearance_m: cell.clearance(&solution.q, &mut scratch),
        })
        .collect();
    let status = if !solutions.is_empty() {
        IkStatus::Solved
    } else if stop.load(Ordering::Relaxed) {
        IkStatus::Stopped
    } else {
        IkStatus::NoSolution { blocked }
    };
    IkAnnotation { grasp, status, solutions, attempts }
}
