use crate::PointCloud;

/// Point cloud as read.
#[derive(Clone, Debug, PartialEq)]
pub struct ReadCloud {
    /// Valid points; at least one.
    pub cloud: PointCloud,
    /// Number of points that were dropped because a coordinate is not finite.
    pub dropped: usize,
}
