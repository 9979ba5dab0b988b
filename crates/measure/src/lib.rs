#![doc = include_str!("../README.md")]

pub mod clouds;
pub mod motion_bench_maker;
