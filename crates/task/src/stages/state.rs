use std::sync::Arc;

use cranny_collision::{Cell, Margins, Resting, Scratch};
use cranny_grasp::ASSUMED_DENSITY;
use cranny_robot::{between, distance};
use cranny_spatial::Pose;

use crate::grasping::load_model::moments_of;
use crate::placing::placed::Placed;
use crate::stages::payload::Payload;
use crate::stages::segment::{Mode, MotionEnd, Segment};
use crate::stages::straight::{FarEnd, straight_line, straight_path};
use crate::{
    Carrier, FailureReason, Goal, Grip, LiftOffSettings, Moved, Pick, Problem, Region, Stage, TaskError,
};

/// Maximum distance between two configurations of [`State::free_along`], in the metric of the joints (m, rad).
const PIECE: f64 = 0.25;
/// Robot, hand and world at an instant of a task: the configuration, the pose of each body, and the object in the hand.
#[derive(Clone, Debug)]
pub struct State {
    /// Configuration (m, rad; one value per joint).
    pub q: Vec<f64>,
    /// The open and empty hand; a held object stands where it was grasped.
    empty: Arc<Cell>,
    held: Option<Held>,
    let_go: Option<(usize, Pose)>,
    rest: Option<Rest>,
    /// Cell in which the hand keeps to a straight line along the present segment.
    line: Option<Arc<Cell>>,
}

/// An object in the hand.
#[derive(Clone, Debug)]
struct Held {
    carrier: Arc<Carrier>,
    grip: Grip,
}

/// Support of a held object at an end of a segment, and the cell in which the two may touch.
#[derive(Clone, Debug)]
struct Rest {
    resting: Resting,
    near: Arc<Cell>,
}

impl State {
    /// Returns the start state of a problem; `None` under `paper`, which has no world.
    pub fn start(problem: &Problem) -> Option<Self> {
        let empty = problem.cell()?.clone();
        Some(Self { q: problem.start().to_vec(), empty, held: None, let_go: None, rest: None, line: None })
    }

    /// Creates the state after the object of a carrier was released with its first solid at a pose in the planning frame, the
    /// arm at a configuration (m, rad; one per joint).
    ///
    /// # Errors
    /// [`TaskError::Collision`] for an invalid pose.
    pub fn after_letting_go(carrier: &Carrier, world_from_held: &Pose, q: &[f64]) -> Result<Self, TaskError> {
        let body = carrier.hand().target();
        let after = carrier.cell().with_body_at(body, world_from_held)?;
        let let_go = Some((body, *world_from_held));
        Ok(Self { q: q.to_vec(), empty: Arc::new(after), held: None, let_go, rest: None, line: None })
    }

    /// Robot and world; an object in the hand moves with the robot.
    pub fn cell(&self) -> &Arc<Cell> {
        match (&self.rest, &self.line, &self.held) {
            (Some(rest), _, _) => &rest.near,
            (None, Some(line), _) => line,
            (None, None, Some(held)) => held.grip.cells()[1],
            (None, None, None) => &self.empty,
        }
    }

    /// The open and empty hand among all bodies, with a held object where it was grasped.
    pub fn empty_cell(&self) -> &Arc<Cell> {
        &self.empty
    }

    /// The object in the hand and its grip.
    pub fn held(&self) -> Option<(&Arc<Carrier>, &Grip)> {
        self.held.as_ref().map(|held| (&held.carrier, &held.grip))
    }

    /// Support of the held object at an end of the present segment.
    pub fn resting(&self) -> Option<&Resting> {
        self.rest.as_ref().map(|rest| &rest.resting)
    }

    /// Body that the hand released last, by index, and the pose of its first solid in the planning frame.
    pub fn let_go(&self) -> Option<(usize, &Pose)> {
        self.let_go.as_ref().map(|(body, pose)| (*body, pose))
    }

    /// Returns this state at another configuration (m, rad; one per joint).
    #[must_use]
    pub fn at(&self, q: &[f64]) -> Self {
        Self { q: q.to_vec(), rest: None, line: None, ..self.clone() }
    }

