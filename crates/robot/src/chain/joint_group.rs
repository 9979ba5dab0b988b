use std::collections::{BTreeSet, HashMap, HashSet};

use cranny_file::nearest_names;

use crate::chain::limits::wrapped;
use crate::description::urdf_model::{Urdf, UrdfJoint, UrdfJointKind, UrdfMotion};
use crate::tree::Tree;
use crate::{JointConstraint, JointGroup, RobotError, RobotOptions, Srdf, SrdfGroup};

/// Resolved joint group: the joints of `q`, the values of all other joints, and the tip link.
pub(crate) struct Resolved {
    /// Joints of the group, as indices into the joints of the file.
    pub(crate) group: Vec<usize>,
    /// The tip, as a node of the tree.
    pub(crate) tip: usize,
    /// Value of each joint of the file.
    pub(crate) values: Vec<JointValue>,
    /// Content of the SRDF that matches no joint, one line each.
    pub(crate) notes: Vec<String>,
}

/// Joint value `multiplier · q[joint] + offset`, or `offset` alone.
#[derive(Clone, Copy, Debug)]
pub(crate) struct JointValue {
    pub(crate) follows: Option<(usize, f64)>,
    pub(crate) offset: f64,
    /// True if the joint is movable, but fixed at a value.
    pub(crate) stands: bool,
}

impl Resolved {
    pub(crate) fn new(
        urdf: &Urdf,
        tree: &Tree,
        srdf: Option<&Srdf>,
        options: &RobotOptions,
    ) -> Result<Self, RobotError> {
        let resolver = Resolver::new(urdf, tree, srdf, options);
        resolver.check_names()?;
        let named = resolver.named_group()?;
        let tip = resolver.tip(named.as_deref())?;
        let group = named.unwrap_or_else(|| resolver.root_to_tip(tip));
        if group.is_empty() {
            return Err(RobotError::EmptyGroup { file: urdf.file.clone() });
        }
        let mut values = Vec::with_capacity(urdf.joints.len());
        for joint in 0..urdf.joints.len() {
            values.push(resolver.value(joint, &group)?);
        }
        resolver.check_held(&values)?;
        Ok(Self { group, tip, values, notes: resolver.passive_notes() })
    }
}

/// Returns the joints of the group named in the options, by index; empty if none is named.
pub(crate) fn named_group(
    urdf: &Urdf,
    tree: &Tree,
    srdf: Option<&Srdf>,
    options: &RobotOptions,
) -> Result<Vec<usize>, RobotError> {
    let resolver = Resolver::new(urdf, tree, srdf, options);
    resolver.check_names()?;
    Ok(resolver.named_group()?.unwrap_or_default())
}

pub(crate) fn unknown_joint(urdf: &Urdf, place: String, name: &str) -> RobotError {
    let nearest = nearest_names(name, urdf.joints.iter().map(|joint| joint.name.as_str()));
    RobotError::UnknownName { place, kind: "joint", name: name.to_owned(), nearest }
}

pub(crate) fn unknown_link(urdf: &Urdf, place: String, name: &str) -> RobotError {
    let nearest = nearest_names(name, urdf.links.iter().map(|link| link.name.as_str()));
    RobotError::UnknownName { place, kind: "link", name: name.to_owned(), nearest }
}

/// Groups on the current branch of a walk through nested groups, and the groups already finished: each is visited once, even if
/// several groups contain it.
#[derive(Default)]
struct Inside<'s> {
    open: Vec<&'s str>,
    closed: HashSet<&'s str>,
}

struct Resolver<'a> {
    urdf: &'a Urdf,
    tree: &'a Tree,
    srdf: Option<&'a Srdf>,
    options: &'a RobotOptions,
    /// Joints that represent a joint of several degrees of freedom, `NAME/x`, …, by its name.
    components: HashMap<&'a str, Vec<usize>>,
}

