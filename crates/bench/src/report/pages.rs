//! Pages of a report.

pub(crate) mod page;
pub(crate) mod page_excerpt;
mod page_figures;
pub(crate) mod page_overall;
pub(crate) mod page_scenarios;
pub(crate) mod page_tables;
