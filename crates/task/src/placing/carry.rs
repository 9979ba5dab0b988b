use std::sync::Arc;

use cranny_collision::{Cell, Closing, CollisionError, Motion, Resting, Scratch};
use cranny_robot::{Hold, IkSettings, IkSolver, between};
use cranny_spatial::{EXACT_ROTATION_RAD, Pose, Rotation, Vector};

use crate::configuration_fault::ends_out_of_bounds;
use crate::grasping::closing_hand::{ClosedHand, ClosingHand};
use crate::{FailureReason, LoadModel, Problem, TaskError};

/// Settings of the lift-off of an object from its support.
///
/// Until the end of the lift-off, the object comes at most `slack_m` nearer to each face that carries it ([`Resting`]) than at
/// rest, and penetrates it no deeper than [`CONTACT_ALLOWANCE_M`](cranny_collision::CONTACT_ALLOWANCE_M). At the end it has a
/// distance of `clear_m` from all these faces; from then on they are ordinary obstacles. All other geometry, including bodies
/// beside the object and higher faces of the same support, is an obstacle throughout.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LiftOffSettings {
    /// Maximum travel of the object, in metres.
    pub most_m: f64,
    /// Least distance of the object from its support at the end, in metres; the margin of the held object applies if larger.
    pub clear_m: f64,
    /// Tolerance by which the object may come nearer to its support than at rest, in metres: joint values are rounded, and
    /// straight lines in joint space are not straight in Cartesian space.
    pub slack_m: f64,
}

impl Default for LiftOffSettings {
    fn default() -> Self {
        Self { most_m: 0.03, clear_m: 0.002, slack_m: 1e-4 }
    }
}

/// Distance between two configurations of a lift-off, in metres.
const RUNG_M: f64 = 0.005;
/// Number of samples along an edge by which its length in Cartesian space is approximated.
const SAMPLES_ALONG: u32 = 8;

/// The target of a problem and the hand that closes on it and carries it, in the same world.
#[derive(Clone, Debug)]
pub struct Carrier {
    cell: Arc<Cell>,
    settings: LiftOffSettings,
    hand: ClosingHand,
    resting: Resting,
    /// The object in the hand during the lift-off.
    lifting: Cell,
}

/// An object in the closed hand.
#[derive(Clone, Debug)]
pub struct Grip {
    /// Pose of the object in the tip's frame and closing of the fingers.
    pub hold: Hold,
    /// Distance between the fingers, in metres.
    pub opening_m: f64,
    /// Travel of the finger that touches last, after the first one touches, in metres.
    pub uneven_m: f64,
    /// Robot, object and world during the lift-off, and after it.
    lifting: Arc<Cell>,
    carrying: Arc<Cell>,
}

impl Carrier {
    /// Creates the carrier of the target of a problem under `exact`.
    ///
    /// # Errors
    /// [`TaskError::NothingToCarry`] for a problem without a target, without proofs, or of a robot whose hand cannot close;
    /// [`TaskError::Collision`] for an unbounded target, or one that touches a body other than its support.
    pub fn new(problem: &Problem, settings: LiftOffSettings) -> Result<Self, TaskError> {
        Self::in_cell(problem.cell(), problem.target(), settings)
    }

