use cranny_robot::{Robot, VirtualJointKind};
use cranny_spatial::Pose;

use crate::moveit::file::StateEntry;
use crate::moveit::frames::{bare, planning_frames};
use crate::moveit::message_file::MessageFile;
use crate::{MoveItDeviation, MoveItError, ScenarioError};

/// Returns the pose of the robot's root in the planning frame: that of the first state with a floating joint.
///
/// # Errors
/// More than one joint, a joint of the URDF, one that is not a virtual joint of the SRDF, a pose in another frame, or a pose
/// outside the range of a planar joint.
pub(crate) fn world_from_root(
    states: &[(&MessageFile, &StateEntry)],
    robot: &Robot,
    deviations: &mut Vec<MoveItDeviation>,
) -> Result<Pose, ScenarioError> {
    for (file, state) in states {
        let Some(floating) = &state.multi_dof_joint_state else { continue };
        let (names, transforms) = (&floating.value.joint_names, &floating.value.transforms);
        if let [_, _, ..] = transforms[..] {
            let hint = "only the one between world and robot is read";
            return Err(file.unsupported(floating.referenced, "more than one floating joint", hint));
        }
        if names.len() != transforms.len() {
            let (at, kind) = (file.at(floating.referenced), "transforms");
            return Err(
                MoveItError::JointState { at, names: names.len(), kind, values: transforms.len() }.into()
            );
        }
        let ([name], [transform]) = (&names[..], &transforms[..]) else { continue };
        let planning = planning_frames(robot);
        if let Some(frame) = &floating.value.header.frame_id
            && !bare(&frame.value).is_empty()
            && !planning.iter().any(|known| bare(known) == bare(&frame.value))
        {
            let (at, known) = (file.at(frame.referenced), planning.join(", "));
            return Err(MoveItError::UnknownFrame { at, frame: frame.value.clone(), known }.into());
        }
        let pose = file.pose(transform)?;
        if robot.has_joint(name) || robot.has_joint(&format!("{name}/x")) {
            let hint = "give NAME/x and its other parts in joint_state";
            return Err(file.unsupported(transform.referenced, "a transform of a joint of the URDF", hint));
        }
        match robot.virtual_joints().iter().find(|joint| joint.name == *name).map(|joint| joint.kind) {
            Some(VirtualJointKind::Planar) if leaves_plane(&pose) => {
                let what = "a planar joint that leaves its plane";
                return Err(file.unsupported(transform.referenced, what, "give x, y and a turn about z"));
            }
            Some(VirtualJointKind::Planar | VirtualJointKind::Floating) => {}
            None if !robot.virtual_joints().is_empty() => {
                let known: Vec<&str> =
                    robot.virtual_joints().iter().map(|joint| joint.name.as_str()).collect();
                let (at, known) = (file.at(transform.referenced), known.join(", "));
                return Err(MoveItError::NoVirtualJoint { at, joint: name.clone(), known }.into());
            }
            Some(VirtualJointKind::Fixed) | None => {
                if pose != Pose::identity() {
                    deviations.push(MoveItDeviation::BasePlaced { joint: name.clone() });
                }
            }
        }
        return Ok(pose);
    }
    Ok(Pose::identity())
}

/// Returns true if a pose leaves the x-y plane by more than rounding.
fn leaves_plane(pose: &Pose) -> bool {
    let up = pose.rotation * cranny_spatial::Vector::z();
    pose.translation.z.abs() > 1e-6 || up.z < 1.0 - 1e-9
}
