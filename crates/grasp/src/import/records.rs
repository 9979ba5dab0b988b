//! Grasps as text: JSON of `GraspGen`, YAML of Isaac Sim.

use std::fmt;

use cranny_file::{TextFault, did_you_mean};
use cranny_spatial::nalgebra::Quaternion;
use cranny_spatial::{Pose, Rotation, Vector};
use serde::Deserialize;
use serde::de::{Deserializer, IgnoredAny, MapAccess, Visitor};

use crate::import::format::{GraspFormat, ImportSettings, Read};
use crate::{Grasp, pose_of_rows};

/// Value of a known key that is not used.
type Unread = Option<IgnoredAny>;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct GraspGen {
    #[serde(default)]
    object: Option<GraspGenObject>,
    #[serde(default)]
    gripper: Option<GraspGenGripper>,
    grasps: GraspGenGrasps,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct GraspGenObject {
    #[serde(default, rename = "file")]
    _file: Unread,
    #[serde(default)]
    scale: Option<f64>,
}

/// Name of the gripper, alone or among other keys, which do not define the frame.
#[derive(Deserialize)]
#[serde(untagged)]
enum GraspGenGripper {
    Name(String),
    Figures {
        #[serde(default)]
        name: Option<String>,
    },
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct GraspGenGrasps {
    transforms: Vec<[[f64; 4]; 4]>,
    #[serde(default)]
    object_in_gripper: Option<Vec<Label>>,
    #[serde(default)]
    score: Unread,
    #[serde(default)]
    suction_points: Unread,
    #[serde(default)]
    approach_vectors: Unread,
    #[serde(default)]
    is_sealed: Unread,
}

/// Label of a grasp: a boolean, or a score from 0 to 1.
#[derive(Deserialize)]
#[serde(untagged)]
enum Label {
    Is(bool),
    Score(f64),
}

/// Keys of Isaac, and those that `GraspDataGen` adds.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct IsaacGrasps {
    format: String,
    format_version: Version,
    #[serde(default, alias = "object_frame_link")]
    object_frame: Option<String>,
    #[serde(default, alias = "gripper_frame_link")]
    gripper_frame: Option<String>,
    grasps: InOrder<IsaacGrasp>,
    #[serde(default)]
    object_scale: Option<f64>,
    #[serde(default)]
    approach_axis: Option<u8>,
    #[serde(default)]
    object_file: Unread,
    #[serde(default)]
    gripper_file: Unread,
    #[serde(default)]
    gripper_name: Unread,
    #[serde(default)]
    finger_colliders: Unread,
    #[serde(default)]
    open_limit: Unread,
    #[serde(default)]
    base_length: Unread,
    #[serde(default)]
    bite_point: Unread,
    #[serde(default)]
    bite_body_idx: Unread,
    #[serde(default)]
    created_by: Unread,
    #[serde(default)]
    created_at: Unread,
}

/// Version as `1.0` or `"1.0"`.
#[derive(Deserialize)]
#[serde(untagged)]
enum Version {
    Number(f64),
    Text(String),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct IsaacGrasp {
    #[serde(default)]
    confidence: Option<f64>,
    position: [f64; 3],
    orientation: Orientation,
    #[serde(default)]
    cspace_position: Unread,
    #[serde(default)]
    pregrasp_cspace_position: Unread,
    #[serde(default)]
    pregrasp_position: Unread,
    #[serde(default)]
    pregrasp_orientation: Unread,
    #[serde(default)]
    bite_point: Unread,
    #[serde(default)]
    pregrasp_bite_point: Unread,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Orientation {
    w: f64,
    xyz: [f64; 3],
}

/// Mapping in the order of its file.
struct InOrder<T>(Vec<(String, T)>);

impl<'de, T: Deserialize<'de>> Deserialize<'de> for InOrder<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Entries<T>(std::marker::PhantomData<T>);

        impl<'de, T: Deserialize<'de>> Visitor<'de> for Entries<T> {
            type Value = InOrder<T>;

            fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
                formatter.write_str("a map")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Self::Value, A::Error> {
                let mut entries = Vec::new();
                while let Some(entry) = map.next_entry()? {
                    entries.push(entry);
                }
                Ok(InOrder(entries))
            }
        }

        deserializer.deserialize_map(Entries(std::marker::PhantomData))
    }
}

