//! All tests of this crate from outside: one program, which is linked once.

mod carrying;
mod page_data;
mod page_server;
mod pictures;
mod recordings;
mod scenes;
