#![doc = include_str!("../README.md")]

pub mod clouds;
pub mod known_bodies;
pub mod motion_bench_maker;
