use std::time::Duration;

use hyper::body::Bytes;
use serde::Serialize;
use tokio::sync::watch;
use tokio::time::timeout;

use crate::viewer::watched_tree::{NewNodes, WatchedTree};
use crate::{PageData, TreeRecording, ViewError};

/// So long a page waits for news in one question; less than a connection may last.
const HOLD: Duration = Duration::from_secs(20);

/// What a served page shows, and how to change that while it is served: another page, another posture of the robot, the
/// trees of a search that is going on.
#[derive(Clone, Debug)]
pub struct PageFeed {
    told: watch::Sender<Told>,
}

#[derive(Clone, Debug)]
struct Told {
    page: Bytes,
    news: News,
    /// How many searches were watched so far, and the last, until another page is shown.
    searches: u64,
    tree: Option<WatchedTree>,
}

/// What a page hears.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct News {
    /// Everything that was told so far is counted.
    changes: u64,
    /// How many pages were there before this one; who shows another loads this one.
    page: u64,
    /// How often the robot was told how to stand, on this page.
    poses: u64,
    /// How it stands (m, rad); `None`: as the page has it.
    q: Option<Vec<f64>>,
    /// How far the search is that is watched, if one is.
    tree: Option<TreeNews>,
}

#[derive(Clone, Copy, Debug, Serialize)]
struct TreeNews {
    /// Which search: each begins with no node.
    search: u64,
    nodes: usize,
}

impl PageFeed {
    /// A page that can be changed. `has_verdicts`: whether its server judges postures.
    ///
    /// # Errors
    /// [`ViewError::PageData`].
    pub fn new(page: &PageData, has_verdicts: bool) -> Result<Self, ViewError> {
        Ok(Self::of(page.served(has_verdicts, Some(0))?))
    }

    /// A page that stays as it is.
    pub(crate) fn still(page: &PageData, has_verdicts: bool) -> Result<Self, ViewError> {
        Ok(Self::of(page.served(has_verdicts, None)?))
    }

    fn of(page: Vec<u8>) -> Self {
        let news = News { changes: 0, page: 0, poses: 0, q: None, tree: None };
        Self { told: watch::Sender::new(Told { page: page.into(), news, searches: 0, tree: None }) }
    }

    /// Shows another page, the robot as that has it.
    ///
    /// # Errors
    /// [`ViewError::PageData`]; what was shown stays.
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

    /// Shows the robot at a configuration (m, rad; one per joint); `None`: as the page has it.
    pub fn pose(&self, q: Option<Vec<f64>>) {
        self.told.send_modify(|told| {
            told.news.changes += 1;
            told.news.poses += 1;
            told.news.q = q;
        });
    }

    /// Begins a search that is watched; `recording` has no node yet.
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

    /// Says how many nodes a search has, if it is still the one that is watched.
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

    /// The nodes of a search after so many; nothing of one that is not watched any more.
    pub(crate) fn nodes(&self, search: u64, after: usize) -> Option<NewNodes> {
        let tree = self.told.borrow().tree.clone().filter(|tree| tree.search == search)?;
        Some(tree.after(after))
    }

    /// What is shown now.
    pub(crate) fn page(&self) -> Bytes {
        self.told.borrow().page.clone()
    }

    /// What is new after so many changes, or after a while that nothing is.
    pub(crate) async fn news(&self, after: u64) -> News {
        let mut told = self.told.subscribe();
        // Nobody is left to tell anything only where the server ends, and with it this.
        let _ = timeout(HOLD, told.wait_for(|told| told.news.changes > after)).await;
        told.borrow().news.clone()
    }
}
