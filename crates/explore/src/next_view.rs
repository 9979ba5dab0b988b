use cranny_sense::Camera;

/// Kinds of cameras that can be moved to a next view.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CameraKind {
    /// A free-standing camera at any pose, not inside anything known.
    #[default]
    Fixed,
    /// A camera on the hand, at a configuration that a proven motion reaches.
    Hand,
}

/// Camera pose from which blocking cells can be seen.
#[derive(Clone, Debug)]
pub struct NextView {
    /// Camera at this pose.
    pub camera: Camera,
    /// Number of the blocking cells whose centres it would see through cells that are not occupied, if all unseen ones are free.
    pub sees: usize,
    /// Number of the blocking cells that the view is predicted to show to be free: by the map of a view that is predicted from the
    /// points measured before. `None` without earlier views.
    pub frees: Option<usize>,
    /// Number of better poses that were refused: no configuration or proven motion reaches them, or something is there.
    pub refused: usize,
    /// In hand: way points from the start to the configuration of the view (m, rad; one value per joint), proven free in the present
    /// seen space. Empty for a free-standing camera.
    pub motion: Vec<Vec<f64>>,
}
