//! Baselines that are not variants of another planner here: those of OMPL's list, and `CBiRRT2`.

pub(crate) mod cbirrt2;
pub(crate) mod est;
pub(crate) mod kpiece;
pub(crate) mod lazy_prm;
