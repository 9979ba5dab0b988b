#![doc = include_str!("../README.md")]

mod call;
mod error;
mod limits;
mod open_connections;
mod reply;
mod server;
mod token;

pub use call::Call;
pub use error::ServerError;
pub use hyper::body::Bytes;
pub use hyper::header;
pub use hyper::{Method, StatusCode};
pub use limits::ServerLimits;
pub use reply::Reply;
pub use server::LocalServer;
