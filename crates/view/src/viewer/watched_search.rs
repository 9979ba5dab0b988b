use std::sync::Arc;
use std::time::{Duration, Instant};

use cranny_plan::Observer;
use cranny_robot::Robot;

use crate::TreeRecording;
use crate::viewer::page_feed::PageFeed;
use crate::viewer::watched_tree::WatchedTree;

/// Pages hear of new nodes no more often: as often as a person sees a tree grow.
const TELL_EVERY: Duration = Duration::from_millis(50);

/// Watches a search whose trees are seen in a browser while they grow ([`PageFeed::watch`]).
#[derive(Debug)]
pub struct WatchedSearch {
    feed: PageFeed,
    tree: WatchedTree,
    told: Instant,
}

impl PageFeed {
    /// Watches a search of the robot that the page shows: until another page is shown, its trees are seen as they grow, in
    /// place of those of any search before. Of more than [`TreeRecording::MOST_NODES`] nodes the first are.
    pub fn watch(&self, robot: Arc<Robot>) -> WatchedSearch {
        let recording = TreeRecording::new(robot, TreeRecording::MOST_NODES);
        WatchedSearch { feed: self.clone(), tree: self.begin_search(recording), told: Instant::now() }
    }
}

impl WatchedSearch {
    /// What was recorded, for the page of the plan that came of it.
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
