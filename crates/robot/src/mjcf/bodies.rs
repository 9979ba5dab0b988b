use cranny_spatial::nalgebra::Matrix3;
use cranny_spatial::{Pose, Vector};

use crate::description::xml::Element;
use crate::mjcf::body_reader::BodyReader;
use crate::mjcf::compiler::Masses;
use crate::mjcf::defaults::Attributes;
use crate::mjcf::geoms::Geom;
use crate::model_file::body_tree::{JointRule, Plane, TreeBody, TreeJoint};
use crate::model_file::hull_points::check_points;
use crate::model_file::unread_list::{check_name, not_supported};
use crate::tree::MAX_LINKS;
use crate::{Inertial, JointKind, RobotError};

/// Maximum number of bodies and frames inside each other; each is read by a call of its own.
const MOST_DEPTH: usize = 256;

/// Attributes of `<body>` that are read.
const BODY: [&str; 9] =
    ["name", "childclass", "pos", "quat", "axisangle", "euler", "xyaxes", "zaxis", "mocap"];

/// Attributes of `<joint>` that are read.
const JOINT: [&str; 8] = ["name", "class", "type", "pos", "axis", "range", "limited", "ref"];

/// Attributes of `<joint>` that affect forces alone.
const JOINT_IGNORED: [&str; 18] = [
    "group",
    "springdamper",
    "solreflimit",
    "solimplimit",
    "solreffriction",
    "solimpfriction",
    "stiffness",
    "actuatorfrcrange",
    "actuatorfrclimited",
    "actuatorgravcomp",
    "margin",
    "springref",
    "armature",
    "damping",
    "frictionloss",
    "user",
    "align",
    "limit",
];

/// Context of the elements inside a body or frame.
#[derive(Clone, Copy)]
struct Inside<'c> {
    body: usize,
    body_from_frame: Pose,
    childclass: Option<&'c str>,
    depth: usize,
}

