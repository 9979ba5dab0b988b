#![doc = include_str!("../README.md")]

mod axis;
mod drawing;
mod error;
mod frame;
mod letters;
mod palette;
mod pdf;
mod pixels;
mod strokes;
mod svg;

pub use axis::{Axis, Scale};
pub use drawing::{Anchor, Dash, Drawing, Emphasis, Ink, Mark, Point, SMALL};
pub use error::ChartError;
pub use frame::{Entry, Frame};
