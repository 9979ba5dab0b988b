use cranny_collision::{Body, Scratch};
use cranny_grasp::{Contact, friction_needed, friction_score, pose_of_rows, rows_of_pose};
use cranny_shape::{AreaDistribution, Surface, TriangleSoup};
use cranny_spatial::{Pose, PoseDifference, Vector};
use serde::{Deserialize, Serialize};

use crate::closing_hand::{ClosedHand, ClosingHand};
use crate::{FailureReason, PlanError, Problem, Violation};

/// A grasp that a path ends at where no set of grasps is given: as it is measured, or as somebody says that it is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct OwnGrasp {
    /// Pose of the gripper frame in the planning frame, as a homogeneous matrix, row by row (m): as files have it, so that
    /// it is read back bit by bit. What somebody says need not be a pose.
    pub world_from_gripper: [[f64; 4]; 4],
    /// How far the fingers are apart once they have closed on the target, in metres.
    pub opening_m: f64,
    /// How good it is, in [0, 1]: how little friction its contacts need ([`friction_score`]).
    pub score: f64,
}

/// What is said of a grasp is right to within these: a pose and an opening, in metres and radians, and a score.
const SAID_TRANSLATION_M: f64 = 1e-4;
const SAID_ROTATION_RAD: f64 = 1e-3;
const SAID_OPENING_M: f64 = 1e-4;
const SAID_SCORE: f64 = 1e-3;

impl OwnGrasp {
    fn pose(&self) -> Option<Pose> {
        let rows = &self.world_from_gripper;
        pose_of_rows(&std::array::from_fn(|index| rows[index / 4][index % 4])).ok()
    }

    /// How far the gripper is from where it is said to be; `None` where that is no pose.
    pub(crate) fn off(&self, said: &Self) -> Option<PoseDifference> {
        Some(PoseDifference::between(&self.pose()?, &said.pose()?))
    }

    /// Whether what is said is so, as far as it is measured; what is no number never is.
    pub(crate) fn is_as_said(&self, said: &Self) -> bool {
        let Some(off) = self.off(said) else { return false };
        let opening_off_m = (self.opening_m - said.opening_m).abs();
        let score_off = (self.score - said.score).abs();
        off.translation_m <= SAID_TRANSLATION_M
            && off.rotation_rad <= SAID_ROTATION_RAD
            && opening_off_m <= SAID_OPENING_M
            && score_off <= SAID_SCORE
    }
}

/// What grasps are measured by where no set of them is given: the surface of the target, how it slides, and the hand that
/// closes on it. It belongs to a problem, as the tree of an obstacle's mesh does, and not to a search.
#[derive(Clone, Debug)]
pub struct GraspMeasure {
    hand: ClosingHand,
    surface_in_world: Surface,
    friction: f64,
    opening_m: f64,
}

impl GraspMeasure {
    /// A grasp of a lower score is none, in [0, 1]: with four fifths of the friction it would still hold, so that pads may
    /// stand a little otherwise.
    pub const LEAST_SCORE: f64 = 0.2;

    /// The measure for a problem, `friction` being the coefficient between pads and target.
    ///
    /// # Errors
    /// [`PlanError::NoGraspMeasure`] for a problem under `paper`, without a target or one that has no end, of a robot whose
    /// hand cannot close, or for a friction that is not positive.
    pub(crate) fn new(problem: &Problem, friction: f64) -> Result<Self, PlanError> {
        let lacking = |needs| PlanError::NoGraspMeasure { needs };
        let hand = ClosingHand::new(problem, lacking)?;
        let body = &problem.exact_cell("a grasp of one's own")?.world().bodies()[hand.target()];
        let surface_in_world = surface_in_world(body).ok_or_else(|| lacking("a target with a surface"))?;
        if !(friction > 0.0 && friction.is_finite()) {
            return Err(lacking("a positive coefficient of friction"));
        }
        let opening_m = problem.robot().hand().map_or(0.0, |hand| hand.description.opening_m);
        if opening_m <= 0.0 {
            return Err(lacking("a hand that opens"));
        }
        Ok(Self { hand, surface_in_world, friction, opening_m })
    }

