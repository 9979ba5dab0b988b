use std::collections::HashSet;
use std::fmt::Write as _;

use cranny_spatial::{Pose, Rotation, Vector};

use crate::description::urdf_text::escaped;
use crate::model_file::body_tree::{BodyTree, ContactMask, JointRule, TreeBody, TreeJoint};
use crate::{FREE_JOINT_LIMIT_M, Inertial, JointKind, LinkForm};

/// Use of a model: which of its bodies are read, and how free bodies are joined to the world.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ModelUse {
    /// A robot: a free body with joints gets a floating joint; one without is an object of the world and omitted, unless
    /// nothing else moves.
    Robot,
    /// A world: all bodies, free ones where the file puts them.
    World,
}

/// Links that represent the bodies of a model.
pub(crate) struct LinkPlan {
    /// Links of each body: one, and a further one for each further mask of its shapes; none for an omitted body.
    pub(crate) links: Vec<Vec<BodyLink>>,
    joints: HashSet<String>,
    names: HashSet<String>,
}

/// Link with the shapes of one mask.
pub(crate) struct BodyLink {
    pub(crate) name: String,
    pub(crate) mask: ContactMask,
    shapes: Vec<usize>,
}

impl LinkPlan {
    pub(crate) fn of(tree: &BodyTree, purpose: ModelUse) -> Self {
        let names = tree.bodies.iter().map(|body| body.name.clone()).collect();
        let joints =
            tree.bodies.iter().flat_map(|body| &body.joints).map(|joint| joint.name.clone()).collect();
        let mut plan = Self { links: Vec::new(), joints, names };
        let is_left_out = tree.left_out(purpose);
        for (body, is_left_out) in tree.bodies.iter().zip(is_left_out) {
            let links = if is_left_out { Vec::new() } else { plan.links_of(body) };
            plan.links.push(links);
        }
        plan
    }

    fn links_of(&mut self, body: &TreeBody) -> Vec<BodyLink> {
        let mut links: Vec<BodyLink> = Vec::new();
        for (index, shape) in body.shapes.iter().enumerate().filter(|(_, shape)| !shape.contacts.is_empty()) {
            if let Some(link) = links.iter_mut().find(|link| link.mask == shape.contacts) {
                link.shapes.push(index);
                continue;
            }
            let name = if links.is_empty() {
                body.name.clone()
            } else {
                unused(&mut self.names, &format!("{}_contact", body.name))
            };
            links.push(BodyLink { name, mask: shape.contacts, shapes: vec![index] });
        }
        if links.is_empty() {
            links.push(BodyLink { name: body.name.clone(), mask: ContactMask::ALL, shapes: Vec::new() });
        }
        links
    }

    /// Links with collision geometry, each with the index of its body.
    pub(crate) fn colliding(&self) -> impl Iterator<Item = (usize, &BodyLink)> {
        let all =
            self.links.iter().enumerate().flat_map(|(body, links)| links.iter().map(move |l| (body, l)));
        all.filter(|(_, link)| !link.shapes.is_empty())
    }
}

impl BodyTree {
    /// Returns for each body whether it is omitted: objects in the model of a robot, with what is fixed to them.
    fn left_out(&self, purpose: ModelUse) -> Vec<bool> {
        let is_object: Vec<bool> = (0..self.bodies.len()).map(|body| self.is_object(body)).collect();
        let moves = self.bodies.iter().any(|body| !body.joints.is_empty());
        let mut left_out: Vec<bool> = Vec::with_capacity(self.bodies.len());
        for (index, body) in self.bodies.iter().enumerate() {
            let above = body.parent.is_some_and(|parent| left_out[parent]);
            left_out.push(purpose == ModelUse::Robot && moves && (above || is_object[index]));
        }
        left_out
    }

    /// Returns true for a free body below which no joint is.
    pub(crate) fn is_object(&self, body: usize) -> bool {
        let is_below = |mut other: usize| {
            while let Some(parent) = self.bodies[other].parent.filter(|_| other != body) {
                other = parent;
            }
            other == body
        };
        let jointed =
            |(other, tree_body): (usize, &TreeBody)| !tree_body.joints.is_empty() && is_below(other);
        self.bodies[body].is_free && !self.bodies.iter().enumerate().any(jointed)
    }