impl<'a> Resolver<'a> {
    fn new(urdf: &'a Urdf, tree: &'a Tree, srdf: Option<&'a Srdf>, options: &'a RobotOptions) -> Self {
        let mut components: HashMap<&str, Vec<usize>> = HashMap::new();
        for (index, joint) in urdf.joints.iter().enumerate() {
            if let Some((name, _)) = joint.name.rsplit_once('/') {
                components.entry(name).or_default().push(index);
            }
        }
        Self { urdf, tree, srdf, options, components }
    }

    /// Checks that every joint named by a mimic joint or the option `fixed` exists, that every chain of mimic joints ends, and
    /// that the values in `fixed` are finite.
    fn check_names(&self) -> Result<(), RobotError> {
        for joint in &self.urdf.joints {
            let mut follower = joint;
            for followed in 0.. {
                let Some(mimic) = follower.motion.as_ref().and_then(|motion| motion.mimic.as_ref()) else {
                    break;
                };
                if followed > self.urdf.joints.len() {
                    return Err(RobotError::MimicLoop { at: joint.at.clone(), joint: joint.name.clone() });
                }
                let place = || format!("{}: joint `{}` mimics another", follower.at, follower.name);
                follower = &self.urdf.joints[self.known_joint(&mimic.master, place)?];
            }
        }
        for name in &self.options.solid_meshes {
            self.known_link(name, || format!("{}: solid_meshes", self.urdf.file))?;
        }
        for (name, &value) in &self.options.fixed {
            let index = self.known_joint(name, || format!("{}: joints held at a value", self.urdf.file))?;
            let joint = &self.urdf.joints[index];
            if joint.motion.is_none() {
                return Err(not_free(joint, "held at a value", JointConstraint::Fixed));
            }
            if !value.is_finite() {
                return Err(not_free(joint, "held at a value", JointConstraint::NotFinite { value }));
            }
        }
        Ok(())
    }

    /// Returns a note for each passive joint of the SRDF that the robot lacks, as when one SRDF serves several hands.
    fn passive_notes(&self) -> Vec<String> {
        let passive = self.srdf.iter().flat_map(|srdf| srdf.passive_joints.iter().zip(&srdf.places.passive));
        let is_unknown = |name: &str| {
            !self.is_virtual(name) && self.tree.joint(name).is_none() && !self.components.contains_key(name)
        };
        passive
            .filter(|(name, _)| is_unknown(name))
            .map(|(name, at)| format!("{at}: passive_joint: unknown joint `{name}`: it is not read"))
            .collect()
    }

    fn known_joint(&self, name: &str, place: impl Fn() -> String) -> Result<usize, RobotError> {
        self.tree.joint(name).ok_or_else(|| unknown_joint(self.urdf, place(), name))
    }

    /// Returns all joints that represent the planar or floating joint named `name`, or the joint of that name.
    fn joint_or_components(&self, name: &str, place: impl Fn() -> String) -> Result<Vec<usize>, RobotError> {
        match self.components.get(name) {
            Some(joints) => Ok(joints.clone()),
            None => Ok(vec![self.known_joint(name, place)?]),
        }
    }

    /// Returns true if the SRDF has a virtual joint of that name and the URDF has no such joint.
    fn is_virtual(&self, name: &str) -> bool {
        self.tree.joint(name).is_none() && self.srdf.is_some_and(|srdf| srdf.virtual_joint(name).is_some())
    }

    /// Returns the base link of a chain: the parent frame of a virtual joint represents the link attached to it.
    fn chain_base(&self, name: &str, place: impl Fn() -> String) -> Result<usize, RobotError> {
        let virtual_joints = self.srdf.iter().flat_map(|srdf| &srdf.virtual_joints);
        let mut standing =
            virtual_joints.filter(|joint| joint.parent_frame == name).map(|joint| &joint.child_link);
        let standing = standing.find_map(|link| self.tree.node(link));
        match standing.filter(|_| self.tree.node(name).is_none()) {
            Some(node) => Ok(node),
            None => self.known_link(name, place),
        }
    }

