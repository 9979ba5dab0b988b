use std::collections::HashSet;

use cranny_file::nearest_names;

use crate::description::unread::Notes;
use crate::description::xml::{Element, XmlText};
use crate::tree::MAX_LINKS;
use crate::{Location, RobotError};

/// Content of an SRDF on groups, states and pairs of links; names are checked when it is combined with a robot.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Srdf {
    /// Named sets of joints.
    pub groups: Vec<SrdfGroup>,
    /// Named values for the joints of a group.
    pub group_states: Vec<GroupState>,
    /// Hands and tools.
    pub end_effectors: Vec<EndEffector>,
    /// Pairs of links that are never tested for collision.
    pub disabled_pairs: Vec<(String, String)>,
    /// Links that are tested only against those of `enabled_pairs` (`disable_default_collisions`).
    pub untested_links: Vec<String>,
    /// Pairs of links that are tested unless they are in `disabled_pairs` (`enable_collisions`).
    pub enabled_pairs: Vec<(String, String)>,
    /// Joints between the robot and its surroundings.
    pub virtual_joints: Vec<VirtualJoint>,
    /// Joints without a motor.
    pub passive_joints: Vec<String>,
    /// Locations of `disabled_pairs`, `untested_links`, `enabled_pairs` and `passive_joints` in the file.
    pub(crate) places: Places,
    /// Notes on content that was not read, one line for each kind.
    pub(crate) notes: Vec<String>,
}

/// Locations in an SRDF, by content.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Places {
    pub(crate) disabled: Vec<Location>,
    pub(crate) untested: Vec<Location>,
    pub(crate) enabled: Vec<Location>,
    pub(crate) passive: Vec<Location>,
}

/// Joint between a robot and its surroundings.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct VirtualJoint {
    /// Name of the joint.
    pub name: String,
    /// Kind of motion.
    pub kind: VirtualJointKind,
    /// Frame that the robot is attached to.
    pub parent_frame: String,
    /// Link attached to that frame.
    pub child_link: String,
}

/// Kind of motion of a [`VirtualJoint`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, strum::EnumString, strum::IntoStaticStr)]
#[strum(serialize_all = "lowercase")]
pub enum VirtualJointKind {
    /// No motion.
    Fixed,
    /// Translation in the plane x, y, and rotation about z.
    Planar,
    /// Motion in all six degrees of freedom.
    Floating,
}

/// Named set of joints: all those of its chains, links, joints and sub-groups.
#[derive(Clone, Debug, PartialEq)]
pub struct SrdfGroup {
    /// Name of the group.
    pub name: String,
    /// Base link and tip link of each chain.
    pub chains: Vec<(String, String)>,
    /// Individually named joints.
    pub joints: Vec<String>,
    /// Links, each standing for the joint above it.
    pub links: Vec<String>,
    /// Names of groups that this one contains.
    pub subgroups: Vec<String>,
    /// Location of the group in the file.
    pub at: Location,
}

/// Named joint values.
#[derive(Clone, Debug, PartialEq)]
pub struct GroupState {
    /// Name of the state.
    pub name: String,
    /// Group that the state belongs to.
    pub group: String,
    /// Joint and value, in metres or radians.
    pub values: Vec<(String, f64)>,
    /// Joints with a pose as value, which is not read.
    pub unread: Vec<String>,
    /// Location of the state in the file.
    pub at: Location,
}

/// Hand or tool.
#[derive(Clone, Debug, PartialEq)]
pub struct EndEffector {
    /// Name of the end effector.
    pub name: String,
    /// Group of its own joints.
    pub group: String,
    /// Link that it is mounted on.
    pub parent_link: String,
    /// Group that moves it, if given.
    pub parent_group: Option<String>,
    /// Location of the end effector in the file.
    pub at: Location,
}

