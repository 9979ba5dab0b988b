use std::time::Instant;

use cranny_collision::{Cell, Collider, Contact, Scratch};
use cranny_grasp::GraspSet;
use cranny_robot::{IkSearch, IkSearchSettings};
use cranny_spatial::{Pose, Stream};

use crate::grasp_poses::poses;
use crate::{FailureReason, GraspFailure, Problem, Statistics};

/// Goal configurations of a problem, found one at a time by inverse kinematics from random starts.
///
/// A pose is left out once the hand alone was seen to collide there: no arm can hold it.
pub(crate) struct GoalPool<'a> {
    cell: &'a Cell,
    /// Grasps and poses not left out yet; the first so many are known to be open to the hand.
    poses: Vec<(usize, Pose)>,
    open: usize,
    search: IkSearch<'a>,
    records: Vec<Record>,
}

/// What was met at one grasp and its twin.
#[derive(Clone, Default)]
struct Record {
    attempts: u64,
    goals: u64,
    hand_contacts: usize,
    hand_contact: Option<Contact>,
    blocked: Vec<f64>,
}

impl<'a> GoalPool<'a> {
    /// The pool of all grasps and their twins.
    pub fn new(problem: &'a Problem, cell: &'a Cell, grasps: &GraspSet) -> Self {
        let both = |(index, grasp)| poses(grasp).map(|pose| (index, pose));
        Self {
            cell,
            poses: grasps.grasps().iter().enumerate().flat_map(both).collect(),
            open: 0,
            search: IkSearch::new(&problem.robot, &Pose::identity(), IkSearchSettings::default()),
            records: vec![Record::default(); grasps.len()],
        }
    }

    /// Whether the hand alone collides at every pose.
    pub fn is_hopeless(&self) -> bool {
        self.poses.is_empty()
    }

    /// One attempt at a random pose; a configuration if it is free.
    pub fn draw(
        &mut self,
        random: &mut Stream,
        scratch: &mut Scratch,
        statistics: &mut Statistics,
    ) -> Option<Vec<f64>> {
        let begin = Instant::now();
        let found = self.attempt(random, scratch, statistics);
        statistics.ik_time_s += begin.elapsed().as_secs_f64();
        found
    }

    fn attempt(
        &mut self,
        random: &mut Stream,
        scratch: &mut Scratch,
        statistics: &mut Statistics,
    ) -> Option<Vec<f64>> {
        let drawn = random.index(self.poses.len());
        let (grasp, pose) = self.poses[drawn];
        let record = &mut self.records[grasp];
        if drawn >= self.open {
            if let Some(contact) = self.cell.hand_contact(&pose, scratch) {
                record.hand_contacts += 1;
                record.hand_contact = Some(contact);
                self.poses.swap_remove(drawn);
                return None;
            }
            self.poses.swap(drawn, self.open);
            self.open += 1;
        }
        self.search.retarget(&pose);
        let mut is_free = |q: &[f64]| {
            statistics.collision_checks += 1;
            let is_free = self.cell.is_free(q, scratch);
            if !is_free {
                record.blocked.clear();
                record.blocked.extend_from_slice(q);
            }
            is_free
        };
        let found = self.search.next_solution(random, 1, &mut is_free).map(|solution| solution.q.clone());
        record.attempts += 1;
        record.goals += u64::from(found.is_some());
        statistics.ik_attempts += 1;
        statistics.goals_tried += u64::from(found.is_some());
        found
    }

    /// What stood between the robot and each grasp, as far as it was met.
    pub fn failures(&self, scratch: &mut Scratch) -> Vec<GraspFailure> {
        let failure = |(grasp, record): (usize, &Record)| {
            let reason = self.reason(record, scratch);
            GraspFailure { grasp, reason, attempts: record.attempts }
        };
        self.records.iter().enumerate().map(failure).collect()
    }

    fn reason(&self, record: &Record, scratch: &mut Scratch) -> FailureReason {
        let name = |collider: Collider| self.cell.name(collider).to_owned();
        if record.goals > 0 {
            return FailureReason::NotConnected { goals: record.goals };
        }
        if let Some(contact) = record.hand_contact.filter(|_| record.hand_contacts == 2) {
            return FailureReason::HandCollides { link: name(contact.first), body: name(contact.second) };
        }
        if record.attempts == 0 {
            return FailureReason::NotTried;
        }
        if record.blocked.is_empty() {
            return FailureReason::NoIk;
        }
        match self.cell.first_contact(&record.blocked, scratch) {
            Some(Contact { first, second: second @ Collider::Body(_), .. }) => {
                FailureReason::ArmCollides { link: name(first), body: name(second) }
            }
            Some(Contact { first, second, .. }) => {
                FailureReason::SelfCollision { first: name(first), second: name(second) }
            }
            None => FailureReason::NoIk,
        }
    }
}
