//! Tracking of processes with their descendants, within the limits of the operating system.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use cranny_file::system;

/// Handle for ending the external program that is running.
#[derive(Clone, Debug, Default)]
pub struct Leash {
    enclosing: Arc<Mutex<Vec<u32>>>,
}

impl Leash {
    /// Sets the processes that enclose a program, the innermost last, or clears them.
    pub fn attach(&self, enclosing: Vec<u32>) {
        *self.enclosing.lock().unwrap_or_else(PoisonError::into_inner) = enclosing;
    }

    /// Ends the program, if there is one. A PID namespace ends with the process that encloses the program.
    pub fn end(&self) {
        for process in self.enclosing.lock().unwrap_or_else(PoisonError::into_inner).iter().rev() {
            system::kill_group(*process);
            system::kill_process(*process);
        }
    }

    /// Ends the program, if there is one, and all descendants of a worker.
    pub fn kill(&self) {
        self.end();
        end_descendants();
    }
}

/// True if this process adopts and ends orphans of its children.
static IS_ADOPTING: AtomicBool = AtomicBool::new(false);

/// Makes this process, a worker, the adopter of all orphaned descendants, however often they fork (a subreaper, Linux): no
/// child of a program outlives its trial.
pub fn adopt() {
    IS_ADOPTING.store(system::adopt_orphans(), Ordering::Relaxed);
}

/// Time limit against processes that fork faster than they are ended.
const PATIENCE: Duration = Duration::from_secs(10);

/// Ends all descendants of a worker until none is left.
pub fn end_descendants() {
    if !IS_ADOPTING.load(Ordering::Relaxed) {
        return;
    }
    let begin = Instant::now();
    let mut family = Family::of(std::process::id());
    while family.end() && begin.elapsed() < PATIENCE {
        thread::sleep(Duration::from_millis(1));
    }
}

/// Descendants of a process, however often it forked, as far as the system reveals them (Linux). A process once observed
/// remains known after the intermediate processes have ended.
#[derive(Clone, Debug)]
pub struct Family {
    root: u32,
    /// Processes between the root and an external program.
    enclosing: Vec<u32>,
    /// Observed processes by process id, with their start times, because ids are reused.
    seen: BTreeMap<u32, u64>,
}

/// Number of processes of a family, and their memory.
#[derive(Clone, Copy, Debug, Default)]
pub struct Census {
    pub processes: usize,
    /// Memory without shared memory, with page tables and sockets beyond [`FREE_SOCKETS`].
    pub bytes: u64,
    /// Resident shared memory.
    pub shared_bytes: u64,
}

/// Number of sockets whose memory does not count, and memory of each further one: the default size of its buffer, which belongs
/// to no process.
const FREE_SOCKETS: u64 = 512;
const SOCKET_BYTES: u64 = 208 << 10;

/// Number of open files that may be sockets, where a program shares the sockets of the machine.
const FREE_FILES: u64 = 2048;

impl Family {
    /// Creates the family of `root`, which is not a member itself.
    pub fn of(root: u32) -> Self {
        Self { root, enclosing: Vec::new(), seen: BTreeMap::new() }
    }

    /// Creates the family of an external program in a worker: all descendants of the worker, which adopts orphans, apart from
    /// the processes that enclose the program.
    pub fn of_program(enclosing: &[u32]) -> Self {
        let adopter = IS_ADOPTING.load(Ordering::Relaxed).then(std::process::id);
        let root = adopter.or_else(|| enclosing.last().copied()).unwrap_or_default();
        Self { enclosing: enclosing.to_vec(), ..Self::of(root) }
    }

    /// Updates the members and counts those that do not enclose a program.
    pub fn count(&mut self) -> Census {
        let mut census = Census::default();
        let (mut files, mut sockets) = (0_u64, None);
        self.seen.retain(|process, began| system::beginning(*process) == Some(*began));
        let mut left: Vec<u32> = self.seen.keys().copied().chain([self.root]).collect();
        let mut counted = BTreeSet::new();
        while let Some(process) = left.pop() {
            if !counted.insert(process) {
                continue;
            }
            left.extend(system::children(process));
            if let Some(began) = system::beginning(process).filter(|_| process != self.root) {
                self.seen.insert(process, began);
                if !self.enclosing.contains(&process) {
                    let memory = system::memory(process).unwrap_or_default();
                    census.bytes +=
                        memory.resident_bytes.saturating_sub(memory.shared_bytes) + memory.other_bytes;
                    census.shared_bytes += memory.shared_bytes;
                    census.processes += 1;
                    files += system::open_files(process);
                    sockets = sockets.or_else(|| system::own_sockets(process));
                }
            }
        }
        let beyond = sockets.map_or(files.saturating_sub(FREE_FILES), |own| own.saturating_sub(FREE_SOCKETS));
        census.bytes += beyond.saturating_mul(SOCKET_BYTES);
        census
    }

    /// Ends all members and returns true if there were any. Each is stopped and ended as soon as it is found: a process that
    /// replaces itself by its child lives for a millisecond.
    pub fn end(&mut self) -> bool {
        self.seen.retain(|process, began| system::beginning(*process) == Some(*began));
        let mut left: Vec<u32> = system::children(self.root);
        left.extend(self.seen.keys());
        let mut ended = BTreeSet::new();
        while let Some(process) = left.pop() {
            if ended.insert(process) {
                system::stop_process(process);
                left.extend(system::children(process));
                system::kill_process(process);
            }
        }
        if IS_ADOPTING.load(Ordering::Relaxed) {
            system::reap();
        }
        !ended.is_empty()
    }
}
