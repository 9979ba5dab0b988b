use cranny_shape::TriangleSoup;
use cranny_spatial::Pose;

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
    /// Surface for display, in the frame of the body.
    pub surface: TriangleSoup,
    /// Pose in the planning frame at each instant.
    pub world_from_body: Vec<Pose>,
}

impl RecordedBody {
    pub(crate) fn new(name: &str, surface: TriangleSoup) -> Self {
        Self { name: name.to_owned(), surface, world_from_body: Vec::new() }
    }
}
