//! Lines as solids: thin tubes with round joints, which cast shadows and are visible from all sides.

use std::f64::consts::TAU;

use cranny_spatial::{Point, Vector, sin_cos};

use crate::MeshPiece;

/// Number of corners of the cross-section of a tube.
const SIDES: u32 = 8;

/// Returns a tube of `radius_m` along a polyline; empty for fewer than two distinct points.
pub(crate) fn tube(points: &[Point], radius_m: f64, material: usize) -> MeshPiece {
    let mut piece = MeshPiece { material, ..MeshPiece::default() };
    let mut row: Vec<Point> = points.to_vec();
    row.dedup_by(|next, here| (*next - *here).norm() < 0.1 * radius_m);
    if row.len() < 2 {
        return piece;
    }
    let directions: Vec<Vector> = row.windows(2).map(|pair| (pair[1] - pair[0]).normalize()).collect();
    let mut across = perpendicular(&directions[0]);
    for (index, point) in row.iter().enumerate() {
        let before = directions[index.saturating_sub(1)];
        let after = directions[index.min(directions.len() - 1)];
        let along = (before + after).try_normalize(1e-6).unwrap_or(after);
        // The direction is transported along the line, so that the tube does not twist.
        across = (across - along * across.dot(&along)).try_normalize(1e-6).unwrap_or(perpendicular(&along));
        let side = along.cross(&across);
        for corner in 0..SIDES {
            let (sine, cosine) = sin_cos(TAU * f64::from(corner) / f64::from(SIDES));
            let normal = across * cosine + side * sine;
            piece.push_point(&(point + normal * radius_m), &normal);
        }
    }
    let rings = u32::try_from(row.len()).unwrap_or(u32::MAX);
    for ring in 0..rings - 1 {
        for corner in 0..SIDES {
            let next = (corner + 1) % SIDES;
            let [a, b] = [ring * SIDES + corner, ring * SIDES + next];
            let [d, c] = [a + SIDES, b + SIDES];
            piece.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    for (point, ring, outward) in
        [(row[0], 0, -directions[0]), (row[row.len() - 1], rings - 1, directions[directions.len() - 1])]
    {
        let tip = piece.push_point(&(point + outward * (0.6 * radius_m)), &outward);
        let is_first = ring == 0;
        piece.triangles.extend((0..SIDES).map(|corner| {
            let (here, next) = (ring * SIDES + corner, ring * SIDES + (corner + 1) % SIDES);
            if is_first { [tip, next, here] } else { [tip, here, next] }
        }));
    }
    piece
}

fn perpendicular(direction: &Vector) -> Vector {
    let least = direction.iamin();
    let mut axis = Vector::zeros();
    axis[least] = 1.0;
    direction.cross(&axis).normalize()
}

/// Returns the symbol of a grasp in the gripper frame: two fingers that reach to the origin, the bar that joins them and a
/// stem. `scale` = 1 is the real opening of `opening_m`.
pub(crate) fn small_gripper(opening_m: f64, radius_m: f64, material: usize) -> MeshPiece {
    /// Reach of the fingers ahead of the origin of the gripper frame, and distance back to the bar, in metres.
    const AHEAD_M: f64 = 0.008;
    const BACK_M: f64 = 0.038;
    const STEM_M: f64 = 0.03;
    let half = 0.5 * opening_m;
    let at = |y: f64, z: f64| Point::new(0.0, y, z);
    let mut piece = tube(
        &[at(-half, AHEAD_M), at(-half, -BACK_M), at(half, -BACK_M), at(half, AHEAD_M)],
        radius_m,
        material,
    );
    piece.append(&tube(&[at(0.0, -BACK_M), at(0.0, -BACK_M - STEM_M)], radius_m, material));
    piece
}

#[cfg(test)]
mod tests {
    use super::*;
    use cranny_shape::{Solid, TriangleSoup};

    #[test]
    fn a_tube_is_closed_and_faces_outwards() {
        let points = [Point::origin(), Point::new(0.1, 0.0, 0.0), Point::new(0.1, 0.2, 0.1)];
        let piece = tube(&points, 0.01, 0);
        let corner = |index: &u32| Point::from(piece.positions[*index as usize].map(f64::from));
        let soup = TriangleSoup::from_corners(piece.triangles.iter().flatten().map(corner)).unwrap();
        Solid::mesh(&soup).expect("closed");
        assert!(soup.signed_volume_m3() > 0.0);
        assert!(tube(&points[..1], 0.01, 0).triangles.is_empty());
        assert!(tube(&[points[0], points[0]], 0.01, 0).triangles.is_empty());
    }
}
