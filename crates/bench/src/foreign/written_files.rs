use std::io;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use cranny_file::system::{ProcessFolder, SHARED_MEMORY, folder_bytes};

/// Files that an external program writes: in its scratch folder, and in shared memory of its own.
#[derive(Debug)]
pub struct WrittenFiles {
    place: Place,
}

#[derive(Debug)]
enum Place {
    /// A folder on a disk, whose size is measured now and then.
    Disk { scratch: PathBuf, bytes: u64, next: Instant },
    /// Folders in memory, which only the program and this value own.
    Memory { scratch: ProcessFolder, shared: Option<ProcessFolder> },
}

/// Sizes of the files of a program, in bytes.
#[derive(Clone, Copy, Debug, Default)]
pub struct WrittenBytes {
    pub scratch: u64,
    shared: u64,
    /// True if both are memory, which the memory of processes that map them includes.
    are_memory: bool,
}

impl WrittenBytes {
    /// Returns the size that counts in addition to the memory that processes do not share; they have `resident` bytes of shared
    /// memory.
    pub fn with_shared(self, resident: u64) -> u64 {
        let Self { scratch, shared, are_memory } = self;
        if are_memory { (scratch + shared).max(resident) } else { scratch + resident }
    }
}

/// Minimum interval between two measurements of a folder, and its ratio to their duration: they take at most a twentieth of a
/// processor.
const MEASURE_EVERY: Duration = Duration::from_millis(200);
const SHARE: u32 = 20;

impl WrittenFiles {
    /// Creates the files of a program with this scratch folder. `inner` is a process in the namespaces of the program, if it has
    /// any.
    ///
    /// # Errors
    /// Those of the operating system.
    pub fn of(scratch: &Path, inner: Option<u32>) -> io::Result<Self> {
        let place = match inner {
            Some(inner) => Place::Memory {
                scratch: ProcessFolder::open(inner, scratch)?,
                shared: ProcessFolder::open(inner, Path::new(SHARED_MEMORY)).ok(),
            },
            None => Place::Disk { scratch: scratch.to_owned(), bytes: 0, next: Instant::now() },
        };
        Ok(Self { place })
    }

    /// Returns the path of the scratch folder for this process, also after the program.
    pub fn scratch(&self) -> PathBuf {
        match &self.place {
            Place::Disk { scratch, .. } => scratch.clone(),
            Place::Memory { scratch, .. } => scratch.path(),
        }
    }

    /// Measures the files, on a disk up to `most` bytes and only now and then.
    pub fn measure(&mut self, most: u64) -> WrittenBytes {
        match &mut self.place {
            Place::Disk { scratch, bytes, next } => {
                let begin = Instant::now();
                if begin >= *next {
                    *bytes = folder_bytes(scratch, most);
                    *next = Instant::now() + MEASURE_EVERY.max(begin.elapsed() * SHARE);
                }
                WrittenBytes { scratch: *bytes, shared: 0, are_memory: false }
            }
            Place::Memory { scratch, shared } => WrittenBytes {
                scratch: scratch.used_bytes(),
                shared: shared.as_ref().map_or(0, ProcessFolder::used_bytes),
                are_memory: true,
            },
        }
    }
}
