use std::path::{Path, PathBuf};

use cranny_file::Readable;

use crate::error::RobotError;

/// A text that comes along with a URDF.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum TextSource {
    /// A file.
    Path(PathBuf),
    /// The text itself.
    Text {
        /// What errors call it.
        name: String,
        /// Its content.
        text: String,
    },
}

/// What `parse` makes of the text of a file and its name.
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
