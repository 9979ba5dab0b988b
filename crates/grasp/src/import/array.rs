//! Single arrays of `NumPy`, and archives of them.

use std::collections::BTreeSet;
use std::io::{self, Cursor, Read as Source};

use cranny_file::{NpyArray, counted, excerpt};
use zip::ZipArchive;

/// Array whose numbers are read in sequence, in C order.
pub struct Array<'a> {
    pub shape: Vec<u64>,
    pub numbers: NpyArray<Box<dyn Source + 'a>>,
}

impl<'a> Array<'a> {
    pub fn of(source: impl Source + 'a, name: &str) -> Result<Self, String> {
        let source: Box<dyn Source> = Box::new(source);
        let numbers = NpyArray::of(source).map_err(|reason| format!("{name}: {reason}"))?;
        let shape = numbers.shape.clone();
        if numbers.is_column_major && shape.len() > 1 {
            return Err(format!("{name} is stored column by column; save it by np.ascontiguousarray"));
        }
        if !numbers.is_numeric() {
            return Err(format!("{name} holds {}, which is not read: save it as float64", numbers.kind));
        }
        Ok(Self { shape, numbers })
    }

    /// Reads all numbers, as many as the shape has and at most `most`, in the unit of the file.
    pub fn all(mut self, most: usize, name: &str) -> Result<Vec<f64>, String> {
        if self.shape.iter().product::<u64>() > most as u64 {
            return Err(format!("{name} is of shape {:?}, more than any set of grasps", self.shape));
        }
        let numbers = self.numbers.by_ref().collect::<Result<_, _>>();
        let numbers = numbers.map_err(|reason: io::Error| match reason.kind() {
            io::ErrorKind::UnexpectedEof => {
                format!(
                    "{name} ends before the last number of its shape {:?} (was it cut short?)",
                    self.shape
                )
            }
            _ => format!("{name}: {reason}"),
        })?;
        self.end(name)?;
        Ok(numbers)
    }

    /// Checks that nothing follows the numbers, all of which have been read.
    pub fn end(mut self, name: &str) -> Result<(), String> {
        match self.numbers.is_at_end() {
            Ok(true) => Ok(()),
            Ok(false) => {
                let shape = &self.shape;
                Err(format!("{name} goes on after the numbers of its shape {shape:?} (is the shape right?)"))
            }
            Err(reason) => Err(format!("{name}: {reason}")),
        }
    }
}

/// Archive of arrays, several of which can be open at once.
pub struct Archive<'a> {
    bytes: &'a [u8],
    /// Names of its arrays.
    pub names: Vec<String>,
    /// Names of its other entries, with their extensions.
    pub others: Vec<String>,
}

impl<'a> Archive<'a> {
    pub fn of(bytes: &'a [u8]) -> Result<Self, String> {
        /// Size of the record that ends an archive, without its comment.
        const END: usize = 22;
        let archive =
            ZipArchive::new(Cursor::new(bytes)).map_err(|reason| format!("the archive: {reason}"))?;
        let end = bytes.len().checked_sub(END + archive.comment().len());
        if archive.offset() != 0 || !end.is_some_and(|end| bytes[end..].starts_with(b"PK\x05\x06")) {
            return Err("the archive: something stands before or after it".to_owned());
        }
        let directory = usize::try_from(archive.central_directory_start()).unwrap_or(usize::MAX);
        let listed = cranny_file::archive_names(bytes.get(directory..).unwrap_or_default());
        if listed.len() < archive.len() {
            return Err(format!(
                "the archive: its directory names {}, but there are {}",
                counted(listed.len(), "entry"),
                archive.len()
            ));
        }
        let mut taken = BTreeSet::new();
        if let Some(twice) = listed.iter().find(|name| !taken.insert(*name)) {
            return Err(format!("the archive holds '{}' twice (keep one of the two)", excerpt(twice)));
        }
        let (mut names, mut others) = (Vec::new(), Vec::new());
        for entry in listed {
            match entry.strip_suffix(".npy") {
                Some(name) => names.push(name.to_owned()),
                None => others.push(entry),
            }
        }
        Ok(Self { bytes, names, others })
    }

    /// Names of the entries other than the arrays in `known`.
    pub fn unread(&self, known: &[&str]) -> Vec<String> {
        let arrays = self.names.iter().filter(|name| !known.contains(&name.as_str()));
        arrays.chain(&self.others).cloned().collect()
    }

    /// Passes the array of a name to `read`; `None` if there is none.
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
