use std::sync::Arc;

use cranny_robot::Hold;

/// The body of the world that is the held object.
#[derive(Clone, Debug)]
pub(crate) struct HeldBody {
    /// Index in the world.
    pub body: usize,
    /// Parts of the world that support it.
    pub spared: Arc<[Spared]>,
    pub hold: Hold,
}

/// A part of the world that the held object may touch with a face; the two are not checked against each other.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Spared {
    /// Index among all parts of the world.
    pub part: usize,
    /// Depth to which the held object rests in it, in metres.
    pub depth_m: f64,
}
