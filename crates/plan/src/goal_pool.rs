use std::time::Instant;

use cranny_collision::Cell;
use cranny_grasp::GraspSet;
use cranny_robot::{IkSearch, IkSearchSettings};
use cranny_spatial::Stream;

use crate::{Problem, Statistics, ValidityScratch};

/// Goal configurations of a problem, found one at a time by inverse kinematics from random starts.
///
/// Grasps at which the hand alone collides are left out from the beginning: no arm can hold them.
pub(crate) struct GoalPool<'a> {
    problem: &'a Problem,
    grasps: &'a GraspSet,
    reachable: Vec<usize>,
    search: IkSearch<'a>,
}

impl<'a> GoalPool<'a> {
    pub fn new(
        problem: &'a Problem,
        cell: &Cell,
        grasps: &'a GraspSet,
        scratch: &mut cranny_collision::Scratch,
    ) -> Self {
        let pose = |grasp: usize| &grasps.grasps()[grasp].world_from_gripper;
        let reachable =
            (0..grasps.len()).filter(|&grasp| cell.hand_is_free(pose(grasp), scratch)).collect::<Vec<_>>();
        let first = pose(reachable.first().copied().unwrap_or(0));
        let search = IkSearch::new(&problem.robot, first, IkSearchSettings::default());
        Self { problem, grasps, reachable, search }
    }

    /// Whether the hand alone collides at every grasp.
    pub fn is_hopeless(&self) -> bool {
        self.reachable.is_empty()
    }

    /// One attempt at a random grasp; a configuration if it is free.
    pub fn draw(
        &mut self,
        random: &mut Stream,
        scratch: &mut ValidityScratch,
        statistics: &mut Statistics,
    ) -> Option<Vec<f64>> {
        let begin = Instant::now();
        let grasp = self.reachable[random.index(self.reachable.len())];
        self.search.retarget(&self.grasps.grasps()[grasp].world_from_gripper);
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
