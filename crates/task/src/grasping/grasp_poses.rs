use cranny_collision::{Cell, Contact, Scratch};
use cranny_grasp::{Grasp, GraspSet};
use cranny_spatial::Pose;

use crate::FailureReason;

/// Returns the two poses of the gripper frame of a grasp in the planning frame: the grasp and its twin with the fingers
/// swapped. Within its joint limits an arm may reach only one of them.
pub fn gripper_poses(grasp: &Grasp) -> [Pose; 2] {
    [grasp.world_from_gripper, grasp.twin().world_from_gripper]
}

/// Returns those poses of a grasp and its twin at which the hand alone is free; if there are none, the contact at the grasp.
pub(crate) fn open_poses(cell: &Cell, grasp: &Grasp, scratch: &mut Scratch) -> Result<Vec<Pose>, Contact> {
    let mut blocked = None;
    let mut open = Vec::new();
    for pose in gripper_poses(grasp) {
        match cell.hand_contact(&pose, scratch) {
            Some(contact) => blocked = blocked.or(Some(contact)),
            None => open.push(pose),
        }
    }
    match blocked {
        Some(contact) if open.is_empty() => Err(contact),
        _ => Ok(open),
    }
}

/// Returns all free poses of the hand alone (gripper frame in the planning frame) with their grasps, by descending score.
pub fn open_gripper_poses(cell: &Cell, grasps: &GraspSet, scratch: &mut Scratch) -> Vec<(usize, Pose)> {
    let mut all = Vec::new();
    let fits = |index: &usize| FailureReason::of_width(cell.robot(), &grasps.grasps()[*index]).is_none();
    for index in grasps.by_score().into_iter().filter(fits) {
        let open = open_poses(cell, &grasps.grasps()[index], scratch).unwrap_or_default();
        all.extend(open.into_iter().map(|pose| (index, pose)));
    }
    all
}
