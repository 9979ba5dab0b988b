//! Baselines of OMPL's list that are not variants of another planner here.

pub(crate) mod est;
pub(crate) mod kpiece;
pub(crate) mod lazy_prm;
