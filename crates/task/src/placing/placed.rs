use std::sync::Arc;

use cranny_collision::{Cell, Motion, Scratch};
use cranny_robot::{IkSettings, IkSolver};
use cranny_spatial::{Pose, Rotation, Vector};

use crate::FailureReason;
use crate::stages::straight::{FarEnd, straight_path};

/// Distance between two configurations of a retreat, and its greatest length, in metres.
const RUNG_M: f64 = 0.01;
pub(crate) const MOST_RETREAT_M: f64 = 0.5;

/// An object that was put down, and the world after that.
#[derive(Clone, Debug)]
pub struct Placed {
    /// Pose of the first solid of the object in the planning frame.
    pub world_from_held: Pose,
    pub(crate) target: usize,
    pub(crate) after: Arc<Cell>,
}

impl Placed {
    /// Creates the result for body `target`, put down in a cell with its first solid at a pose in the planning frame.
    pub fn of(after: &Arc<Cell>, target: usize, world_from_held: Pose) -> Self {
        Self { world_from_held, target, after: after.clone() }
    }

    /// Certified lower bound of the distance of the hand from the object at `q` (m, rad; one per joint), in metres, up to
    /// `beyond_m`.
    ///
    /// # Panics
    /// If `q` has not one value per joint.
    pub fn clearance_m(&self, q: &[f64], beyond_m: f64, scratch: &mut Scratch) -> f64 {
        self.after.hand_clearance(q, self.target, beyond_m, scratch)
    }

    /// Creates scratch for the empty hand.
    pub fn scratch(&self) -> Scratch {
        self.after.scratch()
    }

    /// Computes a path of way points (m, rad; one value per joint) on which the empty hand retreats from the object, from `q`
    /// on, until its distance is `clear_m` (m): back along its approach, up, or in a direction between. Its edges are straight
    /// and proven. If `straight_m` (m) is above 0, it goes only back along the approach, and at least over that length.
    ///
    /// # Errors
    /// Reason why no such path was found.
    ///
    /// # Panics
    /// If `q` has not one value per joint.
    pub fn retreat(&self, q: &[f64], clear_m: f64, straight_m: f64) -> Result<Vec<Vec<f64>>, FailureReason> {
        let mut scratch = self.after.scratch();
        let robot = self.after.robot();
        let back = robot.frames_at(q).link(robot.tip()).rotation * -Vector::z();
        let up = self.after.world().up();
        let mixed = (back + up).try_normalize(1e-6).unwrap_or(up);
        let mut reason = FailureReason::RetreatOutOfReach;
        if let Some(contact) = self.after.first_contact(q, &mut scratch) {
            let [first, second] = contact.names(&self.after);
            return Err(FailureReason::RetreatBlocked { first, second });
        }
        if straight_m > 0.0 {
            let is_clear = |q: &[f64]| self.clearance_m(q, clear_m, &mut scratch) >= clear_m;
            let path = straight_path(&self.after, q, (straight_m, FarEnd::Last), is_clear);
            return path.map_err(|blocked| match blocked {
                Some([first, second]) => FailureReason::RetreatBlocked { first, second },
                None => reason,
            });
        }
        for way in [back, mixed, up] {
            match self.retreated(q, &way, clear_m, &mut scratch) {
                Ok(path) => return Ok(path),
                Err(Some([first, second])) => reason = FailureReason::RetreatBlocked { first, second },
                Err(None) => {}
            }
        }
        Err(reason)
    }

    fn retreated(
        &self,
        q: &[f64],
        way: &Vector,
        clear_m: f64,
        scratch: &mut Scratch,
    ) -> Result<Vec<Vec<f64>>, Option<[String; 2]>> {
        let robot = self.after.robot();
        let world_from_tip = *robot.frames_at(q).link(robot.tip());
        let mut solver = IkSolver::new(robot, IkSettings::default());
        let (mut path, mut gone_m) = (vec![q.to_vec()], 0.0);
        while self.clearance_m(&path[path.len() - 1], clear_m, scratch) < clear_m {
            let last = &path[path.len() - 1];
            if gone_m >= MOST_RETREAT_M {
                return Err(None);
            }
            gone_m += RUNG_M;
            let target = Pose::from_parts((way * gone_m).into(), Rotation::identity()) * world_from_tip;
            let next = solver.step_from(&target, last).ok_or(None)?;
            match self.after.motion_is_free(last, &next, scratch) {
                Motion::Proven => path.push(next),
                Motion::Contact { contact, .. } | Motion::Unresolved { contact, .. } => {
                    return Err(Some(contact.names(&self.after)));
                }
                Motion::OutOfLimits { .. } | Motion::OutOfBounds { .. } => return Err(None),
            }
        }
        Ok(path)
    }
}
