use std::collections::{BTreeMap, HashMap};

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

/// Number of triangles around a point up to which each is compared with each other one; more are grouped by direction. Usual
/// meshes have fewer.
const MOST_AROUND: usize = 128;

/// Number of directions of a group along half an axis: groups are 14° wide, and there are some 300 at most.
const DIRECTIONS: f32 = 4.0;

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
///
/// Around a point of many triangles, the sum is over groups of triangles of similar direction, which belong to it or not as a
/// whole. The work is thus proportional to the number of triangles, also if all of them meet in one point.
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
    let mut normals_at: HashMap<[u32; 3], Vec<Vector3<f32>>> = HashMap::new();
    let place = |vertex: u32| vertices[vertex as usize].map(|x| (x + 0.0).to_bits());
    for (corners, normal) in triangles.iter().zip(&area_normals) {
        for &corner in corners {
            normals_at.entry(place(corner)).or_default().push(*normal);
        }
    }
    for normals in normals_at.values_mut().filter(|normals| normals.len() > MOST_AROUND) {
        *normals = by_direction(normals);
    }
    let mut piece = MeshPiece { material, ..MeshPiece::default() };
    let mut known: HashMap<(u32, [u32; 3]), u32> = HashMap::new();
    for (triangle, corners) in triangles.iter().enumerate() {
        let Some(face) = area_normals[triangle].try_normalize(0.0) else { continue };
        let corners = corners.map(|corner| {
            let sum: Vector3<f32> = normals_at[&place(corner)]
                .iter()
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

/// Returns the sums of the normals in each group of similar directions.
fn by_direction(normals: &[Vector3<f32>]) -> Vec<Vector3<f32>> {
    // Ordered, so that the sums are the same on every machine.
    let mut sums: BTreeMap<[u32; 3], Vector3<f32>> = BTreeMap::new();
    for normal in normals {
        let Some(direction) = normal.try_normalize(0.0) else { continue };
        let group = <[f32; 3]>::from(direction).map(|x| ((x * DIRECTIONS).round() + 0.0).to_bits());
        *sums.entry(group).or_default() += normal;
    }
    sums.into_values().collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use cranny_shape::Surface;
    use cranny_spatial::{Vector, sin_cos};

    /// Returns a cone along z about its tip at the origin, or a disk if it has no depth.
    fn cone(triangles: u32, depth: f64) -> TriangleSoup {
        let corner = |index: u32| {
            let angle = std::f64::consts::TAU * f64::from(index % triangles) / f64::from(triangles);
            let (sine, cosine) = sin_cos(angle);
            Point::new(cosine, sine, -depth)
        };
        let tip = Point::origin();
        TriangleSoup {
            vertices: std::iter::once(tip).chain((0..triangles).map(corner)).collect(),
            triangles: (0..triangles).map(|index| [0, index + 1, (index + 1) % triangles + 1]).collect(),
        }
    }

    /// Without groups, these triangles in one point would be compared 10¹¹ times.
    #[test]
    fn a_point_of_many_triangles_takes_little_work() {
        let count = 300_000;
        let disk = MeshPiece::of_soup(&cone(count, 0.0), 0);
        assert_eq!((disk.positions.len(), disk.triangles.len()), (300_001, 300_000));
        assert!(disk.normals.iter().all(|normal| normal[2] > 0.999));
    }

    #[test]
    fn the_normals_of_groups_are_near_those_of_single_triangles() {
        let count = 1000_u32;
        let piece = MeshPiece::of_soup(&cone(count, 1.0), 0);
        let normals: Vec<Vector3<f32>> = piece
            .triangles
            .iter()
            .map(|corners| corners.map(|corner| Vector3::from(piece.positions[corner as usize])))
            .map(|[a, b, c]| (b - a).cross(&(c - a)).normalize())
            .collect();
        for (corners, face) in piece.triangles.iter().zip(&normals) {
            let around = normals.iter().filter(|normal| normal.dot(face) >= CREASE_COSINE);
            let expected = around.sum::<Vector3<f32>>().normalize();
            let cosine = Vector3::from(piece.normals[corners[0] as usize]).dot(&expected);
            assert!(cosine > 0.97, "{cosine}");
        }
    }

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
