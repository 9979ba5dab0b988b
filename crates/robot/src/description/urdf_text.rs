use cranny_spatial::Pose;

use crate::description::urdf_model::{Urdf, UrdfJoint, UrdfJointKind};
use crate::description::xml::{XmlText, known_prefixes};
use crate::tree::Tree;
use crate::{JointKind, RobotError};

/// The text of a URDF, to be put together with others; everything that is in it stays in it.
#[derive(Clone, Debug)]
pub struct UrdfText {
    text: String,
    file: String,
}

/// How one part of a robot is fixed to another, or moves on it.
#[derive(Clone, Debug)]
pub struct MountingJoint {
    /// The name of the joint.
    pub name: String,
    /// Its type: `fixed`, `planar` or `floating`.
    pub kind: &'static str,
    /// Where what is carried stands while the joint is at 0.
    pub mount_from_carried: Pose,
}

impl UrdfText {
    /// A text that is a URDF; `file` is the name for it in errors.
    ///
    /// # Errors
    /// Whatever makes it none: see [`RobotError`].
    pub fn new(text: String, file: &str) -> Result<Self, RobotError> {
        Tree::of(&Urdf::parse(&text, file)?)?;
        Ok(Self { text, file: file.to_owned() })
    }

    /// The text.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// What errors call it.
    pub fn file(&self) -> &str {
        &self.file
    }

    /// The name of the robot in it.
    ///
    /// # Errors
    /// None for a text that was checked.
    pub fn robot_name(&self) -> Result<String, RobotError> {
        Ok(Urdf::parse(&self.text, &self.file)?.name)
    }

    /// The same with one more link, which is a bare frame fixed to the link `parent`.
    ///
    /// # Errors
    /// [`RobotError::UnknownName`] for a parent that is not there, [`RobotError::DefinedTwice`] for a name that is.
    pub fn with_frame(&self, name: &str, parent: &str, parent_from_frame: &Pose) -> Result<Self, RobotError> {
        let (name, parent) = (escaped(name), escaped(parent));
        let origin = origin(parent_from_frame);
        let added = format!(
            "\n  <link name=\"{name}\"/>\n  <joint name=\"{name}_joint\" type=\"fixed\">\n    <parent \
             link=\"{parent}\"/>\n    <child link=\"{name}\"/>\n    {origin}\n  </joint>\n"
        );
        self.with(&added)
    }

    /// The same without the collision geometry of a link, which then is a frame.
    ///
    /// # Errors
    /// None for a text that was checked.
    pub fn without_body(&self, link: &str) -> Result<Self, RobotError> {
        let known = known_prefixes(&self.text);
        let xml = XmlText::parse(&known, &self.file)?;
        let robot = xml.robot()?;
        let named = robot.all("link").filter(|element| element.optional_text("name") == Some(link));
        let mut places: Vec<_> =
            named.flat_map(|link| link.all("collision")).map(|collision| collision.place()).collect();
        // From the last to the first, so that the places of the others stay.
        places.sort_by_key(|place| std::cmp::Reverse(place.start));
        let mut text = self.text.clone();
        for place in places {
            text.replace_range(place, "");
        }
        Self::new(text, &self.file)
    }

    /// This robot with `carried` on its link `mount`.
    ///
    /// # Errors
    /// As [`Self::with_frame`], also for names that both have.
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

    /// Where the content of the outermost element begins and ends.
    fn inside(&self) -> Result<(usize, usize), RobotError> {
        let known = known_prefixes(&self.text);
        let xml = XmlText::parse(&known, &self.file)?;
        Ok(xml.robot()?.inside())
    }

    /// What it says of its joints, in the order of the file; a planar or floating one as the joints that it stands for.
    ///
    /// # Errors
    /// None for a text that was checked.
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

/// What a URDF says of a joint.
#[derive(Clone, Debug)]
pub struct JointFacts {
    /// Its name.
    pub name: String,
    /// The link above.
    pub parent: String,
    /// The link below.
    pub child: String,
    /// How it moves; `None` for a fixed one.
    pub motion: Option<JointMotion>,
}

/// How a joint of a URDF moves.
#[derive(Clone, Debug)]
pub struct JointMotion {
    /// Whether it turns or slides.
    pub kind: JointKind,
    /// Whether it turns without end.
    pub is_continuous: bool,
    /// The joint that it follows, if it does.
    pub mimics: Option<String>,
    /// Its limits (m, rad).
    pub range: [f64; 2],
    /// Its greatest speed (m/s, rad/s), as it is written; often 0 where nobody knows it.
    pub velocity: Option<f64>,
    /// The greatest force or torque of its drive (N, N m), if a number above 0 is written.
    pub effort: Option<f64>,
    /// Its greatest acceleration (m/s², rad/s²), if URDF 1.2 gives one.
    pub acceleration: Option<f64>,
    /// Its greatest jerk (m/s³, rad/s³), likewise.
    pub jerk: Option<f64>,
}

/// Text as XML reads it back.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;")
}

/// An `<origin>`, as exact as numbers are.
fn origin(pose: &Pose) -> String {
    let [x, y, z] = pose.translation.vector.into();
    let (roll, pitch, yaw) = pose.rotation.euler_angles();
    format!("<origin xyz=\"{x} {y} {z}\" rpy=\"{roll} {pitch} {yaw}\"/>")
}
