use cranny_shape::TriangleSoup;
use cranny_spatial::Pose;

use crate::Piece;

/// Recorded motions of bodies in a simulation, for display.
#[derive(Clone, Debug, Default)]
pub struct Recording {
    /// Instants in seconds from the beginning, ascending.
    pub times_s: Vec<f64>,
    /// Moving bodies.
    pub bodies: Vec<RecordedBody>,
}

/// Body of a [`Recording`].
#[derive(Clone, Debug)]
pub struct RecordedBody {
    /// Name of the body.
    pub name: String,
    /// Convex pieces of the body.
    pub pieces: Vec<Piece>,
    /// Pose in the planning frame at each instant.
    pub world_from_body: Vec<Pose>,
}

impl RecordedBody {
    pub(crate) fn new(name: &str, pieces: &[Piece]) -> Self {
        Self { name: name.to_owned(), pieces: pieces.to_vec(), world_from_body: Vec::new() }
    }

    /// Returns the surfaces of the pieces for display, in the frame of the body.
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
