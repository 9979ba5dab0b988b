use std::fs::{self, File};
use std::io::Write as _;
use std::path::Path;
use std::process::ExitStatus;

/// Memory of a process, in bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ProcessMemory {
    /// Resident set size.
    pub resident_bytes: u64,
    /// Shared memory within the resident set.
    pub shared_bytes: u64,
    /// Page tables and reserved huge pages, which are not within the resident set.
    pub other_bytes: u64,
    /// Peak of the resident set size, since the start of the process or since [`PeakMemory::begin`].
    pub peak_bytes: u64,
}

/// Meter of the growth of the memory of this process (Linux).
#[derive(Debug)]
pub struct PeakMemory {
    /// File that resets the peak; `None` where the system has none.
    reset: Option<File>,
    begin_bytes: Option<u64>,
}

impl PeakMemory {
    /// Creates the meter. This must precede [`close_to_others`], after which only root opens the file of the meter.
    pub fn new() -> Self {
        let reset = File::options().write(true).open("/proc/self/clear_refs").ok();
        Self { reset, begin_bytes: None }
    }

    /// Begins a measurement: sets the peak to the present resident set size.
    pub fn begin(&mut self) {
        // Source: proc_pid_clear_refs(5), value 5.
        let is_reset = self.reset.as_mut().is_some_and(|file| file.write_all(b"5").is_ok());
        self.begin_bytes = own_memory().filter(|_| is_reset).map(|memory| memory.resident_bytes);
    }

    /// Returns the peak of the resident set since [`Self::begin`] less its size then, in bytes; `None` on systems that cannot
    /// reset the peak.
    pub fn growth_bytes(&self) -> Option<u64> {
        Some(own_memory()?.peak_bytes.saturating_sub(self.begin_bytes?))
    }
}

impl Default for PeakMemory {
    fn default() -> Self {
        Self::new()
    }
}

/// Returns the memory of this process, as [`memory`].
pub fn own_memory() -> Option<ProcessMemory> {
    memory(std::process::id())
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
        other_bytes: ["VmPTE:", "HugetlbPages:"].into_iter().filter_map(bytes).sum(),
        peak_bytes: bytes("VmHWM:").unwrap_or_default(),
    })
}

/// Returns the number of sockets in the network namespace of a process, also of those that are sent between processes; `None`
/// if this process shares the namespace, and on systems other than Linux.
pub fn own_sockets(process: u32) -> Option<u64> {
    let namespace = |process: &str| fs::read_link(format!("/proc/{process}/ns/net")).ok();
    let process = process.to_string();
    if namespace(&process)? == namespace("self")? {
        return None;
    }
    let statistics = fs::read_to_string(format!("/proc/{process}/net/sockstat")).ok()?;
    statistics.lines().find_map(|line| line.strip_prefix("sockets: used ")?.trim().parse().ok())
}

/// Returns the number of open file descriptors of a process; 0 if unknown, and on systems other than Linux.
pub fn open_files(process: u32) -> u64 {
    let folder = format!("/proc/{process}/fd");
    // Since Linux 6.2 the size of the folder is their number (proc_pid_fd(5)).
    match fs::metadata(&folder) {
        Ok(facts) if facts.len() > 0 => facts.len(),
        Ok(_) => fs::read_dir(folder).map_or(0, |files| files.count() as u64),
        Err(_) => 0,
    }
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
            assert_eq!((beginning(this), children(this), open_files(this)), (None, Vec::new(), 0));
            return;
        };
        assert!(memory.resident_bytes > memory.shared_bytes && memory.other_bytes > 0, "{memory:?}");
        assert!(open_files(this) >= 3);
        assert_eq!(beginning(this), beginning(this));
        assert!(beginning(this).is_some());
    }

    #[test]
    fn the_peak_of_a_measurement_is_that_of_the_time_since_its_begin() {
        const HELD: usize = 64 << 20;
        let mut meter = PeakMemory::new();
        // Memory that was released before the measurement does not count.
        drop(std::hint::black_box(vec![1_u8; 2 * HELD]));
        meter.begin();
        let Some(before) = meter.growth_bytes() else { return };
        assert!(before < HELD as u64 / 2, "{before}");
        drop(std::hint::black_box(vec![1_u8; HELD]));
        let growth = meter.growth_bytes().expect("a peak");
        assert!(growth >= HELD as u64 * 9 / 10 && growth < 3 * HELD as u64 / 2, "{growth}");
        meter.begin();
        assert!(meter.growth_bytes().is_some_and(|growth| growth < HELD as u64 / 2));
    }
}
