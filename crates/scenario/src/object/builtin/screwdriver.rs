use std::f64::consts::TAU;

use cranny_shape::{Loft, ShapeError};
use cranny_spatial::{Point, sin_cos};

use super::object_shape::ObjectShape;

/// Published length, in metres.
const LENGTH_M: f64 = 0.215;

/// Half the published diameter of the handle, 31 mm, in metres.
const HANDLE_RADIUS_M: f64 = 0.0155;

/// Length of the handle from its butt, in metres; proportions as in pictures of the object.
const HANDLE_LENGTH_M: f64 = 0.1;

/// Radius of the steel shaft, in metres.
const SHAFT_RADIUS_M: f64 = 0.003;

/// Number of flutes around the handle, and their depth, in metres.
const FLUTES: f64 = 6.0;
const FLUTE_DEPTH_M: f64 = 0.0012;

/// Blade: length of its taper, width and thickness of its tip, in metres.
const BLADE_LENGTH_M: f64 = 0.012;
const BLADE_WIDTH_M: f64 = 0.008;
const BLADE_THICKNESS_M: f64 = 0.001;

/// Number of points per ring: eight for each flute.
const RING_POINTS: u32 = 48;

/// Returns the shape, along x from the butt of the handle to the tip of the blade, which is flat across z.
pub fn shape() -> Result<ObjectShape, ShapeError> {
    // Position along x, radius, depth of the flutes, in metres.
    let neck_m = HANDLE_LENGTH_M - 0.02;
    let handle = [
        (0.0, 0.0105, 0.0),
        (0.002, 0.0135, 0.0),
        (0.006, HANDLE_RADIUS_M, 0.0),
        (0.012, HANDLE_RADIUS_M, FLUTE_DEPTH_M),
        (neck_m - 0.008, HANDLE_RADIUS_M, FLUTE_DEPTH_M),
        (neck_m, 0.0145, 0.0),
        (neck_m + 0.008, 0.0095, 0.0),
        (HANDLE_LENGTH_M - 0.004, 0.009, 0.0),
        (HANDLE_LENGTH_M, 0.0075, 0.0),
    ];
    let mut rings: Vec<Vec<Point>> = handle.iter().map(|&(x, r, depth)| fluted(x, r, depth)).collect();
    let shaft_begin = rings.len();
    // The shaft begins inside the end plane of the handle, which closes like a collar.
    rings.push(fluted(HANDLE_LENGTH_M + 0.0005, SHAFT_RADIUS_M, 0.0));
    let blade_begin = rings.len();
    rings.push(fluted(LENGTH_M - BLADE_LENGTH_M, SHAFT_RADIUS_M, 0.0));
    for step in 1..=BLADE_STEPS {
        let share = f64::from(step) / f64::from(BLADE_STEPS);
        let mix = |from: f64, to: f64| from + (to - from) * share;
        let x = LENGTH_M - BLADE_LENGTH_M * (1.0 - share);
        let half_width = mix(SHAFT_RADIUS_M, 0.5 * BLADE_WIDTH_M);
        rings.push(flat(x, half_width, mix(SHAFT_RADIUS_M, 0.5 * BLADE_THICKNESS_M)));
    }
    let loft = Loft::new(rings)?;
    let cuts = [NECK_RING, COLLAR_RING, shaft_begin, blade_begin];
    Ok(ObjectShape { mesh: loft.mesh()?, parts: loft.convex_pieces(&cuts)?, solid: None })
}

/// Number of rings of the blade's taper.
const BLADE_STEPS: u32 = 4;

/// Rings at which the handle is cut into convex parts: at the start of the taper, and at the start of the neck.
const NECK_RING: usize = 4;
const COLLAR_RING: usize = 6;

fn ring(x: f64, across: impl Fn(f64, f64, f64) -> (f64, f64)) -> Vec<Point> {
    (0..RING_POINTS)
        .map(|index| {
            let angle = TAU * f64::from(index) / f64::from(RING_POINTS);
            let (sine, cosine) = sin_cos(angle);
            let (y, z) = across(angle, sine, cosine);
            Point::new(x, y, z)
        })
        .collect()
}

/// Returns a circle with flutes.
fn fluted(x: f64, radius_m: f64, depth_m: f64) -> Vec<Point> {
    ring(x, |angle, sine, cosine| {
        let radius_m = radius_m - depth_m * 0.5 * (1.0 - sin_cos(FLUTES * angle).1);
        (radius_m * cosine, radius_m * sine)
    })
}

/// Returns a curve between an ellipse and a rectangle, wide along y.
fn flat(x: f64, half_width_m: f64, half_thickness_m: f64) -> Vec<Point> {
    ring(x, |_, sine, cosine| (half_width_m * cosine, half_thickness_m * sine))
}
