//! Isolation of external programs, by mechanisms of the kernel (Linux).

use std::process::Command;

use cranny_file::system::installed_command;
use serde::{Deserialize, Serialize};
use strum::{EnumString, IntoStaticStr, VariantArray};

use crate::WorkerProgram;

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

/// Isolation mechanisms of external programs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Isolation {
    /// True if a program can write only in its own folder and to devices, and can neither stop nor inspect a process that it
    /// did not start (Landlock; signals from Linux 6.12 on).
    pub landlock: bool,
    /// True if each trial has its own processes, shared memory, network and read-only view of the file systems, sees no others,
    /// and ends with all its processes (user, PID, IPC, network and mount namespaces).
    pub namespaces: bool,
    /// True if system calls are denied that would leave memory or keys behind, or type into a terminal (seccomp).
    pub call_filter: bool,
}

/// Command that creates the namespaces of a trial, with tools of util-linux: a process that makes a PID namespace is not in it
/// itself. It ends with the worker, and everything within ends with it.
const NAMESPACES: [&str; 14] = [
    "setpriv",
    "--pdeathsig",
    "KILL",
    "--",
    "unshare",
    "--user",
    "--map-root-user",
    "--mount",
    "--ipc",
    "--pid",
    "--net",
    "--fork",
    "--kill-child",
    "--mount-proc",
];

impl Isolation {
    /// Returns the names of the mechanisms in results; `None` if there are none.
    pub fn text(self) -> Option<String> {
        let names =
            [(self.landlock, "Landlock"), (self.namespaces, "namespaces"), (self.call_filter, "call filter")];
        let names: Vec<&str> =
            names.iter().filter(|(is_there, _)| *is_there).map(|(_, name)| *name).collect();
        (!names.is_empty()).then(|| names.join(", "))
    }

    /// Returns the command of a process that encloses a program.
    ///
    /// # Errors
    /// [`std::io::ErrorKind::NotFound`] if a tool is not installed.
    pub fn command(self, worker: &WorkerProgram) -> std::io::Result<Command> {
        let mut command = if self.namespaces {
            let mut command = installed_command(NAMESPACES[0])?;
            command.args(&NAMESPACES[1..]).arg(&worker.program);
            command
        } else {
            Command::new(&worker.program)
        };
        command.args(&worker.arguments);
        Ok(command)
    }
}
