use std::ops::Range;

use cranny_spatial::Pose;

use crate::description::urdf_model::{Urdf, UrdfJoint, UrdfJointKind};
use crate::description::xml::{XmlText, known_prefixes};
use crate::tree::Tree;
use crate::{JointKind, RobotError};

/// Text of a URDF, to be combined with others; its content is preserved.
#[derive(Clone, Debug)]
pub struct UrdfText {
    text: String,
    file: String,
}

/// Joint between two assembled robots.
#[derive(Clone, Debug)]
pub struct MountingJoint {
    /// Name of the joint.
    pub name: String,
    /// Type of the joint: `fixed`, `planar` or `floating`.
    pub kind: &'static str,
    /// Pose of the carried robot's root in the mount frame with the joint at 0.
    pub mount_from_carried: Pose,
}

impl UrdfText {
    /// Checks that `text` is a URDF; `file` is its name in errors.
    ///
    /// # Errors
    /// Any fault of the URDF: see [`RobotError`].
    pub fn new(text: String, file: &str) -> Result<Self, RobotError> {
        Tree::of(&Urdf::parse(&text, file)?)?;
        Ok(Self { text, file: file.to_owned() })
    }

    /// Text of the URDF.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Name in errors.
    pub fn file(&self) -> &str {
        &self.file
    }

    /// Returns the name of the robot.
    ///
    /// # Errors
    /// None for a text that has been checked.
    pub fn robot_name(&self) -> Result<String, RobotError> {
        Ok(Urdf::parse(&self.text, &self.file)?.name)
    }

    /// Returns this URDF with one more link, a bare frame fixed to the link `parent`.
    ///
    /// # Errors
    /// [`RobotError::UnknownName`] for an unknown parent, [`RobotError::DefinedTwice`] for a name that exists.
    pub fn with_frame(&self, name: &str, parent: &str, parent_from_frame: &Pose) -> Result<Self, RobotError> {
        let (name, parent) = (escaped(name), escaped(parent));
        let origin = origin(parent_from_frame);
        let added = format!(
            "\n  <link name=\"{name}\"/>\n  <joint name=\"{name}_joint\" type=\"fixed\">\n    <parent \
             link=\"{parent}\"/>\n    <child link=\"{name}\"/>\n    {origin}\n  </joint>\n"
        );
        self.with(&added)
    }

    /// Returns this URDF without the collision geometry of a link, which becomes a bare frame.
    ///
    /// # Errors
    /// None for a text that has been checked.
    pub fn without_body(&self, link: &str) -> Result<Self, RobotError> {
        let known = known_prefixes(&self.text);
        let xml = XmlText::parse(&known, &self.file)?;
        let robot = xml.robot()?;
        let named = robot.all("link").filter(|element| element.optional_text("name") == Some(link));
        let bodies = named.flat_map(|link| link.all("collision")).map(|collision| (collision.place(), ""));
        let text = replaced(&self.text, bodies);
        Self::new(text, &self.file)
    }

    /// Returns this robot with `carried` mounted on its link `mount`.
    ///
    /// # Errors
    /// As [`Self::with_frame`], also for names that occur in both.
    pub fn carrying(&self, mount: &str, carried: &Self, joint: &MountingJoint) -> Result<Self, RobotError> {
        let urdf = Urdf::parse(&carried.text, &carried.file)?;
        let root = &urdf.links[Tree::of(&urdf)?.nodes[0].link].name;
        let (root, mount, name) = (escaped(root), escaped(mount), escaped(&joint.name));
        let (kind, origin) = (joint.kind, origin(&joint.mount_from_carried));
        let (begin, end) = carried.inside()?;
        let axis = if kind == "planar" { "\n    <axis xyz=\"0 0 1\"/>" } else { "" };
        let added = format!(
            "{}\n  <joint name=\"{name}\" type=\"{kind}\">\n    <parent link=\"{mount}\"/>\n    <child \
             link=\"{root}\"/>\n    {origin}{axis}\n  </joint>\n",
            &carried.text[begin..end]
        );
        self.with(&added)
    }

