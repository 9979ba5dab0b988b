use cranny_spatial::{Point, Pose, Rotation, Vector, nalgebra};

use crate::{Aabb, TriangleSoup};

/// Cuboid whose surface is a run of twelve triangles: its pose in the mesh's frame and its half extents (m); `None` if
/// the run is no cuboid to within `tolerance_m` (m).
///
/// The released obstacle meshes are one to three cuboids of twelve consecutive faces each. The cuboids share vertices, so
/// only the order of the faces separates them, not connectivity.
pub fn cuboid_of_faces(
    soup: &TriangleSoup,
    faces: std::ops::Range<usize>,
    tolerance_m: f64,
) -> Option<(Pose, Vector)> {
    // 1. The corners: there must be eight.
    let mut corners: Vec<Point> = Vec::with_capacity(8);
    for face in faces.clone() {
        for corner in soup.corners(face) {
            if corners.iter().all(|known| (known - corner).norm() > tolerance_m) {
                corners.push(corner);
            }
        }
    }
    if faces.len() != 12 || corners.len() != 8 {
        return None;
    }
    // 2. The axes: the three perpendicular edges that leave the first corner.
    let origin = corners[0];
    let mut edges: Vec<Vector> = corners[1..].iter().map(|c| c - origin).collect();
    edges.sort_by(|a, b| a.norm_squared().total_cmp(&b.norm_squared()));
    let first = edges[0];
    let is_perpendicular = |a: &Vector, b: &Vector| a.dot(b).abs() <= tolerance_m * (a.norm() + b.norm());
    let second = *edges[1..].iter().find(|e| is_perpendicular(e, &first))?;
    let third = *edges[1..].iter().find(|e| is_perpendicular(e, &first) && is_perpendicular(e, &second))?;
    let mut axes = [first, second, third];
    // A cuboid along the axes of its frame gets no rotation.
    axes.sort_by_key(Vector::iamax);
    let mut directions = axes.map(|axis| axis.normalize() * axis[axis.iamax()].signum());
    if directions[0].cross(&directions[1]).dot(&directions[2]) < 0.0 {
        directions[2] = -directions[2];
    }
    let rotation = Rotation::from_rotation_matrix(&nalgebra::Rotation3::from_matrix_unchecked(
        nalgebra::Matrix3::from_columns(&directions),
    ));
    let center = origin + (first + second + third) * 0.5;
    let half_extents = Vector::new(axes[0].norm(), axes[1].norm(), axes[2].norm()) * 0.5;
    let pose = Pose::from_parts(center.coords.into(), rotation);
    // 3. Every corner is a corner of that cuboid.
    let shape = Aabb { center: Point::origin(), half_extents };
    let is_corner = |corner: &Point| {
        let local = pose.inverse_transform_point(corner);
        (local.coords.abs() - shape.half_extents).amax() <= tolerance_m
    };
    corners.iter().all(is_corner).then_some((pose, half_extents))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Surface;

    #[test]
    fn a_turned_cuboid_is_read_back() {
        let half_extents = Vector::new(0.05, 0.4, 0.2);
        let pose = Pose::new(Vector::new(1.0, -2.0, 0.3), Vector::new(0.2, -0.4, 0.3));
        let soup = Surface::cuboid_soup(&half_extents);
        let turned =
            TriangleSoup { vertices: soup.vertices.iter().map(|v| pose * v).collect(), ..soup.clone() };
        let (found, half) = cuboid_of_faces(&turned, 0..12, 1e-6).expect("a cuboid");
        assert!((found.translation.vector - pose.translation.vector).norm() < 1e-9);
        assert!((half.product() - half_extents.product()).abs() < 1e-12);
        let (straight, half) = cuboid_of_faces(&soup, 0..12, 1e-6).expect("a cuboid");
        assert!((half - half_extents).norm() < 1e-12 && straight.rotation.angle() < 1e-9);
    }

    #[test]
    fn a_sheared_box_is_no_cuboid() {
        let mut soup = Surface::cuboid_soup(&Vector::new(0.1, 0.1, 0.1));
        for vertex in &mut soup.vertices {
            vertex.x += 0.3 * vertex.z;
        }
        assert!(cuboid_of_faces(&soup, 0..12, 1e-6).is_none());
    }
}
