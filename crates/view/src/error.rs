use std::path::PathBuf;

/// Why something cannot be shown, or a picture not be written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ViewError {
    /// A mesh that a robot is drawn with is not there.
    #[error("link '{link}' of the robot is drawn as '{mesh}', which is not found; tried:{}", listed(tried))]
    VisualNotFound {
        /// The link.
        link: String,
        /// Its name in the URDF.
        mesh: String,
        /// Where it was looked for.
        tried: Vec<PathBuf>,
    },
    /// A mesh cannot be read.
    #[error(transparent)]
    Shape(#[from] cranny_shape::ShapeError),
    /// A path cannot be sampled.
    #[error(transparent)]
    Path(#[from] cranny_path::PathError),
    /// What writes a file.
    #[error(transparent)]
    Scenario(#[from] cranny_scenario::ScenarioError),
    /// A way point of another robot.
    #[error("way point {waypoint} has {actual} values instead of {expected}")]
    Waypoint {
        /// Which, from 0.
        waypoint: usize,
        /// Joints of the robot.
        expected: usize,
        /// Values that there are.
        actual: usize,
    },
    /// A picture without or with far too many points.
    #[error("a picture of {width} × {height} points cannot be drawn; each side is 16 to {most} points long")]
    Size {
        /// What was asked for.
        width: usize,
        /// What was asked for.
        height: usize,
        /// The most that there may be.
        most: usize,
    },
    /// A picture file cannot be encoded.
    #[error("{}: {reason}", path.display())]
    Encoding {
        /// The file.
        path: PathBuf,
        /// What the encoder says.
        reason: String,
    },
    /// A recording says what cannot be.
    #[error("{}: {problem}", path.display())]
    Recording {
        /// The file.
        path: PathBuf,
        /// What is wrong with it, and what would fit.
        problem: String,
    },
    /// What a page is told, or a recording, cannot be written as JSON.
    #[error("what is shown cannot be written as JSON: {reason}")]
    PageData {
        /// What the encoder says.
        reason: serde_json::Error,
    },
    /// The program was built without the page.
    #[error(
        "this cranny was built without its page: install Node 20 or later (https://nodejs.org), then build it \
         again (`touch crates/view/build.rs`, `cargo build --release`)"
    )]
    NoPage,
    /// A port cannot be had.
    #[error("port {port} of 127.0.0.1 cannot be used: {reason}; leave out --port for a free one")]
    Port {
        /// Which.
        port: u16,
        /// Why.
        reason: std::io::Error,
    },
    /// Nothing can be served here.
    #[error("the page cannot be served: {reason}")]
    Server {
        /// Why.
        reason: std::io::Error,
    },
    /// A file or folder cannot be written.
    #[error("{}: cannot be written: {reason}", path.display())]
    Unwritable {
        /// Which.
        path: PathBuf,
        /// Why.
        reason: std::io::Error,
    },
}

fn listed(paths: &[PathBuf]) -> String {
    if paths.is_empty() {
        return " nothing, for the robot has no folder".to_owned();
    }
    let lines: Vec<String> = paths.iter().map(|path| format!("\n  {}", path.display())).collect();
    lines.concat()
}
