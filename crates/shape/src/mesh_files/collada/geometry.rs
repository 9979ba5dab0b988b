use std::collections::HashMap;
use std::rc::Rc;

use cranny_spatial::Point;
use roxmltree::{Node, NodeId};

use super::element::{HasTag, child, elements, fault, index, numbers, unknown};
use super::primitive::{Inputs, Primitive};
use super::references::References;
use crate::mesh_files::mesh_size::check_corners;
use crate::mesh_files::polygon::triangulate;

/// Geometries of a file. Each of their elements is read once, however many others refer to it: the time is linear in the size
/// of the file.
pub(super) struct Geometries<'a> {
    pub(super) references: References<'a>,
    surfaces: HashMap<NodeId, Rc<[Surface<'a>]>>,
    /// Positions of `<vertices>` and of `<source>` elements.
    positions: HashMap<NodeId, Positions>,
    /// Numbers of arrays, which several sources may share.
    arrays: HashMap<NodeId, Rc<[f64]>>,
    corners: usize,
}

/// Triangles of a primitive, of which there is at least one.
pub(super) struct Surface<'a> {
    pub(super) primitive: Node<'a, 'a>,
    /// Corners of the triangles, three at a time, in the unit of the file.
    pub(super) corners: Vec<Point>,
}

impl<'a> Geometries<'a> {
    pub(super) fn of(root: Node<'a, 'a>) -> Self {
        Self {
            references: References::of(root),
            surfaces: HashMap::new(),
            positions: HashMap::new(),
            arrays: HashMap::new(),
            corners: 0,
        }
    }

    /// Triangles of a `<geometry>` element, primitive by primitive.
    pub(super) fn surfaces(&mut self, geometry: Node<'a, 'a>) -> Result<Rc<[Surface<'a>]>, String> {
        if let Some(known) = self.surfaces.get(&geometry.id()) {
            return Ok(Rc::clone(known));
        }
        let has_faces = |mesh: Node| elements(mesh).any(|part| Primitive::of(part).is_some());
        let (mut surfaces, mut is_empty) = (Vec::new(), true);
        for part in elements(geometry) {
            match part.tag_name().name() {
                "asset" | "extra" => continue,
                "mesh" => self.read_mesh(part, &mut surfaces)?,
                "convex_mesh" if part.attribute("convex_hull_of").is_none() && has_faces(part) => {
                    self.read_mesh(part, &mut surfaces)?;
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
        if is_empty {
            return Err(fault(geometry, "the geometry has no <mesh>"));
        }
        let surfaces: Rc<[Surface]> = surfaces.into();
        self.surfaces.insert(geometry.id(), Rc::clone(&surfaces));
        Ok(surfaces)
    }

    fn read_mesh(&mut self, mesh: Node<'a, 'a>, surfaces: &mut Vec<Surface<'a>>) -> Result<(), String> {
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
            let input = inputs.element.ok_or_else(|| fault(primitive, "there is no <input> of VERTEX"))?;
            let positions = self.positions(self.references.target(input, &["vertices"])?)?;
            let mut corners = Vec::new();
            for polygon in polygons {
                triangles(primitive, &polygon, &positions, &mut corners)?;
                check_corners(self.corners + corners.len()).map_err(|excess| fault(primitive, &excess))?;
            }
            self.corners += corners.len();
            if !corners.is_empty() {
                surfaces.push(Surface { primitive, corners });
            }
        }
        Ok(())
    }

    /// Positions of a `<vertices>` element.
    fn positions(&mut self, vertices: Node<'a, 'a>) -> Result<Positions, String> {
        if let Some(known) = self.positions.get(&vertices.id()) {
            return Ok(known.clone());
        }
        let is_position =
            |node: &Node| node.has_tag_name_of("input") && node.attribute("semantic") == Some("POSITION");
        let input =
            vertices.children().find(is_position).ok_or_else(|| fault(vertices, "no POSITION is given"))?;
        let source = self.references.target(input, &["source"])?;
        let positions = match self.positions.get(&source.id()) {
            Some(known) => known.clone(),
            None => self.positions_of_source(source)?,
        };
        self.positions.insert(source.id(), positions.clone());
        self.positions.insert(vertices.id(), positions.clone());
        Ok(positions)
    }

    fn positions_of_source(&mut self, source: Node<'a, 'a>) -> Result<Positions, String> {
        let accessor = child(source, "technique_common").and_then(|technique| child(technique, "accessor"));
        let accessor = accessor.ok_or_else(|| fault(source, "the source has no <accessor>"))?;
        let numbers = self.numbers(self.references.target(accessor, &["float_array", "int_array"])?)?;
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
        let axes = if let [x, y, z, ..] = named[..] { [x, y, z] } else { [0, 1, 2] };
        let positions = Positions { numbers, count, stride, offset, axes };
        // The last position is the first to be missing.
        let is_complete = count.checked_sub(1).is_none_or(|last| positions.get(last).is_some());
        if is_complete {
            return Ok(positions);
        }
        let given = positions.numbers.len();
        Err(fault(
            accessor,
            &format!("{count} positions of {stride} numbers are more than the {given} given"),
        ))
    }

    fn numbers(&mut self, array: Node<'a, 'a>) -> Result<Rc<[f64]>, String> {
        if let Some(known) = self.arrays.get(&array.id()) {
            return Ok(Rc::clone(known));
        }
        let numbers = numbers(array)?;
        if let Some(count) = array.attribute("count")
            && index(array, count)? != numbers.len()
        {
            let actual = numbers.len();
            return Err(fault(array, &format!("{count} numbers are announced, but there are {actual}")));
        }
        let numbers: Rc<[f64]> = numbers.into();
        self.arrays.insert(array.id(), Rc::clone(&numbers));
        Ok(numbers)
    }
}

/// Positions in an array, in the unit of the file.
#[derive(Clone)]
struct Positions {
    numbers: Rc<[f64]>,
    count: usize,
    /// Number of numbers from one position to the next.
    stride: usize,
    offset: usize,
    /// Places of x, y and z among the numbers of a position.
    axes: [usize; 3],
}

impl Positions {
    fn get(&self, vertex: usize) -> Option<Point> {
        let row = self.stride.checked_mul(vertex)?.checked_add(self.offset)?;
        let number = |axis: usize| self.numbers.get(row.checked_add(axis)?).copied();
        let is_inside = vertex < self.count && self.axes.iter().all(|axis| *axis < self.stride);
        let [x, y, z] = self.axes;
        is_inside.then(|| Some(Point::new(number(x)?, number(y)?, number(z)?))).flatten()
    }
}

/// Adds the corners of a polygon's triangles.
fn triangles(
    primitive: Node,
    polygon: &[usize],
    positions: &Positions,
    corners: &mut Vec<Point>,
) -> Result<(), String> {
    let position = |&vertex: &usize| {
        positions.get(vertex).ok_or_else(|| {
            fault(primitive, &format!("vertex {vertex} is named, but there are {}", positions.count))
        })
    };
    let polygon = polygon.iter().map(position).collect::<Result<Vec<_>, _>>()?;
    let triangles = triangulate(&polygon)
        .ok_or_else(|| fault(primitive, &format!("a polygon of {} corners crosses itself", polygon.len())))?;
    corners.extend(triangles.into_iter().flatten().map(|corner| polygon[corner]));
    Ok(())
}