    /// Certified lower bound of the distance between the object in the hand, or the hand if it is empty, and all bodies but
    /// floors, with the arm at `q` (m, rad; one per joint), in metres, up to `beyond_m`.
    ///
    /// # Panics
    /// If `q` has not one value per joint.
    pub fn clearance_m(&self, q: &[f64], beyond_m: f64, scratch: &mut Scratch) -> f64 {
        let cell = self.cell();
        if self.held.is_some() {
            return cell.held_clearance(q, beyond_m, scratch);
        }
        let bodies = cell.world().bodies().iter().enumerate().filter(|(_, body)| !body.is_floor());
        bodies
            .fold(beyond_m, |least_m, (body, _)| cell.hand_clearance(q, body, least_m, scratch).min(least_m))
    }

    /// Returns the pose of the gripper frame, or of the first solid of the object in the hand, in the planning frame, with the
    /// arm at `q` (m, rad; one per joint); `None` for the object of an empty hand.
    ///
    /// # Panics
    /// If `q` has not one value per joint.
    pub fn pose_of(&self, moved: Moved, q: &[f64]) -> Option<Pose> {
        let robot = self.empty.robot();
        let world_from_tip = *robot.frames_at(q).link(robot.tip());
        Some(world_from_tip * self.tip_from(moved)?)
    }

    /// Returns the pose of the gripper frame in the planning frame that brings the moved frame (the gripper frame, or the first
    /// solid of the object in the hand) to a pose there; `None` for the object of an empty hand.
    pub fn world_from_tip(&self, moved: Moved, world_from_moved: &Pose) -> Option<Pose> {
        Some(world_from_moved * self.tip_from(moved)?.inverse())
    }

    fn tip_from(&self, moved: Moved) -> Option<Pose> {
        match moved {
            Moved::Hand => Some(Pose::identity()),
            Moved::Object => self.held.as_ref().map(|held| held.grip.hold.tip_from_held),
        }
    }

    /// Returns the problem of grasping an object from this state: with the grasps of `problem` for its target; for another
    /// object the planner generates grasps.
    ///
    /// # Errors
    /// As [`Pick::body`], and [`TaskError::NoGraspMeasure`] for an object whose grasps cannot be measured.
    pub fn picking(&self, problem: &Problem, pick: &Pick) -> Result<Problem, TaskError> {
        if pick.object.is_none() && problem.target().is_none() {
            return problem.with_start(&self.q);
        }
        let body = pick.body(problem)?;
        let margins = problem.cell().map_or(self.empty.margins(), |cell| cell.margins());
        let object_margin_m = pick.object_margin_m.unwrap_or(margins.object_margin_m);
        let cell = self.empty.to_grasp(body, Margins { object_margin_m, ..margins })?;
        problem.picking(cell.map_or_else(|| self.empty.clone(), Arc::new), body, &self.q)
    }

    /// Returns this state in the cell of `picking`, the problem of the next grasp.
    #[must_use]
    pub fn before_picking(&self, picking: &Problem) -> Self {
        Self { empty: picking.cell().unwrap_or(&self.empty).clone(), ..self.clone() }
    }

    /// Returns mass and inertia of the object in the hand in the world of a problem; `None` for an empty hand, or an object
    /// without stated moments that encloses no volume.
    pub fn payload(&self, problem: &Problem) -> Option<Payload> {
        let Held { carrier, grip } = self.held.as_ref()?;
        let target = carrier.hand().target();
        let weight = problem.weights.of_body(target);
        let in_world = moments_of(&carrier.cell().world().bodies()[target], &weight)?;
        let moments = in_world.moved(&(grip.hold.tip_from_held * carrier.world_from_object().inverse()));
        let mass_kg = weight.mass_kg.unwrap_or(ASSUMED_DENSITY * moments.volume_m3);
        Some(Payload::new(mass_kg, &moments, weight.mass_kg.is_none()))
    }

    /// Creates a segment of a stage through way points (m, rad; one value per joint) with the object in the hand.
    pub fn segment(&self, stage: usize, mode: Mode, waypoints: Vec<Vec<f64>>) -> Segment {
        let segment = Segment::empty(stage, mode, waypoints);
        match self.held() {
            Some((carrier, grip)) => Segment {
                attached: Some(carrier.object().to_owned()),
                opening_m: Some(grip.opening_m),
                uneven_m: Some(grip.uneven_m),
                ..segment
            },
            None => segment,
        }
    }

