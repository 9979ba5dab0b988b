use std::io::{Error, ErrorKind};
use std::path::Path;

use cranny_spatial::Vector;

use crate::error::check_scale;
use crate::mesh_files::painted_piece::PaintedPiece;
use crate::mesh_files::{collada, painted_obj};
use crate::{ShapeError, TriangleSoup};

/// Mesh for display, with the colours and normals of its file. It is no solid and may be open.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PaintedMesh {
    /// Pieces, each of one material.
    pub pieces: Vec<PaintedPiece>,
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
        let read = painted_obj::pieces(&bytes, path);
        let read = read.map_err(|message| unreadable(Error::new(ErrorKind::InvalidData, message)))?;
        let pieces: Result<Vec<_>, _> = read.into_iter().map(|piece| piece.scaled(&scale)).collect();
        Self::of_pieces(pieces.map_err(|fault| fault.in_file(path))?, path)
    }

    fn of_pieces(mut pieces: Vec<PaintedPiece>, path: &Path) -> Result<Self, ShapeError> {
        pieces.retain(|piece| !piece.triangles.is_empty());
        if pieces.is_empty() {
            return Err(ShapeError::Empty.in_file(path));
        }
        Ok(Self { pieces })
    }

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
        Self::of_pieces(pieces, path)
    }
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
