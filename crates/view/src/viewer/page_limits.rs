use std::time::Duration;

/// Limits of the connections to a page server. Each connection carries one request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PageLimits {
    /// Maximum number of simultaneous connections, at least 1; others wait. Default 64: ten times what a browser opens.
    pub connections: usize,
    /// Timeout of the head of a request, and then of its content. Default 10 s: they normally arrive at once.
    pub request: Duration,
    /// Maximum duration of a connection. Default 2 min: enough for a large page over a forwarded port.
    pub connection: Duration,
}

impl Default for PageLimits {
    fn default() -> Self {
        let (request, connection) = (Duration::from_secs(10), Duration::from_mins(2));
        Self { connections: 64, request, connection }
    }
}
