//! File `grasps.npy` of the released layout: grasps in the scene, in the axis convention of another toolkit.

use std::fs::File;
use std::io::{BufWriter, Write as _};
use std::path::Path;

use cranny_file::{NpyArray, npy_header};
use cranny_grasp::{Grasp, GraspError, GraspSet, pose_of_rows, rows_of_pose};
use cranny_spatial::nalgebra::{Matrix3, Rotation3};
use cranny_spatial::{Pose, Rotation, Vector};

use crate::ScenarioError;
use crate::layout::released_frame::planning_from_scene;

pub(crate) const FILE: &str = "grasps.npy";

/// Returns `array_from_gripper`: x and y are swapped, z is reversed. It is its own inverse.
fn swap_axes() -> Pose {
    let axes = Matrix3::new(0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, -1.0);
    let rotation = Rotation::from_rotation_matrix(&Rotation3::from_matrix_unchecked(axes));
    Pose::from_parts(Vector::zeros().into(), rotation)
}

/// Reads floats of shape (n, 4, 4): poses in the scene. The file contains no scores or widths.
pub(crate) fn read(path: &Path) -> Result<GraspSet, ScenarioError> {
    let fault = |problem: String| ScenarioError::Npy { path: path.to_owned(), problem };
    let bytes = cranny_file::TABLE
        .bytes(path)
        .map_err(|reason| ScenarioError::Unreadable { path: path.to_owned(), reason })?;
    let array = NpyArray::of(&bytes[..]).map_err(fault)?;
    let [count, 4, 4] = array.shape[..] else { return Err(fault(format!("its shape is {:?}", array.shape))) };
    /// Maximum number of grasps; a larger number indicates a broken header.
    const MOST: u64 = 10_000_000;
    if count == 0 || count > MOST || array.is_column_major {
        return Err(fault(format!("it holds {count} poses, or holds them column by column")));
    }
    if !array.is_numeric() {
        return Err(fault(format!("its numbers are {}", array.kind)));
    }
    let numbers: Vec<f64> = array.collect::<Result<_, _>>().map_err(|reason| fault(reason.to_string()))?;
    let in_file = |grasp: usize, reason: &GraspError| fault(format!("grasp {grasp}: {reason}"));
    let mut grasps = Vec::new();
    for (index, rows) in numbers.chunks_exact(16).enumerate() {
        let rows: [f64; 16] = std::array::from_fn(|entry| rows[entry]);
        let scene_from_array = pose_of_rows(&rows).map_err(|reason| in_file(index, &reason))?;
        let world_from_gripper = planning_from_scene() * scene_from_array * swap_axes();
        grasps.push(Grasp::at(world_from_gripper));
    }
    Ok(GraspSet::new(grasps)?)
}

/// Writes a file for [`read`], in single precision as in the release.
pub(crate) fn write(path: &Path, grasps: &GraspSet) -> Result<(), ScenarioError> {
    let unwritable = |reason| ScenarioError::Unwritable { path: path.to_owned(), reason };
    let scene_from_planning = planning_from_scene().inverse();
    let numbers = grasps
        .grasps()
        .iter()
        .flat_map(|grasp| rows_of_pose(&(scene_from_planning * grasp.world_from_gripper * swap_axes())));
    let write = || -> std::io::Result<()> {
        let mut file = BufWriter::new(File::create(path)?);
        file.write_all(&npy_header("<f4", &[grasps.len() as u64, 4, 4]))?;
        for number in numbers {
            #[allow(clippy::cast_possible_truncation, reason = "metres and cosines fit")]
            file.write_all(&(number as f32).to_le_bytes())?;
        }
        file.flush()
    };
    write().map_err(unwritable)
}
