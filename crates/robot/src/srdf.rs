use crate::tree::MAX_LINKS;
use crate::xml::{Element, XmlText};
use crate::{Location, RobotError};

/// What an SRDF says about groups, states and pairs of links; names are checked against a robot when the
/// two are put together.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Srdf {
    /// Named sets of joints.
    pub groups: Vec<SrdfGroup>,
    /// Named values for the joints of a group.
    pub group_states: Vec<GroupState>,
    /// Hands and tools.
    pub end_effectors: Vec<EndEffector>,
    /// Pairs of links that are never tested against each other.
    pub disabled_pairs: Vec<(String, String)>,
    /// Where each of `disabled_pairs` stands.
    pub(crate) disabled_at: Vec<Location>,
}

/// A named set of joints: all those of its chains, links, joints and sub-groups.
#[derive(Clone, Debug, PartialEq)]
pub struct SrdfGroup {
    /// Its name.
    pub name: String,
    /// Base link and tip link of each chain.
    pub chains: Vec<(String, String)>,
    /// Joints named one by one.
    pub joints: Vec<String>,
    /// Links, each standing for the joint above it.
    pub links: Vec<String>,
    /// Names of groups that this one contains.
    pub subgroups: Vec<String>,
    /// Where it stands.
    pub at: Location,
}

/// Named values for joints.
#[derive(Clone, Debug, PartialEq)]
pub struct GroupState {
    /// Its name.
    pub name: String,
    /// The group it is for.
    pub group: String,
    /// Joint and value, in metres or radians.
    pub values: Vec<(String, f64)>,
    /// Where it stands.
    pub at: Location,
}

/// A hand or tool.
#[derive(Clone, Debug, PartialEq)]
pub struct EndEffector {
    /// Its name.
    pub name: String,
    /// The group of its own joints.
    pub group: String,
    /// The link that it is mounted on.
    pub parent_link: String,
    /// The group that moves it, if said.
    pub parent_group: Option<String>,
    /// Where it stands.
    pub at: Location,
}

impl Srdf {
    /// Reads an SRDF from `text`; `file` is the name for it in errors.
    ///
    /// # Errors
    /// XML that is not well-formed, an attribute missing, a value that is no number.
    pub fn parse(text: &str, file: &str) -> Result<Self, RobotError> {
        let xml = XmlText::parse(text, file)?;
        let robot = xml.robot()?;
        let mut srdf = Self::default();
        for element in robot.children() {
            match &*element.tag() {
                "group" => srdf.groups.push(parse_group(element)?),
                "group_state" => srdf.group_states.push(parse_state(element)?),
                "end_effector" => srdf.end_effectors.push(parse_end_effector(element)?),
                "disable_collisions" => {
                    let pair = (element.text("link1")?.to_owned(), element.text("link2")?.to_owned());
                    srdf.disabled_pairs.push(pair);
                    srdf.disabled_at.push(element.at());
                }
                _ => {}
            }
        }
        // Groups may hold groups, and are looked up by their name.
        if let Some(extra) = srdf.groups.get(MAX_LINKS) {
            let (at, actual) = (extra.at.clone(), srdf.groups.len());
            return Err(RobotError::TooMany { at, what: "groups in one SRDF", most: MAX_LINKS, actual });
        }
        Ok(srdf)
    }

    /// The group of that name.
    pub fn group(&self, name: &str) -> Option<&SrdfGroup> {
        self.groups.iter().find(|group| group.name == name)
    }
}

fn parse_group(element: Element<'_>) -> Result<SrdfGroup, RobotError> {
    let names = |tag| -> Result<Vec<String>, RobotError> {
        element.all(tag).map(|child| Ok(child.text("name")?.to_owned())).collect()
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
    Ok(GroupState {
        name: element.text("name")?.to_owned(),
        group: element.text("group")?.to_owned(),
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

/// The value of a joint; of a planar one three, which stand for the three joints that it is here. Of a floating one
/// `MoveIt` writes a quaternion: that is not read.
fn parse_value(joint: Element<'_>) -> Result<Vec<(String, f64)>, RobotError> {
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
    Ok(EndEffector {
        name: element.text("name")?.to_owned(),
        group: element.text("group")?.to_owned(),
        parent_link: element.text("parent_link")?.to_owned(),
        parent_group: element.optional_text("parent_group").map(str::to_owned),
        at: element.at(),
    })
}
