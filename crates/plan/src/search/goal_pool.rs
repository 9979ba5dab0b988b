use std::time::Instant;

use cranny_collision::{Cell, Collider, Contact, Scratch};
use cranny_grasp::GraspSet;
use cranny_robot::{IK_BATCH, IkBatch, IkSettings, between};
use cranny_spatial::{EXACT_ROTATION_RAD, EXACT_TRANSLATION_M, Pose, Stream};
use cranny_task::{FailureReason, Goal, GraspFailure, GraspFilter, Problem, Region, gripper_poses};

use crate::search::grasp_source::GraspSource;
use crate::search::pose_source::PoseSource;
use crate::wall_clock::now;
use crate::{PlanError, Statistics};

/// Number of attempts per open pose before another pose is checked: they cost as much as finding an open pose.
const ATTEMPTS_PER_POSE: usize = 16;
/// Number of open poses found before the first attempt, so that it does not depend on a single one.
const FIRST_POSES: usize = 8;
/// Attempts per goal that delay the next batch by one iteration, once there is a goal.
const ATTEMPTS_PER_ITERATION: u64 = 8;
/// Angle between two poses of the hand as a distance: about the size of a hand, in metres per radian.
const METRES_PER_RADIAN: f64 = 0.1;
/// Maximum number of iterations between two batches.
const MOST_ITERATIONS: u64 = 8;

/// Goal configurations of a problem, found in batches by inverse kinematics from random starts.
///
/// 1. Poses are checked in random order, in proportion to the attempts made. A pose is open if the hand alone is free there and
///    it passes the filter of the problem; otherwise it is discarded. A source of grasps, or of poses of regions, adds poses.
/// 2. Each attempt of a batch goes to a random open pose, from its own start.
/// 3. A reached and free configuration is a goal. For grasps from a source the hand must also hold the target there. Joints
///    with a range of several turns are set near the start.
///
/// Until there is a goal, every iteration of a search runs a batch. Afterwards batches are rarer the more a goal costs, so that
/// neither the attempts nor the search takes all the time.
pub struct GoalPool<'a> {
    cell: &'a Cell,
    start: &'a [f64],
    /// Grasps and poses that are not discarded; the first `open` are known to be open.
    poses: Vec<(usize, Pose)>,
    open: usize,
    /// Source of further poses; `None` if all are given. They are recorded together, under number 0.
    source: Option<PoseSource<'a>>,
    batch: IkBatch<'a>,
    filter: Option<&'a GraspFilter>,
    attempts: u64,
    goals: u64,
    /// Iterations since the last batch.
    waited: u64,
    records: Vec<Record>,
    /// True for each free solution of the last batch.
    verdicts: Vec<bool>,
}

/// Results at one grasp and its twin.
#[derive(Clone, Default)]
struct Record {
    attempts: u64,
    goals: u64,
    hand_contacts: usize,
    hand_contact: Option<Contact>,
    /// Poses of the grasp and of its twin at which the hand alone collides.
    blocked_poses: Vec<Pose>,
    blocked: Vec<f64>,
    /// Reason for exclusion: from the beginning, or by the filter of the problem.
    excluded: Option<FailureReason>,
}

impl<'a> GoalPool<'a> {
    /// Returns the pool of a problem; `None` if its goals are configurations.
    ///
    /// # Errors
    /// [`PlanError`] for a problem under a criterion other than `exact`.
    pub fn of(problem: &'a Problem) -> Result<Option<Self>, PlanError> {
        let cell = problem.exact_cell("reach")?;
        if let Some(measure) = problem.grasp_measure() {
            return Ok(Some(Self::sampling(problem, cell, GraspSource::new(measure, 0.5)?)));
        }
        Ok(match problem.goal() {
            Goal::Grasps(grasps) => Some(Self::new(problem, cell, grasps)),
            Goal::Regions(regions) => Some(Self::of_regions(problem, cell, regions)),
            Goal::Configurations(_) => None,
        })
    }

    /// Creates the pool of all grasps and their twins.
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

    /// Creates the pool of poses of the hand in regions; there is at least one.
    pub(crate) fn of_regions(problem: &'a Problem, cell: &'a Cell, regions: &'a [Region]) -> Self {
        Self::with_source(problem, cell, PoseSource::Regions(regions, 0))
    }

    /// Creates the pool of the grasps from a source.
    pub(crate) fn sampling(problem: &'a Problem, cell: &'a Cell, source: GraspSource<'a>) -> Self {
        Self::with_source(problem, cell, PoseSource::Grasps(Box::new(source)))
    }

