use std::collections::HashSet;
use std::io::{Error, ErrorKind};
use std::path::Path;

use cranny_spatial::{Point, Vector};

use crate::error::{check_scale, usable};
use crate::{ShapeError, TriangleSoup, mesh_files::collada};

/// Mesh for display, with the colours and normals of its file. It is no solid and may be open.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PaintedMesh {
    /// Pieces, each of one material.
    pub pieces: Vec<PaintedPiece>,
}

/// Triangles of one material.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PaintedPiece {
    /// Corner points, in metres.
    pub vertices: Vec<[f32; 3]>,
    /// Unit normal of each vertex; empty if the file gives none.
    pub normals: Vec<[f32; 3]>,
    /// Red, green, blue and opacity of each vertex, 0 to 1, sRGB; empty if the file gives none.
    pub vertex_colours: Vec<[f32; 4]>,
    /// Three indices into `vertices` each, counterclockwise from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Red, green, blue and opacity of the material, 0 to 1, sRGB; `None` if it has none.
    pub colour: Option<[f32; 4]>,
}

impl PaintedMesh {
    /// Reads a mesh file (OBJ with its MTL, STL, DAE, PLY), with coordinates multiplied by `scale`. A mirroring scale
    /// reverses the triangles, so that they still face outwards. Reads diffuse colours, but no textures.
    ///
    /// # Errors
    /// As [`TriangleSoup::load`].
    pub fn load(path: &Path, scale: Vector) -> Result<Self, ShapeError> {
        check_scale(&scale).map_err(|fault| fault.in_file(path))?;
        let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default();
        if ["msh", "ply", "stl"].iter().any(|plain| extension.eq_ignore_ascii_case(plain)) {
            return Ok(Self { pieces: vec![PaintedPiece::of_soup(&TriangleSoup::load(path, scale)?)] });
        }
        if extension.eq_ignore_ascii_case("dae") {
            return Self::of_collada(path, scale);
        }
        if !extension.eq_ignore_ascii_case("obj") {
            return Err(ShapeError::Format { path: path.to_owned(), extension: extension.to_lowercase() });
        }
        let unreadable = |source| ShapeError::Read { path: path.to_owned(), source };
        let bytes = cranny_file::MESH.bytes(path).map_err(unreadable)?;
        check_pieces(&bytes).map_err(|excess| unreadable(Error::new(ErrorKind::InvalidData, excess)))?;
        let mut libraries = HashSet::new();
        let read = mesh_loader::obj::from_slice(&bytes, Some(path), |library| {
            // A second reading of a library of materials changes nothing.
            let is_new = libraries.insert(library.to_owned());
            if is_new { cranny_file::TEXT.bytes(library) } else { Ok(Vec::new()) }
        })
        .map_err(unreadable)?;
        let materials = read.materials.iter().map(Some).chain(std::iter::repeat(None));
        let pieces: Result<Vec<_>, _> =
            read.meshes.iter().zip(materials).map(|(mesh, material)| piece(mesh, material, &scale)).collect();
        let mut pieces = pieces.map_err(|fault| fault.in_file(path))?;
        pieces.retain(|piece| !piece.triangles.is_empty());
        if pieces.is_empty() {
            return Err(ShapeError::Empty.in_file(path));
        }
        Ok(Self { pieces })
    }
}

/// Checks the number of lines of an OBJ file that begin a piece, or name a library of materials.
///
/// # Errors
/// A sentence with the limit.
fn check_pieces(bytes: &[u8]) -> Result<(), String> {
    /// Each takes some 500 bytes, and is a drawing of its own.
    const MOST: usize = 100_000;
    let lines = bytes.split(|byte| [b'\n', b'\r'].contains(byte)).map(<[u8]>::trim_ascii_start);
    let begins =
        |line: &&[u8]| [&b"g "[..], b"g\t", b"usemtl", b"mtllib"].iter().any(|word| line.starts_with(word));
    let actual = lines.filter(begins).count();
    if actual <= MOST {
        return Ok(());
    }
    Err(format!("{actual} groups and materials in one mesh, but at most {MOST} are read"))
}

impl PaintedMesh {
    fn of_collada(path: &Path, scale: Vector) -> Result<Self, ShapeError> {
        let unreadable = |source| ShapeError::Read { path: path.to_owned(), source };
        let broken = |message: String| unreadable(Error::new(ErrorKind::InvalidData, message));
        let text = cranny_file::MESH.text(path).map_err(unreadable)?;
        let mut pieces = Vec::new();
        for piece in collada::pieces(&text).map_err(broken)? {
            let corners = piece.corners.iter().map(|corner| corner.coords.component_mul(&scale).into());
            let mut soup = TriangleSoup::from_corners(corners).map_err(|fault| fault.in_file(path))?;
            if scale.product() < 0.0 {
                soup.triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
            }
            pieces.push(PaintedPiece { colour: piece.colour, ..PaintedPiece::of_soup(&soup) });
        }
        pieces.retain(|piece| !piece.triangles.is_empty());
        if pieces.is_empty() {
            return Err(ShapeError::Empty.in_file(path));
        }
        Ok(Self { pieces })
    }
}

