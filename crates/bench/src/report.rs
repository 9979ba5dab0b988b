//! Reports of trials: a [`Summary`] holds every figure; pages, tables and plots show it and compute nothing.

mod axis;
mod box_plot;
mod comparison;
mod configuration;
mod difficulty_plot;
mod drawing;
mod follow_up;
mod frame;
mod number_text;
mod page;
mod page_figures;
mod page_tables;
mod paper_table;
mod picture;
mod place;
mod plot;
mod row;
mod success_curve;
mod success_plot;
mod summary;
mod warning;
mod worst_trial;

pub use comparison::Comparison;
pub(crate) use configuration::{Configuration, Names};
pub use paper_table::PaperTable;
pub use place::Place;
pub use plot::{Plot, plots};
pub use row::{GoalRow, Row};
pub use success_curve::{Measure, SuccessCurve};
pub use summary::{RunOrigin, Summary, SummarySource};
pub use worst_trial::WorstTrial;