    fn known_link(&self, name: &str, place: impl Fn() -> String) -> Result<usize, RobotError> {
        self.tree.node(name).ok_or_else(|| unknown_link(self.urdf, place(), name))
    }

    /// Returns true if the joint can move and mimics no other.
    fn is_free(&self, joint: usize) -> bool {
        let joint = &self.urdf.joints[joint];
        joint.motion.as_ref().is_some_and(|motion| motion.mimic.is_none())
    }

    fn is_held(&self, joint: usize) -> bool {
        self.options.fixed.contains_key(&self.urdf.joints[joint].name)
    }

    fn is_passive(&self, joint: usize) -> bool {
        let name = &self.urdf.joints[joint].name;
        self.srdf.is_some_and(|srdf| srdf.passive_joints.contains(name))
    }

    fn root_to_tip(&self, tip: usize) -> Vec<usize> {
        let free = |&joint: &usize| self.is_free(joint) && !self.is_held(joint);
        let mut joints: Vec<usize> = self.tree.joints_above(tip).filter(free).collect();
        joints.reverse();
        joints
    }

    fn named_group(&self) -> Result<Option<Vec<usize>>, RobotError> {
        let group = match &self.options.group {
            JointGroup::RootToTip => return Ok(None),
            JointGroup::Joints(names) => self.joints_by_name(names)?,
            JointGroup::Srdf(name) => {
                let mut joints = BTreeSet::new();
                self.collect_group(
                    self.srdf_group(name, "joint group")?,
                    &mut Inside::default(),
                    &mut joints,
                )?;
                // A passive joint with a value in `fixed` keeps this value.
                joints
                    .retain(|&joint| self.is_free(joint) && !(self.is_passive(joint) && self.is_held(joint)));
                let mut joints: Vec<usize> = joints.into_iter().collect();
                joints.sort_by_key(|&joint| self.tree.node_of_joint[joint]);
                joints
            }
        };
        match group.iter().find(|&&joint| self.is_held(joint)) {
            Some(&joint) => {
                Err(not_free(&self.urdf.joints[joint], "held at a value", JointConstraint::InGroup))
            }
            None => Ok(Some(group)),
        }
    }

    fn joints_by_name(&self, names: &[String]) -> Result<Vec<usize>, RobotError> {
        let mut group = Vec::with_capacity(names.len());
        for name in names {
            let index = self.known_joint(name, || format!("{}: joint group", self.urdf.file))?;
            let joint = &self.urdf.joints[index];
            let constraint = match &joint.motion {
                None => Some(JointConstraint::Fixed),
                Some(UrdfMotion { mimic: Some(mimic), .. }) => {
                    Some(JointConstraint::Mimic { master: mimic.master.clone() })
                }
                Some(_) => None,
            };
            if let Some(constraint) = constraint {
                return Err(not_free(joint, "moved", constraint));
            }
            if group.contains(&index) {
                return Err(RobotError::NamedTwice { joint: name.clone() });
            }
            group.push(index);
        }
        Ok(group)
    }

    fn srdf_group(&self, name: &str, place: &str) -> Result<&SrdfGroup, RobotError> {
        self.srdf.and_then(|srdf| srdf.group(name)).ok_or_else(|| {
            let known = self.srdf.iter().flat_map(|srdf| &srdf.groups).map(|group| group.name.as_str());
            RobotError::UnknownName {
                place: place.to_owned(),
                kind: "SRDF group",
                name: name.to_owned(),
                nearest: nearest_names(name, known),
            }
        })
    }

