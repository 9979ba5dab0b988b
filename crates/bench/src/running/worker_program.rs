use std::path::PathBuf;

/// The program that serves trials: `cranny bench worker`, or whatever else calls [`serve`](crate::serve).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WorkerProgram {
    /// The program.
    pub program: PathBuf,
    /// Its arguments.
    pub arguments: Vec<String>,
}
