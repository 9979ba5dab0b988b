use cranny_collision::{Cell, Collider, Contact, Scratch};
use cranny_grasp::GraspSet;
use cranny_robot::{IK_BATCH, IkBatch, IkSettings, between};
use cranny_spatial::{Pose, Stream};
use cranny_task::{FailureReason, GraspFailure, GraspFilter, Problem, gripper_poses};

use crate::search::grasp_source::GraspSource;
use crate::wall_clock::now;
use crate::{PlanError, Statistics};

/// Attempts to a pose that is known to be open to the hand, before another pose is checked: so many cost
/// as much as looking at poses until the hand is free at one.
const ATTEMPTS_PER_POSE: usize = 16;
/// Poses that are checked before the first attempt, so that it does not all hang on one.
const FIRST_POSES: usize = 8;
/// Once there is a goal, a batch is due every so many iterations for each … attempts that a goal costs:
const ATTEMPTS_PER_ITERATION: u64 = 8;
/// … and at the latest after so many.
const MOST_ITERATIONS: u64 = 8;

/// Goal configurations of a problem, found in batches by inverse kinematics from random starts.
///
/// 1. Poses are opened in random order, the more the more attempts were made. One at which the hand alone
///    collides is left out for good: no arm can hold it; and one that will not do for what is to follow. Where there is a
///    source of grasps, it brings new ones.
/// 2. Each attempt of a batch goes to any open pose, from a start of its own.
/// 3. What is reached and free is a goal, unless the hand holds nothing there, which is asked where the grasps come from a
///    source; joints that can stand several turns apart stand near the start's.
///
/// Until there is a goal, every iteration of a search runs a batch; then the fewer the more goals cost, so
/// that neither the attempts nor the search takes all the time.
pub struct GoalPool<'a> {
    cell: &'a Cell,
    start: &'a [f64],
    /// Grasps and poses not left out yet; the first so many are known to be open to the hand.
    poses: Vec<(usize, Pose)>,
    open: usize,
    /// Where more grasps come from; `None` where all are given. Of its grasps no account is kept: all are number 0.
    source: Option<GraspSource<'a>>,
    batch: IkBatch<'a>,
    filter: Option<&'a GraspFilter>,
    attempts: u64,
    goals: u64,
    /// Iterations since the last batch.
    waited: u64,
    records: Vec<Record>,
    /// Whether the solutions of the last batch are free.
    verdicts: Vec<bool>,
}

/// What was met at one grasp and its twin.
#[derive(Clone, Default)]
struct Record {
    attempts: u64,
    goals: u64,
    hand_contacts: usize,
    hand_contact: Option<Contact>,
    blocked: Vec<f64>,
    /// Why it is left out: from the beginning, or by the filter of the problem.
    excluded: Option<FailureReason>,
}

impl<'a> GoalPool<'a> {
    /// The pool of a problem; none where its goals are configurations.
    ///
    /// # Errors
    /// [`PlanError`] for a problem under another criterion than `exact`.
    pub fn of(problem: &'a Problem) -> Result<Option<Self>, PlanError> {
        let cell = problem.exact_cell("reach")?;
        if let Some(measure) = problem.grasp_measure() {
            return Ok(Some(Self::sampling(problem, cell, GraspSource::new(measure, 0.5)?)));
        }
        Ok(problem.grasps().map(|grasps| Self::new(problem, cell, grasps)))
    }

    /// The pool of all grasps and their twins.
    pub fn new(problem: &'a Problem, cell: &'a Cell, grasps: &GraspSet) -> Self {
        let given = grasps.grasps();
        let excluded: Vec<_> =
            given.iter().map(|grasp| FailureReason::of_width(cell.robot(), grasp)).collect();
        let fitting = given.iter().enumerate().filter(|(index, _)| excluded[*index].is_none());
        let poses =
            fitting.flat_map(|(index, grasp)| gripper_poses(grasp).map(|pose| (index, pose))).collect();
        let records = excluded.into_iter().map(|excluded| Record { excluded, ..Record::default() }).collect();
        Self { poses, records, ..Self::empty(problem, cell) }
    }

    /// The pool of the grasps that a source brings.
    pub(crate) fn sampling(problem: &'a Problem, cell: &'a Cell, source: GraspSource<'a>) -> Self {
        Self { source: Some(source), records: vec![Record::default()], ..Self::empty(problem, cell) }
    }

    fn empty(problem: &'a Problem, cell: &'a Cell) -> Self {
        Self {
            cell,
            start: problem.start(),
            poses: Vec::new(),
            open: 0,
            source: None,
            filter: problem.grasp_filter(),
            batch: IkBatch::new(problem.robot(), IkSettings::default()),
            attempts: 0,
            goals: 0,
            waited: 0,
            records: Vec::new(),
            verdicts: Vec::new(),
        }
    }

    /// Whether the hand alone collides at every pose.
    pub fn is_hopeless(&self) -> bool {
        self.poses.is_empty() && self.source.is_none()
    }

    /// The goals (m, rad; one value per joint) that one more iteration of the search brings, each with its grasp.
    pub fn draw(
        &mut self,
        random: &mut Stream,
        scratch: &mut Scratch,
        statistics: &mut Statistics,
    ) -> Vec<(usize, Vec<f64>)> {
        self.waited += 1;
        if !self.is_due() {
            return Vec::new();
        }
        self.draw_batch(&[], random, scratch, statistics)
    }

