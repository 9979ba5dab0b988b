//! Nothing but its manifest: it asks of crates that programs and tests share the features that the tests ask. Cargo builds a
//! crate anew for each set of features, and what stands on it; with one set for all, `cargo run`, `cargo xtask test` and the
//! wheel build each crate once.
//!
//! What belongs there is what `cargo tree -e normal,build -p cranny-cli -f '{p} {f}'` (and `-p cranny-python`) has otherwise
//! than `cargo tree --workspace -f '{p} {f}'`; nothing breaks where it is not complete, but takes minutes longer.
//!
//! ## Limits
//! No code.
