use std::collections::BTreeMap;
use std::path::PathBuf;

use crate::HandDescription;
use crate::description::text_source::TextSource;

/// What a URDF leaves open when a robot is built from it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RobotOptions {
    /// Groups, states and disabled pairs. Default: the file with the URDF's stem and the ending `.srdf`
    /// beside it, if there is one.
    pub srdf: Option<TextSource>,
    /// `MoveIt`'s `joint_limits.yaml`: what it gives replaces what the URDF gives. Default: none.
    pub joint_limits: Option<TextSource>,
    /// Shares of the velocity and acceleration limits that are used, from 0 to 1. Default: those that `joint_limits`
    /// has as `default_velocity_scaling_factor` and `default_acceleration_scaling_factor`, else 1.
    pub rate_scales: RateScales,
    /// Acceleration and jerk limits. Default: `limits.yaml` beside the URDF, if there is one.
    pub limits: Option<TextSource>,
    /// The joints that `q` stands for.
    pub group: JointGroup,
    /// The link that grasps are reached with. Default: the tip of the first chain of the chosen SRDF group;
    /// else the tip of the chain of the SRDF's first end effector, or the link that it is mounted on; else
    /// the leaf link below the most joints that can be moved (joints of `fixed` and mimic joints do not
    /// count, and if a group is given only its joints do), among equals one without geometry (a frame put
    /// there for this purpose), among these the last of the file.
    pub tip: Option<String>,
    /// Values at which joints outside the group are held, in metres or radians. Default of a joint: 0, or
    /// the limit next to it.
    pub fixed: BTreeMap<String, f64>,
    /// What its URDF does not say ([`RobotDescription`](crate::RobotDescription)): group, tip and fixed joints unless they
    /// are given here, where it starts, and its hand: where the fingers stand open, unless `fixed` says otherwise or they
    /// belong to the group. Default: `robot.yaml` beside the URDF, if there is one.
    pub description: Option<TextSource>,
    /// Hands that the robot may have besides: of these, what it lacks is left out.
    pub known_hands: Vec<HandDescription>,
    /// Folders in which `package://` names are looked for, before the folders above the URDF.
    pub packages: Vec<PathBuf>,
    /// What solid a mesh stands for.
    pub meshes: MeshUse,
    /// Links whose meshes stand for what they enclose, whatever `meshes` says.
    pub solid_meshes: Vec<String>,
    /// Pairs of links, by name, that may touch: exempt as those are that the SRDF disables.
    pub unchecked_pairs: Vec<[String; 2]>,
    /// Pairs of links, by name, that are checked whatever the SRDF has to them, and although they are adjacent.
    pub checked_pairs: Vec<[String; 2]>,
}

/// Shares of the velocity and acceleration limits that are used, each from 0 to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RateScales {
    /// Share of the velocity limits.
    pub velocity: Option<f64>,
    /// Share of the acceleration limits.
    pub acceleration: Option<f64>,
}

/// The joints that `q` stands for, in order.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum JointGroup {
    /// All joints from the root to the tip that can move, without those of
    /// [`fixed`](RobotOptions::fixed) and without mimic joints, the root's first.
    #[default]
    RootToTip,
    /// These joints, in this order.
    Joints(Vec<String>),
    /// The joints of a group of the SRDF that can move and mimic no other, the root's first.
    Srdf(String),
}

/// What solid a mesh of a URDF stands for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MeshUse {
    /// Its convex hull: link meshes are mostly convex, and distances to hulls are fast.
    #[default]
    Hull,
    /// The solid that its triangles enclose.
    Solid,
}
