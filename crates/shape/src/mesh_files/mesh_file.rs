use std::collections::HashMap;
use std::fmt::Write as _;
use std::io::{Error, ErrorKind};
use std::path::Path;

use cranny_spatial::{Point, Pose, Vector};

use crate::error::{check_scale, usable};
use crate::{
    ShapeError, mesh_files::collada, mesh_files::msh, mesh_files::obj, mesh_files::ply, mesh_files::stl,
};

/// Triangles as in a file; their surface need not be closed or connected.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriangleSoup {
    /// Corner points, in metres; no two are equal.
    pub vertices: Vec<Point>,
    /// Three indices into `vertices` each, in the order of the file, normals outwards by the right-hand rule.
    pub triangles: Vec<[u32; 3]>,
}

impl TriangleSoup {
    /// Loads the triangles of a mesh file (OBJ, STL, DAE, PLY, MSH), with coordinates multiplied by `scale`. Merges equal vertices
    /// and keeps the order of the triangles. Triangulates polygons exactly; one that is not flat is cut as projected along the
    /// axis nearest to its normal. A mirroring scale reverses the triangles, so that they still face outwards.
    ///
    /// # Errors
    /// [`ShapeError`] with the file's path (and line, where the format has lines) if the file cannot be read, is no mesh,
    /// contains numbers that are not finite, a polygon that crosses itself or an unsupported element of its format, or
    /// has no triangles; [`ShapeError::Scale`] for a factor of zero or one that is not finite.
    pub fn load(path: &Path, scale: Vector) -> Result<Self, ShapeError> {
        check_scale(&scale).map_err(|fault| fault.in_file(path))?;
        let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
        let unreadable = |source| ShapeError::Read { path: path.to_owned(), source };
        let broken = |message| unreadable(Error::new(ErrorKind::InvalidData, message));
        let bytes = || cranny_file::MESH.bytes(path).map_err(unreadable);
        let corners = match extension.as_str() {
            "obj" => obj::corners(&bytes()?).map_err(broken)?,
            "stl" => stl::corners(&bytes()?).map_err(broken)?,
            "dae" => collada::corners(&cranny_file::MESH.text(path).map_err(unreadable)?).map_err(broken)?,
            "msh" => msh::corners(&bytes()?).map_err(broken)?,
            "ply" => ply::corners(&bytes()?).map_err(broken)?,
            _ => return Err(ShapeError::Format { path: path.to_owned(), extension }),
        };
        let mut soup = Self::from_corners(corners.iter().map(|c| c.coords.component_mul(&scale).into()))
            .and_then(|soup| if soup.triangles.is_empty() { Err(ShapeError::Empty) } else { Ok(soup) })
            .map_err(|fault| fault.in_file(path))?;
        if scale.product() < 0.0 {
            soup.triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
        }
        Ok(soup)
    }

    /// Text of the triangles in OBJ format, in metres. The first vertex has the number `first`, 1 in a file of its own.
    /// Reading it back rounds to single precision.
    pub fn obj_text(&self, first: u32) -> String {
        let mut text = String::new();
        for v in &self.vertices {
            let _ = writeln!(text, "v {} {} {}", v.x, v.y, v.z);
        }
        for [a, b, c] in &self.triangles {
            let _ = writeln!(text, "f {} {} {}", a + first, b + first, c + first);
        }
        text
    }

    /// Appends the triangles of another mesh; does not merge equal vertices.
    pub fn append(&mut self, other: &Self, own_from_other: &Pose) {
        let first = u32::try_from(self.vertices.len()).unwrap_or(u32::MAX);
        self.vertices.extend(other.vertices.iter().map(|vertex| own_from_other * vertex));
        self.triangles.extend(other.triangles.iter().map(|triangle| triangle.map(|vertex| vertex + first)));
    }

    /// Builds triangles from their corners, three at a time; merges equal corners.
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

    /// Corners of triangle `index`.
    pub fn corners(&self, index: usize) -> [Point; 3] {
        self.triangles[index].map(|v| self.vertices[v as usize])
    }
}
