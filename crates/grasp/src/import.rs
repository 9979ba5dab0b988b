//! Import of grasps of other projects into the gripper frame of this one: y along the closing axis, z along the approach,
//! the origin between the pads.

mod acronym;
mod array;
mod arrays;
pub(crate) mod format;
mod graspnet;
mod hdf5;
mod records;

use std::path::Path;

use crate::import::format::{ClosingAxis, GraspFormat, ImportSettings, Read};
use crate::{Grasp, GraspError, GraspSet};
use cranny_spatial::{Pose, Rotation, Vector};

/// Grasps of another project, in the frame of their object and of our gripper.
#[derive(Clone, Debug, PartialEq)]
pub struct Imported {
    /// Format of the file.
    pub format: GraspFormat,
    /// Grasps that are kept, in the order of the file.
    pub grasps: GraspSet,
    /// Number of grasps in the file.
    pub in_file: usize,
    /// Number of them that are masked or marked invalid.
    pub masked: usize,
    /// Number of them with a score below the minimum, or without one.
    pub below: usize,
    /// Axis along which the fingers close in the file.
    pub closing: ClosingAxis,
    /// Distance from the origin of the file's frame to that of ours along the approach, in metres.
    pub offset_m: f64,
    /// Scale of the object's mesh in the file, if given.
    pub object_scale: Option<f64>,
    /// Meaning of the score, and contents of the file that were not read.
    pub notes: Vec<String>,
}

/// Imports a file of grasps of another project; the format is recognized by its content.
///
/// # Errors
/// [`GraspError::Unreadable`]; [`GraspError::Import`] for an unknown format, a wrong shape, a grasp that is no rigid pose
/// (named by its index, from 0) or has an invalid score or a width above 1 m, for unknown keys, repeated names and
/// trailing data, for a frame that only the caller knows (any but that of the Franka hand), for an object with more
/// scales than one, and for a file in which no grasp is left.
pub fn import_grasps(path: &Path, settings: &ImportSettings) -> Result<Imported, GraspError> {
    let bytes = cranny_file::TABLE
        .bytes(path)
        .map_err(|reason| GraspError::Unreadable { path: path.to_owned(), reason })?;
    imported(&bytes, settings).map_err(|problem| GraspError::Import { path: path.to_owned(), problem })
}

fn imported(bytes: &[u8], settings: &ImportSettings) -> Result<Imported, String> {
    if let Some(offset_m) = settings.offset_m.filter(|offset_m| offset_m.is_nan() || offset_m.abs() > 1.0) {
        return Err(format!("an offset of {offset_m} m is none of a gripper"));
    }
    let read = if bytes.starts_with(b"\x89HDF\r\n\x1a\n") {
        acronym::read(bytes, settings)
    } else if bytes.starts_with(b"PK\x03\x04") {
        arrays::read_npz(bytes, settings)
    } else if bytes.starts_with(b"\x93NUMPY") {
        arrays::read_npy(bytes, settings)
    } else {
        records::read(bytes, settings)
    }?;
    let Read { format, grasps, in_file, masked, below, object_scale, notes, closing, offset_m } = read;
    if let Some(expected) = settings.format.filter(|expected| *expected != format) {
        return Err(format!("it is {}, not {}", <&str>::from(format), <&str>::from(expected)));
    }
    if let Some(scale) = object_scale.filter(|scale| !(scale.is_finite() && *scale > 0.0)) {
        return Err(format!("the scale of its object is {scale}, but must be above 0"));
    }
    let unknown = |what: &str| {
        format!(
            "its gripper frame is one of the user's choice: say {what} (the closing axis, x or y; the offset to the pads)"
        )
    };
    let closing = settings.closing.or(closing).ok_or_else(|| unknown("along which axis it closes"))?;
    let offset_m =
        settings.offset_m.or(offset_m).ok_or_else(|| unknown("how far its origin is behind the pads"))?;
    let theirs_from_ours = frame(closing, offset_m);
    let ours =
        |grasp: Grasp| Grasp { world_from_gripper: grasp.world_from_gripper * theirs_from_ours, ..grasp };
    if settings.object.is_some() && format != GraspFormat::GraspnetGroup {
        let format: &str = format.into();
        return Err(format!("a file of the format {format} has no ids of objects, so none can be chosen"));
    }
    if settings.min_score.is_some() && grasps.iter().all(|grasp| grasp.score.is_none()) {
        return Err("its grasps have no scores, so none has the least score".to_owned());
    }
    let before = grasps.len();
    let is_kept = |grasp: &Grasp| {
        settings.min_score.is_none_or(|least| grasp.score.is_some_and(|score| score >= least))
    };
    let grasps: Vec<Grasp> = grasps.into_iter().filter(is_kept).map(ours).collect();
    let below = below + before - grasps.len();
    if grasps.is_empty() {
        return Err(format!(
            "of its {in_file} grasps {masked} are masked, invalid or of another object and {below} score too low: none is left"
        ));
    }
    let grasps = GraspSet::new(grasps).map_err(|fault| fault.to_string())?;
    Ok(Imported { format, grasps, in_file, masked, below, closing, offset_m, object_scale, notes })
}

/// Pose `theirs_from_ours` of a gripper frame with approach z: the closing axis becomes y.
fn frame(closing: ClosingAxis, offset_m: f64) -> Pose {
    let turn = match closing {
        ClosingAxis::X => -std::f64::consts::FRAC_PI_2,
        ClosingAxis::Y => 0.0,
    };
    let rotation = Rotation::from_scaled_axis(Vector::z() * turn);
    Pose::from_parts(Vector::new(0.0, 0.0, offset_m).into(), rotation)
}
