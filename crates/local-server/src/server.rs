use std::convert::Infallible;
use std::future::Future;
use std::net::{Ipv4Addr, SocketAddr, TcpListener};
use std::sync::Arc;
use std::time::Duration;

use hyper::body::Incoming;
use hyper::header::{HOST, HeaderMap, HeaderValue, LOCATION, ORIGIN};
use hyper::server::conn::http1;
use hyper::service::service_fn;
use hyper::{Method, Request, StatusCode};
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::server::graceful::GracefulShutdown;
use tokio::task::yield_now;
use tokio::time::{sleep, timeout};

use crate::open_connections::OpenConnections;
use crate::token::Token;
use crate::{Call, Reply, ServerError, ServerLimits};

/// Server on the loopback interface, for clients that know its address.
#[derive(Debug)]
pub struct LocalServer {
    listener: TcpListener,
    address: SocketAddr,
    token: Token,
    limits: ServerLimits,
}

/// Maximum duration of pending responses after the stop of the server.
const GRACE: Duration = Duration::from_secs(1);

/// Delay after a failed accept.
const PAUSE: Duration = Duration::from_millis(50);

impl LocalServer {
    /// Binds a port of the loopback address 127.0.0.1; 0 selects a free one.
    ///
    /// # Errors
    /// [`ServerError::Port`] if the port is taken or not allowed, [`ServerError::Start`] without random numbers for the
    /// address.
    pub fn bind(port: u16, limits: ServerLimits) -> Result<Self, ServerError> {
        let fault = |reason| ServerError::Port { port, reason };
        let token = Token::random().map_err(|reason| ServerError::Start { reason: reason.into() })?;
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port)).map_err(fault)?;
        listener.set_nonblocking(true).map_err(fault)?;
        let address = listener.local_addr().map_err(fault)?;
        Ok(Self { listener, address, token, limits })
    }

    /// Returns the address, with the token. Anyone who knows it is answered.
    pub fn url(&self) -> String {
        format!("http://{}/{}/", self.address, self.token.text())
    }

    /// Answers requests by `answer` until `stop` completes, and pending ones one more second. `ready` is called once requests
    /// can arrive. The future of an answer is dropped if its client disconnects.
    ///
    /// # Errors
    /// [`ServerError::Start`] if the system cannot listen.
    pub fn serve<A: Future<Output = Reply> + Send + 'static>(
        self,
        answer: impl Fn(Call) -> A + Clone + Send + Sync + 'static,
        stop: impl Future<Output = ()> + Send + 'static,
        ready: impl FnOnce(),
    ) -> Result<(), ServerError> {
        let Self { listener, address, token, limits } = self;
        let door = Arc::new(Door { token, limits, hosts: hosts(address.port()) });
        let fault = |reason| ServerError::Start { reason };
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().map_err(fault)?;
        runtime.block_on(async {
            let listener = tokio::net::TcpListener::from_std(listener).map_err(fault)?;
            let stop = tokio::spawn(stop);
            let under_way = Arc::new(GracefulShutdown::new());
            let accepting = tokio::spawn(accept(listener, door, answer, under_way.clone()));
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
async fn accept<A: Future<Output = Reply> + Send + 'static>(
    listener: tokio::net::TcpListener,
    door: Arc<Door>,
    answer: impl Fn(Call) -> A + Clone + Send + Sync + 'static,
    under_way: Arc<GracefulShutdown>,
) {
    let limits = door.limits;
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
        let (door, answer, requested, ended) = (door.clone(), answer.clone(), open.clone(), open.clone());
        let service = service_fn(move |request| {
            requested.requested(number);
            let (door, answer) = (door.clone(), answer.clone());
            async move {
                let reply = match door.let_in(request) {
                    Ok(call) => answer(call).await,
                    Err(refusal) => refusal,
                };
                Ok::<_, Infallible>(reply.whole())
            }
        });
        let connection = under_way.watch(protocol.serve_connection(TokioIo::new(stream), service));
        let task = tokio::spawn(async move {
            let _ = timeout(limits.connection, connection).await;
            ended.ended(number);
        });
        open.add(number, task.abort_handle());
        // A request that has arrived is read before the next connection may displace it.
        yield_now().await;
    }
}

/// Check of every request, before its content is read.
struct Door {
    token: Token,
    limits: ServerLimits,
    /// Host names of this server. A page of another origin whose name resolves to this machine sends another one.
    hosts: Vec<String>,
}

impl Door {
    /// Returns the request as a call, or the reply to one to another host, from another origin or without the token.
    fn let_in(&self, request: Request<Incoming>) -> Result<Call, Reply> {
        if !self.is_meant(request.headers()) {
            let hosts = self.hosts.join(" or ");
            return Err(Reply::text(StatusCode::FORBIDDEN, format!("this server is only {hosts}")));
        }
        let Some(path) = self.inside(request.uri().path()).map(str::to_owned) else {
            let hint =
                "this server has an address that only its user knows: use the whole address that was printed";
            return Err(Reply::text(StatusCode::FORBIDDEN, hint));
        };
        // Addresses in a page are relative to its folder.
        if path.is_empty() && matches!(*request.method(), Method::GET | Method::HEAD) {
            let reply = Reply::text(StatusCode::PERMANENT_REDIRECT, "");
            let folder = HeaderValue::try_from(format!("/{}/", self.token.text()));
            return Err(folder.map_or_else(
                |fault| Reply::text(StatusCode::INTERNAL_SERVER_ERROR, fault.to_string()),
                |folder| reply.with_header(LOCATION, folder),
            ));
        }
        Ok(Call::new(request, path, self.limits.request))
    }

    fn is_meant(&self, headers: &HeaderMap) -> bool {
        let is_own = |name: &str| self.hosts.iter().any(|host| host.eq_ignore_ascii_case(name));
        let texts = |name| headers.get_all(name).iter().map(|value| value.to_str().unwrap_or_default());
        let is_own_origin = |origin: &str| origin.strip_prefix("http://").is_some_and(is_own);
        // A request with several of them is meant for none.
        texts(HOST).count() == 1 && texts(HOST).all(is_own) && texts(ORIGIN).all(is_own_origin)
    }

    /// Returns the path below the token; `None` for another token.
    fn inside<'a>(&self, path: &'a str) -> Option<&'a str> {
        let path = path.strip_prefix('/')?;
        let (token, inside) = path.split_at(path.find('/').unwrap_or(path.len()));
        self.token.is(token).then_some(inside)
    }
}

/// Returns the host names of this server on a port.
fn hosts(port: u16) -> Vec<String> {
    let names = ["127.0.0.1", "localhost"];
    // Browsers omit the default port.
    let bare = names.iter().filter(|_| port == 80).map(|name| (*name).to_owned());
    names.iter().map(|name| format!("{name}:{port}")).chain(bare).collect()
}

/// Returns true if the process or the system has no free descriptor: the codes ENFILE and EMFILE of Unix, WSAEMFILE of Windows.
/// Other failures, such as a connection that its client has closed, concern no other connection.
fn lacks_descriptors(fault: &std::io::Error) -> bool {
    fault.raw_os_error().is_some_and(|code| [23, 24, 10_024].contains(&code))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_lack_of_descriptors_costs_another_connection() {
        use std::io::{Error, ErrorKind};

        assert!(!lacks_descriptors(&ErrorKind::ConnectionAborted.into()));
        // ECONNABORTED of Linux.
        assert!(!lacks_descriptors(&Error::from_raw_os_error(103)));
        assert!(lacks_descriptors(&Error::from_raw_os_error(24)));
    }
}
