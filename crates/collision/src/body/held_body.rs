use std::sync::Arc;

use cranny_robot::Hold;

/// A body of the world in the hand.
#[derive(Clone, Debug)]
pub(crate) struct HeldBody {
    /// Its index in the world.
    pub body: usize,
    /// Parts of the world that carry it.
    pub spared: Arc<[Spared]>,
    pub hold: Hold,
}

/// A part of the world that what is held may touch by a face, and is not checked against.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Spared {
    /// Its number among all parts.
    pub part: usize,
    /// The depth to which what is held rests in it, in metres.
    pub depth_m: f64,
}
