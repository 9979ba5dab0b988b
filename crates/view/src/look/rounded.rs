//! Closed-form meshes of cuboids and cylinders with edges rounded inwards.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, TAU};

use cranny_spatial::{Point, Vector, sin_cos};

use crate::MeshPiece;

/// Number of segments of the rounding of an edge.
const STEPS: u32 = 2;

/// Number of corners of a full circle.
const CIRCLE_POINTS: u32 = 32;

/// Returns a cylinder along z about the origin, with a rounding of at most its radius and half its length.
pub(crate) fn cylinder(half_length_m: f64, radius_m: f64, rounding_m: f64, material: usize) -> MeshPiece {
    let rounding_m = rounding_m.min(half_length_m).min(radius_m);
    // Radius, height and elevation of the normal, from the middle of the bottom to the middle of the top.
    let mut profile = vec![(0.0, -half_length_m, -FRAC_PI_2)];
    for (sign, from) in [(-1.0, -FRAC_PI_2), (1.0, 0.0)] {
        for step in 0..=STEPS {
            let angle = from + FRAC_PI_2 * f64::from(step) / f64::from(STEPS);
            let (sine, cosine) = sin_cos(angle);
            let middle = sign * (half_length_m - rounding_m);
            profile.push((radius_m - rounding_m + rounding_m * cosine, middle + rounding_m * sine, angle));
        }
    }
    profile.push((0.0, half_length_m, FRAC_PI_2));
    let mut piece = MeshPiece { material, ..MeshPiece::default() };
    for &(across, height, angle) in &profile {
        let (up, out) = sin_cos(angle);
        for corner in 0..CIRCLE_POINTS {
            let (sine, cosine) = sin_cos(TAU * f64::from(corner) / f64::from(CIRCLE_POINTS));
            let place = Point::new(across * cosine, across * sine, height);
            piece.push_point(&place, &Vector::new(out * cosine, out * sine, up));
        }
    }
    for (ring, pair) in (0_u32..).zip(profile.windows(2)) {
        for corner in 0..CIRCLE_POINTS {
            let next = (corner + 1) % CIRCLE_POINTS;
            let [a, b] = [ring * CIRCLE_POINTS + corner, ring * CIRCLE_POINTS + next];
            let [d, c] = [a + CIRCLE_POINTS, b + CIRCLE_POINTS];
            if pair[0].0 > 0.0 {
                piece.triangles.push([a, b, c]);
            }
            if pair[1].0 > 0.0 {
                piece.triangles.push([a, c, d]);
            }
        }
    }
    piece
}

/// Returns a cuboid about the origin, with a rounding of at most its least half extent.
pub(crate) fn cuboid(half_extents: &Vector, rounding_m: f64, material: usize) -> MeshPiece {
    let rounding_m = rounding_m.min(half_extents.min());
    let inner = half_extents.add_scalar(-rounding_m);
    // End of the face across which a corner lies, and the slope of the normal there.
    let slope = |step: u32| libm::tan(FRAC_PI_4 * f64::from(step) / f64::from(STEPS));
    let lower = (0..=STEPS).rev().map(|step| (-1.0, -slope(step)));
    let line: Vec<(f64, f64)> = lower.chain((0..=STEPS).map(|step| (1.0, slope(step)))).collect();
    let mut piece = MeshPiece { material, ..MeshPiece::default() };
    for axis in 0..3 {
        for side in [-1.0, 1.0] {
            let first = u32::try_from(piece.positions.len()).unwrap_or(u32::MAX);
            let (one, other) = ((axis + 1) % 3, (axis + 2) % 3);
            for &(end_one, slope_one) in &line {
                for &(end_other, slope_other) in &line {
                    let (mut corner, mut normal) = (Vector::zeros(), Vector::zeros());
                    (corner[axis], corner[one], corner[other]) =
                        (side * inner[axis], end_one * inner[one], end_other * inner[other]);
                    (normal[axis], normal[one], normal[other]) = (side, slope_one, slope_other);
                    let normal = normal.normalize();
                    piece.push_point(&(corner + normal * rounding_m).into(), &normal);
                }
            }
            let count = 2 * (STEPS + 1);
            for row in 0..count - 1 {
                for column in 0..count - 1 {
                    let a = first + row * count + column;
                    let [b, c, d] = [a + count, a + count + 1, a + 1];
                    piece.triangles.extend(if side > 0.0 {
                        [[a, b, c], [a, c, d]]
                    } else {
                        [[a, c, b], [a, d, c]]
                    });
                }
            }
        }
    }
    piece
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use cranny_shape::TriangleSoup;

    /// Returns the volume after checking that the normals agree with the triangles.
    fn volume_m3(piece: &MeshPiece) -> f64 {
        let at = |corner: u32| Point::from(piece.positions[corner as usize].map(f64::from));
        for &[a, b, c] in &piece.triangles {
            let face = (at(b) - at(a)).cross(&(at(c) - at(a)));
            let normal = Vector::from(piece.normals[a as usize].map(f64::from));
            assert!(face.dot(&normal) > -1e-12);
        }
        let corners = piece.triangles.iter().flatten().map(|&corner| at(corner));
        TriangleSoup::from_corners(corners).unwrap().signed_volume_m3()
    }

    #[test]
    fn rounded_bodies_have_the_volume_of_their_formula() {
        let (h, r) = (Vector::new(0.3, 0.2, 0.1), 0.05);
        let inner = h.add_scalar(-r);
        let faces = 8.0 * r * (inner.x * inner.y + inner.y * inner.z + inner.z * inner.x);
        let edges = PI * r * r * 2.0 * (inner.x + inner.y + inner.z);
        let expected = 8.0 * inner.product() + faces + edges + 4.0 / 3.0 * PI * r * r * r;
        let volume = volume_m3(&cuboid(&h, r, 0));
        assert!((volume / expected - 1.0).abs() < 0.01, "{volume} {expected}");
        let sharp = PI * 0.04 * 0.2;
        let volume = volume_m3(&cylinder(0.1, 0.2, 0.0, 0));
        assert!(volume < sharp && volume > 0.99 * sharp);
        let rounded = volume_m3(&cylinder(0.1, 0.2, 0.03, 0));
        assert!(rounded < volume && rounded > 0.95 * volume);
    }
}
