use std::borrow::Cow;
use std::collections::{BTreeMap, HashSet};

use cranny_file::{counted, nearest_names};

use crate::description::xml::{Element, XmlText};
use crate::{Location, RobotError};

/// Elements of a URDF that no plan depends on, by the parent element (`*` for any).
const KNOWN_ELEMENTS: [(&str, &[&str]); 6] = [
    ("*", &["gazebo", "material", "sensor", "transmission", "actuator"]),
    ("robot", &["ros2_control", "mujoco"]),
    // By default a mesh represents its hull, and otherwise the more precise solid.
    ("mesh", &["drake:declare_convex"]),
    ("link", &["contact", "self_collision_checking"]),
    (
        "collision",
        &["contact_coefficients", "surface", "verbose", "max_contacts", "drake:proximity_properties"],
    ),
    (
        "joint",
        &[
            "dynamics",
            "safety_controller",
            "calibration",
            "hardwareInterface",
            "joint_properties",
            "drake:rotor_inertia",
            "drake:gear_ratio",
            "drake:controller_gains",
        ],
    ),
];

/// Attributes that no plan depends on, by element.
const KNOWN_ATTRIBUTES: [(&str, &[&str]); 7] = [
    ("link", &["type"]),
    // These repeat the other half of a symmetric matrix.
    ("inertia", &["iyx", "izx", "izy"]),
    ("visual", &["name"]),
    ("collision", &["name", "group", "concave"]),
    ("geometry", &["name"]),
    ("mesh", &["name"]),
    ("limit", &["damping", "friction"]),
];

/// Elements without effect by joint type, as many exporters write them.
const WITHOUT_EFFECT: [(&str, &[&str]); 2] =
    [("fixed", &["axis", "limit", "mimic"]), ("floating", &["axis"])];

/// Elements that contain others, but no value of their own.
const CONTAINERS: [&str; 3] = ["joint", "collision", "geometry"];

/// Versions of URDF whose additions are read: quaternions in 1.1; capsules, accelerations and jerks in 1.2.
const VERSIONS: [&str; 4] = ["1", "1.0", "1.1", "1.2"];

/// Compares a URDF with the content that was read from it, and returns a note for each kind of unread content that
/// affects neither geometry nor motion.
///
/// In a `<collision>` or `<joint>` all content is relevant: each element, attribute and text. In the rest of the file, an
/// element is relevant if it is, resembles or contains a link, joint or collision geometry.
///
/// # Errors
/// [`RobotError::NotUnderstood`] for the first relevant content that was not read.
pub(crate) fn unread(xml: &XmlText<'_>) -> Result<Vec<String>, RobotError> {
    let mut notes = Notes::default();
    walk(xml.robot()?, false, &mut notes)?;
    Ok(notes.lines())
}

/// First location in the file and number of further ones, by kind of content.
#[derive(Default)]
pub(crate) struct Notes(BTreeMap<String, (Location, usize)>);

impl Notes {
    pub(crate) fn add(&mut self, what: &str, holder: Element<'_>, at: Element<'_>) {
        let kind = format!("{what} of <{}>", holder.tag());
        self.0.entry(kind).and_modify(|(_, more)| *more += 1).or_insert_with(|| (at.at(), 0));
    }

    pub(crate) fn lines(self) -> Vec<String> {
        let line = |(kind, (first, more)): (String, (Location, usize))| match more {
            0 => format!("{first}: {kind} is not read"),
            _ => format!("{first}: {kind} is not read, here and at {}", counted(more, "more place")),
        };
        self.0.into_iter().map(line).collect()
    }
}

