use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use crate::description::text_source::read;
use crate::model_file::body_tree::{BodyTree, JointRule, Plane};
use crate::model_file::urdf_writer::{LinkPlan, ModelUse};
use crate::{DEFAULT_SPEED_M_S, DEFAULT_SPEED_RAD_S, JointKind, RobotError, UrdfText, mjcf, sdf};

/// Model of a robot or a world as URDF: the text itself, or an MJCF or SDF model converted to one.
#[derive(Clone, Debug, Default)]
pub struct ModelText {
    /// Text of the URDF. Names of meshes are relative to the folder of the model.
    pub urdf: String,
    /// Text of an SRDF with the pairs of links that have no contacts in the model, and its named states; `None` for a URDF.
    pub srdf: Option<String>,
    /// Text of a `limits.yaml` with default speeds of the joints without one; `None` for a URDF.
    pub limits: Option<String>,
    /// Content of the model that was not read, one line for each kind; empty for a URDF, which [`Robot`](crate::Robot) reads.
    pub notes: Vec<String>,
    /// Links of each body that moves freely in the world, the body's own first.
    pub movable: Vec<Vec<String>>,
    /// Half-spaces of the world.
    pub planes: Vec<Plane>,
    /// Values (m, rad) of joints at which bodies have the poses of the file, where it is not 0.
    pub references: BTreeMap<String, f64>,
}

impl ModelText {
    /// Reads a model file. Its outermost element decides the format: `<robot>`, `<mujoco>` or `<sdf>`.
    ///
    /// `folders` are searched for the models that an SDF includes, before the environment's and the folders above the file.
    ///
    /// # Errors
    /// As [`Self::of`], and [`RobotError::Unreadable`].
    pub fn read(path: &Path, purpose: ModelUse, folders: &[PathBuf]) -> Result<Self, RobotError> {
        Self::of(read(cranny_file::TEXT, path)?, path, purpose, folders)
    }

    /// Converts the text of the model at `path`.
    ///
    /// # Errors
    /// [`RobotError::NotSupported`] and [`RobotError::NotUnderstood`] for content of an MJCF or SDF that would change geometry
    /// or motion; any fault of the text.
    pub fn of(text: String, path: &Path, purpose: ModelUse, folders: &[PathBuf]) -> Result<Self, RobotError> {
        let tree = match root_tag(&text) {
            Some("mujoco") => mjcf::read(text, path)?,
            Some("sdf") => sdf::read(&text, path, folders)?,
            _ => return Ok(Self { urdf: text, ..Self::default() }),
        };
        Self::of_tree(&tree, path, purpose)
    }

    /// Name of the URDF in errors: lines of a converted one are not those of the file.
    pub fn name_of(&self, path: &Path) -> String {
        let file = path.display();
        if self.srdf.is_some() { format!("{file}, as URDF") } else { file.to_string() }
    }

    fn of_tree(tree: &BodyTree, path: &Path, purpose: ModelUse) -> Result<Self, RobotError> {
        let file = path.display().to_string();
        let mut plan = LinkPlan::of(tree, purpose);
        let urdf = tree.urdf(&mut plan, purpose);
        let mut notes = tree.notes.clone();
        let is_left_out = |(body, links): (usize, &Vec<_>)| links.is_empty() && tree.is_object(body);
        let objects = plan.links.iter().enumerate().filter(|(body, links)| is_left_out((*body, *links)));
        let objects: Vec<&str> = objects.map(|(body, _)| tree.bodies[body].name.as_str()).collect();
        if !objects.is_empty() {
            notes.push(format!("{file}: free bodies are no part of the robot: {}", objects.join(", ")));
        }
        if purpose == ModelUse::Robot && !tree.planes.is_empty() {
            let planes: Vec<&str> = tree.planes.iter().map(|plane| plane.name.as_str()).collect();
            notes.push(format!("{file}: planes are no part of the robot: {}", planes.join(", ")));
        }
        let references = tree.bodies.iter().flat_map(|body| &body.joints);
        let references = references
            .filter(|joint| joint.reference != 0.0 && joint.rule == JointRule::Free)
            .map(|joint| (joint.name.clone(), joint.reference))
            .collect();
        let srdf = tree.srdf(&plan);
        if purpose == ModelUse::Robot {
            notes.extend(BodyTree::mask_note(&srdf, &file));
        }
        Ok(Self {
            srdf: Some(srdf),
            limits: Some(default_limits(&UrdfText::new(urdf.clone(), &file)?)?),
            movable: movable(tree, &plan),
            planes: tree.planes.clone(),
            references,
            notes,
            urdf,
        })
    }
}

/// Returns the links of each free body with what is fixed or jointed to it.
fn movable(tree: &BodyTree, plan: &LinkPlan) -> Vec<Vec<String>> {
    let mut group_of: Vec<Option<usize>> = Vec::with_capacity(tree.bodies.len());
    let mut groups: Vec<Vec<String>> = Vec::new();
    for (body, links) in tree.bodies.iter().zip(&plan.links) {
        let above = body.parent.and_then(|parent| group_of[parent]);
        let group = if body.is_free { Some(groups.len()) } else { above };
        if body.is_free {
            groups.push(Vec::new());
        }
        if let Some(group) = group {
            groups[group].extend(links.iter().map(|link| link.name.clone()));
        }
        group_of.push(group);
    }
    groups
}

/// Returns a `limits.yaml` with a speed for each joint that moves freely and has none.
fn default_limits(urdf: &UrdfText) -> Result<String, RobotError> {
    let mut text = String::new();
    for joint in urdf.joints()? {
        let Some(motion) = joint.motion else { continue };
        if motion.mimics.is_some() || motion.velocity.is_some_and(|speed| speed > 0.0) {
            continue;
        }
        let speed = match motion.kind {
            JointKind::Revolute => DEFAULT_SPEED_RAD_S,
            JointKind::Prismatic => DEFAULT_SPEED_M_S,
        };
        let _ = writeln!(text, "  {:?}: {{velocity: {speed}}}", joint.name);
    }
    Ok(if text.is_empty() { "joints: {}\n".to_owned() } else { format!("joints:\n{text}") })
}

/// Returns the name of the outermost element of an XML text.
fn root_tag(text: &str) -> Option<&str> {
    let mut rest = text;
    loop {
        rest = &rest[rest.find('<')?..];
        let skipped = [("<!--", "-->"), ("<?", "?>"), ("<!", ">")];
        let Some((_, end)) = skipped.iter().find(|(start, _)| rest.starts_with(start)) else {
            let name = &rest[1..];
            return name.split(|c: char| c.is_ascii_whitespace() || c == '>' || c == '/').next();
        };
        rest = &rest[rest.find(end)? + end.len()..];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_outermost_element_is_found_behind_comments() {
        for (text, expected) in [
            ("<mujoco model='a'/>", Some("mujoco")),
            ("<?xml version='1.0'?>\n<!-- <robot> -->\n<sdf version='1.9'>", Some("sdf")),
            ("<!DOCTYPE robot><robot>", Some("robot")),
            ("no element", None),
            ("<!-- no end", None),
        ] {
            assert_eq!(root_tag(text), expected, "{text}");
        }
    }
}
