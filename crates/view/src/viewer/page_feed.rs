use std::time::Duration;

use cranny_local_server::Bytes;
use serde::Serialize;
use tokio::sync::watch;
use tokio::time::timeout;

use crate::viewer::watched_tree::{NewNodes, WatchedTree};
use crate::{PageData, TreeRecording, ViewError};

/// Maximum waiting time of one request for news; less than the limit of a connection.
const HOLD: Duration = Duration::from_secs(20);

/// Content of a served page that can change: another page, another configuration of the robot, the growing trees of a search.
#[derive(Clone, Debug)]
pub struct PageFeed {
    told: watch::Sender<Told>,
}

#[derive(Clone, Debug)]
struct Told {
    page: Bytes,
    news: News,
    /// Number of searches watched up to now, and the tree of the last one, until another page is shown.
    searches: u64,
    tree: Option<WatchedTree>,
}

/// State that is sent to a page.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct News {
    /// Number of all changes up to now.
    changes: u64,
    /// Number of earlier pages; a client that shows another page loads this one.
    page: u64,
    /// Number of configurations set on this page.
    poses: u64,
    /// Configuration of the robot (m, rad); `None`: that of the page.
    q: Option<Vec<f64>>,
    /// Progress of the watched search, if there is one.
    tree: Option<TreeNews>,
}

#[derive(Clone, Copy, Debug, Serialize)]
struct TreeNews {
    /// Number of the search; each begins without nodes.
    search: u64,
    nodes: usize,
}

impl PageFeed {
    /// Creates a page that can be changed. `has_verdicts`: true if its server checks configurations.
    ///
    /// # Errors
    /// [`ViewError::PageData`].
    pub fn new(page: &PageData, has_verdicts: bool) -> Result<Self, ViewError> {
        Ok(Self::of(page.served(has_verdicts, Some(0))?))
    }

    /// Creates a page that does not change.
    pub(crate) fn still(page: &PageData, has_verdicts: bool) -> Result<Self, ViewError> {
        Ok(Self::of(page.served(has_verdicts, None)?))
    }

    fn of(page: Vec<u8>) -> Self {
        let news = News { changes: 0, page: 0, poses: 0, q: None, tree: None };
        Self { told: watch::Sender::new(Told { page: page.into(), news, searches: 0, tree: None }) }
    }

    /// Shows another page, with the robot in the configuration of that page.
    ///
    /// # Errors
    /// [`ViewError::PageData`]; the previous page stays.
    pub fn show(&self, page: &PageData, has_verdicts: bool) -> Result<(), ViewError> {
        let number = self.told.borrow().news.page + 1;
        let page = page.served(has_verdicts, Some(number))?;
        self.told.send_modify(|told| {
            told.page = page.into();
            told.news = News { changes: told.news.changes + 1, page: number, poses: 0, q: None, tree: None };
            told.tree = None;
        });
        Ok(())
    }

    /// Shows the robot at a configuration (m, rad; one per joint); `None` restores that of the page.
    pub fn pose(&self, q: Option<Vec<f64>>) {
        self.told.send_modify(|told| {
            told.news.changes += 1;
            told.news.poses += 1;
            told.news.q = q;
        });
    }

    /// Begins a watched search; `recording` has no nodes yet.
    pub(crate) fn begin_search(&self, recording: TreeRecording) -> WatchedTree {
        let search = self.told.borrow().searches + 1;
        let tree = WatchedTree::new(search, recording);
        let of_feed = tree.clone();
        self.told.send_modify(|told| {
            told.searches = search;
            told.tree = Some(of_feed);
            told.news.changes += 1;
            told.news.tree = Some(TreeNews { search, nodes: 0 });
        });
        tree
    }

    /// Publishes the number of nodes of a search if it is still the watched one.
    pub(crate) fn tell_nodes(&self, search: u64, nodes: usize) {
        self.told.send_if_modified(|told| {
            let is_watched = told.news.tree.is_some_and(|tree| tree.search == search && tree.nodes < nodes);
            if is_watched {
                told.news.changes += 1;
                told.news.tree = Some(TreeNews { search, nodes });
            }
            is_watched
        });
    }

    /// Returns the nodes of a search from index `after` on; `None` if it is no longer watched.
    pub(crate) fn nodes(&self, search: u64, after: usize) -> Option<NewNodes> {
        let tree = self.told.borrow().tree.clone().filter(|tree| tree.search == search)?;
        Some(tree.after(after))
    }

    /// Returns the current page.
    pub(crate) fn page(&self) -> Bytes {
        self.told.borrow().page.clone()
    }

    /// Waits for more than `after` changes, or for a timeout, and returns the current state.
    pub(crate) async fn news(&self, after: u64) -> News {
        let mut told = self.told.subscribe();
        // The wait fails only if all senders are gone: the server ends then, and with it this request.
        let _ = timeout(HOLD, told.wait_for(|told| told.news.changes > after)).await;
        told.borrow().news.clone()
    }
}
