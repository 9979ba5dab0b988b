use std::path::PathBuf;

use serde::{Deserialize, Serialize};

/// Program that serves trials: `cranny bench worker`, or any other that calls [`serve`](crate::serve).
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WorkerProgram {
    /// The program.
    pub program: PathBuf,
    /// Its arguments.
    pub arguments: Vec<String>,
}