impl<'d> BodyReader<'d, '_> {
    /// Reads a `<worldbody>` into the first body.
    pub(crate) fn read_world(&mut self, world: Element<'d>) -> Result<(), RobotError> {
        let inside = Inside { body: 0, body_from_frame: Pose::identity(), childclass: None, depth: 0 };
        self.read_inside(world, inside)
    }

    fn read_inside(&mut self, owner: Element<'d>, inside: Inside<'_>) -> Result<(), RobotError> {
        if inside.depth > MOST_DEPTH {
            let (at, what) = (owner.at(), "bodies inside each other");
            return Err(RobotError::TooMany { at, what, most: MOST_DEPTH, actual: inside.depth });
        }
        for element in self.documents.children(owner) {
            match &*element.tag() {
                "body" => self.body(element, inside)?,
                "frame" => {
                    self.unread.check_attributes(element, &BODY, &[])?;
                    let attributes = self.classes.of(element, None)?;
                    let childclass = element.optional_text("childclass").or(inside.childclass);
                    let body_from_frame = inside.body_from_frame * self.compiler.pose(&attributes)?;
                    let depth = inside.depth + 1;
                    self.read_inside(element, Inside { body_from_frame, childclass, depth, ..inside })?;
                }
                "joint" => self.joint(element, inside)?,
                "freejoint" => self.free_joint(element, inside)?,
                "geom" => self.add_geom(element, inside)?,
                "inertial" => {
                    let stated = self.inertial(element)?;
                    self.bodies[inside.body].inertial =
                        stated.filter(|_| self.compiler.masses == Masses::Stated);
                }
                "site" | "camera" | "light" => self.unread.add(owner, element),
                tag => {
                    let hint = "export the compiled model, for example by mj_saveLastXML";
                    return Err(not_supported(element, format!("<{tag}> in a body"), hint));
                }
            }
        }
        Ok(())
    }

    fn body(&mut self, element: Element<'d>, inside: Inside<'_>) -> Result<(), RobotError> {
        self.unread.check_attributes(element, &BODY, &["gravcomp", "user", "sleep"])?;
        if self.bodies.len() > MAX_LINKS {
            let (at, actual) = (element.at(), self.bodies.len());
            return Err(RobotError::TooMany { at, what: "bodies in one model", most: MAX_LINKS, actual });
        }
        let attributes = self.classes.of(element, None)?;
        let index = self.bodies.len();
        let name = self.name_of(element, "body", index)?;
        let parent_from_body = inside.body_from_frame * self.compiler.pose(&attributes)?;
        self.bodies.push(TreeBody::bare(name, Some(inside.body), parent_from_body));
        let childclass = element.optional_text("childclass").or(inside.childclass);
        let (body_from_frame, depth) = (Pose::identity(), inside.depth + 1);
        self.read_inside(element, Inside { body: index, body_from_frame, childclass, depth })
    }

    /// Returns the name of an element, or one made of its index if it has none.
    fn name_of(
        &mut self,
        element: Element<'_>,
        kind: &'static str,
        index: usize,
    ) -> Result<String, RobotError> {
        let given = element.optional_text("name").filter(|name| !name.is_empty());
        let name = given.map_or_else(|| format!("{kind}_{index}"), str::to_owned);
        check_name(element, &name)?;
        // A body and a joint may have the same name.
        if !self.names.insert(format!("{kind} {name}")) {
            return Err(not_supported(
                element,
                format!("a second {kind} `{name}`"),
                "give each its own name",
            ));
        }
        Ok(name)
    }

    fn joint(&mut self, element: Element<'d>, inside: Inside<'_>) -> Result<(), RobotError> {
        self.unread.check_attributes(element, &JOINT, &JOINT_IGNORED)?;
        let attributes = self.classes.of(element, inside.childclass)?;
        let kind = match attributes.text("type").unwrap_or("hinge") {
            "hinge" => JointKind::Revolute,
            "slide" => JointKind::Prismatic,
            "free" => return self.free_joint(element, inside),
            other => {
                let (at, joint) =
                    (element.at(), element.optional_text("name").unwrap_or_default().to_owned());
                return Err(RobotError::UnsupportedJoint { at, joint, kind: other.to_owned() });
            }
        };
        let name = self.name_of(element, "joint", self.order.len())?;
        let Inside { body_from_frame, body, .. } = inside;
        let axis = attributes.vector("axis")?.unwrap_or_else(Vector::z).try_normalize(1e-10);
        let axis = axis.ok_or_else(|| RobotError::ZeroAxis { at: element.at(), joint: name.clone() })?;
        let anchor = body_from_frame.rotation * attributes.vector("pos")?.unwrap_or_default()
            + body_from_frame.translation.vector;
        let in_file = |value: f64| match kind {
            JointKind::Revolute => self.compiler.radians(value),
            JointKind::Prismatic => value,
        };
        let [reference] = attributes.numbers("ref")?.map(|[value]| [in_file(value)]).unwrap_or_default();
        let joint = TreeJoint {
            range: self.range(&attributes)?.map(|range| range.map(in_file)),
            name: name.clone(),
            kind,
            anchor,
            axis: body_from_frame.rotation * axis,
            reference,
            rule: JointRule::Free,
            velocity: None,
            effort: None,
        };
        if self.bodies[body].is_free {
            return Err(not_supported(element, "a joint beside a free joint", "give the body one of them"));
        }
        self.bodies[body].joints.push(joint);
        self.order.push((Some(name), 1));
        Ok(())
    }

    /// Returns the range of a joint in the units of the file, if it is limited (XML reference, joint: limited).
    fn range(&self, attributes: &Attributes<'_>) -> Result<Option<[f64; 2]>, RobotError> {
        let Some([lower, upper]) = attributes.numbers("range")? else { return Ok(None) };
        let is_limited = match attributes.text("limited") {
            Some("true" | "1") => true,
            Some("false" | "0") => false,
            _ => self.compiler.finds_limits && lower < upper,
        };
        Ok(is_limited.then_some([lower, upper]))
    }

    fn free_joint(&mut self, element: Element<'d>, inside: Inside<'_>) -> Result<(), RobotError> {
        if self.bodies[inside.body].parent != Some(0) || !self.bodies[inside.body].joints.is_empty() {
            let hint = "only a body of the world moves freely, without other joints";
            return Err(not_supported(element, "a free joint here", hint));
        }
        self.bodies[inside.body].is_free = true;
        self.order.push((None, 7));
        Ok(())
    }

    fn add_geom(&mut self, element: Element<'d>, inside: Inside<'_>) -> Result<(), RobotError> {
        match self.geom(element, inside.childclass)? {
            Geom::Nothing | Geom::Plane(None) => {}
            Geom::Shape(mut shape) => {
                shape.body_from_shape = inside.body_from_frame * shape.body_from_shape;
                self.points = check_points(element, &shape.form, self.points)?;
                self.bodies[inside.body].shapes.push(shape);
            }
            Geom::Plane(Some(pose)) => {
                let Some(world_from_body) = self.world_from_static(inside.body) else {
                    return Err(not_supported(element, "a plane that moves", "give a box"));
                };
                let name = element.optional_text("name").map(str::to_owned);
                let name = name.unwrap_or_else(|| format!("plane_{}", self.planes.len()));
                let world_from_plane = world_from_body * inside.body_from_frame * pose;
                self.planes.push(Plane { name, world_from_plane });
            }
        }
        Ok(())
    }

    /// Returns the pose of a body that does not move, or `None`.
    fn world_from_static(&self, mut body: usize) -> Option<Pose> {
        let mut world_from_body = Pose::identity();
        while let Some(parent) = self.bodies[body].parent {
            if self.bodies[body].is_free || !self.bodies[body].joints.is_empty() {
                return None;
            }
            world_from_body = self.bodies[body].parent_from_body * world_from_body;
            body = parent;
        }
        Some(world_from_body)
    }

    /// Returns mass and inertia; `None` for physically impossible ones, which only simulation needs.
    fn inertial(&self, element: Element<'d>) -> Result<Option<Inertial>, RobotError> {
        let attributes = self.classes.of(element, None)?;
        let body_from_inertial = self.compiler.pose(&attributes)?;
        let [mass_kg] = attributes.numbers("mass")?.unwrap_or_default();
        let own = match (attributes.numbers("diaginertia")?, attributes.numbers("fullinertia")?) {
            (_, Some([xx, yy, zz, xy, xz, yz])) => Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz),
            (Some([x, y, z]), None) => Matrix3::from_diagonal(&Vector::new(x, y, z)),
            (None, None) => return Ok(None),
        };
        let turn = body_from_inertial.rotation.to_rotation_matrix();
        let inertia_kg_m2 = turn.matrix() * own * turn.matrix().transpose();
        let center = body_from_inertial.translation.vector.into();
        let is_sound = mass_kg > 0.0 && inertia_kg_m2.cholesky().is_some();
        Ok(is_sound.then_some(Inertial { mass_kg, center, inertia_kg_m2 }))
    }
}