    /// Returns the text of a URDF with a link for each body, and notes on what it omits.
    pub(crate) fn urdf(&self, plan: &mut LinkPlan, purpose: ModelUse) -> String {
        let mut text = format!("<robot name=\"{}\" version=\"1.2\">\n", escaped(&self.name));
        for (index, body) in self.bodies.iter().enumerate() {
            if plan.links[index].is_empty() {
                continue;
            }
            write_links(&mut text, body, &plan.links[index]);
            let further: Vec<String> = plan.links[index][1..].iter().map(|link| link.name.clone()).collect();
            for link in further {
                let joint = unused(&mut plan.joints, &format!("{link}_joint"));
                write_joint(&mut text, (&joint, "fixed"), [&body.name, &link], &Pose::identity(), "");
            }
            if let Some(parent) = body.parent {
                write_joints(&mut text, body, &self.bodies[parent].name, plan, purpose);
            }
        }
        text + "</robot>\n"
    }
}

fn write_links(text: &mut String, body: &TreeBody, links: &[BodyLink]) {
    for (index, link) in links.iter().enumerate() {
        let _ = writeln!(text, "  <link name=\"{}\">", escaped(&link.name));
        if let Some(inertial) = body.inertial.as_ref().filter(|_| index == 0) {
            write_inertial(text, inertial);
        }
        for &shape in &link.shapes {
            let shape = &body.shapes[shape];
            let _ = writeln!(
                text,
                "    <collision>{}{}</collision>",
                origin(&shape.body_from_shape),
                geometry(&shape.form)
            );
        }
        for shape in body.shapes.iter().filter(|_| index == 0) {
            let Some(look) = shape.look else { continue };
            let colour = look.colour.map_or_else(String::new, |[red, green, blue, opacity]| {
                format!("<material><color rgba=\"{red} {green} {blue} {opacity}\"/></material>")
            });
            let _ = writeln!(
                text,
                "    <visual>{}{}{colour}</visual>",
                origin(&shape.body_from_shape),
                geometry(&shape.form)
            );
        }
        text.push_str("  </link>\n");
    }
}

fn write_inertial(text: &mut String, inertial: &Inertial) {
    let [x, y, z] = inertial.center.coords.into();
    let of = &inertial.inertia_kg_m2;
    let _ = writeln!(
        text,
        "    <inertial><origin xyz=\"{x} {y} {z}\"/><mass value=\"{}\"/><inertia ixx=\"{}\" ixy=\"{}\" ixz=\"{}\" \
         iyy=\"{}\" iyz=\"{}\" izz=\"{}\"/></inertial>",
        inertial.mass_kg,
        of[(0, 0)],
        of[(0, 1)],
        of[(0, 2)],
        of[(1, 1)],
        of[(1, 2)],
        of[(2, 2)]
    );
}

/// Writes the joints between a body and its parent. A joint turns about its anchor: the link below it has its origin there, and
/// the next joint, or the body, is fixed to it.
fn write_joints(text: &mut String, body: &TreeBody, parent: &str, plan: &mut LinkPlan, purpose: ModelUse) {
    let mut above = parent.to_owned();
    let mut above_from_next = body.parent_from_body;
    if body.is_free {
        let kind = if purpose == ModelUse::Robot { "floating" } else { "fixed" };
        let joint = unused(&mut plan.joints, &format!("{}_free", body.name));
        return write_joint(text, (&joint, kind), [&above, &body.name], &above_from_next, "");
    }
    for (index, joint) in body.joints.iter().enumerate() {
        let anchor = Pose::translation(joint.anchor.x, joint.anchor.y, joint.anchor.z);
        let is_last = index + 1 == body.joints.len() && joint.anchor == Vector::zeros();
        let below = if is_last {
            body.name.clone()
        } else {
            let bare = unused(&mut plan.names, &format!("{}_frame", joint.name));
            let _ = writeln!(text, "  <link name=\"{}\"/>", escaped(&bare));
            bare
        };
        let origin = above_from_next * anchor * moved(joint, -joint.reference);
        match &joint.rule {
            JointRule::Constant(value) => {
                let ends = [above.as_str(), below.as_str()];
                write_joint(text, (&joint.name, "fixed"), ends, &(origin * moved(joint, *value)), "");
            }
            _ => write_joint(text, (&joint.name, kind_of(joint)), [&above, &below], &origin, &motion(joint)),
        }
        above = below;
        above_from_next = anchor.inverse();
    }
    if above != body.name {
        let joint = unused(&mut plan.joints, &format!("{}_fixed", body.name));
        write_joint(text, (&joint, "fixed"), [&above, &body.name], &above_from_next, "");
    }
}

