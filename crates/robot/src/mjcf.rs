//! Reader of MJCF, the XML format of `MuJoCo` (XML reference, version 3).

pub(crate) mod assets;
pub(crate) mod bodies;
pub(crate) mod body_reader;
pub(crate) mod compiler;
pub(crate) mod constraints;
pub(crate) mod defaults;
pub(crate) mod documents;
pub(crate) mod geoms;
pub(crate) mod model;
pub(crate) mod tendons;

pub(crate) use model::read;
