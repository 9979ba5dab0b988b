//! The triangles of a COLLADA file (`.dae`, version 1.4 or 1.5): what its scene shows, in metres.
//!
//! Read are geometries of meshes (triangles, polylist, polygons, tristrips, trifans), the nodes that place them
//! (matrix, translate, rotate, scale; library nodes), the unit, and the diffuse colours of materials; not read are the upward axis, as in other
//! readers of robots, skins, splines, and all that is only seen.

use std::collections::HashMap;

use cranny_spatial::nalgebra::{Matrix4, Rotation3, Unit, Vector4};
use cranny_spatial::{Point, Vector};
use roxmltree::{Document, Node};

use crate::polygon::triangulate;

/// The corners of the triangles, three at a time.
///
/// # Errors
/// In words, with the line.
pub(crate) fn corners(text: &str) -> Result<Vec<Point>, String> {
    Ok(pieces(text)?.into_iter().flat_map(|piece| piece.corners).collect())
}

/// Triangles of one colour.
pub(crate) struct Piece {
    /// Red, green, blue, opacity, if a material says them.
    pub colour: Option<[f32; 4]>,
    /// Three at a time.
    pub corners: Vec<Point>,
}

/// The triangles, run by run of those with one colour, in the order of the file.
///
/// # Errors
/// In words, with the line.
pub(crate) fn pieces(text: &str) -> Result<Vec<Piece>, String> {
    let document = Document::parse(text).map_err(|reason| reason.to_string())?;
    let root = document.root_element();
    if root.tag_name().name() != "COLLADA" {
        return Err(format!("the outermost element is <{}>, not <COLLADA>", root.tag_name().name()));
    }
    let by_id = root.descendants().filter_map(|node| Some((node.attribute("id")?, node))).collect();
    let mut reader = Reader { by_id, pieces: Vec::new(), corners: 0, nodes: 0 };
    let unit = match child(root, "asset").and_then(|asset| child(asset, "unit")) {
        Some(unit) => unit.attribute("meter").map_or(Ok(1.0), |meter| number(unit, meter))?,
        None => 1.0,
    };
    let scale = Matrix4::new_scaling(unit);
    let shown = child(root, "scene").and_then(|scene| child(scene, "instance_visual_scene"));
    match shown {
        Some(instance) => reader.add_children(reader.target(instance)?, &scale, 0)?,
        None => {
            for geometry in root.descendants().filter(|node| node.has_tag_name_of("geometry")) {
                reader.add_geometry(geometry, None, &scale)?;
            }
        }
    }
    Ok(reader.pieces)
}

/// Deeper nodes are a circle of references.
const MOST_DEPTH: usize = 64;

/// More nodes are references that multiply each other; robots have some dozens.
const MOST_NODES: usize = 100_000;

/// More corners than any mesh of a robot has: 600 megabytes of them.
const MOST_CORNERS: usize = 25_000_000;

struct Reader<'a> {
    by_id: HashMap<&'a str, Node<'a, 'a>>,
    pieces: Vec<Piece>,
    corners: usize,
    nodes: usize,
}

impl<'a> Reader<'a> {
    /// What an element refers to by `url` or `source`.
    fn target(&self, from: Node<'a, 'a>) -> Result<Node<'a, 'a>, String> {
        let name = from.attribute("url").or(from.attribute("source")).unwrap_or_default();
        let id = name.strip_prefix('#').unwrap_or(name);
        let missing =
            || fault(from, &format!("<{}> refers to '{name}', which is not there", from.tag_name().name()));
        self.by_id.get(id).copied().ok_or_else(missing)
    }

    /// All that the nodes directly inside show.
    fn add_children(
        &mut self,
        parent: Node<'a, 'a>,
        placed: &Matrix4<f64>,
        depth: usize,
    ) -> Result<(), String> {
        for node in parent.children().filter(|node| node.has_tag_name_of("node")) {
            self.add_node(node, placed, depth)?;
        }
        Ok(())
    }

    fn add_node(&mut self, node: Node<'a, 'a>, placed: &Matrix4<f64>, depth: usize) -> Result<(), String> {
        self.nodes += 1;
        if depth > MOST_DEPTH || self.nodes > MOST_NODES {
            return Err(fault(node, "nodes hold each other without end"));
        }
        let mut placed = *placed;
        for part in node.children().filter(Node::is_element) {
            if let Some(motion) = motion(part)? {
                placed *= motion;
            }
        }
        for part in node.children().filter(Node::is_element) {
            match part.tag_name().name() {
                "instance_geometry" => self.add_geometry(self.target(part)?, Some(part), &placed)?,
                "instance_node" => self.add_node(self.target(part)?, &placed, depth + 1)?,
                "node" => self.add_node(part, &placed, depth + 1)?,
                _ => {}
            }
        }
        Ok(())
    }