    fn with_source(problem: &'a Problem, cell: &'a Cell, source: PoseSource<'a>) -> Self {
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

    /// Creates scratch for this pool.
    pub(crate) fn scratch(&self) -> Scratch {
        self.cell.scratch()
    }

    /// Returns true if the hand alone collides at every pose.
    pub fn is_hopeless(&self) -> bool {
        self.poses.is_empty() && self.source.is_none()
    }

    /// Returns the goals (m, rad; one value per joint) of one more iteration of the search, each with its grasp.
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

    /// Returns the goals (m, rad; one value per joint) of one more batch, each with its grasp. Every second attempt starts at a
    /// random point of the path, if there is one.
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
            statistics.ik_time_s += begin.elapsed().as_secs_f64();
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
        self.run_batch(grasps, begin, scratch, statistics)
    }

    /// Returns the goals (m, rad; one value per joint) of one batch at the open grasps nearest to the pose of the hand at `q`, from
    /// where each attempt begins, each with its grasp, the nearest first; none for a source of grasps or regions.
    pub(crate) fn draw_near(
        &mut self,
        q: &[f64],
        scratch: &mut Scratch,
        statistics: &mut Statistics,
    ) -> Vec<(usize, Vec<f64>)> {
        let begin = now();
        let frames = self.cell.robot().frames_at(q);
        let at = frames.link(self.cell.robot().tip());
        let apart = |pose: &Pose| {
            let shift_m = (pose.translation.vector - at.translation.vector).norm();
            shift_m + METRES_PER_RADIAN * pose.rotation.angle_to(&at.rotation)
        };
        let mut nearest: Vec<(f64, usize, Pose)> =
            self.poses.iter().map(|(grasp, pose)| (apart(pose), *grasp, *pose)).collect();
        nearest.sort_by(|a, b| a.0.total_cmp(&b.0));
        let is_open = |pose: &Pose, scratch: &mut Scratch| {
            self.cell.hand_contact(pose, scratch).is_none()
                && self.filter.is_none_or(|filter| filter.fault_of(pose).is_none())
        };
        let mut chosen: Vec<(usize, Pose)> = Vec::new();
        for (_, grasp, pose) in nearest {
            if chosen.len() == IK_BATCH {
                break;
            }
            if is_open(&pose, scratch) {
                chosen.push((grasp, pose));
            }
        }
        if chosen.is_empty() {
            return Vec::new();
        }
        for (attempt, (_, pose)) in chosen.iter().cycle().take(IK_BATCH).enumerate() {
            self.batch.begin_at(attempt, pose, q);
        }
        let grasps = std::array::from_fn(|attempt| chosen[attempt % chosen.len()].0);
        self.waited = 0;
        self.run_batch(grasps, begin, scratch, statistics)
    }

    /// Runs the attempts of a batch for these grasps, and returns the goals.
    fn run_batch(
        &mut self,
        grasps: [usize; IK_BATCH],
        begin: Instant,
        scratch: &mut Scratch,
        statistics: &mut Statistics,
    ) -> Vec<(usize, Vec<f64>)> {
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
            } else if self.source.as_mut().is_none_or(|source| source.accepts(&q)) {
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

    /// Searches for open poses until their number matches the attempts.
    fn open_poses(&mut self, random: &mut Stream, scratch: &mut Scratch) {
        let wanted = FIRST_POSES + usize::try_from(self.attempts).unwrap_or(usize::MAX) / ATTEMPTS_PER_POSE;
        if let Some(source) = &mut self.source {
            source.begin_batch(self.goals);
        }
        while self.open < wanted {
            if self.open == self.poses.len() {
                let Some(poses) = self.source.as_mut().and_then(|source| source.draw(random)) else { break };
                self.poses.extend(poses.into_iter().map(|pose| (0, pose)));
            }
            let drawn = self.open + random.index(self.poses.len() - self.open);
            let (grasp, pose) = self.poses[drawn];
            if let Some(contact) = self.cell.hand_contact(&pose, scratch) {
                let record = &mut self.records[grasp];
                record.hand_contacts += 1;
                record.hand_contact = Some(contact);
                if self.source.is_none() {
                    record.blocked_poses.push(pose);
                }
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

    /// Returns the reason for the failure of each given grasp; for a source of grasps, one reason for all of them, if it drew any;
    /// none for regions.
    pub fn failures(&self, scratch: &mut Scratch) -> Vec<GraspFailure> {
        if matches!(self.source, Some(PoseSource::Regions(..))) {
            return Vec::new();
        }
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
            let is_blocked = |pose: &Pose| {
                self.cell.hand_is_blocked_near(pose, (EXACT_TRANSLATION_M, EXACT_ROTATION_RAD), 1, scratch)
            };
            let is_proven = self.source.is_none() && record.blocked_poses.iter().all(is_blocked);
            return FailureReason::HandCollides { link, body, is_proven };
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
