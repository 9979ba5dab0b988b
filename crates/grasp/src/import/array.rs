//! One array of `NumPy`, and archives of them.

use std::io::{Cursor, Read as Source};

use npyz::{NpyFile, Order};
use zip::ZipArchive;

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

    /// All its numbers, of which there may be `most` at the most.
    pub fn all(self, most: usize, name: &str) -> Result<Vec<f64>, String> {
        let count = self.shape.iter().try_fold(1_u64, |all, side| all.checked_mul(*side));
        if count.is_none_or(|count| count > most as u64) {
            return Err(format!("{name} is of shape {:?}, more than any set of grasps", self.shape));
        }
        self.numbers.collect::<Result<_, _>>().map_err(|reason| format!("{name}: {reason}"))
    }
}

/// An archive of arrays, which can be opened side by side.
pub struct Archive<'a> {
    bytes: &'a [u8],
    pub names: Vec<String>,
}

impl<'a> Archive<'a> {
    pub fn of(bytes: &'a [u8]) -> Result<Self, String> {
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
