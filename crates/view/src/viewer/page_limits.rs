use std::time::Duration;

/// What connections to a page may ask of its server. Each carries one request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PageLimits {
    /// Connections at the same time, at least 1; others wait. Default 64: ten times what a browser opens.
    pub connections: usize,
    /// Within which the head of a request has to come, and then its body. Default 10 s: they come at once.
    pub request: Duration,
    /// After which a connection is cut whatever it does. Default 2 min: a large page over a forwarded port.
    pub connection: Duration,
}

impl Default for PageLimits {
    fn default() -> Self {
        let (request, connection) = (Duration::from_secs(10), Duration::from_mins(2));
        Self { connections: 64, request, connection }
    }
}
