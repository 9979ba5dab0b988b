//! Crate without code; only its manifest matters. It requests the crate features that the tests need, so that programs and
//! tests share them. Cargo rebuilds a crate and its dependents for each set of features; with one set for all, `cargo run`,
//! `cargo xtask test` and the wheel build each crate once.
//!
//! The manifest should list every difference between `cargo tree -e normal,build -p cranny-cli -f '{p} {f}'` (and `-p
//! cranny-python`) and `cargo tree --workspace -f '{p} {f}'`. A missing entry breaks nothing, but builds take minutes longer.
//!
//! ## Limits
//! No code.
