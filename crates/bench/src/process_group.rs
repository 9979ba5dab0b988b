//! Processes with all that they start, as far as the system lets one know them.

use std::fs;
use std::process::Command;
use std::sync::{Arc, Mutex, PoisonError};

/// The program of others that is running just now, for whoever must end it.
#[derive(Clone, Debug, Default)]
pub struct Leash {
    leader: Arc<Mutex<Option<u32>>>,
}

impl Leash {
    /// Holds the group of `leader`, or nothing.
    pub fn hold(&self, leader: Option<u32>) {
        *self.leader.lock().unwrap_or_else(PoisonError::into_inner) = leader;
    }

    /// Ends the group that is held, if one is.
    pub fn kill(&self) {
        if let Some(leader) = *self.leader.lock().unwrap_or_else(PoisonError::into_inner) {
            kill(leader);
        }
    }
}

/// Lets a command lead a group of its own: Ctrl-C at the terminal does not reach it, and [`kill`] reaches all that
/// it starts.
pub fn lead(command: &mut Command) -> &mut Command {
    #[cfg(unix)]
    std::os::unix::process::CommandExt::process_group(command, 0);
    command
}

/// Ends all processes of the group of `leader`.
pub fn kill(leader: u32) {
    #[cfg(unix)]
    if let Some(group) = i32::try_from(leader).ok().and_then(rustix::process::Pid::from_raw) {
        // That it is gone already is what is wanted.
        let _ = rustix::process::kill_process_group(group, rustix::process::Signal::KILL);
    }
    #[cfg(not(unix))]
    let _ = leader;
}

/// The memory that a process holds (its resident set), in bytes; `None` where nobody tells.
pub fn resident_bytes(process: u32) -> Option<u64> {
    let status = fs::read_to_string(format!("/proc/{process}/status")).ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"))?;
    let kibibytes: u64 = line.trim().trim_end_matches("kB").trim().parse().ok()?;
    Some(kibibytes * 1024)
}

/// The same of a process and all that it started, as far as they are still its children.
pub fn resident_bytes_of_family(process: u32) -> Option<u64> {
    let own = resident_bytes(process)?;
    let children = fs::read_to_string(format!("/proc/{process}/task/{process}/children")).unwrap_or_default();
    let children = children.split_whitespace().filter_map(|child| child.parse().ok());
    Some(own + children.filter_map(resident_bytes_of_family).sum::<u64>())
}

/// How a process ended, in a few words.
pub fn ending(status: std::process::ExitStatus) -> String {
    #[cfg(unix)]
    if let Some(signal) = std::os::unix::process::ExitStatusExt::signal(&status) {
        return format!("ended by signal {signal}");
    }
    status.code().map_or_else(|| "ended".to_owned(), |code| format!("ended with exit code {code}"))
}
