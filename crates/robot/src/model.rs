use std::any::Any;
use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

use cranny_spatial::Pose;

use crate::chain::derived::Derived;
use crate::chain::joint_group::JointValue;
use crate::chain::joint_step::Step;
use crate::gripper::loose_links::LooseLinks;
use crate::link::{GroupJoint, Link, Mover};
use crate::{JointLimits, LimitViolation, RobotError, RobotHand, ToolDescription, VirtualJoint};

/// A robot: a tree of links, and a group of joints that moves them. Immutable; share it by reference or in an `Arc`.
///
/// The root link is the planning frame, and `q` contains one value per joint of the group, in metres or radians. Joints outside
/// the group have fixed values.
#[derive(Clone, Debug)]
pub struct Robot {
    pub(crate) name: String,
    pub(crate) links: Vec<Link>,
    pub(crate) links_by_name: HashMap<String, usize>,
    pub(crate) joints: Vec<GroupJoint>,
    pub(crate) joint_names: Vec<String>,
    pub(crate) limits: Vec<JointLimits>,
    pub(crate) joint_reaches: Vec<f64>,
    /// True for each joint of the group that can turn by 2π without moving any link.
    pub(crate) full_turns: Vec<bool>,
    /// True for each joint of the group that turns without end: see [`Robot::wrap_towards`].
    pub(crate) endless: Vec<bool>,
    pub(crate) tip: usize,
    pub(crate) hand_links: Vec<usize>,
    pub(crate) hand: Option<RobotHand>,
    pub(crate) tool: Option<ToolDescription>,
    pub(crate) start: Option<Vec<f64>>,
    pub(crate) floor_m: Option<f64>,
    pub(crate) notes: Vec<String>,
    /// Per link.
    pub(crate) movers: Vec<Vec<Mover>>,
    pub(crate) disabled_pairs: Vec<(usize, usize)>,
    pub(crate) adjacent_pairs: Vec<(usize, usize)>,
    pub(crate) group_states: Vec<(String, Vec<f64>)>,
    /// Value of every joint of the URDF, by name.
    pub(crate) values: BTreeMap<String, JointValue>,
    pub(crate) virtual_joints: Vec<VirtualJoint>,
    pub(crate) passive_joints: Vec<String>,
    /// Forward kinematics of every moving link, parents first.
    pub(crate) steps: Vec<Step>,
    /// Elements of `steps` that lead to the tip.
    pub(crate) tip_steps: Vec<Step>,
    /// `root_from_link` of all links at `q = 0`; constant for links that do not move.
    pub(crate) rest: Vec<Pose>,
    /// Links posed by a `Hold`, if the robot holds an object.
    pub(crate) loose: Option<LooseLinks>,
    pub(crate) derived: Derived,
}

impl Robot {
    /// Name from the URDF.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Returns this robot with further notes in front of its own.
    #[must_use]
    pub fn with_notes(mut self, notes: Vec<String>) -> Self {
        self.notes.splice(0..0, notes);
        self
    }

    /// Content of the URDF that was not read, one line for each kind with its file and line. None of it affects geometry or
    /// motion, except as its line states: other such content would be an error.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// All links, parents before children; the root is the first.
    pub fn links(&self) -> &[Link] {
        &self.links
    }

    /// Returns the index of the link named `name`.
    pub fn link_index(&self, name: &str) -> Option<usize> {
        self.links_by_name.get(name).copied()
    }

    /// Returns the number of joints of the group, which is the length of `q`.
    pub fn dof(&self) -> usize {
        self.joints.len()
    }

    /// The joints of the group, in the order of `q`.
    pub fn joints(&self) -> &[GroupJoint] {
        &self.joints
    }

    /// Names of the joints of the group, in the order of `q`.
    pub fn joint_names(&self) -> &[String] {
        &self.joint_names
    }

    /// Limits of the joints of the group, in the order of `q`.
    pub fn limits(&self) -> &[JointLimits] {
        &self.limits
    }

    /// Returns this robot with the limits of the joint of index `joint` narrowed to [`lower`, `upper`], in m or rad. If the
    /// two ranges are disjoint, no value is within the limits.
    #[must_use]
    pub fn with_joint_between(mut self, joint: usize, lower: f64, upper: f64) -> Self {
        let limits = &mut self.limits[joint];
        (limits.lower, limits.upper) = (limits.lower.max(lower), limits.upper.min(upper));
        self
    }

    /// Index of the tip link, the link for which grasp poses are planned.
    pub fn tip(&self) -> usize {
        self.tip
    }

    /// Indices of the links of hand and fingers: those with geometry, rigid with the tip, beyond the arm's last joint.
    pub fn hand_links(&self) -> &[usize] {
        &self.hand_links
    }

    /// Default start configuration of a scenario (m, rad; one per joint), if one is described
    /// ([`RobotDescription::start`](crate::RobotDescription::start)).
    pub fn default_start(&self) -> Option<&[f64]> {
        self.start.as_deref()
    }

    /// Height of the ground below the robot in its root frame, in metres, if it is described
    /// ([`RobotDescription::floor_m`](crate::RobotDescription::floor_m)).
    pub fn floor_m(&self) -> Option<f64> {
        self.floor_m
    }

    /// Hand of the robot, if it is described ([`RobotDescription::hand`](crate::RobotDescription::hand)).
    pub fn hand(&self) -> Option<&RobotHand> {
        self.hand.as_ref()
    }

    /// Tool of the robot, if it has one instead of a hand ([`RobotDescription::tool`](crate::RobotDescription::tool)).
    pub fn tool(&self) -> Option<&ToolDescription> {
        self.tool.as_ref()
    }