fn walk(element: Element<'_>, counts: bool, notes: &mut Notes) -> Result<(), RobotError> {
    let tag = &*element.tag();
    for name in element.unread_attributes() {
        let is_version = tag == "robot"
            && name == "version"
            && element.optional_text("version").is_some_and(|version| VERSIONS.contains(&version));
        if is_version || name.starts_with("xml:") || lists(&KNOWN_ATTRIBUTES, tag, &name) {
            continue;
        }
        let what = format!("attribute `{name}`");
        // The range of a continuous joint has no meaning (URDF specification).
        let is_idle_range = tag == "limit" && (name == "lower" || name == "upper");
        // The attribute is an extension of another program, unless it is one of URDF's own names under a prefix.
        let is_foreign = name.split_once(':').is_some_and(|(_, local)| !is_asked_for(element, local));
        if counts && !is_idle_range && !is_foreign {
            return Err(not_understood(element, element, what));
        }
        notes.add(&what, element, element);
    }
    if let Some(text) = element.own_text() {
        let what = format!("the text `{}`", cranny_file::excerpt(text));
        // Between elements a text is a remark, written without comment marks; inside an element it is a value.
        if counts && !CONTAINERS.contains(&tag) {
            return Err(not_understood(element, element, what));
        }
        notes.add(&what, element, element);
    }
    let read_tags: HashSet<Cow<'_, str>> =
        element.children_and_use().filter(|(_, is_read)| *is_read).map(|(child, _)| child.tag()).collect();
    for (child, is_read) in element.children_and_use() {
        let child_tag = &*child.tag();
        if is_read {
            let begins = matches!((tag, child_tag), ("link", "collision") | ("robot", "joint"));
            walk(child, counts || begins, notes)?;
        } else if !is_known_element(element, child_tag) {
            let is_second = read_tags.contains(child_tag);
            let what = match (is_second, tag) {
                (_, "geometry") => format!("a second shape, <{child_tag}>,"),
                (true, _) => format!("a second <{child_tag}>"),
                (false, _) => format!("element <{child_tag}>"),
            };
            if counts || matches!(tag, "robot" | "link") && resembles_structure(child) {
                return Err(not_understood(child, element, what));
            }
            notes.add(&what, element, child);
        }
    }
    Ok(())
}

fn lists(known: &[(&str, &[&str])], owner: &str, name: &str) -> bool {
    known.iter().any(|(tag, names)| (*tag == owner || *tag == "*") && names.contains(&name))
}

fn is_known_element(owner: Element<'_>, tag: &str) -> bool {
    let is_idle = || owner.optional_text("type").is_some_and(|kind| lists(&WITHOUT_EFFECT, kind, tag));
    lists(&KNOWN_ELEMENTS, &owner.tag(), tag) || owner.tag() == "joint" && is_idle()
}

fn is_asked_for(element: Element<'_>, name: &str) -> bool {
    element.asked_attributes().iter().any(|known| known.eq_ignore_ascii_case(name))
}

/// Returns true if a skipped element resembles a link, joint or geometry, contains one, or includes other files.
fn resembles_structure(element: Element<'_>) -> bool {
    const STRUCTURE: [&str; 4] = ["link", "joint", "collision", "geometry"];
    element.within().any(|element| {
        let tag = element.tag().to_ascii_lowercase();
        // Collision filters only select the tested pairs, and without them more pairs are tested.
        let is_filter = tag.contains("disable_collision") || tag.contains("collision_filter");
        let local = tag.rsplit(':').next().unwrap_or_default();
        let is_like = !nearest_names(local, STRUCTURE.iter().copied()).is_empty()
            || local.contains("include")
            || STRUCTURE.iter().any(|word| local.contains(word));
        is_like && !is_filter
    })
}

fn not_understood(at: Element<'_>, owner: Element<'_>, what: String) -> RobotError {
    let known = if what.starts_with("attribute") {
        owner.asked_attributes().iter().map(ToString::to_string).collect()
    } else if what.starts_with("element") {
        owner.asked_children().iter().map(|tag| format!("<{tag}>")).collect()
    } else {
        Vec::new()
    };
    RobotError::NotUnderstood { at: at.at(), what, owner: owner.title(), known }
}
