//! Arrays of `NumPy`: `.npy` and `.npz`.

use std::io::{Cursor, Read as Source};

use npyz::{NpyFile, Order};
use zip::ZipArchive;

use crate::import::{GraspFormat, ImportSettings, MOST_GRASPS, Read, graspnet};
use crate::{Grasp, pose_of_rows};

/// An array whose numbers are read one after the other, in C order.
pub struct Array<'a> {
    pub shape: Vec<u64>,
    pub numbers: Box<dyn Iterator<Item = std::io::Result<f64>> + 'a>,
}

impl<'a> Array<'a> {
    pub fn of(source: impl Source + 'a, name: &str) -> Result<Self, String> {
        let file = NpyFile::new(source).map_err(|reason| format!("{name}: {reason}"))?;
        let shape = file.shape().to_vec();
        if file.order() != Order::C && shape.len() > 1 {
            return Err(format!("{name} is stored column by column; save it by np.ascontiguousarray"));
        }
        macro_rules! of_type {
            ($file:ident; $($kind:ty => $convert:expr),*) => {{
                $(let $file = match $file.try_data::<$kind>() {
                    Ok(data) => {
                        let numbers = Box::new(data.map(|value| value.map($convert)));
                        return Ok(Self { shape, numbers });
                    }
                    Err(file) => file,
                };)*
                Err(format!("{name} holds {}, not numbers", $file.dtype().descr()))
            }};
        }
        of_type!(file;
            f64 => |value| value, f32 => f64::from, bool => |value| f64::from(u8::from(value)),
            i64 => |value| value as f64, i32 => f64::from, u8 => f64::from, i8 => f64::from)
    }

    /// All its numbers, if there are no more than so many.
    pub fn all(self, most: usize, name: &str) -> Result<Vec<f64>, String> {
        let count = self.shape.iter().try_fold(1_u64, |all, side| all.checked_mul(*side));
        if count.is_none_or(|count| count > most as u64) {
            return Err(format!("{name} is of shape {:?}, more than any set of grasps", self.shape));
        }
        self.numbers.collect::<Result<_, _>>().map_err(|reason| format!("{name}: {reason}"))
    }
}

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

/// An archive of arrays, which can be opened side by side.
pub struct Archive<'a> {
    bytes: &'a [u8],
    names: Vec<String>,
}

impl<'a> Archive<'a> {
    fn of(bytes: &'a [u8]) -> Result<Self, String> {
        let archive =
            ZipArchive::new(Cursor::new(bytes)).map_err(|reason| format!("the archive: {reason}"))?;
        let names = archive.file_names().filter_map(|name| Some(name.ok()?.strip_suffix(".npy")?.to_owned()));
        Ok(Self { bytes, names: names.collect() })
    }

    /// Hands the array of a name on; `None` if there is none.
    pub fn with<T>(
        &self,
        name: &str,
        read: impl FnOnce(Array) -> Result<T, String>,
    ) -> Result<Option<T>, String> {
        if !self.names.iter().any(|own| own == name) {
            return Ok(None);
        }
        let fault = |reason: zip::result::ZipError| format!("{name}: {reason}");
        let mut archive = ZipArchive::new(Cursor::new(self.bytes)).map_err(fault)?;
        let entry = archive.by_name(&format!("{name}.npy")).map_err(fault)?;
        read(Array::of(entry, name)?).map(Some)
    }
}

/// The names that an array of poses may have in an archive.
const POSES: [&str; 4] = ["poses", "transforms", "grasps", "arr_0"];

pub fn read_npz(bytes: &[u8], settings: &ImportSettings) -> Result<Read, String> {
    let archive = Archive::of(bytes)?;
    if ["points", "offsets", "scores"].iter().all(|name| archive.names.iter().any(|own| own == name)) {
        return graspnet::read_labels(&archive, settings);
    }
    let Some(name) = POSES.into_iter().find(|name| archive.names.iter().any(|own| own == name)) else {
        let names = archive.names.join(", ");
        return Err(format!(
            "it holds {names}, but neither points, offsets and scores of GraspNet nor one of {}",
            POSES.join(", ")
        ));
    };
    let column = |name: &str| {
        archive.with(name, |array| Ok((array.shape.clone(), array.all(16 * MOST_GRASPS, name)?)))
    };
    let (scores, widths, mask) = (column("scores")?, column("widths")?, column("mask")?);
    let read = archive.with(name, |array| poses(array, name, &scores, &widths, &mask))?;
    let mut read = read.ok_or_else(|| format!("it has no {name}"))?;
    let known = [name, "scores", "widths", "mask"];
    let unread: Vec<&str> =
        archive.names.iter().map(String::as_str).filter(|own| !known.contains(own)).collect();
    if !unread.is_empty() {
        read.notes.push(format!("not read: {}", unread.join(", ")));
    }
    Ok(read)
}

type Column = Option<(Vec<u64>, Vec<f64>)>;

/// Poses (N, 4, 4), with scores and widths (N,) where NaN is none, and a mask, (N,) or (N, 4, 4), that is true where a grasp
/// is none, as in `NumPy`'s masked arrays.
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
        read.push(place, Grasp { world_from_gripper, score, width_m, robust: None })?;
    }
    Ok(read)
}
