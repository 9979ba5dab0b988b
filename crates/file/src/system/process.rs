use std::fs;
use std::process::{Command, ExitStatus};

/// What a process holds, in bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ProcessMemory {
    /// Its resident set.
    pub resident_bytes: u64,
    /// What of that it shares with others by name.
    pub shared_bytes: u64,
}

/// Closes this process to others of the same user, those of root excepted (Linux): what it has open cannot be reached
/// through `/proc`.
pub fn close_to_others() {
    #[cfg(target_os = "linux")]
    {
        use rustix::process::{DumpableBehavior, set_dumpable_behavior};
        // An old kernel may refuse; then it is as it was.
        let _ = set_dumpable_behavior(DumpableBehavior::NotDumpable);
    }
}

/// Makes this process the one to which processes fall that its children start and leave behind (a subreaper, Linux);
/// whether it is that now.
pub fn adopt_orphans() -> bool {
    #[cfg(target_os = "linux")]
    let is_adopting = {
        use rustix::process::{getpid, set_child_subreaper};
        set_child_subreaper(Some(getpid())).is_ok()
    };
    #[cfg(not(target_os = "linux"))]
    let is_adopting = false;
    is_adopting
}

/// Takes note of the end of all children that have ended, those of [`adopt_orphans`] among them; without that they stay as
/// names. Nobody else in this process may be waiting for one of them.
pub fn reap() {
    #[cfg(unix)]
    while let Ok(Some(_)) = rustix::process::wait(rustix::process::WaitOptions::NOHANG) {}
}

/// When a process began, in ticks since the machine did; nothing for one that has ended, and where nobody tells (Linux
/// does).
pub fn beginning(process: u32) -> Option<u64> {
    let stat = fs::read_to_string(format!("/proc/{process}/stat")).ok()?;
    // The name, in parentheses, may hold anything.
    let (_, fields) = stat.rsplit_once(") ")?;
    let mut fields = fields.split_whitespace();
    let is_gone = matches!(fields.next(), Some("Z" | "X"));
    fields.nth(18).filter(|_| !is_gone)?.parse().ok()
}

/// The children of all threads of a process; none where nobody tells (Linux does).
pub fn children(process: u32) -> Vec<u32> {
    let Ok(threads) = fs::read_dir(format!("/proc/{process}/task")) else { return Vec::new() };
    let threads = threads.filter_map(|thread| Some(thread.ok()?.file_name()));
    let list = |thread: std::ffi::OsString| {
        fs::read_to_string(format!("/proc/{process}/task/{}/children", thread.display())).unwrap_or_default()
    };
    let numbers =
        |list: String| list.split_whitespace().filter_map(|child| child.parse().ok()).collect::<Vec<_>>();
    threads.map(list).flat_map(numbers).collect()
}

/// The memory that a process holds; nothing for one that has ended, and where nobody tells (Linux does).
pub fn memory(process: u32) -> Option<ProcessMemory> {
    let status = fs::read_to_string(format!("/proc/{process}/status")).ok()?;
    let bytes = |name: &str| -> Option<u64> {
        let line = status.lines().find_map(|line| line.strip_prefix(name))?;
        let kibibytes: u64 = line.trim().trim_end_matches("kB").trim().parse().ok()?;
        Some(kibibytes * 1024)
    };
    Some(ProcessMemory {
        resident_bytes: bytes("VmRSS:")?,
        shared_bytes: bytes("RssShmem:").unwrap_or_default(),
    })
}

/// Lets a command lead a group of its own (Unix): Ctrl-C at the terminal does not reach it, and [`kill_group`] reaches
/// all that it starts and leaves in the group.
pub fn lead_group(command: &mut Command) -> &mut Command {
    #[cfg(unix)]
    std::os::unix::process::CommandExt::process_group(command, 0);
    command
}

/// Ends all processes of the group of `leader` (Unix). Elsewhere nothing happens: whoever started the leader ends it.
pub fn kill_group(leader: u32) {
    #[cfg(unix)]
    if let Some(group) = unix_id(leader) {
        // That it is gone already is what is wanted.
        let _ = rustix::process::kill_process_group(group, rustix::process::Signal::KILL);
    }
    #[cfg(not(unix))]
    let _ = leader;
}

/// Ends one process (Unix); elsewhere none is known by its number, see [`children`].
pub fn kill_process(process: u32) {
    #[cfg(unix)]
    if let Some(process) = unix_id(process) {
        // As for a group.
        let _ = rustix::process::kill_process(process, rustix::process::Signal::KILL);
    }
    #[cfg(not(unix))]
    let _ = process;
}

#[cfg(unix)]
fn unix_id(process: u32) -> Option<rustix::process::Pid> {
    i32::try_from(process).ok().and_then(rustix::process::Pid::from_raw)
}

/// Whether somebody ended a process by a signal that nobody sends itself (Unix).
pub fn is_killed(status: ExitStatus) -> bool {
    #[cfg(unix)]
    let is_killed = {
        use rustix::process::Signal;
        let signal = std::os::unix::process::ExitStatusExt::signal(&status);
        signal.is_some_and(|signal| {
            [Signal::KILL, Signal::TERM, Signal::HUP].iter().any(|sent| sent.as_raw() == signal)
        })
    };
    #[cfg(not(unix))]
    let is_killed = {
        let _ = status;
        false
    };
    is_killed
}

/// How a process ended, in a few words.
pub fn ending(status: ExitStatus) -> String {
    #[cfg(unix)]
    if let Some(signal) = std::os::unix::process::ExitStatusExt::signal(&status) {
        return format!("ended by signal {signal}");
    }
    status.code().map_or_else(|| "ended".to_owned(), |code| format!("ended with exit code {code}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_known_of_this_process_holds_together() {
        let this = std::process::id();
        let Some(memory) = memory(this) else {
            // Nobody tells here; then nothing is made up.
            assert_eq!((beginning(this), children(this)), (None, Vec::new()));
            return;
        };
        assert!(memory.resident_bytes > memory.shared_bytes, "{memory:?}");
        assert_eq!(beginning(this), beginning(this));
        assert!(beginning(this).is_some());
    }
}
