use std::any::Any;
use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

use cranny_spatial::Pose;

use crate::chain::derived::Derived;
use crate::chain::joint_group::JointValue;
use crate::chain::joint_step::Step;
use crate::gripper::loose_links::LooseLinks;
use crate::link::{GroupJoint, Link, Mover};
use crate::{JointLimits, LimitViolation, RobotHand, VirtualJoint};

/// A robot: a tree of links, and a group of joints that moves them. Immutable; share it by reference or in
/// an `Arc`.
///
/// The root link is the planning frame, and `q` holds one value per joint of the group, in metres or
/// radians. Joints outside the group stand at fixed values.
#[derive(Clone, Debug)]
pub struct Robot {
    pub(crate) name: String,
    pub(crate) links: Vec<Link>,
    pub(crate) links_by_name: HashMap<String, usize>,
    pub(crate) joints: Vec<GroupJoint>,
    pub(crate) joint_names: Vec<String>,
    pub(crate) limits: Vec<JointLimits>,
    pub(crate) joint_reaches: Vec<f64>,
    /// Per joint of the group.
    pub(crate) full_turns: Vec<bool>,
    /// Per joint of the group whether it has no end: see [`Robot::wrap_towards`].
    pub(crate) endless: Vec<bool>,
    pub(crate) tip: usize,
    pub(crate) hand_links: Vec<usize>,
    pub(crate) hand: Option<RobotHand>,
    pub(crate) start: Option<Vec<f64>>,
    pub(crate) floor_m: Option<f64>,
    pub(crate) notes: Vec<String>,
    /// Per link.
    pub(crate) movers: Vec<Vec<Mover>>,
    pub(crate) disabled_pairs: Vec<(usize, usize)>,
    pub(crate) adjacent_pairs: Vec<(usize, usize)>,
    pub(crate) group_states: Vec<(String, Vec<f64>)>,
    /// The value of every joint of the URDF, by name.
    pub(crate) values: BTreeMap<String, JointValue>,
    pub(crate) virtual_joints: Vec<VirtualJoint>,
    pub(crate) passive_joints: Vec<String>,
    /// Forward kinematics of every link that moves, parents first.
    pub(crate) steps: Vec<Step>,
    /// Those of `steps` that lead to the tip.
    pub(crate) tip_steps: Vec<Step>,
    /// `root_from_link` of the links that do not move; of the others at `q = 0`.
    pub(crate) rest: Vec<Pose>,
    /// What stands on the tip where a hold puts it, if something is held.
    pub(crate) loose: Option<LooseLinks>,
    pub(crate) derived: Derived,
}

impl Robot {
    /// The name in the URDF.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Content of the URDF that was not read, a line for each kind with its place. It changes neither geometry nor motion:
    /// what could is refused.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// All links, parents before children; the root is the first.
    pub fn links(&self) -> &[Link] {
        &self.links
    }

    /// The index of the link of that name.
    pub fn link_index(&self, name: &str) -> Option<usize> {
        self.links_by_name.get(name).copied()
    }

    /// How many joints the group has: the length of `q`.
    pub fn dof(&self) -> usize {
        self.joints.len()
    }

    /// The joints of the group, in the order of `q`.
    pub fn joints(&self) -> &[GroupJoint] {
        &self.joints
    }

    /// Their names, in the order of `q`.
    pub fn joint_names(&self) -> &[String] {
        &self.joint_names
    }

    /// Their limits, in the order of `q`.
    pub fn limits(&self) -> &[JointLimits] {
        &self.limits
    }

    /// The same robot with a joint, by its index, that stays between two values, in m or rad, besides its limits; limits that
    /// exclude each other hold for no value.
    #[must_use]
    pub fn with_joint_between(mut self, joint: usize, lower: f64, upper: f64) -> Self {
        let limits = &mut self.limits[joint];
        (limits.lower, limits.upper) = (limits.lower.max(lower), limits.upper.min(upper));
        self
    }

    /// The link that reaches for grasps.
    pub fn tip(&self) -> usize {
        self.tip
    }

    /// The links of hand and fingers, by index: those with geometry that move as one with the tip, beyond the last
    /// joint of the arm.
    pub fn hand_links(&self) -> &[usize] {
        &self.hand_links
    }

    /// Start configuration where a scenario gives none (m, rad; one per joint), if one is described
    /// ([`RobotDescription::start`](crate::RobotDescription::start)).
    pub fn default_start(&self) -> Option<&[f64]> {
        self.start.as_deref()
    }

