use std::sync::Arc;

use cranny_robot::Hold;

/// A body of the world in the hand.
#[derive(Clone, Debug)]
pub(crate) struct HeldBody {
    /// Its index in the world.
    pub body: usize,
    /// Parts of the world that it is not checked against.
    pub spared: Arc<[usize]>,
    pub hold: Hold,
}
