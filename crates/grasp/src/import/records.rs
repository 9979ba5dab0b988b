//! Grasps as text: JSON of `GraspGen`, YAML of Isaac Sim.

#![allow(clippy::zero_sized_map_values, reason = "what serde gathers other keys in is a map")]

use std::collections::BTreeMap;

use cranny_spatial::nalgebra::Quaternion;
use cranny_spatial::{Pose, Rotation, Vector};
use serde::Deserialize;
use serde::de::IgnoredAny;

use crate::import::format::{GraspFormat, Read};
use crate::{Grasp, pose_of_rows};

/// Keys that nothing is made of; they are named.
type Others = BTreeMap<String, IgnoredAny>;

#[derive(Deserialize)]
struct GraspGen {
    #[serde(default)]
    object: Option<GraspGenObject>,
    grasps: GraspGenGrasps,
    #[serde(flatten)]
    others: Others,
}

#[derive(Deserialize)]
struct GraspGenObject {
    #[serde(default)]
    scale: Option<f64>,
}

#[derive(Deserialize)]
struct GraspGenGrasps {
    transforms: Vec<[[f64; 4]; 4]>,
    #[serde(default)]
    object_in_gripper: Option<Vec<Label>>,
    #[serde(flatten)]
    others: Others,
}

/// `true`, or 0 to 1.
#[derive(Deserialize)]
#[serde(untagged)]
enum Label {
    Is(bool),
    Score(f64),
}

#[derive(Deserialize)]
struct IsaacGrasps {
    format: String,
    format_version: Version,
    #[serde(default)]
    object_frame: Option<String>,
    #[serde(default)]
    gripper_frame: Option<String>,
    grasps: BTreeMap<String, IsaacGrasp>,
    #[serde(flatten)]
    others: Others,
}

/// `1.0` or `"1.0"`.
#[derive(Deserialize)]
#[serde(untagged)]
enum Version {
    Number(f64),
    Text(String),
}

#[derive(Deserialize)]
struct IsaacGrasp {
    #[serde(default)]
    confidence: Option<f64>,
    position: [f64; 3],
    orientation: Orientation,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Orientation {
    w: f64,
    xyz: [f64; 3],
}

pub fn read(bytes: &[u8]) -> Result<Read, String> {
    let text = std::str::from_utf8(bytes).map_err(|_| {
        "it is neither HDF5 (ACRONYM), .npy or .npz (NumPy, GraspNet), JSON (GraspGen) nor YAML (Isaac)"
            .to_owned()
    })?;
    if text.trim_start().starts_with('{') {
        let file = cranny_file::json(bytes);
        graspgen(
            file.map_err(|fault| format!("line {}: as JSON of GraspGen: {}", fault.line, fault.problem))?,
        )
    } else {
        let file = cranny_file::yaml(text);
        isaac(file.map_err(|fault| format!("line {}: as YAML of Isaac: {}", fault.line, fault.problem))?)
    }
}

fn graspgen(file: GraspGen) -> Result<Read, String> {
    let GraspGen {
        object,
        grasps: GraspGenGrasps { transforms, object_in_gripper, others: of_grasps },
        others,
    } = file;
    if let Some(labels) = &object_in_gripper
        && labels.len() != transforms.len()
    {
        let (labels, transforms) = (labels.len(), transforms.len());
        return Err(format!("grasps.object_in_gripper has {labels} entries for {transforms} transforms"));
    }
    let mut read = Read::new(GraspFormat::Graspgen);
    read.in_file = transforms.len();
    read.object_scale = object.and_then(|object| object.scale);
    for (place, rows) in transforms.iter().enumerate() {
        let rows: [f64; 16] = std::array::from_fn(|index| rows[index / 4][index % 4]);
        let world_from_gripper = pose_of_rows(&rows).map_err(|fault| format!("grasp {place}: {fault}"))?;
        let score = object_in_gripper.as_ref().map(|labels| match labels[place] {
            Label::Is(is_held) => f64::from(u8::from(is_held)),
            Label::Score(score) => score,
        });
        read.push(place, Grasp { world_from_gripper, score, width_m: None, robust: None })?;
    }
    read.notes.push("the score is object_in_gripper".to_owned());
    note_unread(&mut read, others.keys().chain(of_grasps.keys()));
    Ok(read)
}

/// Greatest deviation of the norm of a quaternion from 1: files have four digits.
const NORM_TOLERANCE: f64 = 1e-3;

fn isaac(file: IsaacGrasps) -> Result<Read, String> {
    let IsaacGrasps { format, format_version, object_frame, gripper_frame, grasps, others } = file;
    let version = match format_version {
        Version::Number(version) => format!("{version:?}"),
        Version::Text(version) => version,
    };
    if (format.as_str(), version.as_str()) != ("isaac_grasp", "1.0") {
        return Err(format!("it is of format '{format}' {version}, but isaac_grasp 1.0 is read"));
    }
    let mut read = Read::new(GraspFormat::Isaac);
    read.in_file = grasps.len();
    for (place, (name, grasp)) in grasps.iter().enumerate() {
        let IsaacGrasp { confidence, position, orientation: Orientation { w, xyz: [x, y, z] } } = grasp;
        let quaternion = Quaternion::new(*w, *x, *y, *z);
        let norm = quaternion.norm();
        if norm.is_nan() || (norm - 1.0).abs() > NORM_TOLERANCE {
            return Err(format!("grasp '{name}': its orientation is of norm {norm}, not a rotation"));
        }
        let world_from_gripper =
            Pose::from_parts(Vector::from(*position).into(), Rotation::from_quaternion(quaternion));
        let grasp = Grasp { world_from_gripper, score: *confidence, width_m: None, robust: None };
        read.push(place, grasp).map_err(|fault| format!("grasp '{name}': {fault}"))?;
    }
    let frame = |name: Option<String>| name.unwrap_or_else(|| "not named".to_owned());
    read.notes.push(format!("object frame {}, gripper frame {}", frame(object_frame), frame(gripper_frame)));
    read.notes.push("the score is the confidence; cspace_position is not read".to_owned());
    note_unread(&mut read, others.keys());
    Ok(read)
}

fn note_unread<'a>(read: &mut Read, keys: impl Iterator<Item = &'a String>) {
    let keys: Vec<&str> = keys.map(String::as_str).collect();
    if !keys.is_empty() {
        read.notes.push(format!("not read: {}", keys.join(", ")));
    }
}