impl Srdf {
    /// Parses the text of an SRDF; `file` is its name in errors.
    ///
    /// # Errors
    /// Malformed XML, a missing attribute, an invalid number; an unknown attribute or element in a known element, or an
    /// element that may be a misspelt one. Other unknown elements are noted.
    pub fn parse(text: &str, file: &str) -> Result<Self, RobotError> {
        let xml = XmlText::parse(text, file)?;
        let robot = xml.robot()?;
        let mut srdf = Self::default();
        let mut notes = Notes::default();
        let pair = |element: Element<'_>| -> Result<(String, String), RobotError> {
            known(element, &["link1", "link2", "reason"], &[])?;
            Ok((element.text("link1")?.to_owned(), element.text("link2")?.to_owned()))
        };
        for element in robot.children() {
            match &*element.tag() {
                "group" => {
                    srdf.groups.push(parse_group(element)?);
                    element.all("passive_joint").try_for_each(|joint| srdf.add_passive_joint(joint))?;
                }
                "group_state" => srdf.group_states.push(parse_state(element)?),
                "end_effector" => srdf.end_effectors.push(parse_end_effector(element)?),
                "disable_collisions" => {
                    srdf.disabled_pairs.push(pair(element)?);
                    srdf.places.disabled.push(element.at());
                }
                "enable_collisions" => {
                    srdf.enabled_pairs.push(pair(element)?);
                    srdf.places.enabled.push(element.at());
                }
                "disable_default_collisions" => {
                    known(element, &["link"], &[])?;
                    srdf.untested_links.push(element.text("link")?.to_owned());
                    srdf.places.untested.push(element.at());
                }
                "passive_joint" => srdf.add_passive_joint(element)?,
                "virtual_joint" => srdf.virtual_joints.push(parse_virtual_joint(element)?),
                // Approximations, hints and plugins of other programs affect neither groups nor pairs.
                "link_sphere_approximation"
                | "joint_property"
                | "group_tcps"
                | "kinematics_plugin_config"
                | "contact_managers_plugin_config"
                | "calibration_config" => {}
                tag if nearest_names(tag, ELEMENTS.iter().copied()).is_empty() => {
                    notes.add(&format!("element <{tag}>"), robot, element);
                }
                tag => return Err(unknown(element, "element", tag, &ELEMENTS)),
            }
        }
        srdf.check_counts(robot)?;
        srdf.notes = [notes.lines(), srdf.contradictions()].concat();
        Ok(srdf)
    }

    /// Checks the numbers of those elements that are found by name, element by element, or that combine with each joint.
    fn check_counts(&self, robot: Element<'_>) -> Result<(), RobotError> {
        let chains = self.groups.iter().map(|group| group.chains.len()).sum();
        for (what, actual) in [
            ("groups in one SRDF", self.groups.len()),
            ("chains in one SRDF", chains),
            ("virtual joints in one SRDF", self.virtual_joints.len()),
            ("passive joints in one SRDF", self.passive_joints.len()),
        ] {
            if actual > MAX_LINKS {
                return Err(RobotError::TooMany { at: robot.at(), what, most: MAX_LINKS, actual });
            }
        }
        Ok(())
    }

    /// Returns sentences on duplicate names and on names that refer to nothing.
    fn contradictions(&self) -> Vec<String> {
        let mut found = Vec::new();
        let (mut groups, mut states) = (HashSet::new(), HashSet::new());
        for SrdfGroup { name, at, .. } in &self.groups {
            if !groups.insert(name) {
                found.push(format!("{at}: group `{name}` is defined twice: the first definition is used"));
            }
        }
        for state in &self.group_states {
            let GroupState { name, group, values, at, .. } = state;
            if !groups.contains(group) {
                found.push(format!("{at}: state `{name}` refers to the unknown group `{group}`"));
            }
            if !states.insert((name, group)) {
                found.push(format!(
                    "{at}: state `{name}` of group `{group}` is defined twice: the first definition is used"
                ));
            }
            let mut joints = HashSet::new();
            for (joint, _) in values {
                if !joints.insert(joint) {
                    found.push(format!(
                        "{at}: state `{name}` has joint `{joint}` twice: the last value is used"
                    ));
                }
            }
            for joint in &state.unread {
                found.push(format!("{at}: state `{name}` has a pose of joint `{joint}`, which is not read"));
            }
        }
        for EndEffector { name, group, at, .. } in
            self.end_effectors.iter().filter(|end| !groups.contains(&end.group))
        {
            found.push(format!("{at}: end effector `{name}` refers to the unknown group `{group}`"));
        }
        found
    }

    fn add_passive_joint(&mut self, element: Element<'_>) -> Result<(), RobotError> {
        known(element, &["name"], &[])?;
        self.passive_joints.push(element.text("name")?.to_owned());
        self.places.passive.push(element.at());
        Ok(())
    }

    /// Returns the group named `name`.
    pub fn group(&self, name: &str) -> Option<&SrdfGroup> {
        self.groups.iter().find(|group| group.name == name)
    }

    /// Returns true if the group, or one nested in it, names the joint.
    pub fn has_joint(&self, group: &str, joint: &str) -> bool {
        self.any_group(group, |group| group.joints.iter().any(|name| name == joint))
    }

    /// Returns true if a chain of the group, or of one nested in it, begins at that frame or link.
    pub fn has_chain_from(&self, group: &str, base: &str) -> bool {
        self.any_group(group, |group| group.chains.iter().any(|(from, _)| from == base))
    }

    /// Returns true if the group, or one nested in it, satisfies a condition.
    fn any_group(&self, name: &str, holds: impl Fn(&SrdfGroup) -> bool) -> bool {
        let (mut open, mut known) = (vec![name], HashSet::from([name]));
        while let Some(name) = open.pop() {
            let Some(group) = self.group(name) else { continue };
            if holds(group) {
                return true;
            }
            // Nested groups may form a loop.
            open.extend(group.subgroups.iter().map(String::as_str).filter(|name| known.insert(name)));
        }
        false
    }

    /// Returns the virtual joint of that name, or the one of which `name` is a degree of freedom (`NAME/x`).
    pub(crate) fn virtual_joint(&self, name: &str) -> Option<&VirtualJoint> {
        self.virtual_joints.iter().find(|joint| {
            name.strip_prefix(&joint.name).is_some_and(|rest| rest.is_empty() || rest.starts_with('/'))
        })
    }
}

