//! Limits of the numbers of a recipe.

/// Greatest number of rows: beyond it, indices of rows would no longer fit every reader.
pub(crate) const MOST_ROWS: u64 = 1 << 40;
/// Greatest number of queries of a scene, and of clutter objects.
pub(crate) const MOST_QUERIES: u64 = 10_000;
pub(crate) const MOST_CLUTTER: u64 = 50;
/// Greatest rate of trajectories, in Hz.
pub(crate) const MOST_RATE_HZ: f64 = 1000.0;
/// Greatest clearance that a recipe may require, in metres: more than the width of any passage.
pub(crate) const MOST_MARGIN_M: f64 = 1.0;
/// Greatest limits of iterations and changes of one query.
pub(crate) const MOST_ITERATIONS: u64 = 10_000_000;
pub(crate) const MOST_CHANGES: u64 = 100_000;
/// Greatest number of default cameras.
pub(crate) const MOST_CAMERAS: u64 = 8;
