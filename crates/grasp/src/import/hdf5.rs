//! Members of an HDF5 file, by their paths.

use std::collections::BTreeSet;

use cranny_file::excerpt;
use hdf5_reader::error::Error;
use hdf5_reader::group::Group;
use hdf5_reader::{Dataset, Datatype, Hdf5File};

/// Maximum size of a chunk or a whole array, in bytes: two thousand grasps take a quarter of a megabyte.
pub const MOST_BYTES: usize = 256 << 20;

/// Maximum number of members; `DEEPEST` limits nested groups, because a group may be linked into itself.
const MOST_MEMBERS: usize = 10_000;
const DEEPEST: usize = 16;

/// Paths of all members of a file; a dataset is opened only on request.
pub struct Members<'a> {
    file: &'a Hdf5File,
    datasets: BTreeSet<String>,
    /// Attributes of groups, and groups without a member; none of them is read.
    others: BTreeSet<String>,
}

/// A dataset that is read.
pub struct Member<'a> {
    path: &'a str,
    dataset: Dataset,
}

impl<'a> Members<'a> {
    pub fn of(file: &'a Hdf5File) -> Result<Self, Error> {
        let mut members = Self { file, datasets: BTreeSet::new(), others: BTreeSet::new() };
        members.gather(&file.root_group()?, "", 0)?;
        Ok(members)
    }

    fn gather(&mut self, group: &Group, path: &str, depth: usize) -> Result<(), Error> {
        let limit = |what: &str| Err(Error::ResourceLimit(format!("it has {what} than any file of grasps")));
        if depth > DEEPEST {
            return limit("deeper groups");
        }
        let (groups, datasets) = group.member_names()?;
        let attributes = group.attributes()?;
        let count = [groups.len(), datasets.len(), attributes.len(), self.datasets.len(), self.others.len()];
        if count.iter().sum::<usize>() > MOST_MEMBERS {
            return limit("more members");
        }
        let below = |name: &String| if path.is_empty() { name.clone() } else { format!("{path}/{name}") };
        if depth > 0 && groups.is_empty() && datasets.is_empty() {
            self.others.insert(path.to_owned());
        }
        self.others.extend(attributes.iter().map(|attribute| attribute_of(path, &attribute.name)));
        self.datasets.extend(datasets.iter().map(below));
        for name in &groups {
            self.gather(&group.group(name)?, &below(name), depth + 1)?;
        }
        Ok(())
    }

    /// Opens the dataset at a path, if there is one.
    pub fn open<'p>(&self, path: &'p str) -> Result<Option<Member<'p>>, String> {
        if !self.datasets.contains(path) {
            return Ok(None);
        }
        let dataset = self.file.dataset(path).map_err(|reason| fault(path, &reason))?;
        Ok(Some(Member { path, dataset }))
    }

    /// Names of all members that are not `known`.
    pub fn others(&self, known: &[&str]) -> Vec<String> {
        let mut others: Vec<String> =
            self.datasets.iter().filter(|path| !known.contains(&path.as_str())).cloned().collect();
        others.extend(self.others.iter().cloned());
        others
    }
}

fn attribute_of(path: &str, name: &str) -> String {
    format!("attribute {name} of {}", if path.is_empty() { "the file" } else { path })
}

