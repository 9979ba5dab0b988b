use std::sync::{Arc, Mutex, PoisonError};

use serde::Serialize;

use crate::course::tree_recording::SearchTreeRows;
use crate::{TreeRecording, viewer::number_row};

/// Trees of a running search, shared by the search and a server.
#[derive(Clone, Debug)]
pub(crate) struct WatchedTree {
    /// Number of the search in its feed, from 1.
    pub search: u64,
    nodes: Arc<Mutex<TreeRecording>>,
}

/// Nodes that a page does not have yet (`tree?search=S&after=N`), numbered from the first of them.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct NewNodes {
    search: u64,
    from: u32,
    #[serde(flatten)]
    rows: SearchTreeRows,
}

impl WatchedTree {
    pub fn new(search: u64, recording: TreeRecording) -> Self {
        Self { search, nodes: Arc::new(Mutex::new(recording)) }
    }

    pub fn with<T>(&self, look: impl FnOnce(&mut TreeRecording) -> T) -> T {
        look(&mut self.nodes.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// Returns all nodes but the first `nodes`.
    pub fn after(&self, nodes: usize) -> NewNodes {
        let rows = self.with(|recording| recording.rows_after(nodes));
        NewNodes { search: self.search, from: number_row::index(nodes), rows }
    }
}
