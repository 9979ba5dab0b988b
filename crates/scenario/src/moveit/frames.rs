use std::collections::BTreeMap;

use cranny_robot::{Robot, VirtualJoint};
use cranny_spatial::Pose;

use crate::moveit::file::{HeaderEntry, SceneFile};
use crate::moveit::message_file::MessageFile;
use crate::{MoveItError, ScenarioError};

/// Frames in which poses can be given: the planning frame, fixed links, and frames that the scene fixes.
pub(crate) struct Frames {
    root_from_planning: Pose,
    root_from: BTreeMap<String, Pose>,
}

/// Planning frame of a robot without a virtual joint, unless the scene fixes another frame of that name.
const WORLD: &str = "world";

/// Returns the virtual joint between world and robot, if the SRDF has one.
pub(crate) fn base_joint(robot: &Robot) -> Option<&VirtualJoint> {
    let root = &robot.links()[robot.root()].name;
    robot.virtual_joints().iter().find(|joint| joint.child_link == *root)
}

/// Returns the names of the planning frame: the parent frame of the virtual joint, or else the root link and `world`.
pub(crate) fn planning_frames(robot: &Robot) -> Vec<&str> {
    match base_joint(robot) {
        Some(joint) => vec![&joint.parent_frame],
        None => vec![&robot.links()[robot.root()].name, WORLD],
    }
}

impl Frames {
    /// # Errors
    /// [`MoveItError::FrameTwice`] for a fixed transform that contradicts a known frame, [`MoveItError::UnknownFrame`].
    pub fn new(
        file: &MessageFile,
        scene: &SceneFile,
        robot: &Robot,
        world_from_root: &Pose,
    ) -> Result<Self, ScenarioError> {
        let rest = robot.frames();
        let still = (0..robot.links().len()).filter(|&link| robot.ancestors(link).is_empty());
        let root_from: BTreeMap<String, Pose> =
            still.map(|link| (robot.links()[link].name.clone(), *rest.link(link))).collect();
        let mut frames = Self { root_from_planning: world_from_root.inverse(), root_from };
        let transforms = &scene.fixed_frame_transforms;
        match base_joint(robot) {
            Some(joint) => frames.insert(&joint.parent_frame),
            None if transforms.iter().all(|entry| bare(&entry.child_frame_id.value) != WORLD) => {
                frames.insert(WORLD);
            }
            None => {}
        }
        for entry in transforms {
            let root_from_frame = frames.find(file, &entry.header)? * file.pose(&entry.transform)?;
            let name = bare(&entry.child_frame_id.value);
            let known = frames.root_from.entry(name.to_owned()).or_insert(root_from_frame);
            let apart = known.inverse() * root_from_frame;
            // The tolerance exceeds rounding of printed poses, in metres and radians.
            if apart.translation.vector.norm() > 1e-6 || apart.rotation.angle() > 1e-6 {
                let (at, frame) = (file.at(entry.child_frame_id.referenced), name.to_owned());
                return Err(MoveItError::FrameTwice { at, frame }.into());
            }
        }
        Ok(frames)
    }

    fn insert(&mut self, planning_frame: &str) {
        self.root_from.insert(bare(planning_frame).to_owned(), self.root_from_planning);
    }

    /// Returns `root_from_planning`, for poses without a frame.
    pub fn planning(&self) -> &Pose {
        &self.root_from_planning
    }

    /// Returns `root_from_frame`.
    pub fn find(&self, file: &MessageFile, header: &HeaderEntry) -> Result<Pose, ScenarioError> {
        let Some(frame) = header.frame_id.as_ref().filter(|frame| !bare(&frame.value).is_empty()) else {
            return Ok(self.root_from_planning);
        };
        let name = bare(&frame.value);
        self.root_from.get(name).copied().ok_or_else(|| {
            MoveItError::UnknownFrame {
                at: file.at(frame.referenced),
                frame: name.to_owned(),
                known: self.root_from.keys().cloned().collect::<Vec<_>>().join(", "),
            }
            .into()
        })
    }
}

/// Returns the name of a frame without the leading slash of older files.
pub(crate) fn bare(frame: &str) -> &str {
    frame.trim_start_matches('/')
}
