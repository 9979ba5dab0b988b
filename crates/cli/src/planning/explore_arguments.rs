use std::path::PathBuf;

use clap::{Args, ValueEnum};

use crate::number_argument::whole;

/// Options of an exploration.
#[derive(Clone, Debug, Args)]
pub struct ExploreArguments {
    /// Explore ID, a true scenario: render a view, plan in the space that was seen to be free, and if no plan is proven there,
    /// move the camera to where it sees most of what blocks the best candidate, until one is. Writes a folder with what was
    /// seen, as a scenario, and the plan
    #[arg(long, conflicts_with_all = [
        "moveit", "carry", "place", "goal_region", "named_task", "steps", "robust", "try_in_physics", "certificate", "rate",
        "approach", "retreat", "clear", "then", "optimise",
    ])]
    pub explore: bool,
    /// With --explore: maximum number of views, with the first one [default: 8]
    #[arg(long, value_name = "N", requires = "explore", value_parser = whole::<usize>(1..=64))]
    pub views: Option<usize>,
    /// With --explore: camera that is moved [default: fixed]
    #[arg(long, value_enum, requires = "explore")]
    pub camera: Option<CameraArgument>,
    /// With --explore: file of cameras as of `cranny sense`. The first one takes the first view, the first of the kind the
    /// others [default: the first of the default cameras of `cranny sense`]
    #[arg(long, value_name = "FILE", requires = "explore")]
    pub cameras: Option<PathBuf>,
    /// With --explore: obstacles whose places are known, comma-separated, for example the support of the target
    #[arg(long, value_name = "NAMES", requires = "explore", value_delimiter = ',')]
    pub known: Vec<String>,
    /// With --explore: draw errors within the bounds of the sensor from this seed; without it the depths are exact
    #[arg(long, value_name = "N", requires = "explore")]
    pub noise_seed: Option<u64>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum CameraArgument {
    /// A free-standing camera
    Fixed,
    /// A camera on the hand (`frame: link NAME` in the file of cameras), moved by proven motions
    Hand,
}