/// Names of the elements that are read.
const ELEMENTS: [&str; 8] = [
    "group",
    "group_state",
    "end_effector",
    "virtual_joint",
    "passive_joint",
    "disable_collisions",
    "enable_collisions",
    "disable_default_collisions",
];

/// Returns an error if the element has other attributes or elements than these.
fn known(
    element: Element<'_>,
    attributes: &[&'static str],
    elements: &[&'static str],
) -> Result<(), RobotError> {
    if let Some(name) = element.attribute_names().find(|name| !attributes.contains(name)) {
        return Err(unknown(element, "attribute", name, attributes));
    }
    match element.children().find(|child| !elements.contains(&&*child.tag())) {
        Some(child) => Err(unknown(child, "element", &child.tag(), elements)),
        None => Ok(()),
    }
}

fn unknown(element: Element<'_>, kind: &'static str, name: &str, known: &[&str]) -> RobotError {
    let known = if known.is_empty() { "none".to_owned() } else { known.join(", ") };
    RobotError::UnknownInSrdf { at: element.at(), kind, name: name.to_owned(), known }
}

fn parse_virtual_joint(element: Element<'_>) -> Result<VirtualJoint, RobotError> {
    known(element, &["name", "type", "parent_frame", "child_link"], &[])?;
    let kind = element.text("type")?;
    Ok(VirtualJoint {
        name: element.text("name")?.to_owned(),
        kind: kind
            .parse()
            .map_err(|_| unknown(element, "type of virtual joint", kind, &["fixed", "planar", "floating"]))?,
        parent_frame: element.text("parent_frame")?.to_owned(),
        child_link: element.text("child_link")?.to_owned(),
    })
}

fn parse_group(element: Element<'_>) -> Result<SrdfGroup, RobotError> {
    known(element, &["name"], &["chain", "joint", "link", "group", "passive_joint"])?;
    for chain in element.all("chain") {
        known(chain, &["base_link", "tip_link"], &[])?;
    }
    let names = |tag| -> Result<Vec<String>, RobotError> {
        let name = |child: Element<'_>| {
            known(child, &["name"], &[])?;
            Ok(child.text("name")?.to_owned())
        };
        element.all(tag).map(name).collect()
    };
    Ok(SrdfGroup {
        name: element.text("name")?.to_owned(),
        chains: element
            .all("chain")
            .map(|chain| Ok((chain.text("base_link")?.to_owned(), chain.text("tip_link")?.to_owned())))
            .collect::<Result<_, RobotError>>()?,
        joints: names("joint")?,
        links: names("link")?,
        subgroups: names("group")?,
        at: element.at(),
    })
}

fn parse_state(element: Element<'_>) -> Result<GroupState, RobotError> {
    known(element, &["name", "group"], &["joint"])?;
    let is_pose =
        |joint: &Element<'_>| joint.text("value").is_ok_and(|value| value.split_whitespace().count() == 7);
    Ok(GroupState {
        name: element.text("name")?.to_owned(),
        group: element.text("group")?.to_owned(),
        unread: element
            .all("joint")
            .filter(is_pose)
            .map(|joint| Ok(joint.text("name")?.to_owned()))
            .collect::<Result<_, RobotError>>()?,
        values: element
            .all("joint")
            .map(parse_value)
            .collect::<Result<Vec<_>, RobotError>>()?
            .into_iter()
            .flatten()
            .collect(),
        at: element.at(),
    })
}

/// Reads the value of a joint; the three values of a planar joint are those of the three joints that represent it here. The
/// pose that `MoveIt` writes for a floating joint is not read.
fn parse_value(joint: Element<'_>) -> Result<Vec<(String, f64)>, RobotError> {
    known(joint, &["name", "value"], &[])?;
    let name = joint.text("name")?;
    let named = |suffix: &str| format!("{name}/{suffix}");
    Ok(match joint.text("value")?.split_whitespace().count() {
        3 => {
            let [x, y, theta] = joint.numbers("value")?.unwrap_or_default();
            vec![(named("x"), x), (named("y"), y), (named("theta"), theta)]
        }
        7 => Vec::new(),
        _ => vec![(name.to_owned(), joint.number("value")?)],
    })
}

fn parse_end_effector(element: Element<'_>) -> Result<EndEffector, RobotError> {
    known(element, &["name", "group", "parent_link", "parent_group"], &[])?;
    Ok(EndEffector {
        name: element.text("name")?.to_owned(),
        group: element.text("group")?.to_owned(),
        parent_link: element.text("parent_link")?.to_owned(),
        parent_group: element.optional_text("parent_group").map(str::to_owned),
        at: element.at(),
    })
}
