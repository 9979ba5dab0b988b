use std::collections::BTreeMap;
use std::path::PathBuf;

use crate::HandDescription;
use crate::description::text_source::TextSource;

/// Options for building a robot from a URDF.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RobotOptions {
    /// Groups, states and disabled pairs. Default: the file with the URDF's stem and the ending `.srdf`
    /// beside it, if there is one.
    pub srdf: Option<TextSource>,
    /// Limits in `MoveIt`'s `joint_limits.yaml`, which replace those of the URDF and the rates of `limits.yaml`. Default: none.
    pub joint_limits: Option<TextSource>,
    /// Scaling factors of the velocity and acceleration limits, from 0 to 1. Default: `default_velocity_scaling_factor` and
    /// `default_acceleration_scaling_factor` of `joint_limits`, else 1.
    pub rate_scales: RateScales,
    /// Acceleration and jerk limits. Default: `limits.yaml` beside the URDF, if there is one.
    pub limits: Option<TextSource>,
    /// Joints of the configuration `q`.
    pub group: JointGroup,
    /// Link for which grasp poses are planned. Default: the tip of the first chain of the chosen SRDF group; else the tip of
    /// the chain of the SRDF's first end effector, or the link that it is mounted on; else the leaf link below the most
    /// movable joints (joints in `fixed` and mimic joints do not count, and if a group is given only its joints do). Ties
    /// are broken in favour of a leaf without geometry (a frame added for this purpose), then of the last in the file.
    pub tip: Option<String>,
    /// Values at which joints outside the group are fixed, in metres or radians. Default: 0, or the limit nearest to 0.
    pub fixed: BTreeMap<String, f64>,
    /// Description of the robot beyond its URDF ([`RobotDescription`](crate::RobotDescription)): group, tip and fixed joints
    /// unless given here, start configuration, and hand, whose fingers stay open unless they are in `fixed` or belong to the
    /// group. Default: `robot.yaml` beside the URDF, if there is one.
    pub description: Option<TextSource>,
    /// Additional hands that the robot may have; those whose links or joints it lacks are ignored.
    pub known_hands: Vec<HandDescription>,
    /// Folders searched for `package://` names, before the folders above the URDF.
    pub packages: Vec<PathBuf>,
    /// Solid that a mesh represents.
    pub meshes: MeshUse,
    /// Links whose meshes represent the solid they enclose, regardless of `meshes`.
    pub solid_meshes: Vec<String>,
    /// Pairs of links, by name, that may touch: exempt from tests like those disabled in the SRDF.
    pub unchecked_pairs: Vec<[String; 2]>,
    /// Pairs of links, by name, that are tested even if the SRDF disables them or they are adjacent.
    pub checked_pairs: Vec<[String; 2]>,
}

/// Scaling factors of the velocity and acceleration limits, each from 0 to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RateScales {
    /// Scaling factor of the velocity limits.
    pub velocity: Option<f64>,
    /// Scaling factor of the acceleration limits.
    pub acceleration: Option<f64>,
}

/// Choice of the joints of `q`, in order.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum JointGroup {
    /// All movable joints from the root to the tip, without those in [`fixed`](RobotOptions::fixed) and without mimic joints,
    /// the root's first.
    #[default]
    RootToTip,
    /// Joints given by name, in this order.
    Joints(Vec<String>),
    /// Movable joints of a group of the SRDF that mimic no other, the root's first.
    Srdf(String),
}

/// Solid that a mesh of a URDF represents.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MeshUse {
    /// Convex hull of the mesh: most link meshes are nearly convex, and distances to hulls are fast.
    #[default]
    Hull,
    /// Solid enclosed by the triangles.
    Solid,
}