pub fn read(bytes: &[u8], settings: &ImportSettings) -> Result<Read, String> {
    let text = std::str::from_utf8(bytes).map_err(|_| {
        "it is neither HDF5 (ACRONYM), .npy or .npz (NumPy, GraspNet), JSON (GraspGen) nor YAML (Isaac)"
            .to_owned()
    })?;
    let fault = |what: &str, fault: &TextFault| {
        let TextFault { line, problem } = fault;
        format!("line {line}: as {what}: {problem}{}", nearest(problem))
    };
    if text.trim_start().starts_with('{') {
        let file = cranny_file::json(bytes).map_err(|reason| fault("JSON of GraspGen", &reason))?;
        graspgen(file, settings)
    } else {
        isaac(&cranny_file::yaml(text).map_err(|reason| fault("YAML of Isaac", &reason))?)
    }
}

/// Suggestion of the known key for an unknown one, from the message "unknown field `a`, expected one of b, c".
fn nearest(problem: &str) -> String {
    let Some((unknown, known)) =
        problem.strip_prefix("unknown field `").and_then(|rest| rest.split_once("`, expected "))
    else {
        return String::new();
    };
    let known = known.trim_start_matches("one of ").split([',', ' ', '`']);
    did_you_mean(unknown, known.filter(|name| !matches!(*name, "" | "or")))
}

fn graspgen(file: GraspGen, settings: &ImportSettings) -> Result<Read, String> {
    let GraspGen { object, gripper, grasps } = file;
    let GraspGenGrasps { transforms, object_in_gripper, score, suction_points, approach_vectors, is_sealed } =
        grasps;
    if let Some(labels) = &object_in_gripper
        && labels.len() != transforms.len()
    {
        let (labels, transforms) = (labels.len(), transforms.len());
        return Err(format!("grasps.object_in_gripper has {labels} entries for {transforms} transforms"));
    }
    let mut read = Read::new(GraspFormat::Graspgen);
    match gripper {
        None => {}
        Some(GraspGenGripper::Name(name)) => read.of_gripper("gripper", &name, settings)?,
        Some(GraspGenGripper::Figures { name }) => {
            read.of_gripper("gripper.name", &name.unwrap_or_default(), settings)?;
            read.note_unread(&["other keys of gripper"]);
        }
    }
    read.in_file = transforms.len();
    read.object_scale = object.and_then(|object| object.scale);
    for (place, rows) in transforms.iter().enumerate() {
        let rows: [f64; 16] = std::array::from_fn(|index| rows[index / 4][index % 4]);
        let world_from_gripper = pose_of_rows(&rows).map_err(|fault| format!("grasp {place}: {fault}"))?;
        let score = object_in_gripper.as_ref().map(|labels| match labels[place] {
            Label::Is(is_held) => f64::from(u8::from(is_held)),
            Label::Score(score) => score,
        });
        read.push(place, Grasp { score, ..Grasp::at(world_from_gripper) })?;
    }
    read.notes.push(match object_in_gripper {
        Some(_) => "the score is object_in_gripper".to_owned(),
        None => "there is no object_in_gripper: the grasps have no score".to_owned(),
    });
    read.note_unread(&present([
        ("grasps.score", &score),
        ("grasps.suction_points", &suction_points),
        ("grasps.approach_vectors", &approach_vectors),
        ("grasps.is_sealed", &is_sealed),
    ]));
    Ok(read)
}

/// Maximum deviation of the norm of a quaternion from 1: files have four digits.
const NORM_TOLERANCE: f64 = 1e-3;

