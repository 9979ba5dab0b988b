use std::collections::HashMap;

use cranny_spatial::{Point, Vector};

use crate::description::unread::unread;
use crate::description::urdf_model::{
    Urdf, UrdfCollision, UrdfJoint, UrdfJointKind, UrdfLimits, UrdfLink, UrdfMimic, UrdfMotion, parse_limits,
};
use crate::description::xml::{Element, XmlText, known_prefixes};
use crate::free_joint::{FLOATING, PLANAR};
use crate::tree::{JOINTS, LINKS, MAX_LINKS};
use crate::{Inertial, LinkForm, LinkVisual, Location, RobotError};

impl UrdfLink {
    /// Returns a link without geometry.
    pub(crate) fn bare(name: String, at: Location) -> Self {
        Self { name, at, collisions: Vec::new(), visuals: Vec::new(), inertial: None }
    }
}

impl Urdf {
    pub(crate) fn parse(text: &str, file: &str) -> Result<Self, RobotError> {
        let text = known_prefixes(text);
        let xml = XmlText::parse(&text, file)?;
        let robot = xml.robot()?;
        for (tag, what) in [("link", LINKS), ("joint", JOINTS)] {
            if let Some(extra) = robot.all(tag).nth(MAX_LINKS) {
                let actual = robot.all(tag).count();
                return Err(RobotError::TooMany { at: extra.at(), what, most: MAX_LINKS, actual });
            }
        }
        let name = robot.optional_text("name").unwrap_or("robot").to_owned();
        let colours = named_colours(robot);
        let links =
            robot.all("link").map(|link| parse_link(link, &colours)).collect::<Result<Vec<_>, _>>()?;
        let mut urdf = Self { name, file: file.to_owned(), links, joints: Vec::new(), notes: Vec::new() };
        for joint in robot.all("joint") {
            match joint.text("type")? {
                "planar" => urdf.add_free_joint(joint, &PLANAR)?,
                "floating" => urdf.add_free_joint(joint, &FLOATING)?,
                _ => urdf.joints.push(parse_joint(joint)?),
            }
        }
        urdf.notes = unread(&xml)?;
        Ok(urdf)
    }
}

/// Colours (red, green, blue, opacity; 0 to 1) by the name of their material. A material may get its colour at the top
/// or in any visual, and its name is valid everywhere.
type Colours<'a> = HashMap<&'a str, [f64; 4]>;