    /// Height of the ground that it stands on in its root frame, in metres, if that is described
    /// ([`RobotDescription::floor_m`](crate::RobotDescription::floor_m)).
    pub fn floor_m(&self) -> Option<f64> {
        self.floor_m
    }

    /// What is known of the hand, if it is described ([`RobotDescription::hand`](crate::RobotDescription::hand)).
    pub fn hand(&self) -> Option<&RobotHand> {
        self.hand.as_ref()
    }

    /// The root link: always 0. Its frame is the planning frame.
    pub fn root(&self) -> usize {
        0
    }

    /// The joints that move `link`, the root's first. A joint of the group occurs once for itself and once
    /// for every joint on the way that mimics it.
    ///
    /// # Panics
    /// If `link` is no index of [`links`](Self::links).
    pub fn ancestors(&self, link: usize) -> &[Mover] {
        &self.movers[link]
    }

    /// Pairs of links with geometry between which there is no link with geometry, and which at most one joint moves
    /// against each other: `(low, high)`, sorted.
    pub fn adjacent_pairs(&self) -> &[(usize, usize)] {
        &self.adjacent_pairs
    }

    /// Pairs of links that the SRDF never tests against each other: `(low, high)`, sorted.
    pub fn disabled_pairs(&self) -> &[(usize, usize)] {
        &self.disabled_pairs
    }

    /// The values (m, rad; one per joint) that the SRDF's state of that name gives to the whole of `q`; None if there
    /// is no such state, or none that names every joint of the group.
    pub fn group_state(&self, name: &str) -> Option<Vec<f64>> {
        self.group_states.iter().find(|(state, _)| state == name).map(|(_, q)| q.clone())
    }

    /// The value that the joint of that name, whether of the group or not, has at `q` (m, rad; one per joint); 0 if
    /// it is fixed, None if the URDF has no such joint.
    ///
    /// # Panics
    /// If `q` does not hold [`dof`](Self::dof) values.
    pub fn joint_value(&self, joint: &str, q: &[f64]) -> Option<f64> {
        assert_eq!(q.len(), self.dof(), "one value for each joint of the group");
        let JointValue { follows, offset, .. } = *self.values.get(joint)?;
        Some(follows.map_or(offset, |(joint, multiplier)| multiplier * q[joint] + offset))
    }

    /// Returns whether the URDF has a joint of that name, inside or outside the group.
    pub fn has_joint(&self, joint: &str) -> bool {
        self.values.contains_key(joint)
    }

    /// The joints outside the group that could move, but stand still, each with its value (m, rad), by name.
    pub fn standing_joints(&self) -> Vec<(&str, f64)> {
        let standing = self.values.iter().filter(|(_, value)| value.stands);
        let mut standing: Vec<(&str, f64)> =
            standing.map(|(joint, value)| (joint.as_str(), value.offset)).collect();
        standing.sort_unstable_by_key(|(joint, _)| *joint);
        standing
    }

    /// The joints of the SRDF between the robot and what it stands on.
    pub fn virtual_joints(&self) -> &[VirtualJoint] {
        &self.virtual_joints
    }

    /// The joints that no motor drives, by the names in the SRDF.
    pub fn passive_joints(&self) -> &[String] {
        &self.passive_joints
    }

    /// Whether every value of `q` (m, rad; one per joint) lies within its limits. A NaN does not.
    ///
    /// # Panics
    /// If `q` does not hold [`dof`](Self::dof) values.
    pub fn within_limits(&self, q: &[f64]) -> bool {
        assert_eq!(q.len(), self.dof(), "one value for each joint of the group");
        // Without a branch for each joint.
        q.iter().zip(&self.limits).fold(true, |all, (&value, limits)| all & limits.contain(value))
    }

    /// The first joint whose value in `q` (m, rad; one per joint) lies outside its limits.
    ///
    /// # Panics
    /// If `q` does not hold [`dof`](Self::dof) values.
    pub fn first_limit_violation(&self, q: &[f64]) -> Option<LimitViolation> {
        self.limit_violations(q).next()
    }

    /// The joints whose values in `q` (m, rad; one per joint) lie outside their limits, in its order.
    ///
    /// # Panics
    /// If `q` does not hold [`dof`](Self::dof) values.
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
    /// What `work_out` makes of this robot, worked out once as long as the robot lives. There is room for one such
    /// thing, of the type that is asked for first; others are worked out every time.
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