    /// Returns configurations (m, rad; one value per joint) along the beginning of a path of way points, as far as it is proven
    /// in the cell of this state. Neighbours are no farther apart than one step of a tree search.
    pub fn free_along(&self, path: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let mut scratch = self.cell().scratch();
        let mut along: Vec<Vec<f64>> = path.first().cloned().into_iter().collect();
        for edge in path.windows(2) {
            let [a, b] = edge else { break };
            let pieces = (distance(a, b) / PIECE).ceil().max(1.0);
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "at most so many that their number is exact"
            )]
            for piece in 1..=pieces.min(1e6) as u32 {
                let next: Vec<f64> = if f64::from(piece) >= pieces {
                    b.clone()
                } else {
                    between(a, b, f64::from(piece) / pieces).collect()
                };
                let last = &along[along.len() - 1];
                if !self.cell().motion_is_free(last, &next, &mut scratch).is_proven() {
                    return along;
                }
                along.push(next);
            }
        }
        along
    }

    /// Returns the problem of moving from this state to one of these configurations (m, rad; one value per joint).
    ///
    /// # Errors
    /// [`TaskError::JointCount`] or [`TaskError::NotFinite`] for an invalid configuration.
    pub fn moving(&self, to: Vec<Vec<f64>>) -> Result<Problem, TaskError> {
        Problem::in_cell(self.cell().clone(), self.q.clone(), Goal::Configurations(to))
    }

    /// Returns the problem of moving the hand from this state into any of these regions.
    ///
    /// # Errors
    /// [`TaskError::Region`] for an invalid region, or one of the object.
    pub fn moving_into(&self, regions: Vec<Region>) -> Result<Problem, TaskError> {
        Problem::in_cell(self.cell().clone(), self.q.clone(), Goal::Regions(regions))
    }

    /// Returns the state after the hand has closed on the object of a carrier.
    ///
    /// # Errors
    /// The reason why the hand does not hold the object.
    pub fn closed_on(&self, carrier: &Arc<Carrier>) -> Result<Self, FailureReason> {
        let grip = carrier.close(&self.q)?;
        Ok(Self { held: Some(Held { carrier: carrier.clone(), grip }), ..self.clone() })
    }

    /// Returns the state after the hand has released the object.
    ///
    /// # Errors
    /// The contact of the fingers.
    pub fn opened(&self) -> Result<Self, FailureReason> {
        let Some(Held { carrier, grip }) = &self.held else { return Ok(self.clone()) };
        let placed = carrier.open(grip, &self.q)?;
        let let_go = Some((placed.target, placed.world_from_held));
        Ok(Self { empty: placed.after, held: None, let_go, ..self.clone() })
    }

    /// Computes a path of way points (m, rad; one value per joint) on which the open hand retreats from the released object
    /// until its distance is `clear_m` (m), in straight edges, each of them proven; if `straight_m` (m) is above 0, at least
    /// that length of it on a straight line against the z axis of the gripper frame.
    ///
    /// # Errors
    /// Reason why no such path was found.
    pub fn retreat(&self, clear_m: f64, straight_m: f64) -> Result<Vec<Vec<f64>>, FailureReason> {
        let (body, pose) = self.let_go.ok_or(FailureReason::NoPlace)?;
        Placed::of(&self.empty, body, pose).retreat(&self.q, clear_m, straight_m)
    }

    /// Computes a path of way points (m, rad; one value per joint) on which the open hand arrives here straight along the z
    /// axis of the gripper frame, over `length_m` (m), in straight edges, each of them proven.
    ///
    /// # Errors
    /// Reason why no such path was found.
    pub fn approach(&self, length_m: f64) -> Result<Vec<Vec<f64>>, FailureReason> {
        let path = straight_path(&self.empty, &self.q, (length_m, FarEnd::First), |_| true);
        path.map_err(|blocked| match blocked {
            Some([first, second]) => FailureReason::ApproachBlocked { first, second },
            None => FailureReason::ApproachOutOfReach,
        })
    }

    /// Returns the state along a segment that begins here: the hand closes on the object or opens as its mode requires, and the
    /// object may touch its support where the mode allows it. It uses the carrier `known` if that belongs to the cell of this
    /// state, because a new one is costly.
    ///
    /// # Errors
    /// The reason why the hand cannot close or open here.
    pub fn along(&self, segment: &Segment, known: Option<&Arc<Carrier>>) -> Result<Self, FailureReason> {
        let state = match (&self.held, segment.mode.holds) {
            (None, true) => {
                let made = || {
                    let body = self.empty.grasp_body();
                    Carrier::in_cell(Some(&self.empty), body, LiftOffSettings::default()).map(Arc::new)
                };
                let known = known.filter(|carrier| Arc::ptr_eq(carrier.cell(), &self.empty));
                let carrier = known.map_or_else(made, |carrier| Ok(carrier.clone()));
                self.closed_on(&carrier.map_err(|_| FailureReason::ClosesOnNothing)?)?
            }
            (Some(_), false) => self.opened()?,
            _ => self.clone(),
        };
        let rest =
            state.held.as_ref().zip(segment.mode.rests_at).and_then(|(held, end)| held.rest(end, segment));
        Ok(Self { rest, ..state })
    }

    /// Returns this state along a segment of a stage on which the hand keeps to a straight line if required.
    fn keeping_straight(self, stage: Option<&Stage>, segment: &Segment) -> Result<Self, TaskError> {
        let line = straight_line(self.empty.robot(), stage, segment);
        let line = line.map(|line| line.keeping(&self.empty)).transpose()?;
        Ok(Self { line: line.map(Arc::new), ..self })
    }

    /// Returns the state at the end of a segment, from the state along it.
    #[must_use]
    pub fn after(&self, segment: &Segment) -> Self {
        segment.waypoints.last().map_or_else(|| self.clone(), |last| self.at(last))
    }
}