    /// Creates the carrier for a body of the world of a cell.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub(crate) fn in_cell(
        cell: Option<&Arc<Cell>>,
        target: Option<usize>,
        settings: LiftOffSettings,
    ) -> Result<Self, TaskError> {
        let lacking = |needs| TaskError::NothingToCarry { needs };
        let cell = cell.ok_or_else(|| lacking("the exact criterion"))?;
        let (hand, _) = ClosingHand::new(Some(cell), target, lacking)?;
        let clear_m = settings.clear_m.max(cell.margins().of_held_m());
        let resting = cell.resting(hand.target())?;
        Ok(Self {
            lifting: hand.holding().with_allowed_contacts(&resting),
            settings: LiftOffSettings { clear_m, ..settings },
            cell: cell.clone(),
            hand,
            resting,
        })
    }

    /// Returns the load model of grasps of the object where it stands; `None` if it cannot be computed ([`LoadModel`]).
    pub fn load_model(&self, problem: &Problem) -> Option<Arc<LoadModel>> {
        problem.load_model(&self.cell, self.hand.target())
    }

    /// Returns this carrier in the surroundings of another cell, where it grasps the same body. Much faster than [`Self::new`].
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn with_surroundings_of(&self, cell: &Arc<Cell>) -> Result<Self, TaskError> {
        let hand = self.hand.with_surroundings_of(cell);
        let clear_m = self.settings.clear_m.max(cell.margins().of_held_m());
        let resting = cell.resting_with(hand.target(), self.resting.extent())?;
        Ok(Self {
            lifting: hand.holding().with_allowed_contacts(&resting),
            settings: LiftOffSettings { clear_m, ..self.settings },
            cell: cell.clone(),
            hand,
            resting,
        })
    }

    /// Name of the object.
    pub fn object(&self) -> &str {
        &self.lifting.world().bodies()[self.hand.target()].name
    }

    /// Closes the fingers at a configuration (m, rad; one per joint) until the first touches the object.
    ///
    /// # Errors
    /// The reason why the hand does not hold the object: a finger touches nothing, or meets something else while closing.
    ///
    /// # Panics
    /// If `q` has not one value per joint.
    pub fn close(&self, q: &[f64]) -> Result<Grip, FailureReason> {
        let ClosedHand { hold, opening_m, uneven_m, .. } =
            self.hand.close(q, &mut self.hand.holding().scratch())?;
        let held =
            |cell: &Cell| cell.with_hold(hold).map(Arc::new).map_err(|_| FailureReason::ClosesOnNothing);
        let (lifting, carrying) = (held(&self.lifting)?, held(self.hand.holding())?);
        Ok(Grip { hold, opening_m, uneven_m, lifting, carrying })
    }

    /// Returns the reason why the object, gripped with the tip at a pose in the planning frame, can be at none of these
    /// configurations (m, rad; one value per joint): a bound exceeded by more than the tolerance of a grasp, or the contact at the
    /// first one. `None` if one is free.
    ///
    /// # Panics
    /// If a configuration has not one value per joint.
    pub fn blocked_at(&self, world_from_tip: &Pose, ends: &[Vec<f64>]) -> Option<FailureReason> {
        let tip_from_held = world_from_tip.inverse() * self.hand.world_from_target();
        let gripped = |closing| self.hand.holding().with_hold(Hold { tip_from_held, closing }).ok();
        let blocked = |cell: &Cell| {
            let mut scratch = cell.scratch();
            let mut contacts = ends.iter().map(|end| cell.first_contact(end, &mut scratch));
            let first = contacts.next()??;
            let [first, second] = first.names(cell);
            contacts.all(|contact| contact.is_some()).then_some(FailureReason::EndBlocked { first, second })
        };
        // First try the open hand: if one configuration is free with it, the fingers need not be closed.
        let open = gripped(0.0)?;
        if let Some(excess) = ends_out_of_bounds(&open, ends)
            && matches!(excess, FailureReason::EndOutOfBounds { by, .. } if by > EXACT_ROTATION_RAD)
        {
            return Some(excess);
        }
        let contact = blocked(&open)?;
        open.close_on_held().map_or(Some(contact), |Closing { closing, .. }| blocked(&gripped(closing)?))
    }

    /// Pose of the first solid of the object where it stands, in the planning frame.
    pub fn world_from_object(&self) -> Pose {
        self.hand.world_from_target()
    }

    /// Returns the pose of the gripper in the planning frame at a configuration (m, rad; one per joint).
    ///
    /// # Panics
    /// If `q` has not one value per joint.
    pub fn gripper(&self, q: &[f64]) -> Pose {
        *self.cell.robot().frames_at(q).link(self.cell.robot().tip())
    }

    /// Settings of the lift-off.
    pub fn settings(&self) -> LiftOffSettings {
        self.settings
    }

    /// Computes the lift-off path of a held object from `q` (m, rad; one per joint), where the hand closed on it: up, or up and
    /// away from its contacts, in straight edges, each of them proven.
    ///
    /// # Errors
    /// The obstacle that blocks the lift-off, or the reach of the arm.
    ///
    /// # Panics
    /// If `q` has not one value per joint.
    pub fn lift_off(&self, grip: &Grip, q: &[f64]) -> Result<Vec<Vec<f64>>, FailureReason> {
        self.way_off(grip, &self.resting, q).map_err(|blocked| match blocked {
            Some([first, second]) => FailureReason::LiftOffBlocked { first, second },
            None => FailureReason::LiftOffOutOfReach,
        })
    }

    /// Computes the path of a held object off its support, in straight edges, each of them proven; fails with the blocking pair
    /// if it is known, or with `None` beyond the reach of the arm.
    pub(crate) fn way_off(
        &self,
        grip: &Grip,
        resting: &Resting,
        q: &[f64],
    ) -> Result<Vec<Vec<f64>>, Option<[String; 2]>> {
        let mut scratch = grip.lifting.scratch();
        if let Some(contact) = grip.lifting.first_contact(q, &mut scratch) {
            return Err(Some(contact.names(&grip.lifting)));
        }
        let mut reason = None;
        for way in resting.lift_off_directions(self.lifting.world().up()) {
            match self.lifted(grip, resting, q, &way, &mut scratch) {
                Ok(path) => return Ok(path),
                Err(blocked) => reason = blocked.or(reason),
            }
        }
        Err(reason)
    }

    /// Computes the shortest path off the support in one direction; fails with the blocking pair if it is known.
    fn lifted(
        &self,
        grip: &Grip,
        resting: &Resting,
        q: &[f64],
        way: &Vector,
        scratch: &mut Scratch,
    ) -> Result<Vec<Vec<f64>>, Option<[String; 2]>> {
        let robot = self.cell.robot();
        let world_from_tip = *robot.frames_at(q).link(robot.tip());
        // The rest of the pose tolerance is left for the straight edges between the solutions.
        let settings = IkSettings {
            translation_tolerance_m: 1e-6,
            rotation_tolerance_rad: 1e-5,
            ..IkSettings::default()
        };
        let mut solver = IkSolver::new(robot, settings);
        let (mut path, mut gone_m, mut above) = (vec![q.to_vec()], 0.0, grip.carrying.scratch());
        loop {
            let last = &path[path.len() - 1];
            if gone_m > 0.0
                && self.is_off(grip, resting, last, &mut above)
                && grip.carrying.is_free(last, &mut above)
            {
                return Ok(path);
            }
            if gone_m >= self.settings.most_m - 1e-9 {
                let contact = grip.carrying.first_contact(last, &mut above);
                return Err(contact.map(|contact| contact.names(&grip.carrying)));
            }
            gone_m = (gone_m + RUNG_M).min(self.settings.most_m);
            let target = Pose::from_parts((way * gone_m).into(), Rotation::identity()) * world_from_tip;
            let next = solver.step_from(&target, last).ok_or(None)?;
            match grip.lifting.motion_is_free(last, &next, scratch) {
                Motion::Proven => {}
                Motion::Contact { contact, .. } | Motion::Unresolved { contact, .. } => {
                    return Err(Some(contact.names(&grip.lifting)));
                }
                Motion::OutOfLimits { .. } | Motion::OutOfBounds { .. } => return Err(None),
            }
            if let Some((_, body)) =
                self.first_support_violation(&grip.lifting, resting, [last, &next], scratch)
            {
                return Err(Some([self.object().to_owned(), self.body_name(body)]));
            }
            path.push(next);
        }
    }

    /// Returns true if the object is as far from its support at `q` (m, rad; one per joint) as a lift-off requires.
    pub fn is_off(&self, grip: &Grip, resting: &Resting, q: &[f64], scratch: &mut Scratch) -> bool {
        grip.carrying.lifted_m(resting, q, scratch) >= self.settings.clear_m
    }

    /// Returns the parameter in [0, 1] on an edge from `a` to `b` (m, rad; one per joint) at which the object may come nearer
    /// to its support than allowed, and the index of that support; `None` if it is proven not to. `cell` is that of the motion.
    pub fn first_support_violation(
        &self,
        cell: &Cell,
        resting: &Resting,
        [a, b]: [&[f64]; 2],
        scratch: &mut Scratch,
    ) -> Option<(f64, usize)> {
        cell.first_support_violation(resting, self.settings.slack_m, a, b, scratch)
    }

    /// Supports of the object before the lift-off.
    pub(crate) fn resting(&self) -> &Resting {
        &self.resting
    }

    /// The hand that closes on the object.
    pub(crate) fn hand(&self) -> &ClosingHand {
        &self.hand
    }

    /// The open and empty hand, with the object where it stands.
    pub fn cell(&self) -> &Arc<Cell> {
        &self.cell
    }

    /// Length of the path of the object in Cartesian space along a path (m, rad; one value per joint), in metres.
    pub fn length_m(&self, grip: &Grip, path: &[Vec<f64>]) -> f64 {
        let robot = self.cell.robot();
        let place = |q: Vec<f64>| {
            let world_from_held = robot.frames_at(&q).link(robot.tip()) * grip.hold.tip_from_held;
            world_from_held.translation.vector
        };
        let of_edge = |ends: &[Vec<f64>]| {
            let samples = (0..=SAMPLES_ALONG).map(|sample| f64::from(sample) / f64::from(SAMPLES_ALONG));
            let places: Vec<Vector> =
                samples.map(|at| place(between(&ends[0], &ends[1], at).collect())).collect();
            places.windows(2).map(|places| (places[1] - places[0]).norm()).sum::<f64>()
        };
        path.windows(2).map(of_edge).sum()
    }

    /// Returns the name of a body of the world, by index.
    pub fn body_name(&self, body: usize) -> String {
        self.lifting.world().bodies()[body].name.clone()
    }
}

impl Grip {
    /// The cell in which the object is lifted off its support, and the one in which it is carried from there.
    pub fn cells(&self) -> [&Arc<Cell>; 2] {
        [&self.lifting, &self.carrying]
    }

    /// Returns this grip with the object near its new support, in this cell.
    pub(crate) fn near(&self, cell: &Cell) -> Result<Self, CollisionError> {
        Ok(Self { lifting: Arc::new(cell.with_hold(self.hold)?), ..self.clone() })
    }

    /// Creates scratch for the hand with the object in it.
    pub fn carrying_scratch(&self) -> Scratch {
        self.carrying.scratch()
    }
}