    fn with(&self, added: &str) -> Result<Self, RobotError> {
        let (_, end) = self.inside()?;
        let mut text = self.text.clone();
        // An element without content has no end tag.
        if text[..end].ends_with('/') {
            text.replace_range(end - 1..text.len(), &format!(">{added}</robot>\n"));
        } else {
            text.insert_str(end, added);
        }
        Self::new(text, &self.file)
    }

    /// Returns the start and end offset of the content of the outermost element.
    fn inside(&self) -> Result<(usize, usize), RobotError> {
        let known = known_prefixes(&self.text);
        let xml = XmlText::parse(&known, &self.file)?;
        Ok(xml.robot()?.inside())
    }

    /// Returns the joints in the order of the file; a planar or floating one as the joints that represent it.
    ///
    /// # Errors
    /// None for a text that has been checked.
    pub fn joints(&self) -> Result<Vec<JointFacts>, RobotError> {
        let facts = |joint: UrdfJoint| {
            let motion = joint.motion.map(|motion| JointMotion {
                kind: motion.kind.into(),
                is_continuous: motion.kind == UrdfJointKind::Continuous,
                mimics: motion.mimic.map(|mimic| mimic.master),
                range: [motion.limits.lower, motion.limits.upper],
                velocity: motion.limits.velocity,
                effort: motion.limits.effort,
                acceleration: motion.limits.acceleration,
                jerk: motion.limits.jerk,
            });
            JointFacts { name: joint.name, parent: joint.parent, child: joint.child, motion }
        };
        Ok(Urdf::parse(&self.text, &self.file)?.joints.into_iter().map(facts).collect())
    }
}

/// Data of a joint of a URDF.
#[derive(Clone, Debug)]
pub struct JointFacts {
    /// Name of the joint.
    pub name: String,
    /// Parent link.
    pub parent: String,
    /// Child link.
    pub child: String,
    /// Motion of the joint; `None` for a fixed one.
    pub motion: Option<JointMotion>,
}

/// Motion of a joint of a URDF.
#[derive(Clone, Debug)]
pub struct JointMotion {
    /// Revolute or prismatic.
    pub kind: JointKind,
    /// True if it turns without end.
    pub is_continuous: bool,
    /// Name of the joint that it mimics, if any.
    pub mimics: Option<String>,
    /// Lower and upper limit (m, rad).
    pub range: [f64; 2],
    /// Maximum speed (m/s, rad/s), as written; often 0 for an unknown one.
    pub velocity: Option<f64>,
    /// Maximum force or torque of its drive (N, N m), if a number above 0 is written.
    pub effort: Option<f64>,
    /// Maximum acceleration (m/s², rad/s²), if URDF 1.2 gives one.
    pub acceleration: Option<f64>,
    /// Maximum jerk (m/s³, rad/s³), if URDF 1.2 gives one.
    pub jerk: Option<f64>,
}

/// Returns `text` with each range replaced by another text; the ranges are ascending and disjoint.
pub(crate) fn replaced<'t>(
    text: &str,
    replacements: impl IntoIterator<Item = (Range<usize>, &'t str)>,
) -> String {
    let (mut replaced, mut end) = (String::with_capacity(text.len()), 0);
    for (range, replacement) in replacements {
        replaced.push_str(&text[end..range.start]);
        replaced.push_str(replacement);
        end = range.end;
    }
    replaced.push_str(&text[end..]);
    replaced
}

pub(crate) fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;")
}

/// Returns an `<origin>` with the pose in full precision.
fn origin(pose: &Pose) -> String {
    let [x, y, z] = pose.translation.vector.into();
    let (roll, pitch, yaw) = pose.rotation.euler_angles();
    format!("<origin xyz=\"{x} {y} {z}\" rpy=\"{roll} {pitch} {yaw}\"/>")
}
