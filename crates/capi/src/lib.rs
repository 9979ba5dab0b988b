#![doc = include_str!("../README.md")]
#![allow(unsafe_code, reason = "functions under names of C, and the pointers of C in `boundary`")]
#![allow(
    clippy::doc_markdown,
    reason = "doc comments become those of a C header, which shows marks as they are"
)]
#![allow(
    clippy::unnecessary_box_returns,
    clippy::unnecessary_wraps,
    reason = "handles are boxes, and all constructors have one form"
)]
#![allow(clippy::missing_errors_doc, reason = "the head of the header states how every function fails")]

mod boundary;
mod cell;
mod error;
mod grasps;
mod kinematics;
mod motion;
mod options;
mod plan;
mod planning;
mod robot;
mod samples;
mod scenario;
mod text;
mod verification;
mod version;
mod world;