    fn collect_group<'s>(
        &'s self,
        group: &'s SrdfGroup,
        groups: &mut Inside<'s>,
        joints: &mut BTreeSet<usize>,
    ) -> Result<(), RobotError> {
        if groups.open.contains(&group.name.as_str()) {
            return Err(RobotError::GroupLoop { at: group.at.clone(), group: group.name.clone() });
        }
        groups.open.push(&group.name);
        let place = || format!("{}: group `{}`", group.at, group.name);
        for (base, tip) in &group.chains {
            let (base_node, tip_node) = (self.chain_base(base, place)?, self.known_link(tip, place)?);
            let chain = self.chain(base_node, tip_node).ok_or_else(|| {
                let (at, base, tip) = (group.at.clone(), base.clone(), tip.clone());
                RobotError::BrokenChain { at, base, tip }
            })?;
            joints.extend(chain);
        }
        for name in group.joints.iter().filter(|name| !self.is_virtual(name)) {
            joints.extend(self.joint_or_components(name, place)?);
        }
        for name in &group.links {
            let node = self.known_link(name, place)?;
            joints.extend(self.tree.nodes[node].above.map(|(_, joint)| joint));
        }
        for name in &group.subgroups {
            if !groups.closed.contains(name.as_str()) {
                self.collect_group(self.srdf_group(name, &place())?, groups, joints)?;
            }
        }
        groups.open.pop();
        groups.closed.insert(&group.name);
        Ok(())
    }

    /// Returns the joints between two links, if the second descends from the first.
    fn chain(&self, base: usize, tip: usize) -> Option<Vec<usize>> {
        let mut joints = Vec::new();
        let mut node = tip;
        while node != base {
            let (above, joint) = self.tree.nodes[node].above?;
            joints.push(joint);
            node = above;
        }
        Some(joints)
    }

    fn tip(&self, group: Option<&[usize]>) -> Result<usize, RobotError> {
        if let Some(tip) = &self.options.tip {
            return self.known_link(tip, || format!("{}: tip", self.urdf.file));
        }
        if let JointGroup::Srdf(name) = &self.options.group
            && let Some((_, tip)) = self.srdf_group(name, "joint group")?.chains.first()
        {
            return self.known_link(tip, || format!("group `{name}`"));
        }
        if let Some((srdf, end)) = self.srdf.and_then(|srdf| Some((srdf, srdf.end_effectors.first()?))) {
            let place = || format!("{}: end effector `{}`", end.at, end.name);
            let chain = srdf.group(&end.group).and_then(|group| group.chains.first());
            return self.known_link(chain.map_or(&end.parent_link, |(_, tip)| tip), place);
        }
        let counts = |&joint: &usize| match group {
            Some(group) => group.contains(&joint),
            None => self.is_free(joint) && !self.is_held(joint),
        };
        let mut is_leaf = vec![true; self.tree.nodes.len()];
        self.tree.nodes.iter().filter_map(|node| node.above).for_each(|(above, _)| is_leaf[above] = false);
        let rank = |&node: &usize| {
            let link = self.tree.nodes[node].link;
            let is_bare = self.urdf.links[link].collisions.is_empty();
            (self.tree.joints_above(node).filter(counts).count(), is_bare, link)
        };
        Ok((0..is_leaf.len()).filter(|&node| is_leaf[node]).max_by_key(rank).unwrap_or(0))
    }

    /// Returns the value of a joint of the file, with mimicry resolved (see [`check_names`](Self::check_names)).
    fn value(&self, joint: usize, group: &[usize]) -> Result<JointValue, RobotError> {
        let described = &self.urdf.joints[joint];
        let Some(motion) = &described.motion else {
            return Ok(JointValue { follows: None, offset: 0.0, stands: false });
        };
        if let Some(mimic) = &motion.mimic {
            let master = self.known_joint(&mimic.master, || described.at.to_string())?;
            let value = self.value(master, group)?;
            return Ok(JointValue {
                // A joint that follows with factor 0 does not move.
                follows: value
                    .follows
                    .map(|(index, factor)| (index, factor * mimic.multiplier))
                    .filter(|&(_, factor)| factor != 0.0),
                offset: value.offset * mimic.multiplier + mimic.offset,
                stands: false,
            });
        }
        if let Some(index) = group.iter().position(|&member| member == joint) {
            return Ok(JointValue { follows: Some((index, 1.0)), offset: 0.0, stands: false });
        }
        let (lower, upper) = range(motion);
        // The value is not changed by whole turns: they would move a joint that mimics this one with a fractional multiplier.
        let held = self.options.fixed.get(&described.name).copied();
        let offset = held.unwrap_or_else(|| 0.0_f64.clamp(lower, upper));
        Ok(JointValue { follows: None, offset, stands: true })
    }

    /// Checks that the values in `fixed`, and those of joints that mimic them, lie within limits and agree with the mimicry.
    fn check_held(&self, values: &[JointValue]) -> Result<(), RobotError> {
        for (name, &value) in &self.options.fixed {
            let Some(index) = self.tree.joint(name) else { continue };
            let joint = &self.urdf.joints[index];
            let Some(motion) = &joint.motion else { continue };
            let followed = values[index];
            if let Some(mimic) = &motion.mimic {
                let master = mimic.master.clone();
                // The tolerance covers the rounding of one product and one sum of metres or radians.
                let agrees = followed.follows.is_none() && (followed.offset - value).abs() < 1e-12;
                if !agrees {
                    let constraint = match followed.follows {
                        Some(_) => JointConstraint::Mimic { master },
                        None => JointConstraint::MimicValue { master, value: followed.offset },
                    };
                    return Err(not_free(joint, "held at a value", constraint));
                }
            }
            let (lower, upper) = range(motion);
            if !admits(motion, value) {
                let (at, joint) = (joint.at.clone(), joint.name.clone());
                return Err(RobotError::HeldOutsideLimits { at, joint, value, lower, upper });
            }
        }
        for (joint, value) in self.urdf.joints.iter().zip(values) {
            let Some(UrdfMotion { mimic: Some(mimic), .. }) = &joint.motion else { continue };
            if value.follows.is_none() {
                mimic_within_limits(joint, &mimic.master, value.offset)?;
            }
        }
        Ok(())
    }
}

