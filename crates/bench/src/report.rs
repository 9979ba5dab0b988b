//! Reports of trials: a [`Summary`] contains every figure; pages, tables and plots only display them.

mod comparison;
mod configuration;
mod drawn;
mod enclosure;
mod follow_up;
mod machine;
mod number_text;
mod overall;
mod pages;
mod paper_table;
mod planner_rank;
mod row;
mod scenario_class;
mod split_row;
mod summary;
mod warning;
mod worst_trial;

pub use comparison::{Comparison, Finding};
pub(crate) use configuration::{Configuration, Names};
pub use drawn::plot::Plot;
pub use drawn::plots::plots;
pub use drawn::success_curve::{Measure, SuccessCurve};
pub use enclosure::{Enclosure, Png};
pub use machine::Machine;
pub use overall::Overall;
pub use paper_table::PaperTable;
pub use row::{GoalRow, Row};
pub use scenario_class::ScenarioClass;
pub use split_row::SplitRow;
pub use summary::{Summary, SummarySource};
pub use worst_trial::WorstTrial;
