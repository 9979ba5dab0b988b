//! Tracking of processes with their descendants, within the limits of the operating system.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use cranny_file::system;

use crate::foreign::sandbox::Isolation;

/// Handle for ending the external program that is running.
#[derive(Clone, Debug, Default)]
pub struct Leash {
    leader: Arc<Mutex<Option<u32>>>,
}

impl Leash {
    /// Sets the process group by its `leader`, or clears it.
    pub fn hold(&self, leader: Option<u32>) {
        *self.leader.lock().unwrap_or_else(PoisonError::into_inner) = leader;
    }

    /// Ends the process group, if there is one, and all descendants of a worker.
    pub fn kill(&self) {
        if let Some(leader) = *self.leader.lock().unwrap_or_else(PoisonError::into_inner) {
            system::kill_group(leader);
        }
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

/// Ends all descendants of a worker until none is left.
pub fn end_descendants() {
    /// Time limit against processes that fork faster than they are ended.
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

/// Descendants of a process, however often it forked, as far as the system reveals them (Linux). A process once observed
/// remains known after the intermediate processes have ended.
#[derive(Clone, Debug)]
pub struct Family {
    root: u32,
    /// Observed processes by process id, with their start times, because ids are reused.
    seen: BTreeMap<u32, u64>,
}

impl Family {
    /// Creates the family of `root`, which is not a member itself.
    pub fn of(root: u32) -> Self {
        Self { root, seen: BTreeMap::new() }
    }

    /// Creates the family of an external program in a worker: all orphans adopted by the worker are members.
    pub fn of_program(program: u32) -> Self {
        Self::of(if IS_ADOPTING.load(Ordering::Relaxed) { std::process::id() } else { program })
    }

    /// Updates the members and returns their memory, in bytes, with unmapped shared memory if only this family can own it.
    pub fn look(&mut self, walls: Isolation) -> u64 {
        let (mut bytes, mut shared_bytes) = (0, 0);
        self.seen.retain(|process, began| system::beginning(*process) == Some(*began));
        let mut left: Vec<u32> = self.seen.keys().copied().chain([self.root]).collect();
        let mut counted = Vec::new();
        while let Some(process) = left.pop() {
            if counted.contains(&process) {
                continue;
            }
            counted.push(process);
            left.extend(system::children(process));
            if let Some(began) = system::beginning(process).filter(|_| process != self.root) {
                self.seen.insert(process, began);
                let memory = system::memory(process).unwrap_or_default();
                bytes += memory.resident_bytes;
                shared_bytes += memory.shared_bytes;
            }
        }
        bytes + walls.shared_memory_bytes().saturating_sub(shared_bytes)
    }

    /// Ends all members and returns true if there were any.
    pub fn end(&mut self) -> bool {
        self.look(Isolation::default());
        for process in self.seen.keys() {
            system::kill_process(*process);
        }
        if IS_ADOPTING.load(Ordering::Relaxed) {
            system::reap();
        }
        !self.seen.is_empty()
    }
}
