//! Grasps in arrays of `NumPy`: `.npy` and `.npz`.

use std::io::Cursor;

use cranny_file::{did_you_mean, excerpt};

use crate::import::array::{Archive, Array};
use crate::import::format::{GraspFormat, ImportSettings, MOST_GRASPS, Read};
use crate::import::graspnet;
use crate::{Grasp, pose_of_rows};

pub fn read_npy(bytes: &[u8], settings: &ImportSettings) -> Result<Read, String> {
    let array = Array::of(Cursor::new(bytes), "the array")?;
    match array.shape[..] {
        [_, 17] => graspnet::read_group(array, settings),
        [_, 4, 4] => poses(array, "the array", &None, &None, &None),
        _ => Err(format!(
            "the array is of shape {:?}, not (N, 4, 4) for poses nor (N, 17) for a GraspGroup of GraspNet",
            array.shape
        )),
    }
}

/// Names that an array of poses may have in an archive.
const POSES: [&str; 4] = ["poses", "transforms", "grasps", "arr_0"];

pub fn read_npz(bytes: &[u8], settings: &ImportSettings) -> Result<Read, String> {
    let archive = Archive::of(bytes)?;
    if ["points", "offsets", "scores"].iter().all(|name| archive.names.iter().any(|own| own == name)) {
        return graspnet::read_labels(&archive, settings);
    }
    let Some(name) = POSES.into_iter().find(|name| archive.names.iter().any(|own| own == name)) else {
        let names = archive.unread(&[]).join(", ");
        return Err(format!(
            "it holds {names}, but neither points, offsets and scores of GraspNet nor one of {}",
            POSES.join(", ")
        ));
    };
    let unread = archive.unread(&[name, "scores", "widths", "mask"]);
    for own in &unread {
        let near = did_you_mean(own, ["scores", "widths", "mask"]);
        if !near.is_empty() {
            return Err(format!("it holds '{}', which is no array that is read{near}", excerpt(own)));
        }
    }
    let column = |name: &str| {
        archive.with(name, |array| Ok((array.shape.clone(), array.all(16 * MOST_GRASPS, name)?)))
    };
    let (scores, widths, mask) = (column("scores")?, column("widths")?, column("mask")?);
    let read = archive.with(name, |array| poses(array, name, &scores, &widths, &mask))?;
    let mut read = read.ok_or_else(|| format!("it has no {name}"))?;
    read.note_unread(&unread);
    Ok(read)
}

type Column = Option<(Vec<u64>, Vec<f64>)>;

/// Reads poses (N, 4, 4), with scores and widths (N,), where NaN means none, and a mask, (N,) or (N, 4, 4), that is true
/// for invalid grasps, as in `NumPy`'s masked arrays.
fn poses(array: Array, name: &str, scores: &Column, widths: &Column, mask: &Column) -> Result<Read, String> {
    let &[count, 4, 4] = &array.shape[..] else {
        return Err(format!("{name} is of shape {:?}, not (N, 4, 4)", array.shape));
    };
    for (column, name, is_mask) in
        [(scores, "scores", false), (widths, "widths", false), (mask, "mask", true)]
    {
        if let Some((shape, _)) = column
            && *shape != [count]
            && !(is_mask && *shape == [count, 4, 4])
        {
            return Err(format!("{name} is of shape {shape:?}, not ({count},)"));
        }
    }
    if let Some((_, mask)) = mask
        && let Some(value) = mask.iter().find(|value| ![0.0, 1.0].contains(*value))
    {
        return Err(format!("mask holds {value}, which is neither true nor false"));
    }
    let numbers = array.all(16 * MOST_GRASPS, name)?;
    let count = numbers.len() / 16;
    let is_masked = |place: usize| {
        mask.as_ref().is_some_and(|(_, mask)| {
            let width = mask.len() / count;
            mask[place * width..(place + 1) * width].iter().any(|masked| *masked != 0.0)
        })
    };
    let known = |column: &Column, place: usize| {
        column.as_ref().map(|(_, values)| values[place]).filter(|x| !x.is_nan())
    };
    let mut read = Read::new(GraspFormat::Poses);
    read.in_file = count;
    for (place, rows) in numbers.as_chunks::<16>().0.iter().enumerate() {
        if is_masked(place) {
            read.masked += 1;
            continue;
        }
        let world_from_gripper = pose_of_rows(rows).map_err(|fault| format!("grasp {place}: {fault}"))?;
        let (score, width_m) = (known(scores, place), known(widths, place));
        read.push(place, Grasp { score, width_m, ..Grasp::at(world_from_gripper) })?;
    }
    Ok(read)
}