/// Returns the motion of a joint by `value` (m, rad) about an axis through the origin.
fn moved(joint: &TreeJoint, value: f64) -> Pose {
    match joint.kind {
        JointKind::Prismatic => Pose::from_parts((joint.axis * value).into(), Rotation::identity()),
        JointKind::Revolute => Pose::from_parts(Vector::zeros().into(), Rotation::new(joint.axis * value)),
    }
}

fn kind_of(joint: &TreeJoint) -> &'static str {
    match (joint.kind, joint.range) {
        (JointKind::Prismatic, _) => "prismatic",
        (JointKind::Revolute, Some(_)) => "revolute",
        (JointKind::Revolute, None) => "continuous",
    }
}

fn motion(joint: &TreeJoint) -> String {
    let [x, y, z] = joint.axis.into();
    let mut text = format!("<axis xyz=\"{x} {y} {z}\"/>");
    let range = match joint.kind {
        JointKind::Prismatic => Some(joint.range.unwrap_or([-FREE_JOINT_LIMIT_M, FREE_JOINT_LIMIT_M])),
        JointKind::Revolute => joint.range,
    };
    let range = range.map(|[lower, upper]| format!(" lower=\"{lower}\" upper=\"{upper}\""));
    let velocity = joint.velocity.map(|speed| format!(" velocity=\"{speed}\""));
    let effort = joint.effort.map(|effort| format!(" effort=\"{effort}\""));
    let limits: String = [range, velocity, effort].into_iter().flatten().collect();
    if !limits.is_empty() {
        let _ = write!(text, "<limit{limits}/>");
    }
    if let JointRule::Mimic { master, multiplier, offset } = &joint.rule {
        let master = escaped(master);
        let _ = write!(text, "<mimic joint=\"{master}\" multiplier=\"{multiplier}\" offset=\"{offset}\"/>");
    }
    text
}

fn write_joint(
    text: &mut String,
    (name, kind): (&str, &str),
    [parent, child]: [&str; 2],
    pose: &Pose,
    motion: &str,
) {
    let [name, parent, child] = [name, parent, child].map(escaped);
    let origin = origin(pose);
    let _ = writeln!(
        text,
        "  <joint name=\"{name}\" type=\"{kind}\"><parent link=\"{parent}\"/><child link=\"{child}\"/>{origin}{motion}</joint>"
    );
}

fn geometry(form: &LinkForm) -> String {
    let inside = match form {
        LinkForm::Cuboid { size } => format!("<box size=\"{} {} {}\"/>", size.x, size.y, size.z),
        LinkForm::Sphere { radius_m } => format!("<sphere radius=\"{radius_m}\"/>"),
        LinkForm::Cylinder { length_m, radius_m } => {
            format!("<cylinder length=\"{length_m}\" radius=\"{radius_m}\"/>")
        }
        LinkForm::Capsule { length_m, radius_m } => {
            format!("<capsule length=\"{length_m}\" radius=\"{radius_m}\"/>")
        }
        LinkForm::Mesh { name, scale, .. } => {
            format!("<mesh filename=\"{}\" scale=\"{} {} {}\"/>", escaped(name), scale.x, scale.y, scale.z)
        }
        LinkForm::Hull { points } => {
            let points = points.iter().map(|point| format!("{} {} {}", point.x, point.y, point.z));
            format!("<hull points=\"{}\"/>", points.collect::<Vec<_>>().join(" "))
        }
    };
    format!("<geometry>{inside}</geometry>")
}

/// Returns an `<origin>` with the pose in full precision, for every rotation.
fn origin(pose: &Pose) -> String {
    let [x, y, z] = pose.translation.vector.into();
    let [i, j, k, w] = pose.rotation.coords.into();
    format!("<origin xyz=\"{x} {y} {z}\" quat_xyzw=\"{i} {j} {k} {w}\"/>")
}

/// Returns `name`, or `name` with a number if it is taken, and marks it as taken.
fn unused(taken: &mut HashSet<String>, name: &str) -> String {
    let numbered = (2..).map(|number: u32| format!("{name}{number}"));
    let mut names = std::iter::once(name.to_owned()).chain(numbered);
    let name = names.find(|name| !taken.contains(name)).unwrap_or_default();
    taken.insert(name.clone());
    name
}
