use std::convert::Infallible;
use std::future::Future;
use std::net::{Ipv4Addr, SocketAddr, TcpListener};
use std::sync::Arc;
use std::time::Duration;

use hyper::server::conn::http1;
use hyper::service::service_fn;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::server::graceful::GracefulShutdown;
use tokio::sync::Semaphore;
use tokio::time::{sleep, timeout};

use crate::viewer::page_answer::Served;
use crate::viewer::page_limits::PageLimits;
use crate::viewer::page_token::PageToken;
use crate::{PageCells, PageData, PageFeed, ViewError, viewer::page_bundle};

/// Serves one page to this machine alone, and there to who knows its address: the page's own files, which are part
/// of the program, its data, and verdicts on configurations.
#[derive(Debug)]
pub struct PageServer {
    listener: TcpListener,
    address: SocketAddr,
    token: PageToken,
    limits: PageLimits,
}

/// How long answers that are under way may take once the server is to stop.
const GRACE: Duration = Duration::from_secs(1);

/// Until another connection is looked for where the system could not give one.
const PAUSE: Duration = Duration::from_millis(50);

impl PageServer {
    /// Whether this program has a page to serve.
    ///
    /// # Errors
    /// [`ViewError::NoPage`], which says what to install.
    pub fn check_page() -> Result<(), ViewError> {
        page_bundle::check()
    }

    /// Takes a port of the loopback address 127.0.0.1: this one, or a free one for 0.
    ///
    /// # Errors
    /// [`ViewError::Port`] if it is taken or not allowed, [`ViewError::Server`] if the system has no random numbers
    /// for the address.
    pub fn bind(port: u16, limits: PageLimits) -> Result<Self, ViewError> {
        let fault = |reason| ViewError::Port { port, reason };
        let token = PageToken::random().map_err(|reason| ViewError::Server { reason: reason.into() })?;
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port)).map_err(fault)?;
        listener.set_nonblocking(true).map_err(fault)?;
        let address = listener.local_addr().map_err(fault)?;
        Ok(Self { listener, address, token, limits })
    }

    /// Where the page is: whoever knows this can read it.
    pub fn url(&self) -> String {
        format!("http://{}/{}/", self.address, self.token.text())
    }

    /// Answers until `stop` is done, questions as well where there are cells to judge in; answers that are under way
    /// then get a second more. `ready` is called once the first request can come.
    ///
    /// # Errors
    /// [`ViewError::Server`] if the system gives no means to listen, [`ViewError::PageData`].
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

    /// [`Self::serve`] of a page that can be changed meanwhile.
    ///
    /// # Errors
    /// [`ViewError::Server`].
    pub fn serve_feed(
        self,
        feed: PageFeed,
        cells: Option<PageCells>,
        stop: impl Future<Output = ()> + Send + 'static,
        ready: impl FnOnce(),
    ) -> Result<(), ViewError> {
        let Self { listener, address, token, limits } = self;
        let hosts = hosts(address.port());
        let served = Arc::new(Served { feed, cells, token, limits, hosts });
        let fault = |reason| ViewError::Server { reason };
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().map_err(fault)?;
        runtime.block_on(async {
            let listener = tokio::net::TcpListener::from_std(listener).map_err(fault)?;
            let stop = tokio::spawn(stop);
            let under_way = Arc::new(GracefulShutdown::new());
            let accepting = tokio::spawn(accept(listener, served, under_way.clone()));
            ready();
            let _ = stop.await;
            accepting.abort();
            let _ = accepting.await;
            // Whoever has not got an answer by then gets none.
            if let Some(under_way) = Arc::into_inner(under_way) {
                let _ = timeout(GRACE, under_way.shutdown()).await;
            }
            Ok(())
        })
    }
}

/// Takes connections as far as the limits let them in.
async fn accept(listener: tokio::net::TcpListener, served: Arc<Served>, under_way: Arc<GracefulShutdown>) {
    let limits = served.limits;
    let places = Arc::new(Semaphore::new(limits.connections.max(1)));
    // One request each: whatever is slow is then slow by itself, and cut by itself.
    let mut protocol = http1::Builder::new();
    protocol.timer(TokioTimer::new()).header_read_timeout(limits.request).keep_alive(false);
    while let Ok(place) = places.clone().acquire_owned().await {
        let Ok((stream, _)) = listener.accept().await else {
            sleep(PAUSE).await;
            continue;
        };
        let served = served.clone();
        let answer = service_fn(move |request| {
            let served = served.clone();
            async move { Ok::<_, Infallible>(served.answer(request).await) }
        });
        let connection = under_way.watch(protocol.serve_connection(TokioIo::new(stream), answer));
        tokio::spawn(async move {
            let _ = timeout(limits.connection, connection).await;
            drop(place);
        });
    }
}

/// The names of this server on a port.
fn hosts(port: u16) -> Vec<String> {
    let names = ["127.0.0.1", "localhost"];
    // Browsers leave out the usual port.
    let bare = names.iter().filter(|_| port == 80).map(|name| (*name).to_owned());
    names.iter().map(|name| format!("{name}:{port}")).chain(bare).collect()
}
