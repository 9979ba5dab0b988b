//! `cranny bench`: campaigns, their reports, clusters.

pub(crate) mod bench;
pub(crate) mod bench_export;
pub(crate) mod bench_merge;
pub(crate) mod bench_problem;
pub(crate) mod bench_replay;
pub(crate) mod bench_report;
pub(crate) mod bench_run;
pub(crate) mod bench_slurm;
pub(crate) mod bench_status;
pub(crate) mod bench_worker;
pub(crate) mod cluster_folder;
pub(crate) mod cluster_scripts;
pub(crate) mod report_paths;
pub(crate) mod report_pictures;
pub(crate) mod slurm;
