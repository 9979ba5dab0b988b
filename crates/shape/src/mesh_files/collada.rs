//! Triangles of a COLLADA file (`.dae`, version 1.4 or 1.5) as its scene shows them, in metres.
//!
//! Reads geometries of meshes (triangles, polylist, polygons, tristrips, trifans), the nodes that position them (matrix,
//! translate, rotate, scale, lookat; library nodes), the unit, and the diffuse colours of materials. Ignores the up axis, as
//! other readers of robots do, lines, cameras, lights and physics. Rejects all other visible content: skins and morphs,
//! splines, skews, unknown tags.

mod colour;
mod element;
mod geometry;
mod motion;
mod primitive;
mod references;

use std::collections::HashMap;
use std::rc::Rc;

use cranny_file::{XmlExcess, xml_excess};
use cranny_spatial::Point;
use cranny_spatial::nalgebra::Matrix4;
use roxmltree::{Document, Node, NodeId};

use self::colour::{Colour, Colours, bindings};
use self::element::{HasTag, child, children, elements, fault, number, unknown};
use self::geometry::Geometries;
use self::motion::motion;
use crate::mesh_files::mesh_size::check_corners;

/// Corners of the triangles, three at a time, in metres.
///
/// # Errors
/// A message with the line.
pub(crate) fn corners(text: &str) -> Result<Vec<Point>, String> {
    Ok(pieces(text)?.into_iter().flat_map(|piece| piece.corners).collect())
}

/// Triangles of one colour.
pub(crate) struct Piece {
    /// Red, green, blue, opacity, if a material gives them.
    pub colour: Colour,
    /// Corners of the triangles, three at a time, in metres.
    pub corners: Vec<Point>,
}

/// Triangles in runs of one colour, in the order of the file.
///
/// # Errors
/// A message with the line.
pub(crate) fn pieces(text: &str) -> Result<Vec<Piece>, String> {
    if let Some(XmlExcess { line, what, most, actual }) = xml_excess(text) {
        return Err(format!("line {line}: {actual} {what}, but at most {most} are read"));
    }
    let document = Document::parse(text).map_err(|reason| reason.to_string())?;
    let root = document.root_element();
    if root.tag_name().name() != "COLLADA" {
        return Err(format!("the outermost element is <{}>, not <COLLADA>", root.tag_name().name()));
    }
    let mut reader = Reader {
        geometries: Geometries::of(root),
        colours: Colours::default(),
        contents: HashMap::new(),
        painted: HashMap::new(),
        pieces: Vec::new(),
        corners: 0,
        elements: 0,
    };
    let scale = Matrix4::new_scaling(unit(root)?);
    let mut shown = children(root, "scene").flat_map(|scene| children(scene, "instance_visual_scene"));
    let scene = match (shown.next(), shown.next()) {
        (Some(instance), None) => Some(reader.geometries.references.target(instance, &["visual_scene"])?),
        (_, Some(second)) => {
            return Err(fault(second, "a second <instance_visual_scene>; only one can be shown"));
        }
        (None, _) => only_scene(root)?,
    };
    match scene {
        Some(scene) => reader.add_scene(scene, &scale)?,
        None => {
            for geometry in root.descendants().filter(|node| node.has_tag_name_of("geometry")) {
                reader.add_geometry(geometry, None, &scale)?;
            }
        }
    }
    Ok(reader.pieces)
}

/// Length of the file's unit, in metres.
fn unit(root: Node) -> Result<f64, String> {
    let meter = |unit: Node| match unit.attribute("meter") {
        Some(word) => match number(unit, word)? {
            meter if meter > 0.0 && meter.is_finite() => Ok(meter),
            _ => Err(fault(unit, &format!("a unit of '{word}' metres; it must be a positive number"))),
        },
        None => Ok(1.0),
    };
    let unit = child(root, "asset").and_then(|asset| child(asset, "unit"));
    let meters = unit.map_or(Ok(1.0), meter)?;
    // Elements may have a unit of their own, which is valid only inside them.
    let is_unit = |node: &Node| {
        node.has_tag_name_of("unit")
            && node.parent_element().is_some_and(|asset| asset.has_tag_name_of("asset"))
    };
    for own in root.descendants().filter(is_unit) {
        if meter(own)?.total_cmp(&meters).is_ne() {
            return Err(fault(own, "an element with another unit than that of the file is not read"));
        }
    }
    Ok(meters)
}

/// The only scene of a file that does not name the scene to show.
fn only_scene<'a>(root: Node<'a, 'a>) -> Result<Option<Node<'a, 'a>>, String> {
    let mut scenes = root.descendants().filter(|node| node.has_tag_name_of("visual_scene"));
    let first = scenes.next();
    match scenes.next() {
        Some(second) => {
            Err(fault(second, "a second <visual_scene>, and no <scene> names the one that is shown"))
        }
        None => Ok(first),
    }
}

/// Maximum depth of nodes; deeper ones are a cycle of references.
const MOST_DEPTH: usize = 64;

