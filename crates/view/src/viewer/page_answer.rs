use cranny_local_server::header::{CONTENT_SECURITY_POLICY, HeaderValue};
use cranny_local_server::{Call, Method, Reply, StatusCode};

use crate::viewer::page_feed::PageFeed;
use crate::{PageCells, viewer::page_bundle, viewer::verdict};

/// State shared by all responses of a server.
pub(crate) struct Served {
    pub feed: PageFeed,
    /// Cells for verdicts; `None` for a page without verdicts.
    pub cells: Option<PageCells>,
}

/// Maximum size of the content of a request in bytes; a question contains some dozens of numbers.
const MOST_BODY_BYTES: usize = 64 * 1024;

/// Content security policy: everything comes from this server, and nothing goes to another. Scripts also set styles.
const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; \
     img-src 'self' data: blob:; font-src 'self' data:; connect-src 'self'; worker-src 'self' blob:; \
     base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

impl Served {
    /// Answers a request.
    pub async fn answer(&self, call: Call) -> Reply {
        let policy = HeaderValue::from_static(POLICY);
        self.routed(call).await.with_header(CONTENT_SECURITY_POLICY, policy)
    }

    async fn routed(&self, call: Call) -> Reply {
        match (call.method(), call.path()) {
            (&Method::POST, "/verdict") => match &self.cells {
                Some(cells) => judge(cells, call).await,
                None => Reply::text(StatusCode::NOT_FOUND, "this page has no robot to judge"),
            },
            (&Method::GET | &Method::HEAD, "/page.json") => {
                Reply::new(StatusCode::OK, "application/json", self.feed.page())
            }
            (&Method::GET, "/news") => {
                let query = call.query().unwrap_or_default();
                match query.strip_prefix("after=").and_then(|after| after.parse().ok()) {
                    Some(after) => Reply::json(StatusCode::OK, &self.feed.news(after).await),
                    None => Reply::text(StatusCode::BAD_REQUEST, "after how many changes? news?after=0"),
                }
            }
            (&Method::GET, "/tree") => {
                let question = call.query().and_then(search_and_nodes);
                match question.map(|(search, after)| self.feed.nodes(search, after)) {
                    Some(Some(nodes)) => Reply::json(StatusCode::OK, &nodes),
                    Some(None) => Reply::text(StatusCode::NOT_FOUND, "this search is not watched any more"),
                    None => Reply::text(StatusCode::BAD_REQUEST, "of which search? tree?search=1&after=0"),
                }
            }
            (&Method::GET | &Method::HEAD, path) if path != "/verdict" => match page_bundle::asset(path) {
                Some(asset) => Reply::new(StatusCode::OK, asset.kind, asset.bytes.to_vec()),
                None => Reply::text(StatusCode::NOT_FOUND, "there is no such file"),
            },
            _ => Reply::text(StatusCode::METHOD_NOT_ALLOWED, "this cannot be done here"),
        }
    }
}

async fn judge(cells: &PageCells, call: Call) -> Reply {
    let question = match call.content(MOST_BODY_BYTES).await {
        Ok(question) => question,
        Err(refusal) => return refusal,
    };
    match verdict::answer(cells, &question) {
        Ok(verdict) => Reply::json(StatusCode::OK, &verdict),
        Err(fault) => Reply::refused(StatusCode::BAD_REQUEST, fault.to_string()),
    }
}

/// Parses `search=S&after=N`.
fn search_and_nodes(query: &str) -> Option<(u64, usize)> {
    let (search, after) = query.split_once('&')?;
    Some((search.strip_prefix("search=")?.parse().ok()?, after.strip_prefix("after=")?.parse().ok()?))
}
