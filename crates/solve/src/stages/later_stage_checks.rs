use std::sync::Arc;

use cranny_collision::Cell;
use cranny_plan::PlanError;
use cranny_spatial::Pose;
use cranny_task::{Carrier, LiftOffSettings, Pick, Placement, Placer, Problem, Stage, State};

/// Maximum number of sampled placements of each later object.
const DRAWS: u32 = 64;
/// Maximum number of evaluated placements of later objects for one placement.
const MOST_LOOKS: u32 = 400;

/// Necessary conditions for the following picks and placements, without inverse kinematics.
pub(crate) struct LaterStageChecks {
    problem: Problem,
    /// Later picks in the order of the task, from the second pick on.
    nexts: Vec<Next>,
}

/// A later pick.
struct Next {
    /// Index of the pick among the stages.
    stage: usize,
    pick: Pick,
    body: usize,
    /// True if one of the given grasps has to be free.
    has_grasps: bool,
    /// Carrier of the object as it stands at the start, and its placer if it is put down.
    carrier: Carrier,
    placer: Option<Placer>,
}

impl LaterStageChecks {
    /// Creates these conditions for the stages of a task; computes everything that does not depend on the world.
    ///
    /// # Errors
    /// Those of [`State::picking`] and [`Placer::new`].
    pub fn new(problem: &Problem, stages: &[Stage], start: &State, seed: u64) -> Result<Self, PlanError> {
        let mut picks = stages.iter().enumerate().filter(|(_, stage)| !matches!(stage, Stage::Move(_)));
        let mut nexts = Vec::new();
        picks.find(|(_, stage)| matches!(stage, Stage::Pick(_)));
        while let Some((stage, of)) = picks.next() {
            let Stage::Pick(pick) = of else { continue };
            let picking = start.picking(problem, pick)?;
            let Ok(carrier) = Carrier::new(&picking, LiftOffSettings::default()) else { break };
            let placer = match picks.clone().next() {
                Some((_, Stage::Place(place))) => {
                    let placer = Placer::new(problem, &carrier, place)?;
                    Some(placer.with_aligned_draws(seed, DRAWS))
                }
                _ => None,
            };
            let (pick, body) = (pick.clone(), pick.body(problem)?);
            let has_grasps = problem.target() == Some(body) && problem.grasps().is_some();
            nexts.push(Next { stage, pick, body, has_grasps, carrier, placer });
        }
        Ok(Self { problem: problem.clone(), nexts })
    }

    /// Returns true if an object is picked after a stage.
    pub fn is_needed_after(&self, stage: usize) -> bool {
        self.nexts.last().is_some_and(|next| next.stage > stage)
    }

    /// Returns true if the later picks and placements pass all checks once the object of a carrier stands at a placement of a
    /// stage. Returns false if one fails, or if the checks exceed the number `looks`.
    pub fn is_hopeful(
        &self,
        (stage, carrier): (usize, &Carrier),
        placement: &Placement,
        looks: &mut u32,
    ) -> bool {
        let after = self.nexts.partition_point(|next| next.stage <= stage);
        let mut own = MOST_LOOKS.min(*looks);
        *looks -= own;
        let fits = own > 0 && self.fits(&self.nexts[after..], carrier, &placement.world_from_held, &mut own);
        *looks += own;
        fits
    }

    /// Returns true if all these objects can be grasped and placed once the object of a carrier is released at this pose.
    fn fits(&self, nexts: &[Next], carrier: &Carrier, world_from_held: &Pose, looks: &mut u32) -> bool {
        let Some((next, later)) = nexts.split_first() else { return true };
        let start = self.problem.start();
        let Ok(placed) = State::after_letting_go(carrier, world_from_held, start) else { return false };
        if next.has_grasps {
            let picking = placed.picking(&self.problem, &next.pick);
            if !picking.is_ok_and(|picking| picking.may_be_grasped()) {
                return false;
            }
        }
        let Some(placer) = &next.placer else { return true };
        let Ok(carrier) = next.carrier.with_surroundings_of(&to_grasp(placed.empty_cell(), next.body)) else {
            return false;
        };
        let placer = placer.with_surroundings_of(&carrier);
        placer.placements().any(|(_, placement)| {
            *looks = looks.saturating_sub(1);
            *looks > 0 && self.fits(later, &carrier, &placement.world_from_held, looks)
        })
    }
}

fn to_grasp(cell: &Arc<Cell>, body: usize) -> Arc<Cell> {
    cell.to_grasp(body, cell.margins()).ok().flatten().map_or_else(|| cell.clone(), Arc::new)
}
