use std::io;

/// Errors of a server; a request that cannot be answered is none.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ServerError {
    /// A port is unavailable.
    #[error("port {port} of 127.0.0.1 cannot be used: {reason}; leave out --port for a free one")]
    Port {
        /// Requested port.
        port: u16,
        /// Error of the operating system.
        reason: io::Error,
    },
    /// The server cannot start.
    #[error("the server cannot start: {reason}")]
    Start {
        /// Error of the operating system.
        reason: io::Error,
    },
}