    /// Returns the hand, for which grasps can be sampled.
    ///
    /// # Errors
    /// [`RobotError::ToolGrasps`] for a robot with a tool, [`RobotError::NoHand`] for another one without a hand.
    pub fn hand_with_pads(&self) -> Result<&RobotHand, RobotError> {
        match (&self.hand, &self.tool) {
            (_, Some(tool)) => Err(RobotError::ToolGrasps { tool: tool.name.clone() }),
            (Some(hand), None) => Ok(hand),
            (None, None) => Err(RobotError::NoHand { robot: self.name.clone() }),
        }
    }

    /// Index of the root link: always 0. Its frame is the planning frame.
    pub fn root(&self) -> usize {
        0
    }

    /// Joints that move `link`, the root's first. A joint of the group occurs once for itself and once for every joint
    /// between that mimics it.
    ///
    /// # Panics
    /// If `link` is not an index of [`links`](Self::links).
    pub fn ancestors(&self, link: usize) -> &[Mover] {
        &self.movers[link]
    }

    /// Pairs of links with geometry that have no link with geometry between them and that at most one joint moves relative to
    /// each other: `(low, high)`, sorted.
    pub fn adjacent_pairs(&self) -> &[(usize, usize)] {
        &self.adjacent_pairs
    }

    /// Pairs of links that the SRDF excludes from collision tests: `(low, high)`, sorted.
    pub fn disabled_pairs(&self) -> &[(usize, usize)] {
        &self.disabled_pairs
    }

    /// Returns the values (m, rad; one per joint) of the SRDF group state `name`; `None` unless a state of this name gives
    /// every joint of the group a value.
    pub fn group_state(&self, name: &str) -> Option<Vec<f64>> {
        self.group_states.iter().find(|(state, _)| state == name).map(|(_, q)| q.clone())
    }

    /// Returns the value of the joint named `joint`, inside or outside the group, at `q` (m, rad; one per joint); 0 if it is
    /// fixed, `None` if the URDF has no such joint.
    ///
    /// # Panics
    /// If `q` does not have [`dof`](Self::dof) values.
    pub fn joint_value(&self, joint: &str, q: &[f64]) -> Option<f64> {
        assert_eq!(q.len(), self.dof(), "one value for each joint of the group");
        let JointValue { follows, offset, .. } = *self.values.get(joint)?;
        Some(follows.map_or(offset, |(joint, multiplier)| multiplier * q[joint] + offset))
    }

    /// Returns true if the URDF has a joint named `joint`, inside or outside the group.
    pub fn has_joint(&self, joint: &str) -> bool {
        self.values.contains_key(joint)
    }

    /// Movable joints outside the group, each with its constant value (m, rad), sorted by name.
    pub fn standing_joints(&self) -> Vec<(&str, f64)> {
        let standing = self.values.iter().filter(|(_, value)| value.stands);
        let mut standing: Vec<(&str, f64)> =
            standing.map(|(joint, value)| (joint.as_str(), value.offset)).collect();
        standing.sort_unstable_by_key(|(joint, _)| *joint);
        standing
    }

    /// Virtual joints of the SRDF, which connect the robot to its surroundings.
    pub fn virtual_joints(&self) -> &[VirtualJoint] {
        &self.virtual_joints
    }

    /// Names of the joints without a motor, from the SRDF.
    pub fn passive_joints(&self) -> &[String] {
        &self.passive_joints
    }

    /// Returns true if every value of `q` (m, rad; one per joint) lies within its limits; false if one is NaN.
    ///
    /// # Panics
    /// If `q` does not have [`dof`](Self::dof) values.
    pub fn within_limits(&self, q: &[f64]) -> bool {
        assert_eq!(q.len(), self.dof(), "one value for each joint of the group");
        // A fold without a branch for each joint.
        q.iter().zip(&self.limits).fold(true, |all, (&value, limits)| all & limits.contain(value))
    }

    /// Returns the first joint whose value in `q` (m, rad; one per joint) lies outside its limits.
    ///
    /// # Panics
    /// If `q` does not have [`dof`](Self::dof) values.
    pub fn first_limit_violation(&self, q: &[f64]) -> Option<LimitViolation> {
        self.limit_violations(q).next()
    }

    /// Returns the joints whose values in `q` (m, rad; one per joint) lie outside their limits, in the order of `q`.
    ///
    /// # Panics
    /// If `q` does not have [`dof`](Self::dof) values.
    pub fn limit_violations(&self, q: &[f64]) -> impl Iterator<Item = LimitViolation> {
        assert_eq!(q.len(), self.dof(), "one value for each joint of the group");
        let violation = |(joint, (&value, limits)): (usize, (&f64, &JointLimits))| {
            let JointLimits { lower, upper, .. } = *limits;
            (!limits.contain(value)).then_some(LimitViolation { joint, value, lower, upper })
        };
        q.iter().zip(&self.limits).enumerate().filter_map(violation)
    }
}

impl Robot {
    /// Returns `work_out(self)`, computed once per robot and cached. The cache stores one value, of the type requested first;
    /// values of other types are computed at every call.
    pub fn derived<T: Any + Send + Sync>(&self, work_out: impl FnOnce(&Self) -> T) -> Arc<T> {
        let mut work_out = Some(work_out);
        let known = self.derived.0.get_or_init(|| match work_out.take() {
            Some(work_out) => Arc::new(work_out(self)),
            None => Arc::new(()),
        });
        match (known.clone().downcast::<T>(), work_out) {
            (Ok(known), _) => known,
            (Err(_), Some(work_out)) => Arc::new(work_out(self)),
            (Err(_), None) => unreachable!("what was worked out is of the type that was asked for"),
        }
    }
}
