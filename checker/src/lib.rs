//! Checker of certificates of motions, `cranny-certificate/1`: see `docs/certificate.md`, whose inequalities the comments cite.
//! It depends on the standard library alone, searches for nothing, and trusts nothing that a certificate states.

mod certificate;
mod digest;
mod enclosure;
mod interval;
#[cfg(test)]
mod interval_tests;
mod lines;
mod motion;
mod proof;
mod scene;
mod solid;

pub use certificate::check;
pub use digest::sha256;
