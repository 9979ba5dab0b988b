use std::path::PathBuf;

/// Errors of scenes, pictures, pages and recordings.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ViewError {
    /// A visual mesh of a robot is missing.
    #[error("link '{link}' of the robot is drawn as '{mesh}', which is not found; tried:{}", listed(tried))]
    VisualNotFound {
        /// Name of the link.
        link: String,
        /// Name of the mesh in the URDF.
        mesh: String,
        /// Paths that were tried.
        tried: Vec<PathBuf>,
    },
    /// The visual meshes of a robot have more triangles than are drawn.
    #[error(
        "the visual meshes of the robot have more than {most} triangles; draw it with fewer or simpler ones"
    )]
    ManyTriangles {
        /// Maximum number.
        most: usize,
    },
    /// A mesh cannot be read.
    #[error(transparent)]
    Shape(#[from] cranny_shape::ShapeError),
    /// A path cannot be sampled.
    #[error(transparent)]
    Path(#[from] cranny_path::PathError),
    /// A scenario or another file cannot be read.
    #[error(transparent)]
    Scenario(#[from] cranny_scenario::ScenarioError),
    /// A way point has the wrong number of values.
    #[error("way point {waypoint} has {actual} values instead of {expected}")]
    Waypoint {
        /// Index of the way point, from 0.
        waypoint: usize,
        /// Number of joints of the robot.
        expected: usize,
        /// Number of values given.
        actual: usize,
    },
    /// A picture has too few or too many pixels.
    #[error("a picture of {width} × {height} points cannot be drawn; each side is 16 to {most} points long")]
    Size {
        /// Requested width, in pixels.
        width: usize,
        /// Requested height, in pixels.
        height: usize,
        /// Maximum side length, in pixels.
        most: usize,
    },
    /// A picture file cannot be encoded.
    #[error("{}: {reason}", path.display())]
    Encoding {
        /// Path of the file.
        path: PathBuf,
        /// Message of the encoder.
        reason: String,
    },
    /// The encoder of films is not installed.
    #[error(
        "a film in .mp4 is encoded by ffmpeg, which is not on the PATH: install it (Debian: apt install ffmpeg), or write a \
         .gif or .apng"
    )]
    NoFilmEncoder,
    /// A recording has an invalid value.
    #[error("{}: {problem}", path.display())]
    Recording {
        /// Path of the file.
        path: PathBuf,
        /// Description of the fault and of valid values.
        problem: String,
    },
    /// Page data or a recording cannot be written as JSON.
    #[error("what is shown cannot be written as JSON: {reason}")]
    PageData {
        /// Error of the encoder.
        reason: serde_json::Error,
    },
    /// The program was built without the page.
    #[error(
        "this cranny was built without its page: install Node 20 or later (https://nodejs.org), then build it \
         again (`touch crates/view/build.rs`, `cargo build --release`)"
    )]
    NoPage,
    /// The page cannot be served.
    #[error(transparent)]
    Server(#[from] cranny_local_server::ServerError),
    /// A file or folder cannot be written.
    #[error("{}: cannot be written: {reason}", path.display())]
    Unwritable {
        /// Path of the file or folder.
        path: PathBuf,
        /// Error of the operating system.
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
