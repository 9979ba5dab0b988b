use std::path::PathBuf;

use crate::limits::Ranges;

/// Name of the joint of a base that is added under a robot.
pub(crate) const BASE_JOINT: &str = "base";

/// Options for the setup of a robot; those not given are chosen automatically.
#[derive(Clone, Debug, Default)]
pub struct SetupOptions {
    /// Path of its SRDF. Default: the one beside the URDF; else the applicable content of one in `../srdf`, if there is one.
    pub srdf: Option<PathBuf>,
    /// Folders searched for packages in `package://` names and xacro's `$(find …)`.
    pub packages: Vec<PathBuf>,
    /// Arguments of a xacro file, `NAME=VALUE`.
    pub xacro: Vec<String>,
    /// Link with the gripper frame. Default: found with the hand.
    pub tip: Option<String>,
    /// Link that carries the fingers. Default: found by structure.
    pub palm: Option<String>,
    /// Link that is a tool, such as a suction cup or the palm of a hand with more than two fingers: a body with a gripper frame,
    /// whose grasps come from files. Default: a hand whose pads close along an axis is searched for.
    pub tool: Option<String>,
    /// Motion of its root. Default: that of the URDF; a hand without an arm floats.
    pub base: Option<Base>,
    /// True if an arm without a hand gets no gripper. Default: it gets the built-in one.
    pub is_bare: bool,
}

/// Motion of the root of a robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Base {
    /// As in the URDF.
    Own,
    /// Drives on the floor, with a heading.
    Planar,
    /// Moves in all six degrees of freedom.
    Floating,
}

impl Base {
    /// Returns the narrowed ranges of its joints.
    pub(crate) fn ranges(self) -> Ranges {
        let range = |part: &str, range| (format!("{BASE_JOINT}/{part}"), range);
        match self {
            Self::Own => Vec::new(),
            Self::Planar => vec![range("x", DRIVE_M), range("y", DRIVE_M)],
            Self::Floating => vec![range("x", DRIVE_M), range("y", DRIVE_M), range("z", FLY_M)],
        }
    }
}

/// Range of a joint of the base, in metres: as far as typical scenes require, and not below the floor.
const DRIVE_M: [f64; 2] = [-1.0, 1.0];

const FLY_M: [f64; 2] = [0.0, 1.5];
