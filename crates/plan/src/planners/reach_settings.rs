use cranny_spatial::LANES;
use cranny_task::Problem;
use serde::{Deserialize, Serialize};

use crate::{PlanError, Ranges};

/// Main planner: one search for grasp and motion at exact tolerance.
///
/// 1. Batches of inverse kinematics between the iterations add goal configurations, for random grasps or their twins, as
///    further roots of one goal forest.
/// 2. A pose at which the hand alone collides is discarded; if none is left, no grasp can be reached.
/// 3. Bidirectional growth: the smaller side grows towards a random configuration, then the other side as far as possible
///    towards the new node. Random configurations lie in the box between the start and one of the goals, which widens with
///    time. A sequence fills this box evenly, which makes the slowest searches a quarter shorter. A node that was blocked is
///    not extended again towards distant configurations.
/// 4. Growth checks a row of configurations at once and ends before the first that is not free. If both sides meet, every
///    straight edge of the path is proven as a whole. An edge without a proof is cut off at its fault, with its descendants.
///
/// One iteration is one random configuration.
///
/// With a `guess`, such as the output of a learned policy, the search begins along it: the tree from the start grows from one way
/// point to the next as far as they are free, and the first inverse kinematics begins at the last one, for the grasps nearest to
/// it. If both meet at once, the guess is the path, with its end moved to a grasp, and is proven like any other; otherwise the
/// first goal grows back along the guess, and the search goes on from there.
///
/// Sources:
///
/// - alternate growth in 3: RRT-Connect (Kuffner & `LaValle` 2000, §II), with a forest instead of the tree of the goal, the
///   smaller side first, and one pass of checks instead of one step;
/// - sequence in 3: Richtmyer 1951, "The evaluation of definite integrals, and a quasi-Monte-Carlo method based on the
///   properties of algebraic numbers", whole;
/// - domains in 3: Yershova, Jaillet, Siméon & `LaValle` 2005, "Dynamic-domain RRTs", whole; a sample that is dropped counts as
///   an iteration here, where they draw another;
/// - checks in 4 along an edge in the lanes of one instruction: Thomason, Kingston & Kavraki 2024, "Motions in microseconds via
///   vectorized sampling-based planning", Fig. 2; here in the order of the edge, and against exact solids;
/// - proof in 4 after the growth: delayed checks as in SBL (Sánchez & Latombe 2003, "A single-query bi-directional
///   probabilistic roadmap planner with lazy collision checking", whole).
///
/// Original here: goals added by inverse kinematics during the search, the hand alone as a filter of grasps, the widening box,
/// the metric weighted by reach, and the proof of whole edges with a cut at the fault.
// Unknown keys are refused when a planner is created; `GraspReach` flattens these settings into its own.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Reach {
    /// Distance between the nodes of a growth, in the metric weighted by reach. Default 0.25.
    pub step: f64,
    /// Number of configurations checked between two nodes, including the second. One growth checks 16 (`LANES`). Default 4.
    pub looks: usize,
    /// Number of goals that suffice at first. Default 100: more help only if all are cut off, so each 100 iterations add one.
    pub goals: usize,
    /// Distance of each joint of a random configuration beyond start and goal at first (m, rad). It grows by the same amount
    /// for every 100 iterations, up to the joint limits. Default 0.5.
    pub detour: f64,
    /// Maximum distance of a target from a node that was blocked at once, in the metric weighted by reach. Default 2.
    pub domain: f64,
    /// Way points of a path from the start to about a goal that is likely to be free, or nearly (m, rad; one value per joint), for
    /// this problem alone. Default: none.
    pub guess: Vec<Vec<f64>>,
}

impl Default for Reach {
    fn default() -> Self {
        Self { step: 0.25, looks: 4, goals: 100, detour: 0.5, domain: 2.0, guess: Vec::new() }
    }
}

impl Reach {
    /// Checks the ranges of the settings.
    pub(crate) fn search_ranges(&self, ranges: Ranges) -> Result<Ranges, PlanError> {
        ranges
            .positive("step", self.step)?
            .count("looks", self.looks, LANES)?
            .count("goals", self.goals, usize::MAX)?
            .positive("detour", self.detour)?
            .positive("domain", self.domain)?
            .way_points("guess", &self.guess)
    }

    /// Returns these settings with the guess moved into the joint limits.
    ///
    /// # Errors
    /// [`PlanError::Setting`] for way points of another robot.
    pub(crate) fn within_limits(mut self, problem: &Problem) -> Result<Self, PlanError> {
        let robot = problem.robot();
        let dof = robot.dof();
        if let Some(first) = self.guess.first().filter(|q| q.len() != dof) {
            let count = first.len();
            let problem =
                format!("the way points of 'guess' have {count} values, but the robot has {dof} joints");
            return Err(PlanError::Setting { planner: "reach".to_owned(), problem });
        }
        for q in &mut self.guess {
            for (value, limits) in q.iter_mut().zip(robot.limits()) {
                *value = limits.clamp(*value);
            }
        }
        Ok(self)
    }
}
