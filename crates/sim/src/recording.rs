use cranny_shape::TriangleSoup;
use cranny_spatial::Pose;

use crate::Piece;

/// What moved where in a simulation: trajectories of bodies, to be looked at.
#[derive(Clone, Debug, Default)]
pub struct Recording {
    /// When, in seconds from the beginning; ascending.
    pub times_s: Vec<f64>,
    /// All that moves.
    pub bodies: Vec<RecordedBody>,
}

/// A body of a [`Recording`].
#[derive(Clone, Debug)]
pub struct RecordedBody {
    /// What it is called.
    pub name: String,
    /// What it is made of.
    pub pieces: Vec<Piece>,
    /// Its pose in the planning frame at each of the times.
    pub world_from_body: Vec<Pose>,
}

impl RecordedBody {
    pub(crate) fn new(name: &str, pieces: &[Piece]) -> Self {
        Self { name: name.to_owned(), pieces: pieces.to_vec(), world_from_body: Vec::new() }
    }

    /// The surfaces of its pieces, in its frame, to be looked at.
    pub fn surface(&self) -> TriangleSoup {
        let mut surface = TriangleSoup::default();
        for piece in &self.pieces {
            if let Some(soup) = piece.shape.surface() {
                surface.append(&soup, &piece.body_from_piece);
            }
        }
        surface
    }
}
