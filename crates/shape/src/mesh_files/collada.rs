//! Triangles of a COLLADA file (`.dae`, version 1.4 or 1.5) as its scene shows them, in metres.
//!
//! Reads geometries of meshes (triangles, polylist, polygons, tristrips, trifans), the nodes that position them (matrix,
//! translate, rotate, scale, lookat; library nodes), the unit, and the diffuse colours of materials. Ignores the up axis, as
//! other readers of robots do, lines, cameras, lights and physics. Rejects all other visible content: skins and morphs,
//! splines, skews, unknown tags.

mod element;
mod motion;
mod primitive;

use std::collections::HashMap;

use cranny_spatial::Point;
use cranny_spatial::nalgebra::Matrix4;
use roxmltree::{Document, Node};

use self::element::{HasTag, child, children, elements, fault, index, number, numbers, text, unknown};
use self::motion::motion;
use self::primitive::{Inputs, Primitive};
use crate::mesh_files::polygon::triangulate;

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
    pub colour: Option<[f32; 4]>,
    /// Corners of the triangles, three at a time, in metres.
    pub corners: Vec<Point>,
}

/// Triangles in runs of one colour, in the order of the file.
///
/// # Errors
/// A message with the line.
pub(crate) fn pieces(text: &str) -> Result<Vec<Piece>, String> {
    let document = Document::parse(text).map_err(|reason| reason.to_string())?;
    let root = document.root_element();
    if root.tag_name().name() != "COLLADA" {
        return Err(format!("the outermost element is <{}>, not <COLLADA>", root.tag_name().name()));
    }
    let mut reader = Reader { by_id: HashMap::new(), pieces: Vec::new(), corners: 0, nodes: 0 };
    for node in root.descendants() {
        if let Some(id) = node.attribute("id") {
            reader.by_id.entry(id).or_default().push(node);
        }
    }
    let scale = Matrix4::new_scaling(unit(root)?);
    let mut shown = children(root, "scene").flat_map(|scene| children(scene, "instance_visual_scene"));
    let scene = match (shown.next(), shown.next()) {
        (Some(instance), None) => Some(reader.target(instance, &["visual_scene"])?),
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

/// Maximum number of nodes; more are due to references that multiply each other. Robots have some dozens.
const MOST_NODES: usize = 100_000;

/// Maximum number of corners, more than any mesh of a robot has: 600 megabytes of them.
const MOST_CORNERS: usize = 25_000_000;

struct Reader<'a> {
    by_id: HashMap<&'a str, Vec<Node<'a, 'a>>>,
    pieces: Vec<Piece>,
    corners: usize,
    nodes: usize,
}

impl<'a> Reader<'a> {
    /// Element with one of some tags that another one refers to by `url` or `source`. Some exporters repeat an id in several
    /// geometries; the reference then means the element in the same geometry.
    fn target(&self, from: Node<'a, 'a>, tags: &[&str]) -> Result<Node<'a, 'a>, String> {
        let name = from.attribute("url").or(from.attribute("source")).unwrap_or_default();
        let all = self.by_id.get(name.strip_prefix('#').unwrap_or(name)).map_or(&[][..], Vec::as_slice);
        let mut found: Vec<Node> =
            all.iter().copied().filter(|node| tags.contains(&node.tag_name().name())).collect();
        if let Some(geometry) = from.ancestors().find(|node| node.has_tag_name_of("geometry"))
            && found.len() > 1
        {
            found.retain(|node| node.ancestors().any(|around| around == geometry));
        }
        let wrong = |what: &str| {
            let (tag, name) = (from.tag_name().name(), cranny_file::excerpt(name));
            Err(fault(from, &format!("<{tag}> refers to '{name}', {what}")))
        };
        match found[..] {
            [target] => Ok(target),
            [_, second, ..] => wrong(&format!("but there are two of it ({})", fault(second, "the second"))),
            [] if all.is_empty() => wrong("which is not there"),
            [] => wrong(&format!("which is no <{}>", tags.join("> or <"))),
        }
    }

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
        self.nodes += 1;
        if depth > MOST_DEPTH || self.nodes > MOST_NODES {
            return Err(fault(node, "nodes hold each other without end"));
        }
        let mut placed = *placed;
        let mut parts = Vec::new();
        for part in elements(node) {
            match motion(part)? {
                Some(motion) => placed *= motion,
                None => parts.push(part),
            }
        }
        for part in parts {
            match part.tag_name().name() {
                "instance_geometry" => {
                    self.add_geometry(self.target(part, &["geometry"])?, Some(part), &placed)?;
                }
                "instance_node" => self.add_node(self.target(part, &["node"])?, &placed, depth + 1)?,
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

    /// Colour of a primitive of a geometry that a node shows: its symbol refers to a material, which refers to an effect.
    fn colour(&self, instance: Option<Node<'a, 'a>>, primitive: Node<'a, 'a>) -> Option<[f32; 4]> {
        let symbol = primitive.attribute("material")?;
        let bound = |node: &Node<'a, 'a>| {
            node.has_tag_name_of("instance_material") && node.attribute("symbol") == Some(symbol)
        };
        let named = instance.and_then(|instance| instance.descendants().find(bound));
        let target = named.and_then(|node| node.attribute("target")).unwrap_or(symbol);
        let by_id = |name: &str, tag: &str| {
            let all = self.by_id.get(name.strip_prefix('#').unwrap_or(name))?;
            all.iter().find(|node| node.has_tag_name_of(tag)).copied()
        };
        let material = by_id(target, "material")?;
        let effect = by_id(child(material, "instance_effect")?.attribute("url")?, "effect")?;
        let diffuse = effect.descendants().find(|node| node.has_tag_name_of("diffuse"))?;
        let words = text(child(diffuse, "color")?).ok()?;
        let numbers: Vec<f32> = words.split_ascii_whitespace().filter_map(|word| word.parse().ok()).collect();
        numbers.first_chunk().copied().filter(|colour| colour.iter().all(|part| part.is_finite()))
    }

    fn add_geometry(
        &mut self,
        geometry: Node<'a, 'a>,
        instance: Option<Node<'a, 'a>>,
        placed: &Matrix4<f64>,
    ) -> Result<(), String> {
        let has_faces = |mesh: Node| elements(mesh).any(|part| Primitive::of(part).is_some());
        let mut is_empty = true;
        for part in elements(geometry) {
            match part.tag_name().name() {
                "asset" | "extra" => continue,
                "mesh" => self.add_mesh(part, instance, placed)?,
                "convex_mesh" if part.attribute("convex_hull_of").is_none() && has_faces(part) => {
                    self.add_mesh(part, instance, placed)?;
                }
                "convex_mesh" => {
                    return Err(fault(
                        part,
                        "a <convex_mesh> without faces is not read (export its hull as a mesh)",
                    ));
                }
                "brep" | "spline" => {
                    let tag = part.tag_name().name();
                    return Err(fault(
                        part,
                        &format!("a geometry of <{tag}> is not read (export it as a mesh)"),
                    ));
                }
                _ => return Err(unknown(part)),
            }
            is_empty = false;
        }
        if is_empty { Err(fault(geometry, "the geometry has no <mesh>")) } else { Ok(()) }
    }

    fn add_mesh(
        &mut self,
        mesh: Node<'a, 'a>,
        instance: Option<Node<'a, 'a>>,
        placed: &Matrix4<f64>,
    ) -> Result<(), String> {
        for primitive in elements(mesh) {
            let Some(kind) = Primitive::of(primitive) else {
                match primitive.tag_name().name() {
                    // Lines have no surface.
                    "source" | "vertices" | "lines" | "linestrips" | "extra" => continue,
                    _ => return Err(unknown(primitive)),
                }
            };
            let inputs = Inputs::of(primitive)?;
            let polygons = kind.polygons(primitive, &inputs)?;
            if polygons.is_empty() {
                continue;
            }
            let colour = self.colour(instance, primitive);
            if self.pieces.last().is_none_or(|piece| piece.colour != colour) {
                self.pieces.push(Piece { colour, corners: Vec::new() });
            }
            let input = inputs.element.ok_or_else(|| fault(primitive, "there is no <input> of VERTEX"))?;
            let positions = self.positions(self.target(input, &["vertices"])?)?;
            for polygon in polygons {
                self.add_polygon(primitive, &polygon, &positions, placed)?;
            }
        }
        Ok(())
    }

    fn add_polygon(
        &mut self,
        primitive: Node<'a, 'a>,
        polygon: &[usize],
        positions: &[Point],
        placed: &Matrix4<f64>,
    ) -> Result<(), String> {
        let position = |&vertex: &usize| {
            positions.get(vertex).copied().ok_or_else(|| {
                fault(primitive, &format!("vertex {vertex} is named, but there are {}", positions.len()))
            })
        };
        let polygon = polygon.iter().map(position).collect::<Result<Vec<_>, _>>()?;
        let triangles = triangulate(&polygon).ok_or_else(|| {
            fault(primitive, &format!("a polygon of {} corners crosses itself", polygon.len()))
        })?;
        for corner in triangles.into_iter().flatten() {
            let point = placed * polygon[corner].to_homogeneous();
            if let Some(piece) = self.pieces.last_mut() {
                piece.corners.push(Point::new(point.x, point.y, point.z));
            }
            self.corners += 1;
        }
        if self.corners > MOST_CORNERS {
            return Err(fault(primitive, &format!("the file shows more than {MOST_CORNERS} corners")));
        }
        Ok(())
    }

    /// Positions of a `<vertices>` element, in the unit of the file.
    fn positions(&self, vertices: Node<'a, 'a>) -> Result<Vec<Point>, String> {
        let is_position =
            |node: &Node| node.has_tag_name_of("input") && node.attribute("semantic") == Some("POSITION");
        let input =
            vertices.children().find(is_position).ok_or_else(|| fault(vertices, "no POSITION is given"))?;
        let source = self.target(input, &["source"])?;
        let accessor = child(source, "technique_common").and_then(|technique| child(technique, "accessor"));
        let accessor = accessor.ok_or_else(|| fault(source, "the source has no <accessor>"))?;
        let array = self.target(accessor, &["float_array", "int_array"])?;
        let numbers = numbers(array)?;
        if let Some(count) = array.attribute("count")
            && index(array, count)? != numbers.len()
        {
            let actual = numbers.len();
            return Err(fault(array, &format!("{count} numbers are announced, but there are {actual}")));
        }
        let size = |name: &str, default: usize| {
            accessor.attribute(name).map_or(Ok(default), |text| index(accessor, text))
        };
        let (count, stride, offset) = (size("count", 0)?, size("stride", 1)?, size("offset", 0)?);
        // x, y and z are the first three parameters with a name, or the first three.
        let params = accessor.children().filter(|node| node.has_tag_name_of("param"));
        let named: Vec<usize> = params
            .enumerate()
            .filter(|(_, param)| param.attribute("name").is_some())
            .map(|(at, _)| at)
            .collect();
        let [x, y, z] = if let [x, y, z, ..] = named[..] { [x, y, z] } else { [0, 1, 2] };
        let rows = numbers.get(offset..).unwrap_or_default().chunks(stride.max(1));
        let points: Option<Vec<Point>> =
            rows.take(count).map(|row| Some(Point::new(*row.get(x)?, *row.get(y)?, *row.get(z)?))).collect();
        points.filter(|points| points.len() == count).ok_or_else(|| {
            fault(
                accessor,
                &format!("{count} positions of {stride} numbers are more than the {} given", numbers.len()),
            )
        })
    }
}