impl Held {
    /// Returns the support of the object at an end of a segment.
    fn rest(&self, end: MotionEnd, segment: &Segment) -> Option<Rest> {
        let Self { carrier, grip } = self;
        match end {
            MotionEnd::First => {
                Some(Rest { resting: carrier.resting().clone(), near: grip.cells()[0].clone() })
            }
            MotionEnd::Last => {
                let placement = carrier.placement(&carrier.held_at(grip, segment.waypoints.last()?));
                let near = placement.grip_near(grip).ok()?.cells()[0].clone();
                Some(Rest { resting: placement.resting, near })
            }
        }
    }
}

/// States along consecutive segments of a problem, up to the first impossible closing or opening of the hand.
#[derive(Clone, Debug)]
pub struct StateSequence {
    /// State along each segment, up to the first impossible one.
    pub states: Vec<State>,
    /// Problem of each pick, in order.
    pub picks: Vec<Problem>,
    /// State at the end of the last of these segments.
    pub end: State,
    /// Reason why the hand cannot close or open for the next segment, if it cannot.
    pub stopped: Option<FailureReason>,
}

impl StateSequence {
    /// Computes the states along segments of stages; `None` under `paper`, which has no world.
    ///
    /// # Errors
    /// [`TaskError::JointCount`] or [`TaskError::NotFinite`] for an invalid way point, and those of [`State::picking`].
    pub fn of(problem: &Problem, stages: &[Stage], segments: &[Segment]) -> Result<Option<Self>, TaskError> {
        Self::with_carrier(problem, stages, segments, None)
    }

    /// Computes [`Self::of`] with a known carrier of the first object ([`State::along`]).
    ///
    /// # Errors
    /// As [`Self::of`].
    pub fn with_carrier(
        problem: &Problem,
        stages: &[Stage],
        segments: &[Segment],
        first: Option<&Arc<Carrier>>,
    ) -> Result<Option<Self>, TaskError> {
        for q in segments.iter().flat_map(|segment| &segment.waypoints) {
            problem.check_configuration("way point", q)?;
        }
        let Some(mut now) = State::start(problem) else { return Ok(None) };
        let (mut states, mut picks, mut stopped) = (Vec::new(), Vec::new(), None);
        let mut stage = None;
        for segment in segments {
            if stage != Some(segment.stage)
                && let Some(Stage::Pick(pick)) = stages.get(segment.stage)
            {
                let picking = now.picking(problem, pick)?;
                now = now.before_picking(&picking);
                picks.push(picking);
            }
            stage = Some(segment.stage);
            match now.along(segment, first) {
                Ok(along) => {
                    now = along.after(segment);
                    states.push(along.keeping_straight(stages.get(segment.stage), segment)?);
                }
                Err(reason) => {
                    stopped = Some(reason);
                    break;
                }
            }
        }
        Ok(Some(Self { states, picks, end: now, stopped }))
    }
}
