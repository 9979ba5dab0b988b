//! Files of any kind: read with a place for each fault, written whole or not at all.

pub(crate) mod atomic_file;
pub(crate) mod number_table;
pub(crate) mod sizes;
pub(crate) mod yaml;
