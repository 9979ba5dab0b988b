use cranny_spatial::LANES;
use serde::{Deserialize, Serialize};

use crate::{PlanError, Ranges};

/// The flagship: one search for grasp and motion at exact tolerance.
///
/// 1. Batches of inverse kinematics between the iterations add goal configurations, for random grasps or
///    their twins, as further roots of one goal forest.
/// 2. A pose at which the hand alone collides is left out; if none is left, no grasp can be reached.
/// 3. Bidirectional growth: the smaller side grows towards a random configuration, the other side then goes as far as
///    it can towards the new node. Random configurations lie about the box between the start and one of the goals,
///    farther and farther beyond it as time goes on; within it they follow a sequence that fills it evenly, which takes
///    a quarter off the slowest. From a node that was blocked nothing far away is tried again.
/// 4. Growth checks a row of single configurations at once and ends before the first that is not free; where both sides
///    meet, every straight edge of the path is proven as a whole, and one that cannot be is cut off where it fails,
///    with all that grew from there.
///
/// One iteration is one random configuration.
///
/// Taken from publications:
///
/// - the alternate growth of 3: RRT-Connect (Kuffner & `LaValle` 2000, §II), with a forest in place of the goal's tree,
///   the smaller side first, and one pass of checks in place of one step;
/// - the sequence of 3: Richtmyer 1951, "The evaluation of definite integrals, and a quasi-Monte-Carlo method based on
///   the properties of algebraic numbers", whole;
/// - the domains of 3: Yershova, Jaillet, Siméon & `LaValle` 2005, "Dynamic-domain RRTs", whole; a sample that is
///   dropped counts as an iteration here, where they draw another;
/// - the checks of 4 along an edge in the lanes of one instruction: Thomason, Kingston & Kavraki 2024, "Motions in
///   microseconds via vectorized sampling-based planning", Fig. 2; here in the order of the edge, and of exact bodies;
/// - the proof of 4 after the growth: delayed checks as in SBL (Sánchez & Latombe 2003, "A single-query bi-directional
///   probabilistic roadmap planner with lazy collision checking", whole).
///
/// Ours: goals that inverse kinematics adds during the search, the hand alone as a filter of grasps, the box that widens,
/// the metric weighted by reach, and the proof of whole edges with the cut where it fails.
// Other keys are refused where a planner is made; `GraspReach` has these settings among its own.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Reach {
    /// How far apart the nodes of a growth lie, in the metric weighted by reach. Default 0.25.
    pub step: f64,
    /// Configurations that are checked between two nodes, the second included. One growth checks 16 (`LANES`).
    /// Default 4.
    pub looks: usize,
    /// Goals that are enough at first. Default 100: more do not help, unless all are cut off; one more for every 100
    /// iterations.
    pub goals: usize,
    /// How far beyond start and goal each joint of a random configuration may lie at first (m, rad); once more
    /// that far for every 100 iterations, up to the joint limits. Default 0.5.
    pub detour: f64,
    /// A node from which growth was blocked at once is grown from only towards what is no farther away than this, in the
    /// metric weighted by reach. Default 2.
    pub domain: f64,
}

impl Default for Reach {
    fn default() -> Self {
        Self { step: 0.25, looks: 4, goals: 100, detour: 0.5, domain: 2.0 }
    }
}

impl Reach {
    /// The ranges of the settings.
    pub(crate) fn search_ranges(&self, ranges: Ranges) -> Result<Ranges, PlanError> {
        ranges
            .positive("step", self.step)?
            .count("looks", self.looks, LANES)?
            .count("goals", self.goals, usize::MAX)?
            .positive("detour", self.detour)?
            .positive("domain", self.domain)
    }
}
