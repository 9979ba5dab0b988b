use std::path::{Path, PathBuf};

use cranny_file::Readable;

use crate::error::RobotError;

/// Source of a text that accompanies a URDF.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum TextSource {
    /// Path of a file.
    Path(PathBuf),
    /// Text in memory.
    Text {
        /// Name in errors.
        name: String,
        /// Content.
        text: String,
    },
}

/// Reads `source`, if given, and parses it with `parse`, which takes the text and its name.
pub(crate) fn parsed<T>(
    source: Option<&TextSource>,
    parse: impl Fn(&str, &str) -> Result<T, RobotError>,
) -> Result<Option<T>, RobotError> {
    source
        .map(|source| match source {
            TextSource::Path(path) => parse(&read(cranny_file::TEXT, path)?, &path.display().to_string()),
            TextSource::Text { name, text } => parse(text, name),
        })
        .transpose()
}

pub(crate) fn read(kind: Readable, path: &Path) -> Result<String, RobotError> {
    kind.text(path).map_err(|reason| RobotError::Unreadable { path: path.to_owned(), reason })
}
