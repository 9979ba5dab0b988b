//! Integration tests of this crate, in one program that is linked once.

#![allow(clippy::disallowed_methods, reason = "what is compared to may come from the system")]

mod file_readers;

/// Folder of `file_readers` in this crate.
const HERE: &str = "tests/file_readers";

mod answers;
mod any_bytes;
mod bad_input;
mod bench;
mod bench_report;
#[cfg(unix)]
mod campaigns;
mod certificates;
mod changed_certificates;
#[cfg(target_os = "linux")]
mod cheating_planners;
#[cfg(target_os = "linux")]
mod cluster;
mod colours;
mod commands;
#[cfg(target_os = "linux")]
mod enclosed_planners;
mod explore;
mod false_proofs;
#[cfg(unix)]
mod foreign_planners;
mod golden;
mod holding;
mod moveit;
mod mutation;
mod mutation_pairs;
mod optimisation;
#[cfg(unix)]
mod output_files;
#[cfg(unix)]
mod pages;
mod pictures;
mod roadmap;
mod robots;
#[cfg(target_os = "linux")]
mod sabotaging_planners;
mod scenarios;
mod seen_space;
mod serve;
mod simulation;
#[cfg(unix)]
mod stopped;
mod tools;
mod trajectory;
mod view;
mod workshop;
