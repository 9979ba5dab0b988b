use std::time::Duration;

use hyper::body::Bytes;
use serde::Serialize;
use tokio::sync::watch;
use tokio::time::timeout;

use crate::{PageData, ViewError};

/// So long a page waits for news in one question; less than a connection may last.
const HOLD: Duration = Duration::from_secs(20);

/// What a served page shows, and how to change that while it is served: another page, or another posture of the robot.
#[derive(Clone, Debug)]
pub struct PageFeed {
    told: watch::Sender<Told>,
}

#[derive(Clone, Debug)]
struct Told {
    page: Bytes,
    news: News,
}

/// What a page hears.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct News {
    /// Everything that was told so far is counted.
    changes: u64,
    /// How many pages were there before this one; who shows another loads this one.
    page: u64,
    /// How the robot stands (m, rad); `None`: as the page has it.
    q: Option<Vec<f64>>,
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
        let news = News { changes: 0, page: 0, q: None };
        Self { told: watch::Sender::new(Told { page: page.into(), news }) }
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
            told.news = News { changes: told.news.changes + 1, page: number, q: None };
        });
        Ok(())
    }

    /// Shows the robot at a configuration (m, rad); `None`: as the page has it.
    pub fn pose(&self, q: Option<Vec<f64>>) {
        self.told.send_modify(|told| {
            told.news.changes += 1;
            told.news.q = q;
        });
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
