use std::collections::HashMap;
use std::fmt::Write as _;
use std::io::BufReader;
use std::path::Path;

use cranny_spatial::{Point, Vector};
use ply_rs_bw::parser::Parser;
use ply_rs_bw::ply::{DefaultElement, Property};

use crate::error::usable;
use crate::{ShapeError, collada};

/// Triangles as a file gives them: no promise of a closed or connected surface.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriangleSoup {
    /// Corner points, in metres; no two are equal.
    pub vertices: Vec<Point>,
    /// Three indices into `vertices` each, in the order of the file, normals outwards by the right hand.
    pub triangles: Vec<[u32; 3]>,
}

impl TriangleSoup {
    /// The triangles of a mesh file (OBJ, STL, DAE, PLY), its coordinates multiplied by `scale`. Equal
    /// vertices are merged, triangles keep the order of the file, polygons are cut into triangles.
    ///
    /// # Errors
    /// [`ShapeError`] with the file's path (and line, where the format has lines) if it cannot be read, is
    /// no mesh, holds numbers that are not finite, or has no triangles.
    pub fn load(path: &Path, scale: Vector) -> Result<Self, ShapeError> {
        let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
        let corners = match extension.as_str() {
            "obj" | "stl" => read_with_mesh_loader(path)?,
            "dae" => read_collada(path)?,
            "ply" => read_ply(path)?,
            _ => return Err(ShapeError::Format { path: path.to_owned(), extension }),
        };
        Self::from_corners(corners.iter().map(|corner| corner.coords.component_mul(&scale).into()))
            .and_then(|soup| if soup.triangles.is_empty() { Err(ShapeError::Empty) } else { Ok(soup) })
            .map_err(|fault| fault.in_file(path))
    }

    /// Writes the triangles as an OBJ file, in metres; what is read back is rounded to single precision.
    ///
    /// # Errors
    /// [`ShapeError::Write`].
    pub fn write_obj(&self, path: &Path) -> Result<(), ShapeError> {
        let mut text = String::new();
        for v in &self.vertices {
            let _ = writeln!(text, "v {} {} {}", v.x, v.y, v.z);
        }
        for [a, b, c] in &self.triangles {
            let _ = writeln!(text, "f {} {} {}", a + 1, b + 1, c + 1);
        }
        std::fs::write(path, text).map_err(|source| ShapeError::Write { path: path.to_owned(), source })
    }

    /// Triangles from their corners, three at a time; equal corners are merged.
    ///
    /// # Errors
    /// [`ShapeError::NotFinite`] for a corner with a coordinate that is no finite number.
    pub fn from_corners(corners: impl IntoIterator<Item = Point>) -> Result<Self, ShapeError> {
        let mut soup = Self::default();
        let mut known: HashMap<[u64; 3], u32> = HashMap::new();
        let mut corner_indices = Vec::new();
        for (vertex, corner) in corners.into_iter().enumerate() {
            usable(vertex, &corner)?;
            let c = corner.coords;
            // Adding zero turns −0 into 0, so that the two compare equal.
            let key = [c.x, c.y, c.z].map(|x| (x + 0.0).to_bits());
            let index = *known.entry(key).or_insert_with(|| {
                soup.vertices.push(corner);
                u32::try_from(soup.vertices.len() - 1).unwrap_or(u32::MAX)
            });
            corner_indices.push(index);
        }
        soup.triangles = corner_indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect();
        Ok(soup)
    }

    /// The three corners of triangle `index`.
    pub fn corners(&self, index: usize) -> [Point; 3] {
        self.triangles[index].map(|v| self.vertices[v as usize])
    }
}

fn read_with_mesh_loader(path: &Path) -> Result<Vec<Point>, ShapeError> {
    let scene = mesh_loader::Loader::default()
        .custom_reader(|path| cranny_file::MESH.bytes(path))
        .load(path)
        .map_err(|source| ShapeError::Read { path: path.to_owned(), source })?;
    let mut corners = Vec::new();
    for mesh in &scene.meshes {
        for (triangle, face) in mesh.faces.iter().enumerate() {
            for &vertex in face {
                let [x, y, z] = *mesh.vertices.get(vertex as usize).ok_or_else(|| {
                    ShapeError::VertexIndex { triangle, vertex, vertices: mesh.vertices.len() }.in_file(path)
                })?;
                corners.push(Point::new(x.into(), y.into(), z.into()));
            }
        }
    }
    Ok(corners)
}

fn read_collada(path: &Path) -> Result<Vec<Point>, ShapeError> {
    let unreadable = |source| ShapeError::Read { path: path.to_owned(), source };
    let text = cranny_file::MESH.text(path).map_err(unreadable)?;
    let broken = |message| unreadable(std::io::Error::new(std::io::ErrorKind::InvalidData, message));
    collada::corners(&text).map_err(broken)
}

fn read_ply(path: &Path) -> Result<Vec<Point>, ShapeError> {
    let broken = |message: String| ShapeError::Read {
        path: path.to_owned(),
        source: std::io::Error::new(std::io::ErrorKind::InvalidData, message),
    };
    let bytes =
        cranny_file::MESH.bytes(path).map_err(|source| ShapeError::Read { path: path.to_owned(), source })?;
    let ply = Parser::<DefaultElement>::new()
        .read_ply(&mut BufReader::new(&bytes[..]))
        .map_err(|fault| broken(fault.to_string()))?;

    let vertices: Vec<Point> = ply
        .payload
        .get("vertex")
        .ok_or_else(|| broken("the file has no element 'vertex'".into()))?
        .iter()
        .map(|vertex| {
            let coordinate = |name: &str| match vertex.get(name) {
                Some(Property::Float(x)) => Ok(f64::from(*x)),
                Some(Property::Double(x)) => Ok(*x),
                _ => Err(broken(format!("a vertex has no floating-point property '{name}'"))),
            };
            Ok(Point::new(coordinate("x")?, coordinate("y")?, coordinate("z")?))
        })
        .collect::<Result<_, ShapeError>>()?;

    let mut corners = Vec::new();
    for (triangle, face) in ply.payload.get("face").into_iter().flatten().enumerate() {
        let polygon = ["vertex_indices", "vertex_index"]
            .iter()
            .find_map(|name| face.get(*name).and_then(Property::to_u32_list))
            .ok_or_else(|| broken("a face has no list 'vertex_indices'".into()))?;
        for i in 2..polygon.len() {
            for vertex in [polygon[0], polygon[i - 1], polygon[i]] {
                corners.push(*vertices.get(vertex as usize).ok_or_else(|| {
                    ShapeError::VertexIndex { triangle, vertex, vertices: vertices.len() }.in_file(path)
                })?);
            }
        }
    }
    Ok(corners)
}
