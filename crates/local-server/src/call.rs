use std::time::Duration;

use http_body_util::{BodyExt, LengthLimitError, Limited};
use hyper::body::{Bytes, Incoming};
use hyper::{Method, Request, StatusCode};
use tokio::time::timeout;

use crate::Reply;

/// Request of a client that knows the token.
#[derive(Debug)]
pub struct Call {
    request: Request<Incoming>,
    path: String,
    patience: Duration,
}

impl Call {
    pub(crate) fn new(request: Request<Incoming>, path: String, patience: Duration) -> Self {
        Self { request, path, patience }
    }

    /// Method of the request.
    pub fn method(&self) -> &Method {
        self.request.method()
    }

    /// Path below the token, which begins with `/`.
    pub fn path(&self) -> &str {
        &self.path
    }

    /// Text after the `?` of the address.
    pub fn query(&self) -> Option<&str> {
        self.request.uri().query()
    }

    /// Returns the content, at most `most_bytes` long.
    ///
    /// # Errors
    /// The reply to content that is too long, that does not arrive in time, or whose connection breaks.
    pub async fn content(self, most_bytes: usize) -> Result<Bytes, Reply> {
        let content = Limited::new(self.request.into_body(), most_bytes).collect();
        match timeout(self.patience, content).await {
            Ok(Ok(content)) => Ok(content.to_bytes()),
            Ok(Err(fault)) if fault.is::<LengthLimitError>() => {
                let error = format!("a question has at most {most_bytes} bytes");
                Err(Reply::refused(StatusCode::PAYLOAD_TOO_LARGE, error))
            }
            Ok(Err(fault)) => Err(Reply::refused(StatusCode::BAD_REQUEST, fault.to_string())),
            Err(_) => Err(Reply::refused(StatusCode::REQUEST_TIMEOUT, "the question did not come")),
        }
    }
}
