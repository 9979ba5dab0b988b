use cranny_spatial::Stream;

/// Sequence of points that fills the unit cube evenly from the first point on, where random points leave gaps and clusters:
/// `p(n) = p(0) + n · (√2, √3, √5, …)` modulo 1 (Richtmyer 1951, "The evaluation of definite integrals, and a quasi-Monte-Carlo
/// method based on the properties of algebraic numbers", whole). Even samples serve a search better than random ones
/// (`LaValle`, Branicky & Lindemann 2004, "On the relationship between classical grid search and probabilistic roadmaps",
/// whole).
#[derive(Clone, Debug)]
pub(crate) struct EvenSequence {
    point: Vec<f64>,
    steps: Vec<f64>,
}

impl EvenSequence {
    /// Creates a sequence of this dimension that begins at a random point.
    pub fn new(dimensions: usize, random: &mut Stream) -> Self {
        let is_prime = |n: &u32| {
            (2..*n).take_while(|factor| factor * factor <= *n).all(|factor| !n.is_multiple_of(factor))
        };
        let steps = (2..).filter(is_prime).map(|prime| f64::from(prime).sqrt()).take(dimensions);
        Self { point: (0..dimensions).map(|_| random.uniform()).collect(), steps: steps.collect() }
    }

    /// Returns the next point: one coordinate per dimension, in [0, 1), without a unit.
    pub fn next(&mut self) -> &[f64] {
        for (x, step) in self.point.iter_mut().zip(&self.steps) {
            *x += step;
            *x -= x.floor();
        }
        &self.point
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks the share of n points in an interval, which is off by about 1 / n for even points, by 1 / √n for random ones.
    #[test]
    fn every_stretch_of_every_axis_gets_its_share() {
        const COUNT: u32 = 1000;
        for seed in 0..5 {
            let mut sequence = EvenSequence::new(9, &mut Stream::new(seed, 0));
            let points: Vec<Vec<f64>> = (0..COUNT).map(|_| sequence.next().to_vec()).collect();
            for axis in 0..9 {
                let below = |bar: f64| points.iter().filter(|point| point[axis] < bar).count() as f64;
                let off = |tenth: u32| {
                    let bar = f64::from(tenth) / 10.0;
                    (below(bar) / f64::from(COUNT) - bar).abs()
                };
                let worst = (1..10).map(off).fold(0.0, f64::max);
                assert!(worst < 0.007, "axis {axis}: {worst}");
                assert!(points.iter().all(|point| (0.0..1.0).contains(&point[axis])));
            }
        }
    }
}
