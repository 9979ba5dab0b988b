use cranny_file::excerpt;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use strum::{EnumString, IntoStaticStr, VariantNames};

use crate::Grasp;

/// Grasp formats of other projects.
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
    /// HDF5 of ACRONYM (Eppner, Mousavian & Fox 2021, whole; layout of its repository): `grasps/transforms`, z
    /// approach, x closing, origin at the base of the Franka hand.
    Acronym,
    /// Object labels of GraspNet-1Billion (Fang et al. 2020, whole; layout of its API): an `.npz` with `points`,
    /// `offsets`, `scores`.
    GraspnetLabels,
    /// `GraspGroup` of its API: an `.npy` of shape (N, 17), x approach, y closing.
    GraspnetGroup,
    /// JSON of `GraspGen`: `grasps.transforms`, z approach, x closing, origin at the base of the hand.
    Graspgen,
    /// YAML of Isaac Sim, `isaac_grasp` 1.0: a frame of the user's choice.
    Isaac,
    /// Poses alone: an `.npy` of shape (N, 4, 4), or an `.npz` with such an array and, optionally, `scores`, `widths` and
    /// `mask`; z approach.
    Poses,
}

/// Axis of a gripper frame along which its fingers close; its z is the approach.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, EnumString, IntoStaticStr)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "kebab-case")]
pub enum ClosingAxis {
    /// The x axis, as in ACRONYM and `GraspGen`.
    X,
    /// The y axis, as in this project and in the Franka URDF.
    Y,
}

/// Settings of an import. By default the file and its format decide.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ImportSettings {
    /// Format; `None`: detected from the content.
    pub format: Option<GraspFormat>,
    /// Closing axis; `None`: that of the format. The format of Isaac has none. A file that names another gripper than the
    /// Franka hand needs both this and the offset.
    pub closing: Option<ClosingAxis>,
    /// Distance from the origin of the file's frame to that of ours, along the approach, in metres; `None`: that of the
    /// format for the Franka hand ([`FRANKA_PADS_M`]). The format of Isaac has none. For `GraspNet`, whose grasps know
    /// the depth of the fingertips, it is measured from these.
    pub offset_m: Option<f64>,
    /// Minimum score of the grasps that are kept; unscored ones are dropped.
    pub min_score: Option<f64>,
    /// Object whose grasps are read from a `GraspGroup`; `None`: the file must contain those of one object only.
    pub object: Option<i64>,
}

/// Distance from the base of the Franka hand to the gripper frame of the built-in robots with that hand, in metres:
/// between the pads (`panda_grasptarget`; the TCP of libfranka is 1.6 mm behind it).
pub const FRANKA_PADS_M: f64 = 0.105;

/// Distance from the tips of the Franka fingers to that frame, in metres; negative, because it is behind them. The tips
/// are 0.1122 m from the base (`acronym_tools`, `create_gripper_marker`).
pub const FRANKA_TIPS_TO_PADS_M: f64 = FRANKA_PADS_M - 0.1122;

/// Names of the Franka hand in files, in lower case.
const FRANKA_NAMES: [&str; 6] =
    ["panda", "franka", "panda_hand", "franka_hand", "franka_panda", "franka_emika_panda"];

/// Maximum width of an imported grasp, in metres: ten times that of usual hands, and less than any sensible width in
/// centimetres or millimetres.
const MOST_WIDTH_M: f64 = 1.0;

/// Maximum number of grasps that are kept: a gigabyte of memory and of text.
pub(crate) const MOST_GRASPS: usize = 2_000_000;

/// Grasps as in their file: `object_from_theirs`, with approach z, before [`ImportSettings`] apply.
pub(crate) struct Read {
    pub format: GraspFormat,
    pub grasps: Vec<Grasp>,
    pub in_file: usize,
    pub masked: usize,
    /// Number of grasps dropped while reading for their score, if there may be too many to keep.
    pub below: usize,
    pub object_scale: Option<f64>,
    pub notes: Vec<String>,
    /// Closing axis of the format, unless the settings give another.
    pub closing: Option<ClosingAxis>,
    pub offset_m: Option<f64>,
}

impl Read {
    pub fn new(format: GraspFormat) -> Self {
        let (closing, offset_m) = match format {
            GraspFormat::Acronym | GraspFormat::Graspgen => (Some(ClosingAxis::X), Some(FRANKA_PADS_M)),
            // Their poses are rotated to z when they are read.
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

    /// Checks the gripper name of a file at `key`. The frame of the format is that of the Franka hand; for another hand
    /// the settings must give it.
    pub fn of_gripper(&mut self, key: &str, name: &str, settings: &ImportSettings) -> Result<(), String> {
        if FRANKA_NAMES.contains(&name.to_lowercase().as_str()) {
            return Ok(());
        }
        let name = excerpt(name);
        if settings.closing.is_none() || settings.offset_m.is_none() {
            return Err(format!(
                "{key} is '{name}', but the frame that is known is that of the Franka hand ('panda'): say both along \
                 which axis it closes, x or y, and how far its origin is behind the pads (the offset)"
            ));
        }
        self.notes.push(format!("{key} is '{name}': closing axis and offset are those that were given"));
        Ok(())
    }

    /// Notes contents of a file that are not used.
    pub fn note_unread(&mut self, names: &[impl AsRef<str>]) {
        /// Maximum number of names listed; the rest is counted.
        const NAMED: usize = 20;
        let named: Vec<String> = names.iter().take(NAMED).map(|name| excerpt(name.as_ref())).collect();
        let more = names.len() - named.len();
        let more = if more > 0 { format!(" and {more} more") } else { String::new() };
        if !named.is_empty() {
            self.notes.push(format!("not read: {}{more}", named.join(", ")));
        }
    }

    /// Adds a grasp; errors refer to it by its index `place`.
    pub fn push(&mut self, place: usize, grasp: Grasp) -> Result<(), String> {
        if let Some(width_m) = grasp.width_m.filter(|width_m| *width_m > MOST_WIDTH_M) {
            return Err(format!(
                "the width of grasp {place} is {width_m} m, more than any of these hands opens; widths are in metres: \
                 are these centimetres or millimetres?"
            ));
        }
        if self.grasps.len() >= MOST_GRASPS {
            return Err(format!("it holds more than {MOST_GRASPS} grasps; keep the best with a least score"));
        }
        self.grasps.push(grasp.checked(place).map_err(|fault| fault.to_string())?);
        Ok(())
    }
}
