use http_body_util::Full;
use hyper::body::Bytes;
use hyper::header::{
    CACHE_CONTROL, CONTENT_SECURITY_POLICY, CONTENT_TYPE, HeaderName, HeaderValue, REFERRER_POLICY,
    X_CONTENT_TYPE_OPTIONS,
};
use hyper::{Response, StatusCode};
use serde::Serialize;

/// Answer to a request.
#[derive(Debug)]
pub struct Reply(Box<Response<Full<Bytes>>>);

/// Headers of every reply that does not set them itself. In a browser, a reply loads nothing and is in no frame.
const HEADERS: [(HeaderName, &str); 4] = [
    (
        CONTENT_SECURITY_POLICY,
        "default-src 'none'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
    ),
    (X_CONTENT_TYPE_OPTIONS, "nosniff"),
    (REFERRER_POLICY, "no-referrer"),
    (CACHE_CONTROL, "no-store"),
];

/// Content of a reply to a malformed request.
#[derive(Serialize)]
struct Refusal {
    error: String,
}

impl Reply {
    /// Returns a reply of bytes of a media type.
    pub fn new(status: StatusCode, media_type: &'static str, content: impl Into<Bytes>) -> Self {
        let mut reply = Response::new(Full::new(content.into()));
        *reply.status_mut() = status;
        Self(Box::new(reply)).with_header(CONTENT_TYPE, HeaderValue::from_static(media_type))
    }

    /// Returns a reply in plain text.
    pub fn text(status: StatusCode, text: impl Into<Bytes>) -> Self {
        Self::new(status, "text/plain; charset=utf-8", text)
    }

    /// Returns a reply in JSON.
    pub fn json(status: StatusCode, document: &impl Serialize) -> Self {
        match serde_json::to_vec(document) {
            Ok(bytes) => Self::new(status, "application/json", bytes),
            Err(fault) => Self::text(StatusCode::INTERNAL_SERVER_ERROR, fault.to_string()),
        }
    }

    /// Returns a reply in JSON whose `error` states what is wrong with the request.
    pub fn refused(status: StatusCode, error: impl Into<String>) -> Self {
        Self::json(status, &Refusal { error: error.into() })
    }

    /// Returns this reply with a header, in place of one of that name.
    #[must_use]
    pub fn with_header(mut self, name: HeaderName, value: HeaderValue) -> Self {
        self.0.headers_mut().insert(name, value);
        self
    }

    pub(crate) fn whole(self) -> Response<Full<Bytes>> {
        let mut reply = *self.0;
        for (name, value) in HEADERS {
            reply.headers_mut().entry(name).or_insert(HeaderValue::from_static(value));
        }
        reply
    }
}
