use std::future::{Future, IntoFuture, poll_fn};
use std::net::{Ipv4Addr, SocketAddr, TcpListener};
use std::pin::pin;
use std::sync::Arc;
use std::task::Poll;
use std::time::Duration;

use axum::Router;
use axum::body::Bytes;
use axum::extract::rejection::BytesRejection;
use axum::extract::{DefaultBodyLimit, Request, State};
use axum::http::header::{
    CACHE_CONTROL, CONTENT_SECURITY_POLICY, CONTENT_TYPE, HOST, ORIGIN, REFERRER_POLICY,
    X_CONTENT_TYPE_OPTIONS,
};
use axum::http::{HeaderMap, HeaderName, HeaderValue, StatusCode, Uri};
use axum::middleware::{self, Next};
use axum::response::{IntoResponse, Response};
use axum::routing::{get, post};
use cranny_collision::Cell;
use serde::Serialize;

use crate::{PageData, ViewError, page_bundle, verdict};

/// Serves one page to this machine alone: the page's own files, which are part of the program, its data, and
/// verdicts on configurations.
#[derive(Debug)]
pub struct PageServer {
    listener: TcpListener,
    address: SocketAddr,
}

/// What all requests share.
struct Served {
    page: Bytes,
    cell: Arc<Cell>,
    /// The names by which this server can be meant. A page of another origin that has its name resolved to this
    /// machine sends another one.
    hosts: Vec<String>,
}

/// A question holds some dozens of numbers.
const MOST_BODY_BYTES: usize = 64 * 1024;

/// How long answers that are under way may take once the server is to stop.
const GRACE: Duration = Duration::from_secs(1);

/// Everything comes from this server, and nothing leaves to another. Styles are set by scripts too.
const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; \
     img-src 'self' data: blob:; font-src 'self' data:; connect-src 'self'; worker-src 'self' blob:; \
     base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

const HEADERS: [(HeaderName, &str); 4] = [
    (CONTENT_SECURITY_POLICY, POLICY),
    (X_CONTENT_TYPE_OPTIONS, "nosniff"),
    (REFERRER_POLICY, "no-referrer"),
    (CACHE_CONTROL, "no-store"),
];

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
    /// [`ViewError::Port`] if it is taken or not allowed.
    pub fn bind(port: u16) -> Result<Self, ViewError> {
        let fault = |reason| ViewError::Port { port, reason };
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port)).map_err(fault)?;
        listener.set_nonblocking(true).map_err(fault)?;
        let address = listener.local_addr().map_err(fault)?;
        Ok(Self { listener, address })
    }

    /// Where the page is.
    pub fn url(&self) -> String {
        format!("http://{}/", self.address)
    }

    /// Answers until `stop` is done; answers that are under way then get a second more. `ready` is called once
    /// the first request can come and `stop` is watched.
    ///
    /// # Errors
    /// [`ViewError::Server`] if the system gives no means to listen, [`ViewError::PageData`].
    pub fn serve(
        self,
        page: &PageData,
        cell: Arc<Cell>,
        stop: impl Future<Output = ()> + Send + 'static,
        ready: impl FnOnce(),
    ) -> Result<(), ViewError> {
        let served = Served { page: page.to_json(true)?.into(), cell, hosts: hosts(self.address.port()) };
        let fault = |reason| ViewError::Server { reason };
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().map_err(fault)?;
        runtime.block_on(async {
            let listener = tokio::net::TcpListener::from_std(self.listener).map_err(fault)?;
            let stop = tokio::spawn(stop);
            // Signals are watched from the first look at `stop` on.
            tokio::task::yield_now().await;
            let (tell, told) = tokio::sync::oneshot::channel::<()>();
            let server = axum::serve(listener, router(Arc::new(served))).with_graceful_shutdown(async {
                let _ = told.await;
            });
            let server = tokio::spawn(server.into_future());
            ready();
            let _ = stop.await;
            let _ = tell.send(());
            // Whoever has not got an answer by then gets none.
            let _ = tokio::time::timeout(GRACE, server).await;
            Ok(())
        })
    }
}