    /// The triangles of the target, normals outwards.
    pub fn surface_in_world(&self) -> &Surface {
        &self.surface_in_world
    }

    /// The coefficient of friction between pads and target.
    pub fn friction(&self) -> f64 {
        self.friction
    }

    /// Between the pads of the open hand, in metres.
    pub fn opening_m(&self) -> f64 {
        self.opening_m
    }

    /// The two points where the middles of the pads, which close along y of the gripper frame through its origin, meet the
    /// surface first; `None` if they pass it by. The first is that of the pad on the side of −y.
    pub fn contacts_in_world(&self, world_from_gripper: &Pose) -> Option<[Contact; 2]> {
        let origin = world_from_gripper * cranny_spatial::Point::origin();
        let y = world_from_gripper.rotation * Vector::y();
        let contact = |side: f64| {
            let (pad, way) = (origin + y * (0.5 * side * self.opening_m), y * -side);
            let hits = self.surface_in_world.ray_hits(&pad, &way, self.opening_m);
            let hit = hits.first()?;
            Some(Contact { point_in_object: pad + way * hit.distance_m, normal_in_object: hit.normal })
        };
        Some([contact(-1.0)?, contact(1.0)?])
    }

    /// How good the grasp at a pose is, in [0, 1], 0 where its contacts are in no force closure ([`friction_needed`],
    /// [`friction_score`]); `None` where there are no contacts.
    pub fn score(&self, world_from_gripper: &Pose) -> Option<f64> {
        let [a, b] = self.contacts_in_world(world_from_gripper)?;
        Some(friction_score(friction_needed(&a, &b), self.friction))
    }
}

/// The triangles of a body; `None` for one without any, or without an end.
fn surface_in_world(body: &Body) -> Option<Surface> {
    let mut soup = TriangleSoup::default();
    for part in &body.parts {
        soup.append(&part.solid.tessellation()?, &part.world_from_solid);
    }
    let surface = Surface::new(&soup).ok()?;
    AreaDistribution::new(&surface).is_some().then_some(surface)
}

/// Says of a configuration whether the hand holds the target there: the one judge, whom planners ask too.
#[derive(Debug)]
pub(crate) struct GraspJudge<'a> {
    measure: &'a GraspMeasure,
    scratch: Scratch,
}

impl<'a> GraspJudge<'a> {
    pub fn new(measure: &'a GraspMeasure) -> Self {
        Self { measure, scratch: measure.hand.holding().scratch() }
    }

    /// The grasp that the hand takes at a configuration, which is a way point of this number.
    ///
    /// 1. Its contacts on the surface of the target are in force closure, with a score of
    ///    [`GraspMeasure::LEAST_SCORE`] or more.
    /// 2. The fingers close on the target, each until it touches, and proven meet nothing else on their way.
    ///
    /// # Errors
    /// What is wrong with it.
    ///
    /// # Panics
    /// If `q` has not one value per joint.
    pub fn grasp_at(&mut self, q: &[f64], way_point: usize) -> Result<OwnGrasp, Violation> {
        let grip = |reason| Violation::Grip { way_point, reason };
        // 1.
        let robot = self.measure.hand.holding().robot();
        let world_from_gripper = *robot.frames_at(q).link(robot.tip());
        let score =
            self.measure.score(&world_from_gripper).ok_or_else(|| grip(FailureReason::ClosesOnNothing))?;
        if score < GraspMeasure::LEAST_SCORE {
            return Err(Violation::WeakGrasp { way_point, score, required: GraspMeasure::LEAST_SCORE });
        }
        // 2.
        let ClosedHand { opening_m, .. } = self.measure.hand.close(q, &mut self.scratch).map_err(grip)?;
        let rows = rows_of_pose(&world_from_gripper);
        let row = |row: usize| std::array::from_fn(|column| rows[4 * row + column]);
        Ok(OwnGrasp { world_from_gripper: std::array::from_fn(row), opening_m, score })
    }
}
