use std::path::Path;

use cranny_spatial::Pose;
use cranny_spatial::nalgebra::Matrix3;

use crate::description::xml::{Element, XmlText};
use crate::model_file::body_tree::{ContactMask, Look, TreeShape};
use crate::model_file::hull_points::check_points;
use crate::model_file::unread_list::{UnreadList, check_name, not_supported};
use crate::sdf::frames::{Frame, Frames, WORLD};
use crate::sdf::geometry::{SdfShape, shape};
use crate::sdf::includes::{MOST_DEPTH, ModelFolders};
use crate::sdf::joints::SdfJoint;
use crate::sdf::scope::Scope;
use crate::tree::MAX_LINKS;
use crate::{Inertial, LinkForm, Location, RobotError};

/// A link, with its shapes relative to frames.
pub(crate) struct SdfLink {
    pub(crate) name: String,
    pub(crate) at: Location,
    pub(crate) is_free: bool,
    pub(crate) shapes: Vec<SdfPlaced>,
    pub(crate) planes: Vec<(String, String, Pose)>,
    pub(crate) inertial: Option<Inertial>,
}

/// Shape of a link with its pose in a frame.
pub(crate) struct SdfPlaced {
    pub(crate) frame: String,
    /// `body_from_shape` is relative to `frame`.
    pub(crate) shape: TreeShape,
}

/// Content of an SDF with all included models.
pub(crate) struct Collector {
    pub(crate) frames: Frames,
    pub(crate) links: Vec<SdfLink>,
    pub(crate) joints: Vec<SdfJoint>,
    pub(crate) unread: UnreadList,
    pub(crate) folders: ModelFolders,
    /// Number of points of all hulls so far.
    pub(crate) points: usize,
}

impl Collector {
    /// Reads an SDF: its world, or its first model. `name` replaces that of an included model.
    pub(crate) fn read_root(&mut self, root: Element<'_>, folder: &Path) -> Result<String, RobotError> {
        let mut scope = Scope {
            prefix: String::new(),
            model_frame: WORLD.to_owned(),
            is_static: false,
            is_in_world: true,
            version: version(root)?,
            depth: 0,
        };
        if let Some(world) = root.first("world") {
            self.read_inside(world, &scope, folder)?;
            return Ok(world.optional_text("name").unwrap_or("world").to_owned());
        }
        let Some(model) = root.first("model") else {
            return Err(RobotError::MissingElement {
                at: root.at(),
                owner: "<sdf>".to_owned(),
                element: "world> or <model",
            });
        };
        for second in root.all("model").skip(1) {
            self.unread.add(root, second);
        }
        // The names of a model file are those of its model.
        scope.is_in_world = false;
        let own = Included { name: None, pose: None, placement: None, is_static: false, is_merged: false };
        self.read_model(model, (&scope, true), &own, folder)?;
        Ok(model.text("name")?.to_owned())
    }

    /// Reads the content of a world or model.
    fn read_inside(&mut self, owner: Element<'_>, scope: &Scope, folder: &Path) -> Result<(), RobotError> {
        if scope.depth > MOST_DEPTH {
            let (at, what) = (owner.at(), "models inside each other");
            return Err(RobotError::TooMany { at, what, most: MOST_DEPTH, actual: scope.depth });
        }
        for element in owner.children() {
            match &*element.tag() {
                "link" => self.read_link(element, scope, folder)?,
                "joint" => {
                    let joint = SdfJoint::read(element, scope, &mut self.unread)?;
                    let (pose, relative_to) = element.sdf_pose()?;
                    let relative_to =
                        relative_to.map_or_else(|| joint.child.clone(), |name| scope.frame(name));
                    let attached_to = Some(joint.child.clone());
                    let frame = Frame { at: element.at(), relative_to, pose, attached_to };
                    self.frames.add(joint.frame.clone(), frame)?;
                    self.joints.push(joint);
                }
                "frame" => {
                    let (pose, relative_to) = element.sdf_pose()?;
                    let attached = element.optional_text("attached_to").filter(|name| !name.is_empty());
                    let attached =
                        attached.map_or_else(|| scope.model_frame.clone(), |name| scope.frame(name));
                    let relative_to = relative_to.map_or_else(|| attached.clone(), |name| scope.frame(name));
                    let frame = Frame { at: element.at(), relative_to, pose, attached_to: Some(attached) };
                    self.frames.add(scope.name(element.text("name")?), frame)?;
                }
                "model" => {
                    let own = Included {
                        name: None,
                        pose: None,
                        placement: None,
                        is_static: false,
                        is_merged: false,
                    };
                    self.read_model(element, (scope, false), &own, folder)?;
                }
                "include" => self.read_include(element, scope, folder)?,
                "actor" | "population" | "road" => {
                    let what = format!("<{}>", element.tag());
                    return Err(not_supported(element, what, "leave it out, or give models"));
                }
                "pose" | "static" | "name" => {}
                _ => self.unread.add(owner, element),
            }
        }
        Ok(())
    }

