//! Files of a robot's folder, as texts with comments.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;

use cranny_collision::UncheckedReason;
use cranny_file::counted;
use cranny_robot::{HandDescription, Robot, ToolDescription};
use cranny_scenario::ScenarioError;

use crate::choice::Choice;
use crate::contact_search::SEARCH_SAMPLES;
use crate::limits::yaml_key;
use crate::self_contacts::{SELF_CONTACT_SAMPLES, SelfContact};

/// Content of the files.
pub(crate) struct Written {
    pub stem: String,
    pub limits: String,
    pub srdf: Option<String>,
    pub tip: Option<String>,
    pub solid_meshes: Vec<String>,
    /// Values of joints that stand still.
    pub fixed: BTreeMap<String, f64>,
    pub hand: Option<HandDescription>,
    pub tool: Option<ToolDescription>,
    pub floor_m: f64,
    pub start: BTreeMap<String, f64>,
    pub notes: Vec<String>,
}

impl Written {
    pub fn files(&self) -> Vec<(String, Vec<u8>)> {
        let mut files = vec![
            ("robot.yaml".to_owned(), self.description().into_bytes()),
            ("limits.yaml".to_owned(), self.limits.clone().into_bytes()),
        ];
        if let Some(srdf) = &self.srdf {
            files.push((format!("{}.srdf", self.stem), srdf.clone().into_bytes()));
        }
        files
    }

    /// Returns the text of `robot.yaml`.
    pub fn description(&self) -> String {
        let mut text = String::from(
            "# What the URDF of this robot does not say. `cranny robot check` tells what follows from it.\n",
        );
        for note in &self.notes {
            let _ = writeln!(text, "# {}", note.replace('\n', " "));
        }
        let _ = writeln!(text, "urdf: {}", yaml_key(&format!("{}.urdf", self.stem)));
        let _ = writeln!(
            text,
            "# Height of the ground that it stands on in its root frame, in metres.\nfloor_m: {}",
            self.floor_m
        );
        if let Some(tip) = &self.tip {
            let _ = writeln!(text, "# The link that grasps are reached with.\ntip: {}", yaml_key(tip));
        }
        if !self.solid_meshes.is_empty() {
            text.push_str("# Links whose meshes stand for what they enclose, not for their convex hull.\nsolid_meshes:\n");
            for link in &self.solid_meshes {
                let _ = writeln!(text, "  - {}", yaml_key(link));
            }
        }
        if !self.fixed.is_empty() {
            text.push_str("# The fingers stand open, in metres or radians.\nfixed:\n");
            for (joint, value) in &self.fixed {
                let _ = writeln!(text, "  {}: {value}", yaml_key(joint));
            }
        }
        if !self.start.is_empty() {
            text.push_str(
                "# Where it starts unless a scenario says otherwise, in metres or radians.\nstart:\n",
            );
            for (joint, value) in &self.start {
                let _ = writeln!(text, "  {}: {value}", yaml_key(joint));
            }
        }
        if let Some(tool) = &self.tool {
            let _ = writeln!(
                text,
                "# It has no pads that close along an axis: its grasps come from files.\ntool:\n  name: {}",
                yaml_key(&tool.name)
            );
            if let Some(tip) = &tool.tip {
                let _ = writeln!(
                    text,
                    "  # The gripper frame, to which grasps refer: z the approach direction.\n  tip: {}",
                    yaml_key(tip)
                );
            }
        }
        if let Some(hand) = &self.hand {
            let _ = writeln!(text, "hand:\n  name: {}", yaml_key(&hand.name));
            if let Some(tip) = &hand.tip {
                let _ = writeln!(
                    text,
                    "  # The gripper frame: between the pads, y the axis on which they close, z the approach direction.\n  \
                     tip: {}",
                    yaml_key(tip)
                );
            }
            if !hand.fingers.is_empty() {
                text.push_str("  # The joints that close it, in metres or radians; what mimics them closes with them.\n  fingers:\n");
                for (joint, range) in &hand.fingers {
                    let _ = writeln!(
                        text,
                        "    {}: {{open: {}, closed: {}}}",
                        yaml_key(joint),
                        range.open,
                        range.closed
                    );
                }
            }
            let _ = writeln!(
                text,
                "  # Between the open pads; how far behind the gripper frame the palm begins, in metres; newtons.\n  opening_m: {}\n  \
                 finger_depth_m: {}\n  closing_force_n: {}",
                hand.opening_m, hand.finger_depth_m, hand.closing_force_n
            );
        }
        text
    }
}

