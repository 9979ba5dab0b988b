use std::sync::Arc;
use std::time::{Duration, Instant};

use cranny_plan::Observer;
use cranny_robot::Robot;

use crate::TreeRecording;
use crate::viewer::page_feed::PageFeed;
use crate::viewer::watched_tree::WatchedTree;

/// Minimum interval between two updates of a page: a tree then grows smoothly for the eye.
const TELL_EVERY: Duration = Duration::from_millis(50);

/// Observer of a search whose trees a browser shows while they grow ([`PageFeed::watch`]).
#[derive(Debug)]
pub struct WatchedSearch {
    feed: PageFeed,
    tree: WatchedTree,
    told: Instant,
}

impl PageFeed {
    /// Watches a search of the robot of the page, whose first [`TreeRecording::MOST_NODES`] nodes replace the trees of earlier
    /// searches until another page is shown.
    pub fn watch(&self, robot: Arc<Robot>) -> WatchedSearch {
        let recording = TreeRecording::new(robot, TreeRecording::MOST_NODES);
        WatchedSearch { feed: self.clone(), tree: self.begin_search(recording), told: Instant::now() }
    }
}

impl WatchedSearch {
    /// Returns the recording, for the page of the resulting plan.
    pub fn end(self) -> TreeRecording {
        self.tree.with(|recording| recording.clone())
    }

    fn tell(&mut self) {
        self.told = Instant::now();
        self.feed.tell_nodes(self.tree.search, self.tree.with(|recording| recording.len()));
    }
}

impl Observer for WatchedSearch {
    fn node_added(&mut self, tree: usize, q: &[f64], parent: Option<usize>) {
        self.tree.with(|recording| recording.node_added(tree, q, parent));
        if self.told.elapsed() >= TELL_EVERY {
            self.tell();
        }
    }

    fn search_ended(&mut self) {
        self.tell();
    }
}