/// Maximum number of elements of the nodes that a scene shows; more are due to references that multiply each other. Robots
/// have some hundreds.
const MOST_ELEMENTS: usize = 1_000_000;

/// Transforms of a node, the outermost first, and its other elements.
type Content<'a> = Rc<(Vec<Matrix4<f64>>, Vec<Node<'a, 'a>>)>;

struct Reader<'a> {
    geometries: Geometries<'a>,
    colours: Colours,
    contents: HashMap<NodeId, Content<'a>>,
    /// Colour of each primitive of each geometry that a node shows, by the element that refers to the geometry.
    painted: HashMap<NodeId, Rc<[Colour]>>,
    pieces: Vec<Piece>,
    corners: usize,
    /// Number of elements of the nodes shown up to now.
    elements: usize,
}

impl<'a> Reader<'a> {
    /// Adds everything that a scene shows.
    fn add_scene(&mut self, scene: Node<'a, 'a>, placed: &Matrix4<f64>) -> Result<(), String> {
        for part in elements(scene) {
            match part.tag_name().name() {
                "node" => self.add_node(part, placed, 0)?,
                "asset" | "evaluate_scene" | "extra" => {}
                _ => return Err(unknown(part)),
            }
        }
        Ok(())
    }

    fn add_node(&mut self, node: Node<'a, 'a>, placed: &Matrix4<f64>, depth: usize) -> Result<(), String> {
        let content = self.content(node)?;
        let (motions, parts) = &*content;
        self.elements += 1 + motions.len() + parts.len();
        if depth > MOST_DEPTH {
            return Err(fault(
                node,
                &format!("nodes hold each other without end, or more than {MOST_DEPTH} deep"),
            ));
        }
        if self.elements > MOST_ELEMENTS {
            return Err(fault(node, &format!("the scene shows more than {MOST_ELEMENTS} elements of nodes")));
        }
        let mut placed = *placed;
        for motion in motions {
            placed *= motion;
        }
        for &part in parts {
            match part.tag_name().name() {
                "instance_geometry" => {
                    let geometry = self.geometries.references.target(part, &["geometry"])?;
                    self.add_geometry(geometry, Some(part), &placed)?;
                }
                "instance_node" => {
                    let node = self.geometries.references.target(part, &["node"])?;
                    self.add_node(node, &placed, depth + 1)?;
                }
                "node" => self.add_node(part, &placed, depth + 1)?,
                "instance_controller" => {
                    return Err(fault(
                        part,
                        "<instance_controller>, a mesh with a skin or a morph, is not read (apply skin or morph, \
                         then export the mesh)",
                    ));
                }
                "asset" | "extra" | "instance_camera" | "instance_light" => {}
                _ => return Err(unknown(part)),
            }
        }
        Ok(())
    }

    /// Content of a node, read once, as many others may refer to it.
    fn content(&mut self, node: Node<'a, 'a>) -> Result<Content<'a>, String> {
        if let Some(known) = self.contents.get(&node.id()) {
            return Ok(Rc::clone(known));
        }
        let (mut motions, mut parts) = (Vec::new(), Vec::new());
        for part in elements(node) {
            match motion(part)? {
                Some(motion) => motions.push(motion),
                None => parts.push(part),
            }
        }
        let content = Rc::new((motions, parts));
        self.contents.insert(node.id(), Rc::clone(&content));
        Ok(content)
    }

    fn add_geometry(
        &mut self,
        geometry: Node<'a, 'a>,
        instance: Option<Node<'a, 'a>>,
        placed: &Matrix4<f64>,
    ) -> Result<(), String> {
        let surfaces = self.geometries.surfaces(geometry)?;
        let shown = instance.unwrap_or(geometry);
        let colours = if let Some(known) = self.painted.get(&shown.id()) {
            Rc::clone(known)
        } else {
            let bound = instance.map(bindings).unwrap_or_default();
            let primitives = surfaces.iter().map(|surface| surface.primitive);
            let colours = primitives.map(|primitive| self.colour(primitive, &bound)).collect();
            Rc::clone(self.painted.entry(shown.id()).or_insert(colours))
        };
        for (surface, &colour) in surfaces.iter().zip(&*colours) {
            self.corners += surface.corners.len();
            check_corners(self.corners).map_err(|excess| fault(surface.primitive, &excess))?;
            if self.pieces.last().is_none_or(|piece| piece.colour != colour) {
                self.pieces.push(Piece { colour, corners: Vec::new() });
            }
            if let Some(piece) = self.pieces.last_mut() {
                piece.corners.extend(surface.corners.iter().map(|corner| {
                    let point = placed * corner.to_homogeneous();
                    Point::new(point.x, point.y, point.z)
                }));
            }
        }
        Ok(())
    }

    /// Colour of a primitive: its symbol names a material, directly or as the node binds it.
    fn colour(&mut self, primitive: Node<'a, 'a>, bound: &HashMap<&str, &str>) -> Colour {
        let symbol = primitive.attribute("material")?;
        let material = bound.get(symbol).copied().unwrap_or(symbol);
        self.colours.of_material(material, &self.geometries.references)
    }
}
