use std::process::Command;
use std::time::Duration;

use cranny_file::system;
use tempfile::TempDir;

use crate::foreign::foreign_process::{self, Ending, Limits};
use crate::foreign::process_group::Leash;
use crate::{BenchError, Isolation, Sandbox, WorkerProgram};

impl Isolation {
    /// Returns the requested mechanisms as far as this machine supports them, which is tried with `worker`.
    ///
    /// # Errors
    /// [`BenchError::NoSandbox`] if all are required and one is missing.
    pub fn of(sandbox: Sandbox, worker: &WorkerProgram) -> Result<Self, BenchError> {
        if sandbox == Sandbox::Off {
            return Ok(Self::default());
        }
        let (landlock, call_filter) = (system::has_file_walls(), system::has_call_filter());
        let namespaces =
            system::can_have_namespaces() && Self { landlock, namespaces: true, call_filter }.works(worker);
        let isolation = Self { landlock, namespaces, call_filter };
        match isolation.first_missing() {
            Some(missing) if sandbox == Sandbox::Require => Err(BenchError::NoSandbox { missing }),
            _ => Ok(isolation),
        }
    }

    /// Returns true if a program runs with these mechanisms and writes a file, by trying it once.
    fn works(self, worker: &WorkerProgram) -> bool {
        const WRITTEN: &str = "written";
        let Ok(scratch) = TempDir::new() else { return false };
        let mut command = Command::new("touch");
        command.arg(WRITTEN);
        let limits = Limits {
            time: Duration::from_secs(10),
            memory_bytes: 64 << 20,
            scratch: scratch.path(),
            isolation: self,
            hidden: &[],
            kept: &[],
            worker,
        };
        let ran = foreign_process::run(&command, "\n".to_owned(), limits, &Leash::default(), || ());
        ran.is_ok_and(|ran| {
            let has_succeeded = matches!(ran.ending, Ending::Exited { status, .. } if status.success());
            has_succeeded && ran.files.scratch().join(WRITTEN).is_file()
        })
    }
}
