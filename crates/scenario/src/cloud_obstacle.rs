use std::path::Path;

use cranny_sense::PointCloud;
use cranny_shape::{BoxUnion, Solid};
use serde::Serialize;

use crate::ScenarioError;

/// Numbers of points of a cloud that a file of a scenario names.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct CloudCounts {
    /// Name of the body.
    pub body: String,
    /// Name of the file.
    pub file: String,
    /// Points in the file.
    pub points: usize,
    /// Points that were dropped because a coordinate is not finite.
    pub not_finite: usize,
    /// Points that were dropped because another one is in the same voxel; the balls around the others cover them.
    pub thinned: usize,
    /// Points that are left, each a ball.
    pub kept: usize,
}

/// Returns the balls of a radius (m) around the points of a file, and their numbers for the body of this name. If voxels of a side (m)
/// leave points out, the balls around the others are larger by the diagonal of a voxel, and cover them.
pub(crate) fn cloud_obstacle(
    path: &Path,
    radius_m: f64,
    voxel_m: Option<f64>,
    body: &str,
) -> Result<(Solid, CloudCounts), ScenarioError> {
    let read = PointCloud::read(path)?;
    let (cloud, radius_m) = match voxel_m {
        Some(side_m) => (&read.cloud.thinned(side_m)?, radius_m + 3_f64.sqrt() * side_m),
        None => (&read.cloud, radius_m),
    };
    let union = BoxUnion::of_points(&cloud.points, radius_m).map_err(|fault| fault.in_file(path))?;
    let (valid, kept) = (read.cloud.points.len(), cloud.points.len());
    let counts = CloudCounts {
        body: body.to_owned(),
        file: path.file_name().unwrap_or_default().to_string_lossy().into_owned(),
        points: valid + read.dropped,
        not_finite: read.dropped,
        thinned: valid - kept,
        kept,
    };
    Ok((Solid::union(union), counts))
}
