//! Isolation of external programs, by mechanisms of the kernel (Linux).

use std::path::Path;
use std::process::{Command, Stdio};

use cranny_file::system;
use serde::{Deserialize, Serialize};
use strum::{EnumString, IntoStaticStr, VariantArray};

use crate::{BenchError, WorkerProgram};

/// Isolation of external programs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, EnumString, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "kebab-case")]
pub enum Sandbox {
    /// Uses the mechanisms that this machine supports.
    #[default]
    Auto,
    /// Runs without isolation, with all rights of the user.
    Off,
    /// Requires all mechanisms.
    Require,
}

impl Sandbox {
    /// Returns the name in flags.
    pub fn name(self) -> &'static str {
        self.into()
    }
}

/// Isolation mechanisms of a worker and its programs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Isolation {
    /// True if a program can write only in its own folder, and can neither stop nor inspect a process that it did not start
    /// (Landlock; signals from Linux 6.12 on).
    pub landlock: bool,
    /// True if a worker has its own processes, shared memory and `/dev/shm`, sees no others, and ends with all its
    /// processes (user, PID, IPC and mount namespaces).
    pub namespaces: bool,
}

/// Command that creates the namespaces of a worker, with util-linux: the creator of a PID namespace is not in it itself.
const NAMESPACES: [&str; 11] = [
    "unshare",
    "--user",
    "--map-root-user",
    "--mount",
    "--ipc",
    "--pid",
    "--fork",
    "--kill-child",
    "--mount-proc",
    "sh",
    "-c",
];

/// First command within the namespaces: it drops all capabilities of the user namespace.
const ENTER: &str = "mount -t tmpfs -o \"size=$1\" cranny /dev/shm && shift && \
    exec setpriv --bounding-set -all --inh-caps -all --no-new-privs -- \"$@\"";

impl Isolation {
    /// Returns the requested mechanisms as far as this machine supports them.
    ///
    /// # Errors
    /// [`BenchError::NoSandbox`] if all are required and one is missing.
    pub fn of(sandbox: Sandbox) -> Result<Self, BenchError> {
        if sandbox == Sandbox::Off {
            return Ok(Self::default());
        }
        let walls = Self { landlock: system::has_file_walls(), namespaces: has_namespaces() };
        let missing = match walls {
            Self { landlock: false, .. } => "Landlock (Linux 5.13 or newer, with it switched on)",
            Self { namespaces: false, .. } => {
                "namespaces (user namespaces allowed to this user, and `unshare`, `mount` and `setpriv` of util-linux)"
            }
            _ => return Ok(walls),
        };
        if sandbox == Sandbox::Require { Err(BenchError::NoSandbox { missing }) } else { Ok(walls) }
    }

    /// Returns the names of the mechanisms in results; `None` if there are none.
    pub fn text(self) -> Option<String> {
        let names = [(self.landlock, "Landlock"), (self.namespaces, "namespaces")];
        let names: Vec<&str> =
            names.iter().filter(|(is_there, _)| *is_there).map(|(_, name)| *name).collect();
        (!names.is_empty()).then(|| names.join(", "))
    }

    /// Returns the command that starts an isolated worker.
    pub fn worker(self, worker: &WorkerProgram, memory_limit_bytes: u64) -> Command {
        if self.namespaces {
            let mut command = namespaces(memory_limit_bytes);
            command.arg(&worker.program).args(&worker.arguments);
            command
        } else {
            let mut command = Command::new(&worker.program);
            command.args(&worker.arguments);
            command
        }
    }

    /// Restricts this thread, and all processes that it starts from now on, to writing in `scratch`.
    ///
    /// # Errors
    /// Error of the operating system.
    pub fn close(self, scratch: &Path) -> std::io::Result<()> {
        if self.landlock { system::write_only_in(scratch) } else { Ok(()) }
    }

    /// Returns the used amount of named shared memory, in bytes; 0 unless it belongs to the worker alone.
    pub fn shared_memory_bytes(self) -> u64 {
        if self.namespaces { system::shared_memory_bytes() } else { 0 }
    }

    /// Removes named shared memory that a program left, if it belongs to the worker alone.
    pub fn clear_shared_memory(self) {
        // Only within namespaces is a worker process 1.
        if !self.namespaces || std::process::id() != 1 {
            return;
        }
        let Ok(entries) = std::fs::read_dir(system::SHARED_MEMORY) else { return };
        for path in entries.filter_map(|entry| Some(entry.ok()?.path())) {
            // Remaining files take memory of later programs.
            let _ = if path.is_dir() { std::fs::remove_dir_all(&path) } else { std::fs::remove_file(&path) };
        }
    }
}

/// Returns the command that precedes that of a worker.
fn namespaces(memory_limit_bytes: u64) -> Command {
    let mut command = Command::new(NAMESPACES[0]);
    command.args(&NAMESPACES[1..]).arg(ENTER).arg("worker").arg(memory_limit_bytes.to_string());
    command
}

/// Returns true if a program runs in namespaces of its own, by trying it once.
fn has_namespaces() -> bool {
    if !system::can_have_namespaces() {
        return false;
    }
    let mut trial = namespaces(1 << 20);
    trial.arg("true").stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    trial.status().is_ok_and(|status| status.success())
}