/// Returns an SRDF with the pairs of links that need no check, and those that touch in every sample.
pub(crate) fn srdf_text(robot: &Robot, contacts: &[SelfContact], extra: &[[String; 2]]) -> String {
    let name = |link: usize| robot.links()[link].name.as_str();
    let mut text = format!(
        "<?xml version=\"1.0\"?>\n<!-- Pairs of links that are not checked against each other. Of most it is proven that they \
         touch wherever the joints between\n     them stand, or nowhere. Others touched in {SEARCH_SAMPLES} configurations and at \
         the start, which is no proof: look at those,\n     and take out what does not touch in truth. -->\n<robot name=\"{}\">\n",
        escaped(robot.name())
    );
    for contact in contacts {
        if let Some(reason) = reason(contact) {
            let (a, b) = contact.links;
            text.push_str(&disabled(name(a), name(b), &reason));
        }
    }
    for [a, b] in extra {
        text.push_str(&disabled(a, b, "By design"));
    }
    text + "</robot>\n"
}

/// Extends an SRDF by the checked pairs that need no check, or touch in every sample.
pub(crate) fn with_always_pairs(own: &str, robot: &Robot, contacts: &[SelfContact]) -> String {
    let name = |link: usize| robot.links()[link].name.as_str();
    let line = |c: &SelfContact| Some(disabled(name(c.links.0), name(c.links.1), &reason(c)?));
    let lines: String = contacts.iter().filter(|contact| !contact.is_declared).filter_map(line).collect();
    match own.rfind("</robot>") {
        Some(end) => [&own[..end], &lines, &own[end..]].concat(),
        None => own.to_owned(),
    }
}

/// Returns the reason for a pair in the SRDF, or `None` if it is not written there.
fn reason(contact: &SelfContact) -> Option<String> {
    let depth_mm = contact.least_depth_m * 1000.0;
    match contact.unchecked {
        Some(UncheckedReason::AlwaysTouching) => {
            Some(format!("Always, proven: at least {depth_mm:.1} mm deep"))
        }
        Some(UncheckedReason::AdjacentTouching) => Some("Adjacent: always, proven".to_owned()),
        Some(UncheckedReason::AdjacentFree) => Some("Adjacent: never, proven".to_owned()),
        _ => contact.is_always().then(|| format!("Always in samples: at least {depth_mm:.1} mm deep")),
    }
}

/// Returns a line of an SRDF.
fn disabled(a: &str, b: &str, reason: &str) -> String {
    let (a, b) = (escaped(a), escaped(b));
    format!("  <disable_collisions link1=\"{a}\" link2=\"{b}\" reason=\"{reason}\"/>\n")
}

pub(crate) fn pairs_choice(robot: &Robot, contacts: &[SelfContact], is_own: bool, stem: &str) -> Choice {
    let name = |link: usize| robot.links()[link].name.as_str();
    let count = |is: &dyn Fn(&SelfContact) -> bool| contacts.iter().filter(|contact| is(contact)).count();
    let pair = |c: &SelfContact| {
        format!(
            "{} and {}, at least {:.1} mm deep",
            name(c.links.0),
            name(c.links.1),
            c.least_depth_m * 1000.0
        )
    };
    let mut parts = Vec::new();
    if is_own {
        parts.push(format!("{}, as declared in its SRDF", counted(robot.disabled_pairs().len(), "pair")));
    }
    let adjacent = count(&|contact| contact.is_adjacent && contact.is_proven());
    parts.push(format!("{} proven to touch always or never", counted(adjacent, "adjacent pair")));
    let proven = contacts.iter().filter(|c| c.unchecked == Some(UncheckedReason::AlwaysTouching)).map(pair);
    parts.extend(proven.map(|pair| format!("{pair}, in every configuration, proven")));
    let sampled: Vec<String> = contacts
        .iter()
        .filter(|contact| contact.is_always())
        .map(|contact| format!("{} ({} can have been missed)", pair(contact), contact.missed))
        .collect();
    if !sampled.is_empty() {
        parts.push(format!(
            "{} that touched in all of {SEARCH_SAMPLES} configurations and at the start, which is no proof; \
             contacts of these pairs are never reported: {}",
            counted(sampled.len(), "pair"),
            sampled.join(", ")
        ));
    }
    let never = count(&|contact| contact.touching == 0);
    parts.push(format!("{never} never touched and are checked all the same"));
    Choice {
        what: "unchecked pairs",
        chosen: parts.join("; "),
        why: format!("proofs, and {SELF_CONTACT_SAMPLES} drawn configurations"),
        otherwise: format!("take lines out of {stem}.srdf"),
    }
}

/// Writes files, given by name with slashes, into a folder.
pub(crate) fn write(folder: &Path, files: &BTreeMap<String, Vec<u8>>) -> Result<(), ScenarioError> {
    for (name, content) in files {
        let path = folder.join(name);
        let parent = path.parent().unwrap_or(folder);
        let written = std::fs::create_dir_all(parent).and_then(|()| std::fs::write(&path, content));
        written.map_err(|reason| ScenarioError::Unwritable { path, reason })?;
    }
    Ok(())
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;")
}
