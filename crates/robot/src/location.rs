use std::fmt;

/// Location in a text file, displayed as `file:line`, or an entry of a message in memory, displayed as its name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Location {
    /// Path of the file, the name that the caller gave to a text, or the name of an entry.
    pub file: String,
    /// Line number, counted from 1; 0 for an entry of a message in memory.
    pub line: u32,
}

impl fmt::Display for Location {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.line {
            0 => formatter.write_str(&self.file),
            line => write!(formatter, "{}:{line}", self.file),
        }
    }
}
