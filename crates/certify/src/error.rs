/// Reason why a motion has no certificate.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CertifyError {
    /// A pair comes closer than demanded, or too close for a proof.
    #[error(
        "edge {edge} of the {path} path: {first} and {second} are not proven to be {margin_m} m apart near {at:.6}"
    )]
    NotApart {
        /// Name of the path: `way-points` or `rounded`.
        path: &'static str,
        /// Index of the edge, or of the piece of a rounded path, from 0.
        edge: usize,
        /// Name of a link.
        first: String,
        /// Name of another link, or of a body.
        second: String,
        /// Distance demanded, in metres.
        margin_m: f64,
        /// Parameter in [0, 1] along the edge.
        at: f64,
    },
    /// A bound of a link is not proven to be kept.
    #[error("edge {edge} of the {path} path: the bound {bound} is not proven to be kept near {at:.6}")]
    NotKept {
        /// Name of the path.
        path: &'static str,
        /// Index of the edge or piece.
        edge: usize,
        /// Name of the bound.
        bound: String,
        /// Parameter in [0, 1] along the edge.
        at: f64,
    },
    /// The path does not begin at the start of the problem.
    #[error("the path begins elsewhere: {joint} is {off} (m or rad) from the start")]
    Start {
        /// Name of the joint.
        joint: String,
        /// Distance from the start, in m or rad.
        off: f64,
    },
    /// A value of the path is outside the limits of its joint.
    #[error("{joint} is outside its limits at {value} (m or rad)")]
    Limit {
        /// Name of the joint.
        joint: String,
        /// The value, in m or rad.
        value: f64,
    },
    /// It is not proven that no motion exists.
    #[error(
        "no proof that the base stays away from every goal where the hand is free: it may pass, only the arm or the margin keeps it \
         from passing, or the obstacles are hulls or meshes"
    )]
    NotExcluded,
    /// No grasp is shown to be impossible.
    #[error(
        "no grasp is shown to be impossible: none is beyond reach, and at none does the hand reach into a box, ball, capsule, \
         cylinder or half-space by more than the tolerance of 1 mm and 1°"
    )]
    NoneImpossible,
    /// The path ends at no grasp.
    #[error("the path ends at none of the grasps, to 1 mm and 1°")]
    Goal,
    /// The motion is of a kind that certificates do not cover.
    #[error("a certificate does not cover {what}")]
    NotCovered {
        /// Kind of motion or rule.
        what: String,
    },
    /// A body is never shown to be outside another one that is not convex.
    #[error(
        "{first} and {second}: no plane shows at any instant that one is outside the other, which is not convex"
    )]
    NotOutside {
        /// Name of a link.
        first: String,
        /// Name of another link, or of a body.
        second: String,
    },
}
