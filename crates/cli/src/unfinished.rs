//! Partial results of a long computation that was stopped, kept beside the output until the same command resumes.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use cranny_scenario::write_whole_file;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use sha2::{Digest as _, Sha256};

use crate::arguments::Output;
use crate::failure::Failure;
use crate::file_kind::FileKind;
use crate::output_file;

/// File of the partial result of one computation, and the identity of that computation.
pub struct Unfinished {
    file: PathBuf,
    identity: String,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Content<Rows> {
    format: String,
    /// SHA-256 of the version of Cranny and of everything that the rows depend on.
    identity: String,
    rows: Rows,
}

const FORMAT: &str = "cranny-unfinished/1";

impl Unfinished {
    /// Returns the file beside `output`: `scored.csv` → `scored.csv.unfinished-1a2b3c4d.json`, with the start of the identity.
    /// Two computations are the same if the version of Cranny and everything in `depends_on` are.
    ///
    /// # Errors
    /// [`Failure`] if a file of another kind has that name.
    pub fn beside(output: &Path, depends_on: &[&str], flags: Output) -> Result<Self, Failure> {
        let mut sum = Sha256::new();
        for part in [&[env!("CARGO_PKG_VERSION")], depends_on].concat() {
            sum.update(part.len().to_le_bytes());
            sum.update(part);
        }
        let mut identity = String::new();
        for byte in sum.finalize() {
            let _ = write!(identity, "{byte:02x}");
        }
        let mut name = output.as_os_str().to_owned();
        name.push(format!(".unfinished-{}.json", &identity[..8]));
        let file = PathBuf::from(name);
        output_file::check(&file, FileKind::Unfinished, flags)?;
        Ok(Self { file, identity })
    }

    /// Returns the rows that an earlier run of the same computation finished.
    ///
    /// # Errors
    /// [`Failure::File`] for a file that cannot be read, or belongs to another computation.
    pub fn rows<Row: DeserializeOwned>(&self) -> Result<Vec<Row>, Failure> {
        if !self.file.exists() {
            return Ok(Vec::new());
        }
        let fault = |problem: String| Failure::File { path: self.file.clone(), problem };
        let text = cranny_file::TABLE.text(&self.file).map_err(|reason| fault(reason.to_string()))?;
        let content: Content<Vec<Row>> = cranny_file::json(text.as_bytes())
            .map_err(|reason| fault(format!("{}; remove the file to start again", reason.problem)))?;
        if content.format != FORMAT || content.identity != self.identity {
            return Err(fault(
                "the file contains rows of another command; remove it to start again".to_owned(),
            ));
        }
        Ok(content.rows)
    }

    /// Replaces the stored rows and returns the file.
    ///
    /// # Errors
    /// [`Failure`] if it cannot be written.
    pub fn keep<Row: Serialize>(&self, rows: &[Row]) -> Result<&Path, Failure> {
        let content = Content { format: FORMAT.to_owned(), identity: self.identity.clone(), rows };
        let text = serde_json::to_string(&content).map_err(std::io::Error::other)? + "\n";
        write_whole_file(&self.file, text.as_bytes())?;
        Ok(&self.file)
    }

    /// Removes the file after the computation is complete.
    ///
    /// # Errors
    /// [`Failure`] if it cannot be removed.
    pub fn clear(&self) -> Result<(), Failure> {
        match std::fs::remove_file(&self.file) {
            Err(reason) if reason.kind() != std::io::ErrorKind::NotFound => Err(reason.into()),
            _ => Ok(()),
        }
    }
}