/// Done when the user presses Ctrl-C or the system asks the program to end.
pub async fn interrupted() {
    let mut pressed = pin!(tokio::signal::ctrl_c());
    #[cfg(unix)]
    if let Ok(mut terminated) = tokio::signal::unix::signal(tokio::signal::unix::SignalKind::terminate()) {
        let mut ended = pin!(terminated.recv());
        let either = poll_fn(|context| {
            let is_done = ended.as_mut().poll(context).is_ready() | pressed.as_mut().poll(context).is_ready();
            if is_done { Poll::Ready(()) } else { Poll::Pending }
        });
        return either.await;
    }
    let _ = pressed.await;
}

fn router(served: Arc<Served>) -> Router {
    Router::new()
        .route("/page.json", get(page_data))
        .route("/verdict", post(judge))
        .fallback_service(get(page_asset))
        .layer(DefaultBodyLimit::max(MOST_BODY_BYTES))
        .layer(middleware::from_fn_with_state(served.clone(), guard))
        .with_state(served)
}

fn hosts(port: u16) -> Vec<String> {
    let names = ["127.0.0.1", "localhost"];
    // Browsers leave out the usual port.
    let bare = names.iter().filter(|_| port == 80).map(|name| (*name).to_owned());
    names.iter().map(|name| format!("{name}:{port}")).chain(bare).collect()
}

/// Turns away what means another host or comes from another origin, and adds the headers of every answer.
async fn guard(State(served): State<Arc<Served>>, request: Request, next: Next) -> Response {
    let mut response = if is_meant(&served, request.headers()) {
        next.run(request).await
    } else {
        let message = format!("this server is only {}", served.hosts.join(" or "));
        (StatusCode::FORBIDDEN, message).into_response()
    };
    for (name, value) in HEADERS {
        response.headers_mut().insert(name, HeaderValue::from_static(value));
    }
    response
}

fn is_meant(served: &Served, headers: &HeaderMap) -> bool {
    let is_own = |name: &str| served.hosts.iter().any(|host| host.eq_ignore_ascii_case(name));
    let text = |value: &HeaderValue| value.to_str().map(str::to_owned).unwrap_or_default();
    let host = headers.get(HOST).map(text).unwrap_or_default();
    let origin = headers.get(ORIGIN).map(text);
    let is_own_origin = |origin: &String| origin.strip_prefix("http://").is_some_and(is_own);
    is_own(&host) && origin.as_ref().is_none_or(is_own_origin)
}

async fn page_data(State(served): State<Arc<Served>>) -> Response {
    ([(CONTENT_TYPE, "application/json")], served.page.clone()).into_response()
}

async fn page_asset(uri: Uri) -> Response {
    match page_bundle::asset(uri.path()) {
        Some(asset) => ([(CONTENT_TYPE, asset.kind)], asset.bytes).into_response(),
        None => (StatusCode::NOT_FOUND, "there is no such file").into_response(),
    }
}

/// What a malformed question is told.
#[derive(Serialize)]
struct Refusal {
    error: String,
}

async fn judge(State(served): State<Arc<Served>>, body: Result<Bytes, BytesRejection>) -> Response {
    let body = match body {
        Ok(body) => body,
        Err(rejection) => return json(rejection.status(), &Refusal { error: rejection.body_text() }),
    };
    match verdict::answer(&served.cell, &body) {
        Ok(verdict) => json(StatusCode::OK, &verdict),
        Err(fault) => json(StatusCode::BAD_REQUEST, &Refusal { error: fault.to_string() }),
    }
}

fn json(status: StatusCode, answer: &impl Serialize) -> Response {
    match serde_json::to_vec(answer) {
        Ok(bytes) => (status, [(CONTENT_TYPE, "application/json")], bytes).into_response(),
        Err(_) => StatusCode::INTERNAL_SERVER_ERROR.into_response(),
    }
}
