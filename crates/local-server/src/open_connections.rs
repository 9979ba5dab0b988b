use std::collections::BTreeMap;
use std::sync::{Mutex, MutexGuard, PoisonError};

use tokio::task::AbortHandle;

/// Open connections of a server, up to a maximum. Beyond it the least valuable one is closed: the oldest without a whole request,
/// or else the oldest.
///
/// Clients without the token get a short answer at once, so that they cannot occupy a connection by a request.
#[derive(Debug)]
pub(crate) struct OpenConnections {
    most: usize,
    open: Mutex<Ranked>,
}

#[derive(Debug, Default)]
struct Ranked {
    next: u64,
    /// Connections by rank: true if the request has arrived, and the number in order of opening. The first is closed first.
    connections: BTreeMap<(bool, u64), AbortHandle>,
}

impl OpenConnections {
    /// Creates an empty set of at most `most` connections, at least 1.
    pub fn new(most: usize) -> Self {
        Self { most: most.max(1), open: Mutex::default() }
    }

    /// Returns the number of the next connection.
    pub fn number(&self) -> u64 {
        let mut open = self.open();
        open.next += 1;
        open.next
    }

    /// Adds a connection without a request, and closes others beyond the maximum.
    pub fn add(&self, number: u64, connection: AbortHandle) {
        let mut open = self.open();
        while open.connections.len() >= self.most {
            open.close_first();
        }
        open.connections.insert((false, number), connection);
    }

    /// Records that the request of a connection has arrived.
    pub fn requested(&self, number: u64) {
        let mut open = self.open();
        if let Some(connection) = open.connections.remove(&(false, number)) {
            open.connections.insert((true, number), connection);
        }
    }

    /// Removes a connection that has ended.
    pub fn ended(&self, number: u64) {
        let mut open = self.open();
        for has_request in [false, true] {
            open.connections.remove(&(has_request, number));
        }
    }

    /// Closes the least valuable connection, for systems that have no further one.
    pub fn close_one(&self) {
        self.open().close_first();
    }

    fn open(&self) -> MutexGuard<'_, Ranked> {
        self.open.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Ranked {
    fn close_first(&mut self) {
        if let Some((_, connection)) = self.connections.pop_first() {
            connection.abort();
        }
    }
}
