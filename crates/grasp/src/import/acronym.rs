//! HDF5 of ACRONYM: `grasps/transforms` (N, 4, 4) and `grasps/qualities/flex/object_in_gripper` (N,).

use hdf5_reader::error::Error;
use hdf5_reader::{Hdf5File, OpenOptions};

use crate::import::format::{GraspFormat, ImportSettings, Read};
use crate::import::hdf5::{MOST_BYTES, Member, Members};
use crate::{Grasp, pose_of_rows};

const TRANSFORMS: &str = "grasps/transforms";
const HELD: &str = "grasps/qualities/flex/object_in_gripper";
const MASK: &str = "grasps/mask";
const GRIPPER: &str = "gripper/type";
const SCALE: &str = "object/scale";

/// Other datasets of a file that do not affect a pose: names, opening, mass, and the motion of the object.
const WITHOUT_BEARING: [&str; 12] = [
    "grasps/qualities/flex/object_motion_during_closing_angular",
    "grasps/qualities/flex/object_motion_during_closing_linear",
    "grasps/qualities/flex/object_motion_during_shaking_angular",
    "grasps/qualities/flex/object_motion_during_shaking_linear",
    "gripper/configuration",
    "object/com",
    "object/density",
    "object/file",
    "object/friction",
    "object/inertia",
    "object/mass",
    "object/volume",
];

pub fn read(bytes: &[u8], settings: &ImportSettings) -> Result<Read, String> {
    let fault = |reason: Error| format!("the HDF5 file cannot be read: {reason}");
    let options = OpenOptions::default().with_max_read_bytes(MOST_BYTES).with_max_chunk_bytes(MOST_BYTES);
    let file = Hdf5File::from_bytes_with_options(bytes, options).map_err(fault)?;
    let members = Members::of(&file).map_err(fault)?;
    let Some(transforms) = members.open(TRANSFORMS)? else {
        return Err(format!("it has no {TRANSFORMS}, which a file of ACRONYM has"));
    };
    let &[count, 4, 4] = transforms.shape() else {
        return Err(format!("{TRANSFORMS} is of shape {:?}, not (N, 4, 4)", transforms.shape()));
    };
    let poses = transforms.numbers()?;
    let column = |name: &str| match members.open(name)? {
        None => Ok(None),
        Some(column) if *column.shape() == [count] => column.numbers().map(Some),
        Some(column) => Err(format!("{name} is of shape {:?}, not ({count},)", column.shape())),
    };
    let (held, mask) = (column(HELD)?, column(MASK)?);
    if let Some(place) = mask.iter().flatten().position(|value| ![0.0, 1.0].contains(value)) {
        return Err(format!("{MASK} of grasp {place} is neither true nor false"));
    }
    let mut read = Read::new(GraspFormat::Acronym);
    if let Some(gripper) = members.open(GRIPPER)? {
        read.of_gripper(GRIPPER, &gripper.text()?, settings)?;
    }
    read.object_scale = match members.open(SCALE)? {
        Some(scale) => Some(uniform(&scale.numbers()?)?),
        None => None,
    };
    let (poses, _) = poses.as_chunks::<16>();
    read.in_file = poses.len();
    for (place, rows) in poses.iter().enumerate() {
        if mask.as_ref().is_some_and(|mask| mask[place] != 0.0) {
            read.masked += 1;
            continue;
        }
        let world_from_gripper = pose_of_rows(rows).map_err(|fault| format!("grasp {place}: {fault}"))?;
        let score = held.as_ref().map(|held| held[place]);
        read.push(place, Grasp { score, ..Grasp::at(world_from_gripper) })?;
    }
    read.notes.push(match held {
        Some(_) => "the score is 1 where the object stayed in the gripper (flex/object_in_gripper), else 0"
            .to_owned(),
        None => format!("there is no {HELD}: the grasps have no score"),
    });
    if mask.is_some() {
        read.notes.push(format!("grasps for which {MASK} is true are left out"));
    }
    let read_here = [TRANSFORMS, HELD, MASK, GRIPPER, SCALE];
    let mut unread = members.others(&[&read_here, &WITHOUT_BEARING[..]].concat());
    for path in read_here {
        unread.extend(members.open(path)?.iter().flat_map(Member::attributes));
    }
    read.note_unread(&unread);
    Ok(read)
}

/// Scale of an object, which may be given for each axis if all are equal.
fn uniform(scales: &[f64]) -> Result<f64, String> {
    #[allow(clippy::float_cmp, reason = "one scale, written three times")]
    match scales {
        [scale, others @ ..] if others.iter().all(|other| other == scale) => Ok(*scale),
        _ => Err(format!("{SCALE} is {scales:?}, but grasps fit an object of one scale alone")),
    }
}