    /// The goals (m, rad; one value per joint) of one more batch, each with its grasp; with a path, every other
    /// attempt starts at a random point of it.
    pub fn draw_batch(
        &mut self,
        path: &[Vec<f64>],
        random: &mut Stream,
        scratch: &mut Scratch,
        statistics: &mut Statistics,
    ) -> Vec<(usize, Vec<f64>)> {
        let begin = now();
        self.waited = 0;
        // 1.
        self.open_poses(random, scratch);
        if self.open == 0 {
            return Vec::new();
        }
        // 2.
        let grasps: [usize; IK_BATCH] = std::array::from_fn(|attempt| {
            let (grasp, pose) = &self.poses[random.index(self.open)];
            if path.len() > 1 && attempt % 2 == 0 {
                let edge = random.index(path.len() - 1);
                let start: Vec<f64> = between(&path[edge], &path[edge + 1], random.uniform()).collect();
                self.batch.begin_at(attempt, pose, &start);
            } else {
                self.batch.draw(attempt, pose, random);
            }
            *grasp
        });
        self.batch.run(IK_BATCH);
        // 3.
        let solutions: Vec<(usize, Vec<f64>)> = grasps
            .into_iter()
            .enumerate()
            .filter_map(|(attempt, grasp)| Some((grasp, self.batch.solution(attempt)?.q)))
            .map(|(grasp, mut q)| {
                self.cell.robot().turn_towards(self.start, &mut q);
                (grasp, q)
            })
            .collect();
        for grasp in grasps {
            self.records[grasp].attempts += 1;
        }
        let rows: Vec<f64> = solutions.iter().flat_map(|(_, q)| q).copied().collect();
        self.cell.are_free(&rows, scratch, &mut self.verdicts);
        statistics.collision_checks += solutions.len() as u64;
        let mut goals = Vec::new();
        for ((grasp, q), is_free) in solutions.into_iter().zip(&self.verdicts) {
            let record = &mut self.records[grasp];
            if !is_free {
                record.blocked = q;
            } else if self.source.as_mut().is_none_or(|source| source.holds(&q)) {
                record.goals += 1;
                goals.push((grasp, q));
            }
        }
        self.attempts += IK_BATCH as u64;
        self.goals += goals.len() as u64;
        statistics.ik_attempts = self.attempts;
        statistics.goals_tried = self.goals;
        statistics.ik_time_s += begin.elapsed().as_secs_f64();
        goals
    }

    fn is_due(&self) -> bool {
        self.goals == 0
            || self.waited >= MOST_ITERATIONS
            || self.waited * ATTEMPTS_PER_ITERATION * self.goals >= self.attempts
    }

    /// Looks for poses that are open to the hand until there are as many as the attempts so far deserve.
    fn open_poses(&mut self, random: &mut Stream, scratch: &mut Scratch) {
        let wanted = FIRST_POSES + usize::try_from(self.attempts).unwrap_or(usize::MAX) / ATTEMPTS_PER_POSE;
        if let Some(source) = &mut self.source {
            source.begin_batch(self.goals);
        }
        while self.open < wanted {
            if self.open == self.poses.len() {
                let Some(poses) = self.source.as_mut().and_then(|source| source.draw(random)) else { break };
                self.poses.extend(poses.map(|pose| (0, pose)));
            }
            let drawn = self.open + random.index(self.poses.len() - self.open);
            let (grasp, pose) = self.poses[drawn];
            if let Some(contact) = self.cell.hand_contact(&pose, scratch) {
                let record = &mut self.records[grasp];
                record.hand_contacts += 1;
                record.hand_contact = Some(contact);
                self.poses.swap_remove(drawn);
            } else if let Some(reason) = self.filter.and_then(|filter| filter.fault_of(&pose)) {
                self.records[grasp].excluded = Some(reason);
                self.poses.swap_remove(drawn);
            } else {
                self.poses.swap(drawn, self.open);
                self.open += 1;
            }
        }
    }

    /// Obstacle between the robot and each grasp that was given, as far as it was met; of those from a source the last that
    /// was met at any, as one.
    pub fn failures(&self, scratch: &mut Scratch) -> Vec<GraspFailure> {
        if self.source.is_some()
            && self.records.iter().all(|record| record.hand_contacts == 0 && record.attempts == 0)
        {
            return Vec::new();
        }
        let failure = |(grasp, record): (usize, &Record)| {
            let reason = self.reason(record, scratch);
            GraspFailure { grasp, reason, attempts: record.attempts }
        };
        self.records.iter().enumerate().map(failure).collect()
    }

    fn reason(&self, record: &Record, scratch: &mut Scratch) -> FailureReason {
        if let Some(excluded) = &record.excluded {
            return excluded.clone();
        }
        if record.goals > 0 {
            return FailureReason::NotConnected { goals: record.goals };
        }
        let is_hand_blocked =
            if self.source.is_some() { record.attempts == 0 } else { record.hand_contacts == 2 };
        if let Some(contact) = record.hand_contact.filter(|_| is_hand_blocked) {
            let [link, body] = contact.names(self.cell);
            return FailureReason::HandCollides { link, body };
        }
        if record.attempts == 0 {
            return FailureReason::NotTried;
        }
        if record.blocked.is_empty() {
            return FailureReason::NoIk;
        }
        let Some(contact) = self.cell.first_contact(&record.blocked, scratch) else {
            let bound = self.cell.first_bound_exceeded(&record.blocked, scratch);
            return bound.map_or(FailureReason::NoIk, |bound| FailureReason::OutOfBounds { bound });
        };
        let [first, second] = contact.names(self.cell);
        match contact.second {
            Collider::Body(_) => FailureReason::ArmCollides { link: first, body: second },
            Collider::Link(_) => FailureReason::SelfCollision { first, second },
        }
    }
}
