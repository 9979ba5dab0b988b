use std::time::Instant;

use cranny_collision::{Cell, Scratch};
use cranny_grasp::GraspSet;
use cranny_robot::{IkSearch, IkSearchSettings};
use cranny_spatial::{Pose, Stream};

use crate::grasp_poses::all_open_poses;
use crate::{Problem, Statistics, ValidityScratch};

/// Goal configurations of a problem, found one at a time by inverse kinematics from random starts.
///
/// Grasps at which the hand alone collides are left out from the beginning: no arm can hold them.
pub(crate) struct GoalPool<'a> {
    problem: &'a Problem,
    poses: Vec<Pose>,
    search: IkSearch<'a>,
}

impl<'a> GoalPool<'a> {
    /// The pool of all poses of the grasps that the hand alone can take; `None` if there is none.
    pub fn new(problem: &'a Problem, cell: &Cell, grasps: &GraspSet, scratch: &mut Scratch) -> Option<Self> {
        let poses: Vec<Pose> =
            all_open_poses(cell, grasps, scratch).into_iter().map(|(_, pose)| pose).collect();
        let search = IkSearch::new(&problem.robot, poses.first()?, IkSearchSettings::default());
        Some(Self { problem, poses, search })
    }

    /// One attempt at a random pose; a configuration if it is free.
    pub fn draw(
        &mut self,
        random: &mut Stream,
        scratch: &mut ValidityScratch,
        statistics: &mut Statistics,
    ) -> Option<Vec<f64>> {
        let begin = Instant::now();
        let pose = self.poses[random.index(self.poses.len())];
        self.search.retarget(&pose);
        let mut is_free = |q: &[f64]| {
            statistics.collision_checks += 1;
            self.problem.validity.is_free(q, scratch)
        };
        let found = self.search.next_solution(random, 1, &mut is_free).map(|solution| solution.q.clone());
        statistics.ik_attempts += 1;
        statistics.goals_tried += u64::from(found.is_some());
        statistics.ik_time_s += begin.elapsed().as_secs_f64();
        found
    }
}
