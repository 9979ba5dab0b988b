//! Files of grasps of other projects, read into the gripper frame of this one: y along the closing axis, z along the approach,
//! the origin between the pads.

mod acronym;
mod arrays;
mod graspnet;
mod records;

use std::path::Path;

use cranny_spatial::{Pose, Rotation, Vector};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use strum::{EnumString, IntoStaticStr, VariantNames};

use crate::{Grasp, GraspError, GraspSet};

/// Formats of grasps of other projects.
#[derive(
    Clone,
    Copy,
    Debug,
    PartialEq,
    Eq,
    Serialize,
    Deserialize,
    JsonSchema,
    EnumString,
    IntoStaticStr,
    VariantNames,
)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "kebab-case")]
pub enum GraspFormat {
    /// HDF5 of ACRONYM (Eppner, Mousavian & Fox 2021): `grasps/transforms`, z approach, x closing, origin at the base of the
    /// Franka hand.
    Acronym,
    /// Object labels of GraspNet-1Billion (Fang et al. 2020): an `.npz` with `points`, `offsets`, `scores`.
    GraspnetLabels,
    /// `GraspGroup` of its API: an `.npy` of shape (N, 17), x approach, y closing.
    GraspnetGroup,
    /// JSON of `GraspGen`: `grasps.transforms`, z approach, x closing, origin at the base of the hand.
    Graspgen,
    /// YAML of Isaac Sim, `isaac_grasp` 1.0: a frame of the user's choice.
    Isaac,
    /// Poses alone: an `.npy` of shape (N, 4, 4), or an `.npz` with such an array and, if wanted, `scores`, `widths` and
    /// `mask`; z approach.
    Poses,
}

/// The axis of a gripper frame along which its fingers close; its z is the approach.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, EnumString, IntoStaticStr)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "kebab-case")]
pub enum ClosingAxis {
    /// As in ACRONYM and `GraspGen`.
    X,
    /// As in this project and in the Franka URDF.
    Y,
}

/// Choices of an import. The default leaves all to the file and its format.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ImportSettings {
    /// The format; `None`: by the content.
    pub format: Option<GraspFormat>,
    /// The closing axis; `None`: that of the format. Isaac's has none.
    pub closing: Option<ClosingAxis>,
    /// From the origin of the file's frame to that of ours, along the approach, in metres; `None`: that of the format for the
    /// Franka hand ([`FRANKA_PADS_M`]). Isaac's has none. For `GraspNet`, whose grasps know the depth of the fingertips, it is
    /// measured from these.
    pub offset_m: Option<f64>,
    /// Least score of the grasps that are kept; those without a score are not.
    pub min_score: Option<f64>,
    /// The object whose grasps a `GraspGroup` is read for; `None`: it must hold those of one object.
    pub object: Option<i64>,
}

/// From the base of the Franka hand to the gripper frame of the built-in robots with that hand, in metres: between the pads
/// (`panda_grasptarget`; the TCP of libfranka is 1.6 mm behind it).
pub const FRANKA_PADS_M: f64 = 0.105;

/// From the tips of the Franka fingers to that frame, in metres, negative as it is behind them: the tips are 0.1122 m from the base
/// (`acronym_tools`, `create_gripper_marker`).
pub const FRANKA_TIPS_TO_PADS_M: f64 = FRANKA_PADS_M - 0.1122;

/// No file holds more grasps that are kept: a gigabyte of memory and of text.
pub(crate) const MOST_GRASPS: usize = 2_000_000;

/// Grasps of another project, in the frame of their object and of our gripper.
#[derive(Clone, Debug, PartialEq)]
pub struct Imported {
    /// The format that was read.
    pub format: GraspFormat,
    /// The grasps that are kept, in the order of the file.
    pub grasps: GraspSet,
    /// How many grasps the file holds.
    pub in_file: usize,
    /// How many of them are masked or marked invalid.
    pub masked: usize,
    /// How many have a score below the least, or none.
    pub below: usize,
    /// The axis along which fingers close in the file.
    pub closing: ClosingAxis,
    /// From the origin of the file's frame to that of ours along the approach, in metres.
    pub offset_m: f64,
    /// By how much the file scales the mesh of its object.
    pub object_scale: Option<f64>,
    /// What the score is, and what else the file holds that was not read.
    pub notes: Vec<String>,
}

