use cranny_spatial::Stream;

use crate::Robot;

/// Interpolates linearly between `a` (at 0) and `b` (at 1), both (m, rad; one per joint), at `share`; exact at both ends.
pub fn between(a: &[f64], b: &[f64], share: f64) -> impl Iterator<Item = f64> {
    a.iter().zip(b).map(move |(a, b)| if share >= 1.0 { *b } else { a + (b - a) * share })
}

/// Returns the L2 distance of two configurations (m, rad; one per joint); metres and radians have equal weight.
pub fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
}

impl Robot {
    /// Draws a configuration (m, rad; one per joint) uniformly from within the joint limits, the first joint first.
    pub fn random_configuration(&self, random: &mut Stream) -> Vec<f64> {
        self.limits.iter().map(|limits| random.uniform_between(limits.lower, limits.upper)).collect()
    }
}
