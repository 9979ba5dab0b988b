//! Solids of the sizes in files; an error must report a size as it is in the file, not halved.

use cranny_shape::{ShapeError, Solid};
use cranny_spatial::{FARTHEST_M, Vector};

/// Returns a box with these side lengths, in metres.
pub(crate) fn cuboid(size: [f64; 3]) -> Result<Solid, ShapeError> {
    let half = |side| half_of("each side of a box", side);
    let [x, y, z] = size;
    Solid::cuboid(Vector::new(half(x)?, half(y)?, half(z)?))
}

/// Returns a cylinder, in metres.
pub(crate) fn cylinder(length: f64, radius: f64) -> Result<Solid, ShapeError> {
    Solid::cylinder(half_of("the length of a cylinder", length)?, radius)
}

/// Returns a capsule whose cylindrical section has this length, in metres.
pub(crate) fn capsule(length: f64, radius: f64) -> Result<Solid, ShapeError> {
    Solid::capsule(half_of("the length of a capsule", length)?, radius)
}

fn half_of(what: &'static str, value: f64) -> Result<f64, ShapeError> {
    let fits = value > 0.0 && value <= FARTHEST_M;
    fits.then_some(0.5 * value).ok_or(ShapeError::Size { what, value })
}
