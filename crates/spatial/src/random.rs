use rand::Rng;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::Rotation;

/// Random numbers of one trial: a `ChaCha` stream chosen by `(seed, trial)`.
///
/// All draws are defined here in terms of the generator's 64-bit words, so that no release of a library can change them:
/// `uniform = (word >> 11) · 2⁻⁵³`.
#[derive(Clone, Debug)]
pub struct Stream {
    words: ChaCha8Rng,
}

impl Stream {
    /// Creates the stream of `trial` under `seed`. Streams of different trials are independent.
    pub fn new(seed: u64, trial: u64) -> Self {
        let mut words = ChaCha8Rng::seed_from_u64(seed);
        words.set_stream(trial);
        Self { words }
    }

    /// Draws a number uniform in [0, 1).
    pub fn uniform(&mut self) -> f64 {
        const STEP: f64 = 1.0 / (1u64 << 53) as f64;
        (self.words.next_u64() >> 11) as f64 * STEP
    }

    /// Draws a number uniform in [`low`, `high`).
    pub fn uniform_between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.uniform()
    }

    /// Draws an index uniform in 0..`count`, by multiplication (Lemire 2019, "Fast random integer generation in an interval",
    /// whole, without its rejection: the bias is below `count`·2⁻⁶⁴).
    ///
    /// # Panics
    /// If `count` is zero.
    pub fn index(&mut self, count: usize) -> usize {
        assert!(count > 0, "an index needs at least one element to choose from");
        let scaled = (u128::from(self.words.next_u64()) * count as u128) >> 64;
        usize::try_from(scaled).unwrap_or(count - 1)
    }

    /// Draws a number from the standard normal distribution (Box & Muller 1958, "A note on the generation of random normal
    /// deviates", whole; the cosine branch alone).
    pub fn normal(&mut self) -> f64 {
        let radius = (-2.0 * libm::log(1.0 - self.uniform())).sqrt();
        radius * libm::cos(std::f64::consts::TAU * self.uniform())
    }

    /// Draws a rotation uniform over SO(3) (Shoemake 1992, "Uniform random rotations", Graphics Gems III, ch. III.6).
    pub fn rotation(&mut self) -> Rotation {
        let (u, a, b) = (self.uniform(), self.uniform(), self.uniform());
        let (sin_a, cos_a) = crate::sin_cos(std::f64::consts::TAU * a);
        let (sin_b, cos_b) = crate::sin_cos(std::f64::consts::TAU * b);
        let (s, t) = ((1.0 - u).sqrt(), u.sqrt());
        Rotation::from_quaternion(nalgebra::Quaternion::new(t * cos_b, s * sin_a, s * cos_a, t * sin_b))
    }
}

/// Returns another seed for every round, far from those that people choose (Steele, Lea & Flood 2014, "Fast splittable
/// pseudorandom number generators", whole, of which only the increment `GOLDEN_GAMMA` is used).
pub fn other_seed(seed: u64, round: u64) -> u64 {
    const GOLDEN: u64 = 0x9E37_79B9_7F4A_7C15;
    seed.wrapping_add(round.wrapping_mul(GOLDEN))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_seed_gives_the_same_numbers_for_ever() {
        let mut stream = Stream::new(7, 3);
        let drawn: Vec<u64> = (0..3).map(|_| stream.uniform().to_bits()).collect();
        let mut again = Stream::new(7, 3);
        assert_eq!(drawn, (0..3).map(|_| again.uniform().to_bits()).collect::<Vec<_>>());
        assert_ne!(drawn[0], Stream::new(7, 4).uniform().to_bits());
        assert_ne!(drawn[0], Stream::new(8, 3).uniform().to_bits());
    }

    #[test]
    fn uniform_draws_have_the_moments_of_a_uniform_distribution() {
        let mut stream = Stream::new(1, 0);
        let draws: Vec<f64> = (0..100_000).map(|_| stream.uniform()).collect();
        let count = draws.len() as f64;
        let mean = draws.iter().sum::<f64>() / count;
        let variance = draws.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / count;
        assert!((mean - 0.5).abs() < 0.005 && (variance - 1.0 / 12.0).abs() < 0.002);
    }

    #[test]
    fn indices_reach_every_element() {
        let mut stream = Stream::new(2, 0);
        let mut seen = [0; 5];
        for _ in 0..5000 {
            seen[stream.index(5)] += 1;
        }
        assert!(seen.iter().all(|&count| count > 850), "{seen:?}");
    }
}
