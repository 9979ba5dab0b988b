use std::path::PathBuf;

use crate::limits::Ranges;

/// What a base is called that is put under a robot.
pub(crate) const BASE_JOINT: &str = "base";

/// What whoever adds a robot says of it; what is left open is chosen.
#[derive(Clone, Debug, Default)]
pub struct SetupOptions {
    /// Its SRDF. Default: the one beside the URDF; else what fits of one in `../srdf`, if there is one.
    pub srdf: Option<PathBuf>,
    /// Folders in which `package://` names, and xacro's `$(find …)`, are looked for.
    pub packages: Vec<PathBuf>,
    /// Arguments of a xacro file, `NAME=VALUE`.
    pub xacro: Vec<String>,
    /// The gripper frame, a link. Default: found with the hand.
    pub tip: Option<String>,
    /// The link that carries the fingers. Default: found.
    pub palm: Option<String>,
    /// How its root moves. Default: as the URDF has it; a hand without an arm flies.
    pub base: Option<Base>,
    /// Whether an arm without a hand gets the built-in gripper. Default: it does.
    pub is_bare: bool,
}

/// How the root of a robot moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Base {
    /// As the URDF has it.
    Own,
    /// Drives on the floor, with a heading.
    Planar,
    /// Flies.
    Floating,
}

impl Base {
    /// How its joints are narrowed.
    pub(crate) fn ranges(self) -> Ranges {
        let range = |part: &str, range| (format!("{BASE_JOINT}/{part}"), range);
        match self {
            Self::Own => Vec::new(),
            Self::Planar => vec![range("x", DRIVE_M), range("y", DRIVE_M)],
            Self::Floating => vec![range("x", DRIVE_M), range("y", DRIVE_M), range("z", FLY_M)],
        }
    }
}

/// A joint's range, in metres: as far as today's scenes ask, and no lower than the floor.
const DRIVE_M: [f64; 2] = [-1.0, 1.0];

const FLY_M: [f64; 2] = [0.0, 1.5];