impl Member<'_> {
    pub fn shape(&self) -> &[u64] {
        self.dataset.shape()
    }

    /// Names of its attributes, none of which is read.
    pub fn attributes(&self) -> Vec<String> {
        self.dataset.attributes().iter().map(|attribute| attribute_of(self.path, &attribute.name)).collect()
    }

    /// Reads all numbers, as many as it has elements, in the unit of the file; those of an enumeration (h5py's booleans) are
    /// its values.
    pub fn numbers(&self) -> Result<Vec<f64>, String> {
        let Self { path, dataset } = self;
        let elements = dataset.num_elements().map_err(|reason| fault(path, &reason))?;
        if elements > (MOST_BYTES / 8) as u64 {
            return Err(format!("{path} holds {elements} numbers, more than any set of grasps"));
        }
        macro_rules! of_type {
            ($kind:ty) => {{
                let array = dataset.read_array::<$kind>().map_err(|reason| fault(path, &reason))?;
                #[allow(
                    clippy::cast_lossless,
                    clippy::cast_precision_loss,
                    clippy::unnecessary_cast,
                    reason = "labels and lengths are small"
                )]
                Ok(array.iter().map(|value| *value as f64).collect())
            }};
        }
        match dataset.dtype() {
            Datatype::FloatingPoint { size: 8, .. } => of_type!(f64),
            Datatype::FloatingPoint { size: 4, .. } => of_type!(f32),
            Datatype::FixedPoint { size: 8, signed: true, .. } => of_type!(i64),
            Datatype::FixedPoint { size: 4, signed: true, .. } => of_type!(i32),
            Datatype::FixedPoint { size: 2, signed: true, .. } => of_type!(i16),
            Datatype::FixedPoint { size: 1, signed: true, .. } => of_type!(i8),
            Datatype::FixedPoint { size: 8, signed: false, .. } => of_type!(u64),
            Datatype::FixedPoint { size: 4, signed: false, .. } => of_type!(u32),
            Datatype::FixedPoint { size: 2, signed: false, .. } => of_type!(u16),
            Datatype::FixedPoint { size: 1, signed: false, .. } => of_type!(u8),
            Datatype::Enum { base, members }
                if matches!(**base, Datatype::FixedPoint { size: 1, .. })
                    && members.iter().all(|member| ["FALSE", "TRUE"].contains(&member.name.as_str())) =>
            {
                let bytes = dataset.read_raw_bytes().map_err(|reason| fault(path, &reason))?;
                Ok(bytes.iter().map(|byte| f64::from(*byte)).collect())
            }
            Datatype::FloatingPoint { size, .. } => Err(format!(
                "{path} holds floating-point numbers of {} bits, but those of 32 and 64 are read: save it as float64",
                8 * u32::from(*size)
            )),
            other => Err(format!("{path} holds {}, not numbers", named(other))),
        }
    }

    /// Reads its only text.
    pub fn text(&self) -> Result<String, String> {
        let path = self.path;
        match self.dataset.dtype() {
            Datatype::String { .. } | Datatype::VarLen { .. } => {
                self.dataset.read_string().map_err(|reason| fault(path, &reason))
            }
            other => Err(format!("{path} holds {}, not a text", named(other))),
        }
    }
}

fn fault(path: &str, reason: &Error) -> String {
    match reason {
        Error::Context { source, .. } => fault(path, source),
        Error::UnsupportedFilter(filter) => {
            let number = filter.rsplit(' ').next().unwrap_or_default();
            let filter = FILTERS.iter().find(|(known, _)| *known == number);
            let filter = filter.map_or_else(
                || format!("filter {}", excerpt(number)),
                |(number, name)| format!("{name} (filter {number})"),
            );
            format!("{path} is compressed by {filter}, which is not read: save it with gzip, or uncompressed")
        }
        reason => format!("{path}: {reason}"),
    }
}

/// Registered filters that h5py or hdf5plugin write (HDF Group, list of registered filters).
const FILTERS: [(&str, &str); 6] = [
    ("32000", "LZF"),
    ("32001", "Blosc"),
    ("32004", "LZ4"),
    ("32008", "Bitshuffle"),
    ("32013", "ZFP"),
    ("32015", "Zstandard"),
];

/// Describes the contents of a dataset of a type.
fn named(datatype: &Datatype) -> &'static str {
    match datatype {
        Datatype::FixedPoint { .. } | Datatype::FloatingPoint { .. } => "numbers",
        Datatype::String { .. } => "texts",
        Datatype::Compound { .. } => "records",
        Datatype::Array { .. } => "arrays",
        Datatype::Enum { .. } => "values of an enumeration",
        Datatype::VarLen { .. } => "lists of any length",
        Datatype::Opaque { .. } => "opaque bytes",
        Datatype::Reference { .. } => "references",
        Datatype::Bitfield { .. } => "fields of bits",
    }
}