impl PaintedPiece {
    /// Makes a piece of triangles without colours or normals.
    pub fn of_soup(soup: &TriangleSoup) -> Self {
        #[allow(clippy::cast_possible_truncation, reason = "the precision of graphics")]
        let vertices = soup.vertices.iter().map(|v| [v.x as f32, v.y as f32, v.z as f32]).collect();
        Self { vertices, triangles: soup.triangles.clone(), ..Self::default() }
    }
}

fn piece(
    mesh: &mesh_loader::Mesh,
    material: Option<&mesh_loader::Material>,
    scale: &Vector,
) -> Result<PaintedPiece, ShapeError> {
    #[allow(clippy::cast_possible_truncation, reason = "single precision is what is meant")]
    let factors = [scale.x as f32, scale.y as f32, scale.z as f32];
    let scaled = |v: &[f32; 3]| [v[0] * factors[0], v[1] * factors[1], v[2] * factors[2]];
    let count = mesh.vertices.len();
    let vertices: Vec<[f32; 3]> = mesh.vertices.iter().map(scaled).collect();
    for (vertex, corner) in vertices.iter().enumerate() {
        usable(vertex, &Point::from(corner.map(f64::from)))?;
    }
    let is_mirrored = factors.iter().product::<f32>() < 0.0;
    let mut triangles = Vec::with_capacity(mesh.faces.len());
    for (triangle, &[a, b, c]) in mesh.faces.iter().enumerate() {
        if let Some(&vertex) = [a, b, c].iter().find(|&&vertex| vertex as usize >= count) {
            return Err(ShapeError::VertexIndex { triangle, vertex, vertices: count });
        }
        triangles.push(if is_mirrored { [a, c, b] } else { [a, b, c] });
    }
    // Normals scale by the inverse of the factors of points.
    let normal = |n: &[f32; 3]| {
        let n = [n[0] / factors[0], n[1] / factors[1], n[2] / factors[2]];
        let length = (n[0] * n[0] + n[1] * n[1] + n[2] * n[2]).sqrt();
        n.map(|x| x / length)
    };
    let mut normals: Vec<[f32; 3]> = mesh.normals.iter().map(normal).collect();
    if normals.len() != count || normals.iter().flatten().any(|x| !x.is_finite()) {
        normals.clear();
    }
    let has_colours = mesh.colors[0].len() == count && !mesh.colors[0].is_empty();
    Ok(PaintedPiece {
        vertices,
        normals,
        vertex_colours: if has_colours { mesh.colors[0].clone() } else { Vec::new() },
        triangles,
        colour: material.and_then(|material| material.color.diffuse),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_obj_brings_the_colours_of_its_materials() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("two.obj");
        std::fs::write(
            folder.path().join("two.mtl"),
            "newmtl red\nKd 1 0 0\nnewmtl grey\nKd 0.25 0.25 0.25\n",
        )
        .unwrap();
        let text = "mtllib two.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvn 0 0 1\nusemtl red\nf 1//1 2//1 3//1\n\
                    usemtl grey\nf 1//1 2//1 4//1\n";
        std::fs::write(&path, text).unwrap();
        let mesh = PaintedMesh::load(&path, Vector::new(2.0, 2.0, -2.0)).unwrap();
        let colours: Vec<_> = mesh.pieces.iter().map(|piece| piece.colour.map(|c| c[0])).collect();
        assert_eq!(colours, [Some(1.0), Some(0.25)]);
        // The mirroring scale reverses the triangles and the normals.
        let first = &mesh.pieces[0];
        assert!(
            first.normals[0].iter().zip([0.0, 0.0, -1.0]).all(|(a, b): (&f32, f32)| (a - b).abs() < 1e-6)
        );
        let corner = |index: usize| first.vertices[first.triangles[0][index] as usize];
        assert_eq!([corner(0), corner(1), corner(2)], [[0.0, 0.0, 0.0], [0.0, 2.0, 0.0], [2.0, 0.0, 0.0]]);
    }

    #[test]
    fn what_is_no_mesh_is_refused_with_its_path() {
        let folder = tempfile::tempdir().unwrap();
        for (name, text) in
            [("a.obj", ""), ("a.stl", "solid"), ("a.txt", "v 0 0 0"), ("a.obj", "v nan 0 0\nf 1 1 1\n")]
        {
            let path = folder.path().join(name);
            std::fs::write(&path, text).unwrap();
            let fault = PaintedMesh::load(&path, Vector::repeat(1.0)).unwrap_err().to_string();
            assert!(fault.contains(name), "{fault}");
        }
    }
}
