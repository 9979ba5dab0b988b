use clap::ValueEnum;
use cranny_grasp::{COVERAGE_THRESHOLD, Grasp, covering_subset, farthest_subset, random_subset};

/// How few grasps are chosen from many.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum GraspChoice {
    /// So that as many as possible of all are within 15 (mm + degrees) of a chosen one
    Covering,
    /// Always the one farthest from all chosen before
    Farthest,
    /// Each as likely as any other
    Random,
}

impl GraspChoice {
    /// Indices of the chosen ones.
    pub fn choose(self, grasps: &[Grasp], count: usize, seed: u64) -> Vec<usize> {
        match self {
            Self::Covering => covering_subset(grasps, count, COVERAGE_THRESHOLD),
            Self::Farthest => farthest_subset(grasps, count, seed),
            Self::Random => random_subset(grasps.len(), count, seed),
        }
    }
}