    fn read_include(&mut self, include: Element<'_>, scope: &Scope, folder: &Path) -> Result<(), RobotError> {
        let (text, path) = self.folders.included(include, folder)?;
        let file = path.display().to_string();
        let xml = XmlText::parse(&text, &file)?;
        let root = xml.root();
        let Some(model) = root.first("model") else {
            return Err(not_supported(include, format!("{file} without a <model>"), "include a model"));
        };
        let pose = if include.first("pose").is_some() { Some(placed(include, scope)?) } else { None };
        let included = Included {
            name: include.value("name").map(str::to_owned),
            pose,
            placement: include.value("placement_frame").map(str::to_owned),
            is_static: include.value_flag("static"),
            is_merged: matches!(include.optional_text("merge"), Some("true" | "1")),
        };
        let inner = Scope { version: version(root)?, depth: scope.depth + 1, ..scope.clone() };
        let folder = path.parent().unwrap_or_else(|| Path::new(""));
        self.read_model(model, (&inner, false), &included, folder)
    }

    /// Reads a model in the scope around it. The names of the model of a model file, and of a merged one, are those of the scope.
    fn read_model(
        &mut self,
        model: Element<'_>,
        (outer, is_file): (&Scope, bool),
        included: &Included,
        folder: &Path,
    ) -> Result<(), RobotError> {
        let name = included.name.as_deref().map_or_else(|| model.text("name"), Ok)?;
        check_name(model, &outer.name(name))?;
        let keeps_names = is_file || included.is_merged;
        // No element of a file can have such a name.
        let frame = if keeps_names { format!("{}{name}::__model__", outer.prefix) } else { outer.name(name) };
        let scope = Scope {
            prefix: if keeps_names { outer.prefix.clone() } else { format!("{}::", outer.name(name)) },
            model_frame: frame.clone(),
            is_static: outer.is_static || included.is_static || model.value_flag("static"),
            is_in_world: outer.is_in_world,
            version: outer.version,
            depth: outer.depth + 1,
        };
        let (pose, relative_to) = included.pose.clone().map_or_else(|| placed(model, outer), Ok)?;
        self.read_inside(model, &scope, folder)?;
        let canonical = model.optional_text("canonical_link").map(|link| scope.frame(link));
        let first =
            model.first("link").and_then(|link| link.optional_text("name")).map(|link| scope.name(link));
        let attached_to = Some(canonical.or(first).unwrap_or_else(|| outer.model_frame.clone()));
        let at = model.at();
        let placement = included.placement.as_deref().or_else(|| model.optional_text("placement_frame"));
        let add = |frames: &mut Frames, pose: Pose| {
            let attached_to = attached_to.clone();
            frames.add(
                frame.clone(),
                Frame { at: at.clone(), relative_to: relative_to.clone(), pose, attached_to },
            )
        };
        let Some(placed) = placement.filter(|name| !name.is_empty()) else {
            return add(&mut self.frames, pose);
        };
        // The pose is that of the placement frame, which is known relative to the model.
        let model_from_placed = self.frames.between(&frame, &scope.frame(placed), &at)?;
        add(&mut self.frames, pose * model_from_placed.inverse())
    }

    fn read_link(&mut self, element: Element<'_>, scope: &Scope, folder: &Path) -> Result<(), RobotError> {
        let name = scope.name(element.text("name")?);
        check_name(element, &name)?;
        if self.links.len() > MAX_LINKS {
            let (at, actual) = (element.at(), self.links.len());
            return Err(RobotError::TooMany { at, what: "links in one model", most: MAX_LINKS, actual });
        }
        let (pose, relative_to) = element.sdf_pose()?;
        let relative_to = relative_to.map_or_else(|| scope.model_frame.clone(), |name| scope.frame(name));
        self.frames.add(name.clone(), Frame { at: element.at(), relative_to, pose, attached_to: None })?;
        let mut link = SdfLink {
            name,
            at: element.at(),
            is_free: scope.is_in_world && !scope.is_static,
            shapes: Vec::new(),
            planes: Vec::new(),
            inertial: self.inertial(element)?,
        };
        for child in element.children() {
            match &*child.tag() {
                "collision" | "visual" => self.add_shape(child, &mut link, scope, folder)?,
                "pose" | "inertial" => {}
                _ => self.unread.add(element, child),
            }
        }
        self.links.push(link);
        Ok(())
    }

