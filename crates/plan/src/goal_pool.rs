use std::time::Instant;

use cranny_collision::{Cell, Scratch};
use cranny_grasp::GraspSet;
use cranny_robot::{IkSearch, IkSearchSettings};
use cranny_spatial::{Pose, Stream};

use crate::grasp_poses::poses;
use crate::{Problem, Statistics};

/// Goal configurations of a problem, found one at a time by inverse kinematics from random starts.
///
/// A pose is left out once the hand alone was seen to collide there: no arm can hold it.
pub(crate) struct GoalPool<'a> {
    cell: &'a Cell,
    /// Poses not left out yet; the first so many are known to be open to the hand.
    poses: Vec<Pose>,
    open: usize,
    search: IkSearch<'a>,
}

impl<'a> GoalPool<'a> {
    /// The pool of all grasps and their twins.
    pub fn new(problem: &'a Problem, cell: &'a Cell, grasps: &GraspSet) -> Self {
        let search = IkSearch::new(&problem.robot, &Pose::identity(), IkSearchSettings::default());
        Self { cell, poses: grasps.grasps().iter().flat_map(poses).collect(), open: 0, search }
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
        let pose = self.poses[drawn];
        if drawn >= self.open {
            if !self.cell.hand_is_free(&pose, scratch) {
                self.poses.swap_remove(drawn);
                return None;
            }
            self.poses.swap(drawn, self.open);
            self.open += 1;
        }
        self.search.retarget(&pose);
        let mut is_free = |q: &[f64]| {
            statistics.collision_checks += 1;
            self.cell.is_free(q, scratch)
        };
        let found = self.search.next_solution(random, 1, &mut is_free).map(|solution| solution.q.clone());
        statistics.ik_attempts += 1;
        statistics.goals_tried += u64::from(found.is_some());
        found
    }
}
