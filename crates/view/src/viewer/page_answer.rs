use http_body_util::{BodyExt, Full, LengthLimitError, Limited};
use hyper::body::{Bytes, Incoming};
use hyper::header::{
    CACHE_CONTROL, CONTENT_SECURITY_POLICY, CONTENT_TYPE, HOST, HeaderMap, HeaderName, HeaderValue, LOCATION,
    ORIGIN, REFERRER_POLICY, X_CONTENT_TYPE_OPTIONS,
};
use hyper::{Method, Request, Response, StatusCode};
use serde::Serialize;
use tokio::time::timeout;

use crate::viewer::page_feed::PageFeed;
use crate::viewer::page_token::PageToken;
use crate::{PageCells, PageLimits, viewer::page_bundle, viewer::verdict};

/// State shared by all responses of a server.
pub(crate) struct Served {
    pub feed: PageFeed,
    /// Cells for verdicts; `None` for a page without verdicts.
    pub cells: Option<PageCells>,
    pub token: PageToken,
    pub limits: PageLimits,
    /// Host names of this server. A page of another origin whose name resolves to this machine sends another one.
    pub hosts: Vec<String>,
}

type Answer = Response<Full<Bytes>>;

/// Maximum size of the content of a request in bytes; a question contains some dozens of numbers.
const MOST_BODY_BYTES: usize = 64 * 1024;

/// Content security policy: everything comes from this server, and nothing goes to another. Scripts also set styles.
const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; \
     img-src 'self' data: blob:; font-src 'self' data:; connect-src 'self'; worker-src 'self' blob:; \
     base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

const HEADERS: [(HeaderName, &str); 4] = [
    (CONTENT_SECURITY_POLICY, POLICY),
    (X_CONTENT_TYPE_OPTIONS, "nosniff"),
    (REFERRER_POLICY, "no-referrer"),
    (CACHE_CONTROL, "no-store"),
];

const JSON: &str = "application/json";
const TEXT: &str = "text/plain; charset=utf-8";

/// Response to a malformed question.
#[derive(Serialize)]
struct Refusal {
    error: String,
}

impl Served {
    /// Answers a request. Rejects requests to other hosts, from other origins or without the token.
    pub async fn answer(&self, request: Request<Incoming>) -> Answer {
        let mut answer = if !self.is_meant(request.headers()) {
            told(StatusCode::FORBIDDEN, TEXT, format!("this server is only {}", self.hosts.join(" or ")))
        } else if let Some(path) = self.inside(request.uri().path()).map(str::to_owned) {
            self.routed(&path, request).await
        } else {
            let hint = "this page has an address that only its user knows: open the whole of what \
                        `cranny view` printed";
            told(StatusCode::FORBIDDEN, TEXT, hint)
        };
        for (name, value) in HEADERS {
            answer.headers_mut().insert(name, HeaderValue::from_static(value));
        }
        answer
    }

    fn is_meant(&self, headers: &HeaderMap) -> bool {
        let is_own = |name: &str| self.hosts.iter().any(|host| host.eq_ignore_ascii_case(name));
        let text = |value: &HeaderValue| value.to_str().map(str::to_owned).unwrap_or_default();
        let host = headers.get(HOST).map(text).unwrap_or_default();
        let origin = headers.get(ORIGIN).map(text);
        let is_own_origin = |origin: &String| origin.strip_prefix("http://").is_some_and(is_own);
        is_own(&host) && origin.as_ref().is_none_or(is_own_origin)
    }

