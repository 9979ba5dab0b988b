//! Processes with all that they start, as far as the system lets one know them.

use std::collections::BTreeMap;
use std::fs;
use std::process::Command;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use crate::sandbox::Walls;

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

    /// Ends the group that is held, if one is, and all that a worker has started.
    pub fn kill(&self) {
        if let Some(leader) = *self.leader.lock().unwrap_or_else(PoisonError::into_inner) {
            kill(leader);
        }
        end_descendants();
    }
}

/// Whether this process adopts what its children leave behind, and ends it.
static IS_ADOPTING: AtomicBool = AtomicBool::new(false);

/// Closes this process to others of the same user, those of root excepted (Linux): what it has open, the results of a
/// campaign among them, cannot be reached through `/proc`.
pub fn close_to_others() {
    #[cfg(target_os = "linux")]
    {
        use rustix::process::{DumpableBehavior, set_dumpable_behavior};
        // An old kernel may refuse; then it is as it was.
        let _ = set_dumpable_behavior(DumpableBehavior::NotDumpable);
    }
}

/// Makes this process, a worker, the one to which processes fall that its children start and leave behind, however often
/// they fork (a subreaper, Linux): nothing that a program starts outlives its trial.
pub fn adopt() {
    #[cfg(target_os = "linux")]
    {
        use rustix::process::{getpid, set_child_subreaper};
        IS_ADOPTING.store(set_child_subreaper(Some(getpid())).is_ok(), Ordering::Relaxed);
    }
}

/// Ends all that a worker has started, and what that has started, until nothing is left of it.
pub fn end_descendants() {
    /// Who forks faster than they are ended is left after so long.
    const PATIENCE: Duration = Duration::from_secs(2);
    if !IS_ADOPTING.load(Ordering::Relaxed) {
        return;
    }
    let begin = Instant::now();
    let mut family = Family::of(std::process::id());
    while family.end() && begin.elapsed() < PATIENCE {
        thread::sleep(Duration::from_millis(1));
    }
}

/// What a process started, however often it forked, as far as the system tells (Linux): what was once seen to belong to it
/// is known even after those between have ended.
#[derive(Clone, Debug)]
pub struct Family {
    root: u32,
    /// Everybody that was seen, by process id, and when it began: ids are used again.
    seen: BTreeMap<u32, u64>,
}

impl Family {
    /// That of `root`, which does not belong to it itself.
    pub fn of(root: u32) -> Self {
        Self { root, seen: BTreeMap::new() }
    }

    /// That of a worker with a program of others: whatever the worker has adopted belongs to it.
    pub fn of_program(program: u32) -> Self {
        Self::of(if IS_ADOPTING.load(Ordering::Relaxed) { std::process::id() } else { program })
    }

    /// Looks who belongs to it now; the memory that they hold, in bytes, with shared memory that nobody of them has mapped
    /// where that can be only theirs.
    pub fn look(&mut self, walls: Walls) -> u64 {
        let (mut bytes, mut shared_bytes) = (0, 0);
        self.seen.retain(|process, began| beginning(*process) == Some(*began));
        let mut left: Vec<u32> = self.seen.keys().copied().chain([self.root]).collect();
        let mut counted = Vec::new();
        while let Some(process) = left.pop() {
            if counted.contains(&process) {
                continue;
            }
            counted.push(process);
            left.extend(children(process));
            if let Some(began) = beginning(process).filter(|_| process != self.root) {
                self.seen.insert(process, began);
                let status = fs::read_to_string(format!("/proc/{process}/status")).unwrap_or_default();
                bytes += bytes_in(&status, "VmRSS:").unwrap_or(0);
                shared_bytes += bytes_in(&status, "RssShmem:").unwrap_or(0);
            }
        }
        bytes + walls.shared_memory_bytes().saturating_sub(shared_bytes)
    }

    /// Ends all of them; whether anybody was there.
    pub fn end(&mut self) -> bool {
        self.look(Walls::default());
        for process in self.seen.keys() {
            signal_kill(*process);
        }
        reap();
        !self.seen.is_empty()
    }
}

/// When a process began, in ticks since the machine did; nothing for one that has ended.
fn beginning(process: u32) -> Option<u64> {
    let stat = fs::read_to_string(format!("/proc/{process}/stat")).ok()?;
    // The name, in parentheses, may hold anything.
    let (_, fields) = stat.rsplit_once(") ")?;
    let mut fields = fields.split_whitespace();
    let is_gone = matches!(fields.next(), Some("Z" | "X"));
    fields.nth(18).filter(|_| !is_gone)?.parse().ok()
}

/// The children of all threads of a process.
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

fn signal_kill(process: u32) {
    #[cfg(unix)]
    if let Some(process) = i32::try_from(process).ok().and_then(rustix::process::Pid::from_raw) {
        // That it is gone already is what is wanted.
        let _ = rustix::process::kill_process(process, rustix::process::Signal::KILL);
    }
    #[cfg(not(unix))]
    let _ = process;
}

/// Takes note of the end of processes that were adopted; without that they stay as names.
fn reap() {
    #[cfg(unix)]
    if IS_ADOPTING.load(Ordering::Relaxed) {
        while let Ok(Some(_)) = rustix::process::wait(rustix::process::WaitOptions::NOHANG) {}
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
    bytes_in(&fs::read_to_string(format!("/proc/{process}/status")).ok()?, "VmRSS:")
}

/// An amount of memory in the status of a process, in bytes.
fn bytes_in(status: &str, name: &str) -> Option<u64> {
    let line = status.lines().find_map(|line| line.strip_prefix(name))?;
    let kibibytes: u64 = line.trim().trim_end_matches("kB").trim().parse().ok()?;
    Some(kibibytes * 1024)
}

/// Whether somebody ended a process by a signal that nobody sends itself.
pub fn is_killed(status: std::process::ExitStatus) -> bool {
    #[cfg(unix)]
    {
        use rustix::process::Signal;
        let signal = std::os::unix::process::ExitStatusExt::signal(&status);
        signal.is_some_and(|signal| {
            [Signal::KILL, Signal::TERM, Signal::HUP].iter().any(|sent| sent.as_raw() == signal)
        })
    }
    #[cfg(not(unix))]
    {
        let _ = status;
        false
    }
}

/// How a process ended, in a few words.
pub fn ending(status: std::process::ExitStatus) -> String {
    #[cfg(unix)]
    if let Some(signal) = std::os::unix::process::ExitStatusExt::signal(&status) {
        return format!("ended by signal {signal}");
    }
    status.code().map_or_else(|| "ended".to_owned(), |code| format!("ended with exit code {code}"))
}
