//! Tests of data sets, as one program.

mod recipes;
mod sets;