fn named_colours(robot: Element<'_>) -> Colours<'_> {
    let visuals = robot.all("link").flat_map(|link| link.all("visual"));
    let materials = robot.all("material").chain(visuals.flat_map(|visual| visual.all("material")));
    let mut colours = HashMap::new();
    for material in materials {
        if let (Some(name), Some(colour)) = (material.optional_text("name"), parse_colour(material)) {
            colours.entry(name).or_insert(colour);
        }
    }
    colours
}

/// Returns the colour of a material; `None` for an invalid one, which many files have, as colours only affect display.
fn parse_colour(material: Element<'_>) -> Option<[f64; 4]> {
    material.first("color").and_then(|colour| colour.numbers("rgba").ok()?)
}

fn parse_link(element: Element<'_>, colours: &Colours<'_>) -> Result<UrdfLink, RobotError> {
    let name = element.text("name")?.to_owned();
    let collisions =
        element.all("collision").map(|child| parse_collision(child, &name)).collect::<Result<_, _>>()?;
    let visuals =
        element.all("visual").map(|child| parse_visual(child, &name, colours)).collect::<Result<_, _>>()?;
    Ok(UrdfLink { name, at: element.at(), collisions, visuals, inertial: Inertial::of(element) })
}

fn parse_collision(element: Element<'_>, link: &str) -> Result<UrdfCollision, RobotError> {
    let (at, form) = parse_geometry(element, link)?;
    Ok(UrdfCollision { at, link_from_shape: element.origin()?, form })
}

fn parse_visual(element: Element<'_>, link: &str, colours: &Colours<'_>) -> Result<LinkVisual, RobotError> {
    let (_, form) = parse_geometry(element, link)?;
    let colour = match element.first("material") {
        Some(material) => {
            let named = || material.optional_text("name").and_then(|name| colours.get(name).copied());
            parse_colour(material).or_else(named)
        }
        None => None,
    };
    let length = |attribute| {
        let given = element.optional_text(attribute).map(|_| element.positive(attribute));
        given.transpose().map(Option::unwrap_or_default)
    };
    Ok(LinkVisual {
        link_from_visual: element.origin()?,
        form,
        colour,
        rounding_m: length("rounding")?,
        blend_m: length("blend")?,
    })
}

/// Reads the geometry of a `<collision>` or a `<visual>`, and its location in the file.
fn parse_geometry(element: Element<'_>, link: &str) -> Result<(Location, LinkForm), RobotError> {
    let owner = || format!("<{}> of link `{link}`", element.tag());
    let shape = element.needed("geometry", &owner())?.children().next().ok_or_else(|| {
        RobotError::MissingElement { at: element.at(), owner: owner(), element: "geometry" }
    })?;
    let (length_m, radius_m) = (|| shape.positive("length"), || shape.positive("radius"));
    let form = match &*shape.tag() {
        "box" => LinkForm::Cuboid { size: parse_size(shape)? },
        "sphere" => LinkForm::Sphere { radius_m: radius_m()? },
        "cylinder" => LinkForm::Cylinder { length_m: length_m()?, radius_m: radius_m()? },
        "capsule" | "drake:capsule" => LinkForm::Capsule { length_m: length_m()?, radius_m: radius_m()? },
        "mesh" => {
            let name = shape.text("filename")?.to_owned();
            LinkForm::Mesh { name, candidates: Vec::new(), scale: parse_scale(shape)? }
        }
        "hull" => LinkForm::Hull { points: parse_points(shape)? },
        other => {
            return Err(RobotError::UnknownGeometry {
                at: shape.at(),
                link: link.to_owned(),
                geometry: other.to_owned(),
            });
        }
    };
    Ok((shape.at(), form))
}

fn parse_size(element: Element<'_>) -> Result<Vector, RobotError> {
    element.text("size")?;
    let size = element.vector("size")?.unwrap_or_default();
    size.iter().try_for_each(|&length| element.check_positive("size", length))?;
    Ok(size)
}

/// Maximum number of points of a hull.
const MOST_POINTS: usize = 1_000_000;

fn parse_points(element: Element<'_>) -> Result<Vec<Point>, RobotError> {
    element.text("points")?;
    let numbers = element.list("points", 3 * MOST_POINTS)?.unwrap_or_default();
    let points = numbers.chunks_exact(3);
    if !points.remainder().is_empty() {
        return Err(element.not_numbers("points", 3 * points.len() + 3));
    }
    Ok(points.map(|point| Point::new(point[0], point[1], point[2])).collect())
}

/// Reads the scale of a mesh. A negative factor mirrors the mesh and is allowed; zero flattens it and is not.
fn parse_scale(element: Element<'_>) -> Result<Vector, RobotError> {
    let scale = element.vector("scale")?.unwrap_or_else(|| Vector::repeat(1.0));
    scale.iter().try_for_each(|&factor| element.check_positive("scale", factor.abs()))?;
    Ok(scale)
}

fn parse_joint(element: Element<'_>) -> Result<UrdfJoint, RobotError> {
    let name = element.text("name")?.to_owned();
    let owner = format!("joint `{name}`");
    let kind = match element.text("type")? {
        "fixed" => None,
        "revolute" => Some(UrdfJointKind::Revolute),
        "continuous" => Some(UrdfJointKind::Continuous),
        "prismatic" => Some(UrdfJointKind::Prismatic),
        other => {
            let (at, kind) = (element.at(), other.to_owned());
            return Err(RobotError::UnsupportedJoint { at, joint: name, kind });
        }
    };
    Ok(UrdfJoint {
        at: element.at(),
        parent: element.needed("parent", &owner)?.text("link")?.to_owned(),
        child: element.needed("child", &owner)?.text("link")?.to_owned(),
        parent_from_joint: element.origin()?,
        motion: kind.map(|kind| parse_motion(element, kind, &name)).transpose()?,
        name,
    })
}

fn parse_motion(element: Element<'_>, kind: UrdfJointKind, joint: &str) -> Result<UrdfMotion, RobotError> {
    // The default in the URDF specification is the x axis.
    let (axis, axis_at) = match element.first("axis") {
        Some(axis) => (axis.vector("xyz")?.unwrap_or_else(Vector::x), axis.at()),
        None => (Vector::x(), element.at()),
    };
    // Axes below this length have no reliable direction; axes in files have a length of about one.
    let axis_in_child = axis
        .try_normalize(1e-9)
        .ok_or_else(|| RobotError::ZeroAxis { at: axis_at, joint: joint.to_owned() })?;
    let limits = match element.first("limit") {
        None if kind == UrdfJointKind::Continuous => UrdfLimits::of_continuous(),
        _ => parse_limits(element.needed("limit", &format!("joint `{joint}`"))?, kind, joint)?,
    };
    let mimic = element.first("mimic").map(parse_mimic).transpose()?;
    Ok(UrdfMotion { kind, axis_in_child, limits, mimic })
}

fn parse_mimic(element: Element<'_>) -> Result<UrdfMimic, RobotError> {
    Ok(UrdfMimic {
        master: element.text("joint")?.to_owned(),
        multiplier: element.number_or("multiplier", 1.0)?,
        offset: element.number_or("offset", 0.0)?,
    })
}