    /// Returns the path below the token; `None` for another token.
    fn inside<'a>(&self, path: &'a str) -> Option<&'a str> {
        let path = path.strip_prefix('/')?;
        let (token, inside) = path.split_at(path.find('/').unwrap_or(path.len()));
        self.token.is(token).then_some(inside)
    }

    async fn routed(&self, path: &str, request: Request<Incoming>) -> Answer {
        match (request.method(), path) {
            (&Method::POST, "/verdict") => match &self.cells {
                Some(cells) => self.judge(cells, request.into_body()).await,
                None => told(StatusCode::NOT_FOUND, TEXT, "this page has no robot to judge"),
            },
            // Addresses in the page are relative to its folder.
            (&Method::GET | &Method::HEAD, "") => {
                let mut answer = told(StatusCode::PERMANENT_REDIRECT, TEXT, "");
                if let Ok(folder) = HeaderValue::try_from(format!("/{}/", self.token.text())) {
                    answer.headers_mut().insert(LOCATION, folder);
                }
                answer
            }
            (&Method::GET | &Method::HEAD, "/page.json") => told(StatusCode::OK, JSON, self.feed.page()),
            (&Method::GET, "/news") => {
                let query = request.uri().query().unwrap_or_default();
                match query.strip_prefix("after=").and_then(|after| after.parse().ok()) {
                    Some(after) => json(StatusCode::OK, &self.feed.news(after).await),
                    None => told(StatusCode::BAD_REQUEST, TEXT, "after how many changes? news?after=0"),
                }
            }
            (&Method::GET, "/tree") => {
                let question = request.uri().query().and_then(search_and_nodes);
                match question.map(|(search, after)| self.feed.nodes(search, after)) {
                    Some(Some(nodes)) => json(StatusCode::OK, &nodes),
                    Some(None) => told(StatusCode::NOT_FOUND, TEXT, "this search is not watched any more"),
                    None => told(StatusCode::BAD_REQUEST, TEXT, "of which search? tree?search=1&after=0"),
                }
            }
            (&Method::GET | &Method::HEAD, path) if path != "/verdict" => match page_bundle::asset(path) {
                Some(asset) => told(StatusCode::OK, asset.kind, asset.bytes.to_vec()),
                None => told(StatusCode::NOT_FOUND, TEXT, "there is no such file"),
            },
            _ => told(StatusCode::METHOD_NOT_ALLOWED, TEXT, "this cannot be done here"),
        }
    }

    async fn judge(&self, cells: &PageCells, body: Incoming) -> Answer {
        let body = timeout(self.limits.request, Limited::new(body, MOST_BODY_BYTES).collect()).await;
        let refused = |status, error: String| json(status, &Refusal { error });
        let question = match body {
            Ok(Ok(body)) => body.to_bytes(),
            Ok(Err(fault)) if fault.is::<LengthLimitError>() => {
                let error = format!("a question has at most {MOST_BODY_BYTES} bytes");
                return refused(StatusCode::PAYLOAD_TOO_LARGE, error);
            }
            Ok(Err(fault)) => return refused(StatusCode::BAD_REQUEST, fault.to_string()),
            Err(_) => return refused(StatusCode::REQUEST_TIMEOUT, "the question did not come".to_owned()),
        };
        match verdict::answer(cells, &question) {
            Ok(verdict) => json(StatusCode::OK, &verdict),
            Err(fault) => refused(StatusCode::BAD_REQUEST, fault.to_string()),
        }
    }
}

/// Parses `search=S&after=N`.
fn search_and_nodes(query: &str) -> Option<(u64, usize)> {
    let (search, after) = query.split_once('&')?;
    Some((search.strip_prefix("search=")?.parse().ok()?, after.strip_prefix("after=")?.parse().ok()?))
}

fn told(status: StatusCode, kind: &'static str, body: impl Into<Bytes>) -> Answer {
    let mut answer = Response::new(Full::new(body.into()));
    *answer.status_mut() = status;
    answer.headers_mut().insert(CONTENT_TYPE, HeaderValue::from_static(kind));
    answer
}

fn json(status: StatusCode, answer: &impl Serialize) -> Answer {
    match serde_json::to_vec(answer) {
        Ok(bytes) => told(status, JSON, bytes),
        Err(fault) => told(StatusCode::INTERNAL_SERVER_ERROR, TEXT, fault.to_string()),
    }
}
