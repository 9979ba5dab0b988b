//! Checker of certificates of motions, `cranny-certificate/1`: see `docs/certificate.md`, whose inequalities the comments cite.
//! It depends on the standard library alone, searches for nothing, and trusts nothing that a certificate states.

mod digest;
mod interval;
#[cfg(test)]
mod interval_tests;
mod proof;
mod reader;
mod scene;

pub use digest::sha256;
pub use reader::{Certified, CertifiedScene, Refusal, check};
