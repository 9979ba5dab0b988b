//! Plots of a report.

pub(crate) mod box_plot;
pub(crate) mod difficulty_plot;
pub(crate) mod plot;
pub(crate) mod plots;
pub(crate) mod profile_plot;
pub(crate) mod success_curve;
pub(crate) mod success_plot;
