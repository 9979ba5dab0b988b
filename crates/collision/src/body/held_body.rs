use std::sync::Arc;

use cranny_robot::Hold;

/// A body of the world that the hand holds.
#[derive(Clone, Debug)]
pub(crate) struct HeldBody {
    /// Its index in the world.
    pub body: usize,
    /// Parts of the world that support it.
    pub spared: Arc<[Spared]>,
    pub hold: Hold,
}

/// A part of the world that the held body may touch with a face, and is not checked against.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Spared {
    /// Its number among all parts.
    pub part: usize,
    /// Depth to which the held body rests in it, in metres.
    pub depth_m: f64,
}
