use std::sync::Arc;

use cranny_collision::{Cell, Closing, CollisionError, Motion, Resting, Scratch};
use cranny_robot::{Hold, IkSettings, IkSolver, between};
use cranny_spatial::{Pose, Rotation, Vector};

use crate::grasping::closing_hand::{ClosedHand, ClosingHand};
use crate::{FailureReason, Firmness, Problem, TaskError};

/// How an object leaves what it rests on.
///
/// To each face that carries it ([`Resting`]) it stays, until the end of the lift-off, no nearer than at rest, but for
/// `slack_m`, and no deeper in it than [`CONTACT_ALLOWANCE_M`](cranny_collision::CONTACT_ALLOWANCE_M); there it is `clear_m`
/// off all of them, and from there on they are obstacles like any other. Everything else, what is beside the object and what
/// is higher on the same body too, is an obstacle all the time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LiftOffSettings {
    /// How far the object goes at most, in metres.
    pub most_m: f64,
    /// How far it is off what it rested on in the end, at least, in metres; more where the margin is.
    pub clear_m: f64,
    /// How much nearer than at rest it may come to what it touches, in metres: joint values are rounded, and straight
    /// lines in joint space are none in space.
    pub slack_m: f64,
}

impl Default for LiftOffSettings {
    fn default() -> Self {
        Self { most_m: 0.03, clear_m: 0.002, slack_m: 1e-4 }
    }
}

/// Between two configurations of a lift-off, in metres.
const RUNG_M: f64 = 0.005;
/// Pieces of an edge whose lengths together are that of its way in space.
const SAMPLES_ALONG: u32 = 8;

/// What follows a grasp: the target of a problem in the hand that has closed on it, in the same world.
#[derive(Clone, Debug)]
pub struct Carrier {
    /// The open and empty hand, and the object where it stands.
    cell: Arc<Cell>,
    settings: LiftOffSettings,
    hand: ClosingHand,
    resting: Resting,
    /// The object in the hand while it is lifted off.
    lifting: Cell,
}

/// An object in the hand that has closed on it.
#[derive(Clone, Debug)]
pub struct Grip {
    /// How the hand holds it.
    pub hold: Hold,
    /// How far the fingers are apart, in metres.
    pub opening_m: f64,
    /// How much farther the finger that touches last has to go than the first, in metres.
    pub uneven_m: f64,
    /// Robot, object and world while the object is lifted off, and from then on.
    lifting: Arc<Cell>,
    carrying: Arc<Cell>,
}

impl Carrier {
    /// Of a problem under `exact` whose target is to be carried.
    ///
    /// # Errors
    /// [`TaskError::NothingToCarry`] for a problem without a target, without proofs, or of a robot whose hand cannot
    /// close; [`TaskError::Collision`] for a target that has no end, or touches what does not carry it.
    pub fn new(problem: &Problem, settings: LiftOffSettings) -> Result<Self, TaskError> {
        Self::in_cell(problem.cell(), problem.target(), settings)
    }

