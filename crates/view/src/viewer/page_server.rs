use std::future::Future;
use std::sync::Arc;

use cranny_local_server::{LocalServer, ServerLimits};

use crate::viewer::page_answer::Served;
use crate::{PageCells, PageData, PageFeed, ViewError, viewer::page_bundle};

/// Server of one page on the loopback interface, for clients that know its address: files of the page, embedded in the program,
/// its data, and verdicts on configurations.
#[derive(Debug)]
pub struct PageServer(LocalServer);

impl PageServer {
    /// Checks that this program has a page to serve.
    ///
    /// # Errors
    /// [`ViewError::NoPage`], which names what to install.
    pub fn check_page() -> Result<(), ViewError> {
        page_bundle::check()
    }

    /// Binds a port of the loopback address 127.0.0.1; 0 selects a free one.
    ///
    /// # Errors
    /// As [`LocalServer::bind`].
    pub fn bind(port: u16, limits: ServerLimits) -> Result<Self, ViewError> {
        Ok(Self(LocalServer::bind(port, limits)?))
    }

    /// Returns the address of the page. Anyone who knows it can read the page.
    pub fn url(&self) -> String {
        self.0.url()
    }

    /// Serves until `stop` completes, and pending responses one more second, with verdicts if there are cells to check in.
    /// `ready` is called once requests can arrive.
    ///
    /// # Errors
    /// As [`LocalServer::serve`], [`ViewError::PageData`].
    pub fn serve(
        self,
        page: &PageData,
        cells: Option<PageCells>,
        stop: impl Future<Output = ()> + Send + 'static,
        ready: impl FnOnce(),
    ) -> Result<(), ViewError> {
        let feed = PageFeed::still(page, cells.is_some())?;
        self.serve_feed(feed, cells, stop, ready)
    }

    /// Serves like [`Self::serve`] a page that can change meanwhile.
    ///
    /// # Errors
    /// As [`LocalServer::serve`].
    pub fn serve_feed(
        self,
        feed: PageFeed,
        cells: Option<PageCells>,
        stop: impl Future<Output = ()> + Send + 'static,
        ready: impl FnOnce(),
    ) -> Result<(), ViewError> {
        let served = Arc::new(Served { feed, cells });
        let answer = move |call| {
            let served = served.clone();
            async move { served.answer(call).await }
        };
        Ok(self.0.serve(answer, stop, ready)?)
    }
}
