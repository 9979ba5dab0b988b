//! Processes with all that they start, as far as the system lets one know them.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use cranny_file::system;

use crate::foreign::sandbox::Walls;

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
            system::kill_group(leader);
        }
        end_descendants();
    }
}

/// Whether this process adopts what its children leave behind, and ends it.
static IS_ADOPTING: AtomicBool = AtomicBool::new(false);

/// Makes this process, a worker, the one to which processes fall that its children start and leave behind, however often
/// they fork (a subreaper, Linux): nothing that a program starts outlives its trial.
pub fn adopt() {
    IS_ADOPTING.store(system::adopt_orphans(), Ordering::Relaxed);
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

    /// Ends all of them; whether anybody was there.
    pub fn end(&mut self) -> bool {
        self.look(Walls::default());
        for process in self.seen.keys() {
            system::kill_process(*process);
        }
        if IS_ADOPTING.load(Ordering::Relaxed) {
            system::reap();
        }
        !self.seen.is_empty()
    }
}