    /// The same of a body of the world of a cell.
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
            lifting: hand.holding().sparing(&resting),
            settings: LiftOffSettings { clear_m, ..settings },
            cell: cell.clone(),
            hand,
            resting,
        })
    }

    /// The firmness of grasps of the object, where it stands; `None` where it cannot be computed ([`Firmness`]).
    pub fn firmness(&self, problem: &Problem) -> Option<Firmness> {
        problem.firmness(&self.cell, self.hand.target())
    }

    /// The same object in the surroundings of another cell, which is to grasp it: far less work than from the start.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn amid(&self, cell: &Arc<Cell>) -> Result<Self, TaskError> {
        let hand = self.hand.amid(cell);
        let clear_m = self.settings.clear_m.max(cell.margins().of_held_m());
        let resting = cell.resting_with(hand.target(), self.resting.extent())?;
        Ok(Self {
            lifting: hand.holding().sparing(&resting),
            settings: LiftOffSettings { clear_m, ..self.settings },
            cell: cell.clone(),
            hand,
            resting,
        })
    }

    /// What the object is called.
    pub fn object(&self) -> &str {
        &self.lifting.world().bodies()[self.hand.target()].name
    }

    /// Closes the hand at a configuration (m, rad; one per joint): the fingers, until the first touches the object as
    /// it then stands in the hand.
    ///
    /// # Errors
    /// Why it does not hold the object then: a finger touches nothing, or meets something else on its way.
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

    /// The contact that keeps the object, gripped with the tip at a pose, from being at every one of these configurations
    /// (m, rad; one value per joint); `None` if it can be at one of them, as far as collisions go.
    ///
    /// # Panics
    /// If a configuration has not one value per joint.
    pub fn blocked_at(&self, world_from_tip: &Pose, ends: &[Vec<f64>]) -> Option<[String; 2]> {
        let tip_from_held = world_from_tip.inverse() * self.hand.world_from_target();
        let blocked = |closing| {
            let cell = self.hand.holding().with_hold(Hold { tip_from_held, closing }).ok()?;
            let mut scratch = cell.scratch();
            let mut contacts = ends.iter().map(|end| cell.first_contact(end, &mut scratch));
            let first = contacts.next()??;
            contacts.all(|contact| contact.is_some()).then(|| (first.names(&cell), cell))
        };
        // Most are free with the hand open too, which it need not be closed for.
        let (names, open) = blocked(0.0)?;
        open.close_on_held().map_or(Some(names), |Closing { closing, .. }| Some(blocked(closing)?.0))
    }

    /// Pose of the first solid of the object where it stands, in the planning frame.
    pub fn world_from_object(&self) -> Pose {
        self.hand.world_from_target()
    }

    /// Pose of the gripper in the planning frame at a configuration (m, rad; one per joint).
    ///
    /// # Panics
    /// If `q` has not one value per joint.
    pub fn gripper(&self, q: &[f64]) -> Pose {
        *self.cell.robot().frames_at(q).link(self.cell.robot().tip())
    }

    /// How the object leaves what it rests on.
    pub fn settings(&self) -> LiftOffSettings {
        self.settings
    }

    /// The way of a held object off what it rests on, from `q` (m, rad; one per joint), where the hand closed on it:
    /// up, or up and away from what it touches, in straight pieces that are proven each.
    ///
    /// # Errors
    /// What is in the way.
    ///
    /// # Panics
    /// If `q` has not one value per joint.
    pub fn lift_off(&self, grip: &Grip, q: &[f64]) -> Result<Vec<Vec<f64>>, FailureReason> {
        self.way_off(grip, &self.resting, q).map_err(|blocked| match blocked {
            Some([first, second]) => FailureReason::LiftOffBlocked { first, second },
            None => FailureReason::LiftOffOutOfReach,
        })
    }

    /// The way of a held object off what it rests on, in straight pieces that are proven each; else what stops it, if that
    /// is known, and not the reach of the arm.
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
        for way in resting.ways_off(self.lifting.world().up()) {
            match self.lifted(grip, resting, q, &way, &mut scratch) {
                Ok(path) => return Ok(path),
                Err(blocked) => reason = blocked.or(reason),
            }
        }
        Err(reason)
    }

    /// The way off in one direction, as short as it can be; what stops it, if that is known.
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
        // What is left of the tolerance of an answer is for the straight lines between.
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
            if let Some((_, body)) = self.stays_off(&grip.lifting, resting, [last, &next], scratch) {
                return Err(Some([self.object().to_owned(), self.body_name(body)]));
            }
            path.push(next);
        }
    }

    /// Whether the object is as far off what it rested on as it must be at the end of a lift-off. `q` (m, rad; one per
    /// joint).
    pub fn is_off(&self, grip: &Grip, resting: &Resting, q: &[f64], scratch: &mut Scratch) -> bool {
        grip.carrying.lifted_m(resting, q, scratch) >= self.settings.clear_m
    }

    /// Where an edge of a motion near what carries the object brings it nearer to that, or may, and to which body: in the
    /// cell along that motion. Ends `a` and `b` (m, rad; one per joint).
    pub fn stays_off(
        &self,
        cell: &Cell,
        resting: &Resting,
        [a, b]: [&[f64]; 2],
        scratch: &mut Scratch,
    ) -> Option<(f64, usize)> {
        cell.stays_off(resting, self.settings.slack_m, a, b, scratch)
    }

    /// How the object rests before it is lifted off.
    pub(crate) fn resting(&self) -> &Resting {
        &self.resting
    }

    /// The hand that closes on it.
    pub(crate) fn hand(&self) -> &ClosingHand {
        &self.hand
    }

    /// The open and empty hand, and the object where it stands.
    pub fn cell(&self) -> &Arc<Cell> {
        &self.cell
    }

    /// Length of the way of the object along a path (m, rad; one value per joint), in metres.
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

    /// Name of a body of the world, by its index.
    pub fn body_name(&self, body: usize) -> String {
        self.lifting.world().bodies()[body].name.clone()
    }
}

impl Grip {
    /// The cell in which the object is taken off what it rests on, and the one in which it is carried on from there.
    pub fn cells(&self) -> [&Arc<Cell>; 2] {
        [&self.lifting, &self.carrying]
    }

    /// The same with the object near what it is put down on, in this cell.
    pub(crate) fn near(&self, cell: &Cell) -> Result<Self, CollisionError> {
        Ok(Self { lifting: Arc::new(cell.with_hold(self.hold)?), ..self.clone() })
    }

    /// Scratch for the hand with the object in it.
    pub fn carrying_scratch(&self) -> Scratch {
        self.carrying.scratch()
    }
}