    /// Returns mass and inertia of a link as stated; `None` if its shapes and densities determine them, which is noted.
    fn inertial(&mut self, link: Element<'_>) -> Result<Option<Inertial>, RobotError> {
        let Some(element) = link.first("inertial") else { return Ok(None) };
        if !matches!(element.optional_text("auto"), Some("true" | "1")) {
            return stated_inertial(element);
        }
        let at = element.at();
        self.unread
            .note(format!("{at}: <inertial auto=\"true\"> is not computed: the link counts as without mass"));
        Ok(None)
    }

    fn add_shape(
        &mut self,
        element: Element<'_>,
        link: &mut SdfLink,
        scope: &Scope,
        folder: &Path,
    ) -> Result<(), RobotError> {
        let is_visual = element.tag() == "visual";
        let (pose, relative_to) = element.sdf_pose()?;
        let frame = relative_to.map_or_else(|| link.name.clone(), |name| scope.frame(name));
        let form = match shape(element, &self.folders, folder) {
            Ok(SdfShape::Form(form)) => form,
            Ok(SdfShape::Plane(own)) if !is_visual => {
                let name = element.optional_text("name").unwrap_or("plane");
                link.planes.push((format!("{}::{name}", link.name), frame, pose * own));
                return Ok(());
            }
            Ok(_) => return Ok(()),
            // A visual only affects the look.
            Err(fault) if is_visual => {
                self.unread.note(format!("a visual is not drawn: {fault}"));
                return Ok(());
            }
            Err(fault) => return Err(fault),
        };
        let colour = element.first("material").map(|material| material.value_numbers("diffuse"));
        let colour = colour.and_then(|colour| colour.ok().flatten());
        let look = is_visual.then_some(Look { colour });
        let contacts =
            if is_visual { ContactMask { own: 0, others: 0, pair: None } } else { ContactMask::ALL };
        let contact = element.first("surface").and_then(|surface| surface.first("contact"));
        if contact.is_some_and(|contact| contact.first("collide_bitmask").is_some()) {
            self.unread
                .note(format!("{}: <collide_bitmask> is not read: all pairs are checked", element.at()));
        }
        let is_missing =
            matches!(&form, LinkForm::Mesh { name, .. } if is_visual && !Path::new(name).is_file());
        if !is_missing {
            self.points = check_points(element, &form, self.points)?;
            link.shapes
                .push(SdfPlaced { frame, shape: TreeShape { body_from_shape: pose, form, contacts, look } });
        }
        Ok(())
    }
}

/// Returns the pose of a model or an inclusion, and the frame that it is relative to: by default that of the scope.
fn placed(element: Element<'_>, scope: &Scope) -> Result<(Pose, String), RobotError> {
    let (pose, relative_to) = element.sdf_pose()?;
    Ok((pose, relative_to.map_or_else(|| scope.model_frame.clone(), |name| scope.frame(name))))
}

/// Settings of an `<include>` that replace those of its model.
struct Included {
    name: Option<String>,
    pose: Option<(Pose, String)>,
    placement: Option<String>,
    is_static: bool,
    is_merged: bool,
}

/// Returns the version of an SDF.
fn version(root: Element<'_>) -> Result<[u32; 2], RobotError> {
    let text = root.text("version")?;
    let mut parts = text.split('.').map(|part| part.parse().unwrap_or(0));
    let version = [parts.next().unwrap_or(0), parts.next().unwrap_or(0)];
    if (1..=1).contains(&version[0]) && (2..=12).contains(&version[1]) {
        return Ok(version);
    }
    Err(not_supported(root, format!("version {text} of SDF"), "give version 1.4 to 1.12"))
}

/// Returns mass and inertia of an element; `None` for physically impossible ones, which only dynamics needs.
fn stated_inertial(element: Element<'_>) -> Result<Option<Inertial>, RobotError> {
    let (link_from_inertial, _) = element.sdf_pose()?;
    let mass_kg = element.value_number("mass")?.unwrap_or(1.0);
    let number = |tag, default| -> Result<f64, RobotError> {
        element.first("inertia").map_or(Ok(default), |of| Ok(of.value_number(tag)?.unwrap_or(default)))
    };
    let [xx, yy, zz] = [number("ixx", 1.0)?, number("iyy", 1.0)?, number("izz", 1.0)?];
    let [xy, xz, yz] = [number("ixy", 0.0)?, number("ixz", 0.0)?, number("iyz", 0.0)?];
    let own = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
    let turn = link_from_inertial.rotation.to_rotation_matrix();
    let inertia_kg_m2 = turn.matrix() * own * turn.matrix().transpose();
    let center = link_from_inertial.translation.vector.into();
    let is_sound = mass_kg > 0.0 && mass_kg.is_finite() && inertia_kg_m2.cholesky().is_some();
    Ok(is_sound.then_some(Inertial { mass_kg, center, inertia_kg_m2 }))
}
