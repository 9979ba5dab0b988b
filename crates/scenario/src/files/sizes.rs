//! Solids of the sizes that stand in files, which a fault must name as they stand there: whole, not halved.

use cranny_shape::{ShapeError, Solid};
use cranny_spatial::{FARTHEST_M, Vector};

/// A box of these sides, in metres.
pub(crate) fn cuboid(size: [f64; 3]) -> Result<Solid, ShapeError> {
    let half = |side| half_of("each side of a box", side);
    let [x, y, z] = size;
    Solid::cuboid(Vector::new(half(x)?, half(y)?, half(z)?))
}

/// A cylinder, in metres.
pub(crate) fn cylinder(length: f64, radius: f64) -> Result<Solid, ShapeError> {
    Solid::cylinder(half_of("the length of a cylinder", length)?, radius)
}

/// A capsule whose cylindrical part has this length, in metres.
pub(crate) fn capsule(length: f64, radius: f64) -> Result<Solid, ShapeError> {
    Solid::capsule(half_of("the length of a capsule", length)?, radius)
}

fn half_of(what: &'static str, value: f64) -> Result<f64, ShapeError> {
    let fits = value > 0.0 && value <= FARTHEST_M;
    fits.then_some(0.5 * value).ok_or(ShapeError::Size { what, value })
}
