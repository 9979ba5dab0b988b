use std::f64::consts::TAU;

use cranny_shape::{Loft, ShapeError};
use cranny_spatial::{Point, sin_cos};

use super::object_shape::ObjectShape;

/// Published length along the bend, in metres.
const LENGTH_M: f64 = 0.19;

/// Radius, in metres: half the published thickness of 36 mm, plus the amount that the ridges remove across the bend.
const RADIUS_M: f64 = 0.01835;

/// Bend angle from end to end, in radians, as in pictures of the object.
const BEND_RAD: f64 = 1.6;

/// Pairs of position, as a share of the length from the tip, and radius, as a share of the maximum: a blunt tip, and a stem.
const TAPER: [(f64, f64); 8] =
    [(0.0, 0.25), (0.04, 0.5), (0.14, 0.85), (0.35, 1.0), (0.6, 1.0), (0.8, 0.85), (0.91, 0.4), (1.0, 0.3)];

/// Number of soft ridges, and share of the radius that is removed between them.
const RIDGES: f64 = 5.0;
const RIDGE_SHARE: f64 = 0.05;

/// Number of rings along the bend, and of points per ring.
const RINGS: u32 = 49;
const RING_POINTS: u32 = 40;

/// Number of convex parts: each bends by about a tenth of a radian.
const PARTS: usize = 12;

/// Returns the shape, bent in the plane z = 0.
pub fn shape() -> Result<ObjectShape, ShapeError> {
    let bend_radius_m = LENGTH_M / BEND_RAD;
    let ring = |index: u32| {
        let share = f64::from(index) / f64::from(RINGS - 1);
        let (sine, cosine) = sin_cos(BEND_RAD * (share - 0.5));
        let point = |corner: u32| {
            let angle = TAU * f64::from(corner) / f64::from(RING_POINTS);
            let ridge = 1.0 - RIDGE_SHARE * 0.5 * (1.0 - sin_cos(RIDGES * angle).1);
            let radius_m = RADIUS_M * radius_share(share) * ridge;
            let (up, out) = sin_cos(angle);
            let reach_m = bend_radius_m + radius_m * out;
            Point::new(reach_m * cosine, reach_m * sine, radius_m * up)
        };
        // The order is reversed because the row leads towards +y, from where z then x is counterclockwise.
        (0..RING_POINTS).rev().map(point).collect()
    };
    let loft = Loft::new((0..RINGS).map(ring).collect())?;
    let cuts: Vec<usize> = (1..PARTS).map(|part| part * (RINGS as usize - 1) / PARTS).collect();
    Ok(ObjectShape { mesh: loft.mesh()?, parts: loft.convex_pieces(&cuts)?, solid: None })
}

/// Returns the radius as a share of the maximum, smoothly interpolated between the entries of [`TAPER`].
fn radius_share(share: f64) -> f64 {
    let next = TAPER.partition_point(|(at, _)| *at <= share).clamp(1, TAPER.len() - 1);
    let ((from, low), (to, high)) = (TAPER[next - 1], TAPER[next]);
    let t = ((share - from) / (to - from)).clamp(0.0, 1.0);
    low + (high - low) * t * t * (3.0 - 2.0 * t)
}
