use cranny_spatial::Pose;

use crate::chain::joint_step::Step;
use crate::{Hold, Robot};

/// Poses of all links of a robot, written by [`Robot::forward_kinematics`].
#[derive(Clone, Debug)]
pub struct LinkFrames {
    pub(crate) root_from_link: Vec<Pose>,
    /// Poses of the loose links in the tip frame ([`Robot::place_held`](crate::Robot::place_held)).
    pub(crate) loose: Vec<Pose>,
}

impl LinkFrames {
    /// Returns the pose of the link of this index in the root frame, `root_from_link`.
    ///
    /// # Panics
    /// If the robot of these frames has no such link.
    pub fn link(&self, index: usize) -> &Pose {
        &self.root_from_link[index]
    }

    /// The poses `root_from_link` of all links, in the order of [`Robot::links`].
    pub fn all(&self) -> &[Pose] {
        &self.root_from_link
    }
}

/// Links between two links of a robot, these included, but not their nearest common ancestor: their frames determine the pose
/// of the two links relative to each other.
#[derive(Clone, Debug)]
pub struct LinkPath {
    steps: Vec<Step>,
}

impl Robot {
    /// Returns frames of this robot at `q = 0` (which may lie outside its limits).
    pub fn frames(&self) -> LinkFrames {
        let mut frames = LinkFrames { root_from_link: self.rest.clone(), loose: Vec::new() };
        if let Some(loose) = &self.loose {
            frames.loose = vec![Pose::identity(); loose.len()];
            self.place_held(&Hold { tip_from_held: Pose::identity(), closing: 0.0 }, &mut frames);
        }
        frames
    }

    /// Returns the pose of every link at `q` (m, rad; one per joint). Use [`Self::forward_kinematics`] for repeated calls:
    /// it does not allocate.
    ///
    /// # Panics
    /// If `q` does not have [`dof`](Self::dof) values.
    pub fn frames_at(&self, q: &[f64]) -> LinkFrames {
        let mut frames = self.frames();
        self.forward_kinematics(q, &mut frames);
        frames
    }

    /// Writes the pose of every link at `q` (m, rad; one per joint) to `frames`. Every call computes all poses from `q`, so
    /// rounding errors do not accumulate. Limits are not checked.
    ///
    /// # Panics
    /// If `q` does not have [`dof`](Self::dof) values, or `frames` belong to another robot.
    pub fn forward_kinematics(&self, q: &[f64], frames: &mut LinkFrames) {
        assert_eq!(frames.root_from_link.len(), self.rest.len(), "frames of this robot");
        self.follow(&self.steps, q, frames);
    }

    /// Writes the poses of the links from the root to the tip at `q` (m, rad; one per joint); other frames stay unchanged.
    ///
    /// # Panics
    /// As [`Self::forward_kinematics`].
    pub fn tip_kinematics(&self, q: &[f64], frames: &mut LinkFrames) {
        self.follow(&self.tip_steps, q, frames);
    }

    /// Updates `frames` to `q` (m, rad; one per joint), given that only `joints` have changed since `frames` were computed.
    ///
    /// # Panics
    /// As [`Self::forward_kinematics`].
    pub fn update_kinematics(&self, q: &[f64], joints: &[usize], frames: &mut LinkFrames) {
        assert_eq!(q.len(), self.dof(), "one value for each joint of the group");
        let is_moved =
            |step: &&Step| self.movers[step.link].iter().any(|mover| joints.contains(&mover.joint));
        for step in self.steps.iter().filter(is_moved) {
            let LinkFrames { root_from_link, loose } = &mut *frames;
            root_from_link[step.link] = step.root_from_link(&root_from_link[step.parent], loose, q);
        }
    }

    /// Returns the path between two links, given by their indices.
    ///
    /// # Panics
    /// If the robot has no such links.
    pub fn path_between(&self, links: [usize; 2]) -> LinkPath {
        let [first, second] = links.map(|link| {
            let mut is_above = vec![false; self.links().len()];
            is_above[link] = true;
            // Each step follows that of its parent.
            for step in self.steps.iter().rev() {
                is_above[step.parent] |= is_above[step.link];
            }
            is_above
        });
        let steps = self.steps.iter().filter(|step| first[step.link] != second[step.link]).cloned().collect();
        LinkPath { steps }
    }

    /// Writes the poses of the links of a path at `q` (m, rad; one per joint); other frames stay unchanged. Relative to each
    /// other, the links at its ends are where [`Self::forward_kinematics`] places them, up to rounding.
    ///
    /// # Panics
    /// As [`Self::forward_kinematics`].
    pub fn path_kinematics(&self, path: &LinkPath, q: &[f64], frames: &mut LinkFrames) {
        self.follow(&path.steps, q, frames);
    }

    fn follow(&self, steps: &[Step], q: &[f64], frames: &mut LinkFrames) {
        assert_eq!(q.len(), self.dof(), "one value for each joint of the group");
        let LinkFrames { root_from_link, loose } = frames;
        for step in steps {
            root_from_link[step.link] = step.root_from_link(&root_from_link[step.parent], loose, q);
        }
    }
}