/// Grasps as their file has them: `object_from_theirs`, with approach z, before [`ImportSettings`] apply.
pub(crate) struct Read {
    pub format: GraspFormat,
    pub grasps: Vec<Grasp>,
    pub in_file: usize,
    pub masked: usize,
    /// Grasps left out while reading because of the least score, where there may be too many to keep.
    pub below: usize,
    pub object_scale: Option<f64>,
    pub notes: Vec<String>,
    /// What holds unless somebody says otherwise.
    pub closing: Option<ClosingAxis>,
    pub offset_m: Option<f64>,
}

impl Read {
    pub fn new(format: GraspFormat) -> Self {
        let (closing, offset_m) = match format {
            GraspFormat::Acronym | GraspFormat::Graspgen => (Some(ClosingAxis::X), Some(FRANKA_PADS_M)),
            // Turned to z when they are read.
            GraspFormat::GraspnetLabels | GraspFormat::GraspnetGroup => {
                (Some(ClosingAxis::Y), Some(FRANKA_TIPS_TO_PADS_M))
            }
            GraspFormat::Isaac => (None, None),
            GraspFormat::Poses => (Some(ClosingAxis::Y), Some(0.0)),
        };
        let notes = Vec::new();
        Self {
            format,
            grasps: Vec::new(),
            in_file: 0,
            masked: 0,
            below: 0,
            object_scale: None,
            notes,
            closing,
            offset_m,
        }
    }

    /// Adds a grasp, which errors call by its place.
    pub fn push(&mut self, place: usize, grasp: Grasp) -> Result<(), String> {
        if self.grasps.len() >= MOST_GRASPS {
            return Err(format!("it holds more than {MOST_GRASPS} grasps; keep the best with a least score"));
        }
        self.grasps.push(grasp.checked(place).map_err(|fault| fault.to_string())?);
        Ok(())
    }
}

/// Reads a file of grasps of another project; the format is told by the content.
///
/// # Errors
/// [`GraspError::Unreadable`]; [`GraspError::Import`] for a file of no such format, of a wrong shape, with a grasp that is no
/// rigid pose (named by its place, from 0) or has no such score, for a frame that only the caller knows, and for one in which
/// no grasp is left.
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
        acronym::read(bytes)
    } else if bytes.starts_with(b"PK\x03\x04") {
        arrays::read_npz(bytes, settings)
    } else if bytes.starts_with(b"\x93NUMPY") {
        arrays::read_npy(bytes, settings)
    } else {
        records::read(bytes)
    }?;
    let Read { format, grasps, in_file, masked, below, object_scale, notes, closing, offset_m } = read;
    if let Some(expected) = settings.format.filter(|expected| *expected != format) {
        return Err(format!("it is {}, not {}", <&str>::from(format), <&str>::from(expected)));
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
    let before = grasps.len();
    let is_kept = |grasp: &Grasp| {
        settings.min_score.is_none_or(|least| grasp.score.is_some_and(|score| score >= least))
    };
    let grasps: Vec<Grasp> = grasps.into_iter().filter(is_kept).map(ours).collect();
    let below = below + before - grasps.len();
    if grasps.is_empty() {
        return Err(format!(
            "of its {in_file} grasps {masked} are masked or invalid and {below} score too low: none is left"
        ));
    }
    let grasps = GraspSet::new(grasps).map_err(|fault| fault.to_string())?;
    Ok(Imported { format, grasps, in_file, masked, below, closing, offset_m, object_scale, notes })
}

/// `theirs_from_ours` of a gripper frame with approach z: the closing axis becomes y.
fn frame(closing: ClosingAxis, offset_m: f64) -> Pose {
    let turn = match closing {
        ClosingAxis::X => -std::f64::consts::FRAC_PI_2,
        ClosingAxis::Y => 0.0,
    };
    let rotation = Rotation::from_scaled_axis(Vector::z() * turn);
    Pose::from_parts(Vector::new(0.0, 0.0, offset_m).into(), rotation)
}
