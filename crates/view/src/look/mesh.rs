use std::collections::HashMap;

use cranny_shape::{PaintedPiece, TriangleSoup};
use cranny_spatial::nalgebra::Vector3;
use cranny_spatial::{Point, Vector};

use crate::Colour;

/// Mesh for display: triangles in pieces of one material each. It need not be closed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Name of the mesh.
    pub name: String,
    /// Pieces of one material each.
    pub pieces: Vec<MeshPiece>,
}

/// Triangles of one material.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshPiece {
    /// Corner points, in metres, in the frame of the node that shows the mesh.
    pub positions: Vec<[f32; 3]>,
    /// Unit normal of each corner point.
    pub normals: Vec<[f32; 3]>,
    /// Factor of the material colour at each corner point; empty for white.
    pub colours: Vec<Colour>,
    /// Three indices each, counterclockwise from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Index of the material in [`Scene::materials`](crate::Scene::materials).
    pub material: usize,
}

/// Cosine of the crease angle, 35°: faces that meet at a smaller angle form one smooth surface, as those of round solids (9°).
const CREASE_COSINE: f32 = 0.819;

impl MeshPiece {
    /// Creates a piece with normals that are smooth over flat angles and break at edges.
    pub fn of_soup(soup: &TriangleSoup, material: usize) -> Self {
        Self::of_painted(&PaintedPiece::of_soup(soup), material)
    }

    /// Creates a piece from a mesh file; without normals in the file, they are those of [`Self::of_soup`].
    pub fn of_painted(piece: &PaintedPiece, material: usize) -> Self {
        let colour = |c: &[f32; 4]| Colour::srgb([c[0].into(), c[1].into(), c[2].into()]);
        let colours: Vec<Colour> = piece.vertex_colours.iter().map(colour).collect();
        if piece.normals.len() == piece.vertices.len() {
            return Self {
                positions: piece.vertices.clone(),
                normals: piece.normals.clone(),
                colours,
                triangles: piece.triangles.clone(),
                material,
            };
        }
        smoothed(&piece.vertices, &colours, &piece.triangles, material)
    }

    /// Returns the piece without unused corners.
    #[must_use]
    pub(crate) fn compacted(&self) -> Self {
        let mut piece = Self { material: self.material, ..Self::default() };
        let mut moved: Vec<Option<u32>> = vec![None; self.positions.len()];
        for triangle in &self.triangles {
            let corners = triangle.map(|corner| {
                let corner = corner as usize;
                *moved[corner].get_or_insert_with(|| {
                    piece.push(self.positions[corner], self.normals[corner], self.colours.get(corner))
                })
            });
            piece.triangles.push(corners);
        }
        piece
    }

    /// Adds a corner and returns its index.
    pub(crate) fn push(&mut self, position: [f32; 3], normal: [f32; 3], colour: Option<&Colour>) -> u32 {
        let index = u32::try_from(self.positions.len()).unwrap_or(u32::MAX);
        self.positions.push(position);
        self.normals.push(normal);
        self.colours.extend(colour);
        index
    }

    /// Adds a corner of double precision without a colour and returns its index.
    pub(crate) fn push_point(&mut self, position: &Point, normal: &Vector) -> u32 {
        #[allow(clippy::cast_possible_truncation, reason = "single precision is what is meant")]
        let single = |v: &Vector| [v.x as f32, v.y as f32, v.z as f32];
        self.push(single(&position.coords), single(normal), None)
    }

    /// Appends the triangles of another piece, regardless of its material.
    pub(crate) fn append(&mut self, other: &Self) {
        let offset = u32::try_from(self.positions.len()).unwrap_or(u32::MAX);
        self.positions.extend_from_slice(&other.positions);
        self.normals.extend_from_slice(&other.normals);
        self.colours.extend_from_slice(&other.colours);
        self.triangles.extend(other.triangles.iter().map(|t| t.map(|corner| corner + offset)));
    }
}

/// Computes normals as the mean of the faces around a point within the crease angle of each face, weighted by their area.
/// Corners with equal normals are shared.
fn smoothed(
    vertices: &[[f32; 3]],
    vertex_colours: &[Colour],
    triangles: &[[u32; 3]],
    material: usize,
) -> MeshPiece {
    let point = |vertex: u32| Vector3::from(vertices[vertex as usize]);
    let area_normals: Vec<Vector3<f32>> =
        triangles.iter().map(|&[a, b, c]| (point(b) - point(a)).cross(&(point(c) - point(a)))).collect();
    // Coincident vertices count as one, so that a soup of separate triangles is smooth too.
    let mut places: HashMap<[u32; 3], Vec<usize>> = HashMap::new();
    let place = |vertex: u32| vertices[vertex as usize].map(|x| (x + 0.0).to_bits());
    for (triangle, corners) in triangles.iter().enumerate() {
        for &corner in corners {
            places.entry(place(corner)).or_default().push(triangle);
        }
    }
    let mut piece = MeshPiece { material, ..MeshPiece::default() };
    let mut known: HashMap<(u32, [u32; 3]), u32> = HashMap::new();
    for (triangle, corners) in triangles.iter().enumerate() {
        let Some(face) = area_normals[triangle].try_normalize(0.0) else { continue };
        let corners = corners.map(|corner| {
            let around = &places[&place(corner)];
            let sum: Vector3<f32> = around
                .iter()
                .map(|&other| &area_normals[other])
                .filter(|normal| normal.dot(&face) >= CREASE_COSINE * normal.norm())
                .sum();
            let normal: [f32; 3] = sum.try_normalize(0.0).unwrap_or(face).into();
            *known.entry((corner, normal.map(f32::to_bits))).or_insert_with(|| {
                piece.push(vertices[corner as usize], normal, vertex_colours.get(corner as usize))
            })
        });
        piece.triangles.push(corners);
    }
    piece
}

#[cfg(test)]
mod tests {
    use super::*;
    use cranny_shape::Surface;
    use cranny_spatial::Vector;

    #[test]
    fn a_box_has_sharp_edges_and_a_ball_is_smooth() {
        let cuboid = MeshPiece::of_soup(&Surface::cuboid_soup(&Vector::new(1.0, 2.0, 3.0)), 0);
        assert_eq!((cuboid.triangles.len(), cuboid.positions.len()), (12, 24));
        for normal in &cuboid.normals {
            assert!(normal.iter().map(|x| x.abs()).fold(0.0, f32::max) > 0.9999);
        }
        let ball = MeshPiece::of_soup(&TriangleSoup::geodesic_sphere(2.0, 3), 0);
        assert_eq!(ball.positions.len(), 642);
        for (position, normal) in ball.positions.iter().zip(&ball.normals) {
            let cosine = Vector3::from(*position).dot(&Vector3::from(*normal)) / 2.0;
            assert!(cosine > 0.999, "{cosine}");
        }
    }
}
