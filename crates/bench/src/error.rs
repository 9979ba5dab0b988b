use std::path::PathBuf;

/// What can be wrong with a campaign, its results or a worker. What a planner does wrong is none of these: it is
/// an outcome of its trial.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum BenchError {
    /// A file of results is not there.
    #[error("{}: there are no results (`cranny bench run -o {}` makes some)", path.display(), path.display())]
    NoResults {
        /// The file.
        path: PathBuf,
    },
    /// A file is no results of Cranny.
    #[error("{}: the file holds no results of campaigns; give one that `cranny bench run` wrote", path.display())]
    NotResults {
        /// The file.
        path: PathBuf,
    },
    /// Results were written by another version of Cranny.
    #[error("{}: the results are of version {actual}, and this program knows version {expected}", path.display())]
    ResultsVersion {
        /// The file.
        path: PathBuf,
        /// The version that can be read.
        expected: i64,
        /// The version that the file has.
        actual: i64,
    },
    /// A row of the results says what it cannot.
    #[error("{}: trial {id}: '{text}' is no {what}", path.display())]
    Row {
        /// The file.
        path: PathBuf,
        /// Which trial.
        id: u64,
        /// What the text should have been.
        what: &'static str,
        /// What stands there.
        text: String,
    },
    /// There is no such trial.
    #[error("{}: there is no trial {id} (the trials are 1 to {last})", path.display())]
    NoTrial {
        /// The file.
        path: PathBuf,
        /// The one asked for.
        id: u64,
        /// The last there is.
        last: u64,
    },
    /// The database refuses.
    #[error("{}: {reason}", path.display())]
    Database {
        /// The file.
        path: PathBuf,
        /// What it says.
        reason: rusqlite::Error,
    },
    /// A trial with a figure that no trial can have.
    #[error("trial {trial}: its {figure} is {value}, which no trial can have")]
    Figure {
        /// Number of the trial.
        trial: u64,
        /// Which figure.
        figure: &'static str,
        /// What stands there.
        value: f64,
    },
    /// There is nothing to report.
    #[error("{results}: the results hold no trial; `cranny bench run -o {results}` adds some")]
    NoTrials {
        /// Name of the results.
        results: String,
    },
    /// A plot could not be made into pixels.
    #[error("cannot draw '{plot}': {problem}")]
    Picture {
        /// Name of the plot.
        plot: String,
        /// What the library says.
        problem: String,
    },
}
