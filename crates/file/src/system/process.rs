use std::fs;
use std::path::Path;
use std::process::ExitStatus;

/// Memory of a process, in bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ProcessMemory {
    /// Resident set size.
    pub resident_bytes: u64,
    /// Named shared memory within the resident set.
    pub shared_bytes: u64,
}

/// Protects this process (Linux): other processes of the same user, except root, cannot reach its open files through `/proc`.
pub fn close_to_others() {
    #[cfg(target_os = "linux")]
    {
        use rustix::process::{DumpableBehavior, set_dumpable_behavior};
        // An old kernel may refuse; then nothing changes.
        let _ = set_dumpable_behavior(DumpableBehavior::NotDumpable);
    }
}

/// Makes this process the parent of orphaned descendants (a subreaper, Linux); returns true if it now is.
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

/// Reaps all children that have ended, including those of [`adopt_orphans`]; otherwise they stay as zombies. No other code in
/// this process may be waiting for one of them.
pub fn reap() {
    #[cfg(unix)]
    while let Ok(Some(_)) = rustix::process::wait(rustix::process::WaitOptions::NOHANG) {}
}

/// Returns the start time of a process, in ticks since the machine started; `None` for a process of which all threads have
/// ended, and on systems other than Linux.
pub fn beginning(process: u32) -> Option<u64> {
    let stat = fs::read_to_string(format!("/proc/{process}/stat")).ok()?;
    // The name, in parentheses, may contain any character.
    let (_, fields) = stat.rsplit_once(") ")?;
    let mut fields = fields.split_whitespace();
    let is_gone = matches!(fields.next(), Some("Z" | "X"));
    let began = fields.nth(18)?.parse().ok();
    // The first thread of a process may end before the others; it then looks like a process that has ended.
    if is_gone && thread_memory(process).is_none() { None } else { began }
}

/// Returns the memory of a process by one of its threads that has not ended; `None` if there is none.
fn thread_memory(process: u32) -> Option<ProcessMemory> {
    let threads = fs::read_dir(format!("/proc/{process}/task")).ok()?;
    threads.flatten().find_map(|thread| memory_in(&thread.path().join("status")))
}

/// Returns the children of all threads of a process; empty on systems other than Linux.
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

/// Returns the memory of a process; `None` for a process that has ended, and on systems other than Linux.
pub fn memory(process: u32) -> Option<ProcessMemory> {
    memory_in(Path::new(&format!("/proc/{process}/status"))).or_else(|| thread_memory(process))
}

/// Reads the memory in a status file, which has none after the end of its process or thread.
fn memory_in(status: &Path) -> Option<ProcessMemory> {
    let status = fs::read_to_string(status).ok()?;
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

/// Ends all processes of the group of `leader` (Unix). Elsewhere it does nothing: the process that started the leader ends it.
pub fn kill_group(leader: u32) {
    #[cfg(unix)]
    if let Some(group) = unix_id(leader) {
        // The group may have ended already, which is no error.
        let _ = rustix::process::kill_process_group(group, rustix::process::Signal::KILL);
    }
    #[cfg(not(unix))]
    let _ = leader;
}

/// Ends one process (Unix). Elsewhere it does nothing: process ids are unknown there, see [`children`].
pub fn kill_process(process: u32) {
    #[cfg(unix)]
    send(process, rustix::process::Signal::KILL);
    #[cfg(not(unix))]
    let _ = process;
}

/// Stops one process, until it is ended (Unix): it starts no other process meanwhile.
pub fn stop_process(process: u32) {
    #[cfg(unix)]
    send(process, rustix::process::Signal::STOP);
    #[cfg(not(unix))]
    let _ = process;
}

#[cfg(unix)]
fn send(process: u32, signal: rustix::process::Signal) {
    if let Some(process) = unix_id(process) {
        // The process may have ended already.
        let _ = rustix::process::kill_process(process, signal);
    }
}

#[cfg(unix)]
fn unix_id(process: u32) -> Option<rustix::process::Pid> {
    i32::try_from(process).ok().and_then(rustix::process::Pid::from_raw)
}

/// Returns true if a process was ended by a signal that comes from outside it (Unix).
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

/// Describes how a process ended, in a few words.
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
            // This system does not report memory; then the other functions must not return anything either.
            assert_eq!((beginning(this), children(this)), (None, Vec::new()));
            return;
        };
        assert!(memory.resident_bytes > memory.shared_bytes, "{memory:?}");
        assert_eq!(beginning(this), beginning(this));
        assert!(beginning(this).is_some());
    }
}
