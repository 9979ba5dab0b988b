use std::convert::Infallible;
use std::future::Future;
use std::net::{Ipv4Addr, SocketAddr, TcpListener};
use std::sync::Arc;
use std::time::Duration;

use hyper::server::conn::http1;
use hyper::service::service_fn;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::server::graceful::GracefulShutdown;
use tokio::task::yield_now;
use tokio::time::{sleep, timeout};

use crate::viewer::open_connections::OpenConnections;
use crate::viewer::page_answer::Served;
use crate::viewer::page_limits::PageLimits;
use crate::viewer::page_token::PageToken;
use crate::{PageCells, PageData, PageFeed, ViewError, viewer::page_bundle};

/// Server of one page on the loopback interface, for clients that know its address: files of the page, embedded in the program,
/// its data, and verdicts on configurations.
#[derive(Debug)]
pub struct PageServer {
    listener: TcpListener,
    address: SocketAddr,
    token: PageToken,
    limits: PageLimits,
}

/// Maximum duration of pending responses after the stop of the server.
const GRACE: Duration = Duration::from_secs(1);

/// Delay after a failed accept.
const PAUSE: Duration = Duration::from_millis(50);

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
    /// [`ViewError::Port`] if the port is taken or not allowed, [`ViewError::Server`] without random numbers for the address.
    pub fn bind(port: u16, limits: PageLimits) -> Result<Self, ViewError> {
        let fault = |reason| ViewError::Port { port, reason };
        let token = PageToken::random().map_err(|reason| ViewError::Server { reason: reason.into() })?;
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port)).map_err(fault)?;
        listener.set_nonblocking(true).map_err(fault)?;
        let address = listener.local_addr().map_err(fault)?;
        Ok(Self { listener, address, token, limits })
    }

    /// Returns the address of the page. Anyone who knows it can read the page.
    pub fn url(&self) -> String {
        format!("http://{}/{}/", self.address, self.token.text())
    }

    /// Serves until `stop` completes, and pending responses one more second, with verdicts if there are cells to check in.
    /// `ready` is called once requests can arrive.
    ///
    /// # Errors
    /// [`ViewError::Server`] if the system cannot listen, [`ViewError::PageData`].
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
            // Pending responses after this time are dropped.
            if let Some(under_way) = Arc::into_inner(under_way) {
                let _ = timeout(GRACE, under_way.shutdown()).await;
            }
            Ok(())
        })
    }
}

/// Maximum size of the head of a request in bytes, with all cookies of this machine's other servers.
const MOST_HEAD_BYTES: usize = 64 * 1024;

/// Accepts every connection at once, so that no client waits for others, and closes those beyond the limits.
async fn accept(listener: tokio::net::TcpListener, served: Arc<Served>, under_way: Arc<GracefulShutdown>) {
    let limits = served.limits;
    let open = Arc::new(OpenConnections::new(limits.connections));
    // Each connection carries one request, so that a slow one delays only itself, and only it is cut.
    let mut protocol = http1::Builder::new();
    protocol.timer(TokioTimer::new()).header_read_timeout(limits.request).keep_alive(false);
    protocol.max_buf_size(MOST_HEAD_BYTES);
    loop {
        let stream = match listener.accept().await {
            Ok((stream, _)) => stream,
            Err(fault) => {
                if lacks_descriptors(&fault) {
                    open.close_one();
                }
                sleep(PAUSE).await;
                continue;
            }
        };
        let number = open.number();
        let (served, requested, ended) = (served.clone(), open.clone(), open.clone());
        let answer = service_fn(move |request| {
            requested.requested(number);
            let served = served.clone();
            async move { Ok::<_, Infallible>(served.answer(request).await) }
        });
        let connection = under_way.watch(protocol.serve_connection(TokioIo::new(stream), answer));
        let task = tokio::spawn(async move {
            let _ = timeout(limits.connection, connection).await;
            ended.ended(number);
        });
        open.add(number, task.abort_handle());
        // A request that has arrived is read before the next connection may displace it.
        yield_now().await;
    }
}

/// Returns true if the process or the system has no free descriptor: the codes ENFILE and EMFILE of Unix, WSAEMFILE of Windows.
/// Other failures, such as a connection that its client has closed, concern no other connection.
fn lacks_descriptors(fault: &std::io::Error) -> bool {
    fault.raw_os_error().is_some_and(|code| [23, 24, 10_024].contains(&code))
}

/// Returns the host names of this server on a port.
fn hosts(port: u16) -> Vec<String> {
    let names = ["127.0.0.1", "localhost"];
    // Browsers omit the default port.
    let bare = names.iter().filter(|_| port == 80).map(|name| (*name).to_owned());
    names.iter().map(|name| format!("{name}:{port}")).chain(bare).collect()
}

#[cfg(test)]
mod tests {
    use std::io::{Error, ErrorKind};

    use super::*;

    #[test]
    fn only_a_lack_of_descriptors_costs_another_connection() {
        assert!(!lacks_descriptors(&ErrorKind::ConnectionAborted.into()));
        // ECONNABORTED of Linux.
        assert!(!lacks_descriptors(&Error::from_raw_os_error(103)));
        assert!(lacks_descriptors(&Error::from_raw_os_error(24)));
    }
}
