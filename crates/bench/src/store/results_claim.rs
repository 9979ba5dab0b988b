//! Claim of a campaign on its results: no other campaign writes them, and they stay where they are.

use std::fs::{self, TryLockError};
use std::path::PathBuf;

use cranny_file::system::{FileIdentity, open_plain_file};

use crate::store::results_file::{self, Claim};
use crate::{BenchError, Results};

impl Results {
    /// Locks the results for one campaign until they are closed: two writers would do all work twice.
    ///
    /// # Errors
    /// [`BenchError::InUse`], [`BenchError::Unwritable`].
    pub fn claim(&mut self) -> Result<(), BenchError> {
        if self.claim.is_some() {
            return Ok(());
        }
        let file = open_plain_file(&self.path)
            .map_err(|reason| BenchError::Unwritable { path: self.path.clone(), reason })?;
        // Another error means that the file system has no locks.
        if let Err(TryLockError::WouldBlock) = file.try_lock() {
            return Err(BenchError::InUse { path: self.path.clone() });
        }
        self.claim = Some(Claim { file, bytes: 0 });
        Ok(())
    }

    /// Checks that the path still names the claimed file, and that the file was not truncated: what `SQLite` writes to another
    /// one is lost when it is closed.
    ///
    /// # Errors
    /// [`BenchError::ResultsGone`], after an attempt to save all trials elsewhere.
    pub(crate) fn check_in_place(&mut self) -> Result<(), BenchError> {
        let Some(claim) = &mut self.claim else { return Ok(()) };
        let identity = claim.file.metadata().map(|facts| FileIdentity::of(&facts)).ok();
        match fs::metadata(&self.path) {
            Ok(found) if identity == Some(FileIdentity::of(&found)) && found.len() >= claim.bytes => {
                claim.bytes = found.len();
                Ok(())
            }
            _ => Err(self.gone()),
        }
    }

    /// Checks, as another program would read it, that the file contains a run with this number of trials.
    ///
    /// # Errors
    /// As [`Self::check_in_place`].
    pub(crate) fn check_stored(&mut self, run: u64, trials: usize) -> Result<(), BenchError> {
        self.check_in_place()?;
        // A reader delays this, but then it reads the log, too.
        let _ = self.connection.query_row("PRAGMA wal_checkpoint(TRUNCATE)", [], |_| Ok(()));
        let sql = "SELECT count(*) FROM trials WHERE run = ?1";
        let stored = results_file::open(&self.path)
            .and_then(|file| self.done(file.query_row(sql, [run], |row| row.get::<_, usize>(0))));
        if stored.is_ok_and(|stored| stored == trials) { self.check_in_place() } else { Err(self.gone()) }
    }

    fn gone(&self) -> BenchError {
        let kept = self.saved();
        let kept = kept.map_or_else(
            || "its trials could not be saved".to_owned(),
            |kept| {
                format!(
                    "its trials are saved in {}: rename that file, and run the same command again",
                    kept.strip_prefix(".").unwrap_or(&kept).display()
                )
            },
        );
        BenchError::ResultsGone { path: self.path.clone(), kept }
    }

    /// Saves the results as the database still sees them to a new file, beside the results or in the folder of temporary files.
    fn saved(&self) -> Option<PathBuf> {
        let folders = [results_file::folder_of(&self.path).to_owned(), std::env::temp_dir()];
        folders.iter().find_map(|folder| {
            let name = tempfile::Builder::new().prefix("results-saved-").suffix(".db").tempfile_in(folder);
            let file = name.ok()?.into_temp_path();
            self.connection.execute("VACUUM INTO ?1", [file.to_str()?]).ok()?;
            file.keep().ok()
        })
    }
}