    /// The colour of a primitive of a geometry that a node shows: its symbol leads to a material, that to an effect.
    fn colour(&self, instance: Option<Node<'a, 'a>>, primitive: Node<'a, 'a>) -> Option<[f32; 4]> {
        let symbol = primitive.attribute("material")?;
        let bound = |node: &Node<'a, 'a>| {
            node.has_tag_name_of("instance_material") && node.attribute("symbol") == Some(symbol)
        };
        let named = instance.and_then(|instance| instance.descendants().find(bound));
        let target = named.and_then(|node| node.attribute("target")).unwrap_or(symbol);
        let by_id = |name: &str| self.by_id.get(name.strip_prefix('#').unwrap_or(name)).copied();
        let effect = by_id(child(by_id(target)?, "instance_effect")?.attribute("url")?)?;
        let diffuse = effect.descendants().find(|node| node.has_tag_name_of("diffuse"))?;
        let numbers: Vec<f32> =
            words(child(diffuse, "color")?).filter_map(|word| word.parse().ok()).collect();
        numbers.first_chunk().copied().filter(|colour| colour.iter().all(|part| part.is_finite()))
    }

    fn add_geometry(
        &mut self,
        geometry: Node<'a, 'a>,
        instance: Option<Node<'a, 'a>>,
        placed: &Matrix4<f64>,
    ) -> Result<(), String> {
        let Some(mesh) = child(geometry, "mesh") else { return Ok(()) };
        for primitive in mesh.children().filter(Node::is_element) {
            let Some(kind) = Primitive::of(primitive) else { continue };
            let colour = self.colour(instance, primitive);
            if self.pieces.last().is_none_or(|piece| piece.colour != colour) {
                self.pieces.push(Piece { colour, corners: Vec::new() });
            }
            let (mut positions, mut at, mut stride) = (None, 0, 1);
            for input in primitive.children().filter(|node| node.has_tag_name_of("input")) {
                let offset = input.attribute("offset").map_or(Ok(0), |offset| index(input, offset))?;
                stride = stride.max(offset.saturating_add(1));
                if input.attribute("semantic") == Some("VERTEX") {
                    positions = Some(self.positions(self.target(input)?)?);
                    at = offset;
                }
            }
            let Some(positions) = positions else { continue };
            if let Some(holed) = child(primitive, "ph") {
                return Err(fault(holed, "a polygon with holes (<ph>) is not read"));
            }
            let lists = primitive.children().filter(|node| node.has_tag_name_of("p"));
            let mut polygons: Vec<Vec<usize>> = Vec::new();
            for list in lists {
                let indices = words(list).map(|word| index(list, word)).collect::<Result<Vec<_>, _>>()?;
                let vertices: Vec<usize> =
                    indices.chunks(stride).filter_map(|c| c.get(at).copied()).collect();
                polygons.extend(kind.polygons(primitive, &vertices)?);
            }
            kind.check_count(primitive, polygons.len())?;
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

    /// The positions of a `<vertices>`.
    fn positions(&self, vertices: Node<'a, 'a>) -> Result<Vec<Point>, String> {
        let is_position =
            |node: &Node| node.has_tag_name_of("input") && node.attribute("semantic") == Some("POSITION");
        let input =
            vertices.children().find(is_position).ok_or_else(|| fault(vertices, "no POSITION is given"))?;
        let source = self.target(input)?;
        let accessor = child(source, "technique_common").and_then(|technique| child(technique, "accessor"));
        let accessor = accessor.ok_or_else(|| fault(source, "the source has no <accessor>"))?;
        let array = self.target(accessor)?;
        let numbers = words(array).map(|word| number(array, word)).collect::<Result<Vec<_>, _>>()?;
        let size = |name: &str, default: usize| {
            accessor.attribute(name).map_or(Ok(default), |text| index(accessor, text))
        };
        let (count, stride, offset) = (size("count", 0)?, size("stride", 1)?, size("offset", 0)?);
        // x, y and z are the first three that have a name, or the first three.
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

/// How the vertices of a primitive make polygons.
enum Primitive {
    Triangles,
    Polylist,
    Polygon,
    Strip,
    Fan,
}

impl Primitive {
    fn of(element: Node) -> Option<Self> {
        Some(match element.tag_name().name() {
            "triangles" => Self::Triangles,
            "polylist" => Self::Polylist,
            "polygons" => Self::Polygon,
            "tristrips" => Self::Strip,
            "trifans" => Self::Fan,
            _ => return None,
        })
    }

    /// Refuses a count that is not that of the polygons; of strips and fans it is that of the lists.
    fn check_count(&self, element: Node, actual: usize) -> Result<(), String> {
        match (self, element.attribute("count")) {
            (Self::Triangles | Self::Polylist, Some(count)) if index(element, count)? != actual => {
                Err(fault(element, &format!("{count} polygons are announced, but there are {actual}")))
            }
            _ => Ok(()),
        }
    }

    fn polygons(&self, element: Node, vertices: &[usize]) -> Result<Vec<Vec<usize>>, String> {
        Ok(match self {
            Self::Triangles => vertices.chunks_exact(3).map(<[usize]>::to_vec).collect(),
            Self::Polygon => vec![vertices.to_vec()],
            Self::Fan => {
                (2..vertices.len()).map(|at| vec![vertices[0], vertices[at - 1], vertices[at]]).collect()
            }
            Self::Strip => {
                // Every second triangle of a strip runs the other way round.
                let turned = |(at, t): (usize, &[usize])| {
                    if at % 2 == 0 { vec![t[0], t[1], t[2]] } else { vec![t[1], t[0], t[2]] }
                };
                vertices.windows(3).enumerate().map(turned).collect()
            }
            Self::Polylist => {
                let counts =
                    child(element, "vcount").ok_or_else(|| fault(element, "there is no <vcount>"))?;
                let mut rest = vertices;
                let mut polygons = Vec::new();
                for word in words(counts) {
                    let split = rest.split_at_checked(index(counts, word)?);
                    let (polygon, behind) =
                        split.ok_or_else(|| fault(counts, "it counts more than there are"))?;
                    polygons.push(polygon.to_vec());
                    rest = behind;
                }
                polygons
            }
        })
    }
}

/// What an element of a node does to all in it, if it is a motion.
fn motion(element: Node) -> Result<Option<Matrix4<f64>>, String> {
    let numbers = || words(element).map(|word| number(element, word)).collect::<Result<Vec<f64>, _>>();
    let wrong = |count: usize| fault(element, &format!("{count} numbers are needed"));
    Ok(Some(match element.tag_name().name() {
        "matrix" => {
            let numbers = numbers()?;
            let rows: &[f64; 16] = numbers.first_chunk().ok_or_else(|| wrong(16))?;
            Matrix4::from_row_slice(rows)
        }
        "translate" => {
            let [x, y, z] = *numbers()?.first_chunk().ok_or_else(|| wrong(3))?;
            Matrix4::new_translation(&Vector::new(x, y, z))
        }
        "scale" => {
            let [x, y, z] = *numbers()?.first_chunk().ok_or_else(|| wrong(3))?;
            Matrix4::from_diagonal(&Vector4::new(x, y, z, 1.0))
        }
        "rotate" => {
            let [x, y, z, degrees] = *numbers()?.first_chunk().ok_or_else(|| wrong(4))?;
            let axis = Unit::try_new(Vector::new(x, y, z), 0.0)
                .ok_or_else(|| fault(element, "the axis has no length"))?;
            Rotation3::from_axis_angle(&axis, degrees.to_radians()).to_homogeneous()
        }
        _ => return Ok(None),
    }))
}

/// Tags are compared without their namespace, which differs between versions.
trait HasTag {
    fn has_tag_name_of(&self, tag: &str) -> bool;
}

impl HasTag for Node<'_, '_> {
    fn has_tag_name_of(&self, tag: &str) -> bool {
        self.is_element() && self.tag_name().name() == tag
    }
}

fn child<'a>(node: Node<'a, 'a>, tag: &str) -> Option<Node<'a, 'a>> {
    node.children().find(|child| child.has_tag_name_of(tag))
}

/// The words of an element's text.
fn words<'a>(node: Node<'a, 'a>) -> impl Iterator<Item = &'a str> {
    node.text().unwrap_or_default().split_ascii_whitespace()
}

fn number(node: Node, word: &str) -> Result<f64, String> {
    word.parse().map_err(|_| fault(node, &format!("'{word}' is no number")))
}

fn index(node: Node, word: &str) -> Result<usize, String> {
    word.parse().map_err(|_| fault(node, &format!("'{word}' is no index")))
}

fn fault(node: Node, what: &str) -> String {
    format!("line {}: {what}", node.document().text_pos_at(node.range().start).row)
}
