use std::time::Duration;

/// Limits of the connections to a server. Each connection carries one request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ServerLimits {
    /// Maximum number of simultaneous connections, at least 1. For each further one the oldest without a whole request is
    /// closed, or else the oldest. Default 256: fifty times what a browser opens, and a quarter of the files that a process may
    /// usually open.
    pub connections: usize,
    /// Timeout of the head of a request, from the opening of the connection on, and then of its content. Default 2 s: they
    /// normally arrive at once.
    pub request: Duration,
    /// Maximum duration of a connection. Default 2 min: enough for a large page over a forwarded port.
    pub connection: Duration,
}

impl Default for ServerLimits {
    fn default() -> Self {
        Self { connections: 256, request: Duration::from_secs(2), connection: Duration::from_mins(2) }
    }
}