/// Number of the axis z, along which `GraspDataGen` approaches.
const APPROACH_Z: u8 = 2;

fn isaac(file: &IsaacGrasps) -> Result<Read, String> {
    let version = match &file.format_version {
        Version::Number(version) => format!("{version:?}"),
        Version::Text(version) => version.clone(),
    };
    let format = file.format.as_str();
    if (format, version.as_str()) != ("isaac_grasp", "1.0") {
        return Err(format!("it is of format '{format}' {version}, but isaac_grasp 1.0 is read"));
    }
    if let Some(axis) = file.approach_axis.filter(|axis| *axis != APPROACH_Z) {
        return Err(format!(
            "approach_axis is {axis}, but grasps that approach along z ({APPROACH_Z}) are read"
        ));
    }
    let mut read = Read::new(GraspFormat::Isaac);
    let InOrder(grasps) = &file.grasps;
    read.in_file = grasps.len();
    read.object_scale = file.object_scale;
    for (place, (name, grasp)) in grasps.iter().enumerate() {
        let IsaacGrasp { confidence, position, orientation: Orientation { w, xyz: [x, y, z] }, .. } = grasp;
        let quaternion = Quaternion::new(*w, *x, *y, *z);
        let norm = quaternion.norm();
        if norm.is_nan() || (norm - 1.0).abs() > NORM_TOLERANCE {
            return Err(format!("grasp '{name}': its orientation is of norm {norm}, not a rotation"));
        }
        let world_from_gripper =
            Pose::from_parts(Vector::from(*position).into(), Rotation::from_quaternion(quaternion));
        let grasp = Grasp { score: *confidence, ..Grasp::at(world_from_gripper) };
        read.push(place, grasp).map_err(|fault| format!("grasp '{name}': {fault}"))?;
    }
    let frame = |name: &Option<String>| name.clone().unwrap_or_else(|| "not named".to_owned());
    let (object, gripper) = (frame(&file.object_frame), frame(&file.gripper_frame));
    read.notes.push(format!("object frame {object}, gripper frame {gripper}"));
    let unscored = grasps.iter().filter(|(_, grasp)| grasp.confidence.is_none()).count();
    read.notes.push(match unscored {
        0 => "the score is the confidence".to_owned(),
        all if all == grasps.len() => "there is no confidence: the grasps have no score".to_owned(),
        1 => "the score is the confidence; 1 grasp has none".to_owned(),
        some => format!("the score is the confidence; {some} grasps have none"),
    });
    let any = |of: fn(&IsaacGrasp) -> &Unread| grasps.iter().find_map(|(_, grasp)| *of(grasp));
    read.note_unread(&present([
        ("object_file", &file.object_file),
        ("gripper_file", &file.gripper_file),
        ("gripper_name", &file.gripper_name),
        ("finger_colliders", &file.finger_colliders),
        ("open_limit", &file.open_limit),
        ("base_length", &file.base_length),
        ("bite_point", &file.bite_point),
        ("bite_body_idx", &file.bite_body_idx),
        ("created_by", &file.created_by),
        ("created_at", &file.created_at),
        ("cspace_position", &any(|grasp| &grasp.cspace_position)),
        ("pregrasp_cspace_position", &any(|grasp| &grasp.pregrasp_cspace_position)),
        ("pregrasp_position", &any(|grasp| &grasp.pregrasp_position)),
        ("pregrasp_orientation", &any(|grasp| &grasp.pregrasp_orientation)),
        ("bite_point of grasps", &any(|grasp| &grasp.bite_point)),
        ("pregrasp_bite_point", &any(|grasp| &grasp.pregrasp_bite_point)),
    ]));
    Ok(read)
}

/// Keys that a file contains.
fn present<'a, const N: usize>(keys: [(&'a str, &Unread); N]) -> Vec<&'a str> {
    keys.into_iter().filter(|(_, value)| value.is_some()).map(|(key, _)| key).collect()
}
