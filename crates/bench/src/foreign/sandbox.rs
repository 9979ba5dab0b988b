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
    /// True if each trial has its own processes, shared memory, network, scratch folder in memory and read-only view of the other
    /// file systems, sees no others, and ends with all its processes (user, PID, IPC, network and mount namespaces).
    pub namespaces: bool,
    /// True if system calls are denied that would leave memory or keys behind, type into a terminal, delay others or take more
    /// than one share of the processors (seccomp).
    pub call_filter: bool,
}

/// Isolation mechanism.
struct Mechanism {
    is_there: fn(&Isolation) -> bool,
    name: &'static str,
    /// Description for a machine that lacks it.
    requirement: &'static str,
    /// Actions that it alone prevents, after "an external program can".
    danger: &'static str,
}

const MECHANISMS: [Mechanism; 3] = [
    Mechanism {
        is_there: |isolation| isolation.landlock,
        name: "Landlock",
        requirement: "Landlock (Linux 5.13 or newer, with it switched on)",
        danger: "write to any device and, without namespaces, to any file of this user, and stop processes",
    },
    Mechanism {
        is_there: |isolation| isolation.namespaces,
        name: "namespaces",
        requirement: "namespaces (user namespaces allowed to this user, and `unshare` and `setpriv` of util-linux)",
        danger: "see, slow down and limit other processes, read results and other trials, leave notes for its next trial (shared \
                 memory, queues, modes and times of files), use the network and the services of this machine, and fill the disk \
                 in files that it has deleted",
    },
    Mechanism {
        is_there: |isolation| isolation.call_filter,
        name: "call filter",
        requirement: "filter of system calls (seccomp)",
        danger: "leave keys in the kernel, hold memory that is not counted, delay those who open a file, and take many shares of \
                 the processors",
    },
];

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
        let there = MECHANISMS.iter().filter(|mechanism| (mechanism.is_there)(&self));
        let names: Vec<&str> = there.map(|mechanism| mechanism.name).collect();
        (!names.is_empty()).then(|| names.join(", "))
    }

    /// Returns the description of the first missing mechanism.
    pub(crate) fn first_missing(self) -> Option<&'static str> {
        self.missing().next().map(|mechanism| mechanism.requirement)
    }

    /// Describes the missing mechanisms, and what a program can do without them; `None` if there are all.
    pub(crate) fn weakness(self) -> Option<String> {
        let sentences = self.missing().map(|mechanism| {
            format!(
                "this machine has no {}: an external program can {}",
                mechanism.requirement, mechanism.danger
            )
        });
        let sentences: Vec<String> = sentences.collect();
        (!sentences.is_empty()).then(|| format!("{} (--sandbox require refuses this)", sentences.join("; ")))
    }

    fn missing(self) -> impl Iterator<Item = &'static Mechanism> {
        MECHANISMS.iter().filter(move |mechanism| !(mechanism.is_there)(&self))
    }

    /// Returns true if results state that programs ran in namespaces.
    pub(crate) fn text_has_namespaces(text: Option<&str>) -> bool {
        text.is_some_and(|text| text.split(", ").any(|name| name == MECHANISMS[1].name))
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
