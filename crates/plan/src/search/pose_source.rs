use cranny_collision::{Cell, Scratch};
use cranny_spatial::{Pose, Stream};
use cranny_task::{Region, gripper_poses};

use crate::search::grasp_source::GraspSource;

/// Maximum number of poses drawn from regions per batch of inverse kinematics: about 1 ms if the hand nearly always collides.
const DRAWS_PER_BATCH: usize = 128;

/// Source of poses of the gripper, drawn as a search needs them.
pub(crate) enum PoseSource<'a> {
    /// Grasps on the target, each with its twin.
    Grasps(Box<GraspSource<'a>>),
    /// Regions, one of which is chosen for each pose ([`Region::choose`]), and the draws left in the batch.
    Regions(&'a [Region], usize),
}

impl PoseSource<'_> {
    /// Begins a new batch, with `goals` goals found before.
    pub fn begin_batch(&mut self, goals: u64) {
        match self {
            Self::Grasps(grasps) => grasps.begin_batch(goals),
            Self::Regions(_, left) => *left = DRAWS_PER_BATCH,
        }
    }

    /// Draws one more pose or two twins, as `world_from_gripper`; `None` if the batch has no draws left.
    pub fn draw(&mut self, random: &mut Stream) -> Option<Vec<Pose>> {
        match self {
            Self::Grasps(grasps) => Some(gripper_poses(&grasps.draw(random)?).to_vec()),
            Self::Regions(regions, left) => {
                *left = left.checked_sub(1)?;
                let chosen = Region::choose(regions, random);
                Some(vec![regions[chosen].draw(random)])
            }
        }
    }

    /// Returns true if a configuration (m, rad; one per joint) at such a pose is a goal.
    pub fn accepts(&mut self, q: &[f64]) -> bool {
        match self {
            Self::Grasps(grasps) => grasps.holds(q),
            Self::Regions(..) => true,
        }
    }
}

/// Draws poses of regions for planners that choose among a list of goals: returns those at which the hand alone is free.
pub(crate) fn open_region_poses(
    cell: &Cell,
    regions: &[Region],
    random: &mut Stream,
    scratch: &mut Scratch,
) -> Vec<(usize, Pose)> {
    /// As many as the goals that suffice for planners with all goals at once.
    const OPEN: usize = 100;
    const DRAWS: usize = 2000;
    let mut open = Vec::new();
    for _ in 0..DRAWS {
        let chosen = Region::choose(regions, random);
        let pose = regions[chosen].draw(random);
        if cell.hand_is_free(&pose, scratch) {
            open.push((open.len(), pose));
        }
        if open.len() == OPEN {
            break;
        }
    }
    open
}
