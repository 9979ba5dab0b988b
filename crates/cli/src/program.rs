//! The program itself: help, licences, completions, self-test.

pub(crate) mod completions;
pub(crate) mod doctor;
pub(crate) mod help;
pub(crate) mod licences;
pub(crate) mod manual;
pub(crate) mod version;
