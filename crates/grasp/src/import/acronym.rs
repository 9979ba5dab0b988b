//! HDF5 of ACRONYM: `grasps/transforms` (N, 4, 4) and `grasps/qualities/flex/object_in_gripper` (N,).

use hdf5_reader::{Dataset, Hdf5File, OpenOptions};

use crate::import::format::{GraspFormat, Read};
use crate::{Grasp, pose_of_rows};

const TRANSFORMS: &str = "grasps/transforms";
const HELD: &str = "grasps/qualities/flex/object_in_gripper";

/// Greatest size of a chunk or a whole array, in bytes: two thousand grasps take a quarter of a megabyte.
const MOST_BYTES: usize = 256 << 20;

pub fn read(bytes: &[u8]) -> Result<Read, String> {
    let fault = |reason: hdf5_reader::error::Error| format!("the HDF5 file cannot be read: {reason}");
    let options = OpenOptions::default().with_max_read_bytes(MOST_BYTES).with_max_chunk_bytes(MOST_BYTES);
    let file = Hdf5File::from_bytes_with_options(bytes, options).map_err(fault)?;
    let dataset = |path: &str| file.dataset(path);
    let transforms = dataset(TRANSFORMS)
        .map_err(|reason| format!("it has no {TRANSFORMS}, which a file of ACRONYM has ({reason})"))?;
    let &[count, 4, 4] = transforms.shape() else {
        return Err(format!("{TRANSFORMS} is of shape {:?}, not (N, 4, 4)", transforms.shape()));
    };
    let poses = numbers(&transforms, TRANSFORMS)?;
    let held = match dataset(HELD) {
        Err(_) => None,
        Ok(held) if *held.shape() == [count] => Some(numbers(&held, HELD)?),
        Ok(held) => return Err(format!("{HELD} is of shape {:?}, not ({count},)", held.shape())),
    };
    let mut read = Read::new(GraspFormat::Acronym);
    read.object_scale = match dataset("object/scale") {
        Ok(scale) => numbers(&scale, "object/scale")?.first().copied(),
        Err(_) => None,
    };
    for (place, rows) in poses.as_chunks::<16>().0.iter().enumerate() {
        let world_from_gripper = pose_of_rows(rows).map_err(|fault| format!("grasp {place}: {fault}"))?;
        let score = held.as_ref().map(|held| held[place]);
        read.push(place, Grasp { world_from_gripper, score, width_m: None, robust: None })?;
    }
    read.in_file = read.grasps.len();
    read.notes.push(match held {
        Some(_) => "the score is 1 where the object stayed in the gripper (flex/object_in_gripper), else 0"
            .to_owned(),
        None => format!("there is no {HELD}: the grasps have no score"),
    });
    Ok(read)
}

/// All numbers of an array, as Python's h5py would convert them.
fn numbers(dataset: &Dataset, name: &str) -> Result<Vec<f64>, String> {
    let elements = dataset.num_elements().map_err(|reason| format!("{name}: {reason}"))?;
    if elements > (MOST_BYTES / 8) as u64 {
        return Err(format!("{name} holds {elements} numbers, more than any set of grasps"));
    }
    macro_rules! of_type {
        ($($kind:ty),*) => {$(
            if let Ok(array) = dataset.read_array::<$kind>() {
                #[allow(clippy::cast_lossless, clippy::cast_precision_loss, reason = "labels and lengths are small")]
                return Ok(array.iter().map(|value| *value as f64).collect());
            }
        )*};
    }
    of_type!(f64, f32, i64, i32, i16, i8, u64, u32, u16, u8);
    Err(format!("{name} holds no numbers"))
}
