use clap::ValueEnum;
use cranny_grasp::{COVERAGE_THRESHOLD, Grasp, covering_subset, farthest_subset, random_subset};

/// Method for choosing a few grasps from many.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum GraspChoice {
    /// Cover as many candidates as possible: within 15 (mm + degrees) of a chosen grasp
    Covering,
    /// Repeatedly the grasp farthest from all chosen ones
    Farthest,
    /// Uniformly at random
    Random,
}

impl GraspChoice {
    /// Returns the indices of the chosen grasps.
    pub fn choose(self, grasps: &[Grasp], count: usize, seed: u64) -> Vec<usize> {
        match self {
            Self::Covering => covering_subset(grasps, count, COVERAGE_THRESHOLD),
            Self::Farthest => farthest_subset(grasps, count, seed),
            Self::Random => random_subset(grasps.len(), count, seed),
        }
    }
}