/// Tolerated excess of a mimic joint over its limits (m, rad): files round factors and limits to some four digits.
pub(crate) const MIMIC_SLACK: f64 = 1e-3;

/// Checks that the value a mimic joint gets from its master is within its limits, up to [`MIMIC_SLACK`].
///
/// # Errors
/// [`RobotError::NotFree`] for a value outside its limits.
pub(crate) fn mimic_within_limits(joint: &UrdfJoint, master: &str, value: f64) -> Result<(), RobotError> {
    let Some(motion) = &joint.motion else { return Ok(()) };
    let (lower, upper) = range(motion);
    if [value - MIMIC_SLACK, value, value + MIMIC_SLACK].iter().any(|&near| admits(motion, near)) {
        return Ok(());
    }
    let beyond = (value - upper).max(lower - value);
    let constraint = JointConstraint::MimicOutsideLimits { master: master.to_owned(), beyond };
    Err(not_free(joint, "held", constraint))
}

/// Maximum absolute value at which an endless joint may be fixed, in radians: its links are then accurate to within 1e-12 rad.
const FARTHEST_TURN_RAD: f64 = 1e4;

/// Returns `value` of an endless joint wrapped nearest to 0 by whole turns within its limits; other values unchanged.
fn wrapped_if_endless(motion: &UrdfMotion, value: f64) -> f64 {
    let (lower, upper) = range(motion);
    let is_endless = motion.kind == UrdfJointKind::Continuous && value.abs() <= FARTHEST_TURN_RAD;
    if is_endless { wrapped(value, 0.0, [lower, upper]).unwrap_or(value) } else { value }
}

pub(crate) fn range(motion: &UrdfMotion) -> (f64, f64) {
    (motion.limits.lower, motion.limits.upper)
}

/// Returns true if a joint may be fixed at `value`; for a continuous joint, modulo whole turns.
pub(crate) fn admits(motion: &UrdfMotion, value: f64) -> bool {
    let (lower, upper) = range(motion);
    (lower..=upper).contains(&wrapped_if_endless(motion, value))
}

fn not_free(joint: &UrdfJoint, wanted: &'static str, constraint: JointConstraint) -> RobotError {
    RobotError::NotFree { at: joint.at.clone(), joint: joint.name.clone(), wanted, constraint }
}
