use std::path::PathBuf;

/// Program that serves trials: `cranny bench worker`, or any other that calls [`serve`](crate::serve).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WorkerProgram {
    /// The program.
    pub program: PathBuf,
    /// Its arguments.
    pub arguments: Vec<String>,
}
