//! Walls around the programs of others, made of what the kernel offers (Linux).

use std::path::Path;
use std::process::{Command, Stdio};

use cranny_file::system;
use serde::{Deserialize, Serialize};
use strum::{EnumString, IntoStaticStr, VariantArray};

use crate::{BenchError, WorkerProgram};

/// Whether the programs of others run within walls.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, EnumString, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "kebab-case")]
pub enum Sandbox {
    /// Within those that this machine has.
    #[default]
    Auto,
    /// Free, as the user who began the campaign.
    Off,
    /// Within all of them, or not at all.
    Require,
}

impl Sandbox {
    /// What flags call it.
    pub fn name(self) -> &'static str {
        self.into()
    }
}

/// The walls around a worker and the programs that it runs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Walls {
    /// A program writes nowhere but in its own folder, and neither stops nor looks into a process that it did not start
    /// (Landlock; signals from Linux 6.12 on).
    pub landlock: bool,
    /// A worker has processes, shared memory and `/dev/shm` of its own, sees no others, and takes all with it when it
    /// ends (user, PID, IPC and mount namespaces).
    pub namespaces: bool,
}

/// What goes before a worker to put it into namespaces of its own: the tools of util-linux, since a process that makes a
/// PID namespace is not in it itself.
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

/// The first thing that runs there: it gives away all rights that come with a user namespace.
const ENTER: &str = "mount -t tmpfs -o \"size=$1\" cranny /dev/shm && shift && \
    exec setpriv --bounding-set -all --inh-caps -all --no-new-privs -- \"$@\"";

impl Walls {
    /// The walls that are wished for, as far as this machine has them.
    ///
    /// # Errors
    /// [`BenchError::NoSandbox`] where all are required and one is missing.
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

    /// What results call them; nothing where there are none.
    pub fn text(self) -> Option<String> {
        let names = [(self.landlock, "Landlock"), (self.namespaces, "namespaces")];
        let names: Vec<&str> =
            names.iter().filter(|(is_there, _)| *is_there).map(|(_, name)| *name).collect();
        (!names.is_empty()).then(|| names.join(", "))
    }

    /// The command that starts a worker within them.
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

    /// Lets this thread, and all processes that it starts from now on, write in `scratch` alone.
    ///
    /// # Errors
    /// What the system says.
    pub fn close(self, scratch: &Path) -> std::io::Result<()> {
        if self.landlock { system::write_only_in(scratch) } else { Ok(()) }
    }

    /// How much of shared memory by name is in use, in bytes; only where it is the worker's own.
    pub fn shared_memory_bytes(self) -> u64 {
        if self.namespaces { system::shared_memory_bytes() } else { 0 }
    }

    /// Removes what a program left in shared memory by name, where that is the worker's own.
    pub fn clear_shared_memory(self) {
        // Only within namespaces a worker is the first process.
        if !self.namespaces || std::process::id() != 1 {
            return;
        }
        let Ok(entries) = std::fs::read_dir(system::SHARED_MEMORY) else { return };
        for path in entries.filter_map(|entry| Some(entry.ok()?.path())) {
            // What stays takes memory of the programs that come after.
            let _ = if path.is_dir() { std::fs::remove_dir_all(&path) } else { std::fs::remove_file(&path) };
        }
    }
}

/// What goes before the command of a worker.
fn namespaces(memory_limit_bytes: u64) -> Command {
    let mut command = Command::new(NAMESPACES[0]);
    command.args(&NAMESPACES[1..]).arg(ENTER).arg("worker").arg(memory_limit_bytes.to_string());
    command
}

/// Whether a program can be run in namespaces of its own: tried once.
fn has_namespaces() -> bool {
    if !system::can_have_namespaces() {
        return false;
    }
    let mut trial = namespaces(1 << 20);
    trial.arg("true").stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    trial.status().is_ok_and(|status| status.success())
}
