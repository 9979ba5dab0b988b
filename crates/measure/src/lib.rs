#![doc = include_str!("../README.md")]

pub mod motion_bench_maker;
