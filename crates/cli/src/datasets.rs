//! `cranny dataset`: sets of proven demonstrations.

pub(crate) mod dataset;
pub(crate) mod dataset_check;
pub(crate) mod dataset_export;
pub(crate) mod dataset_generate;
