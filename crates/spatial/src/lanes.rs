use std::sync::OnceLock;

use fearless_simd::prelude::*;
use fearless_simd::{Level, Simd, f32x16, i32x16};

/// Returns the instruction set of the vector lanes: the widest that the machine has, or the one named by the environment
/// variable `CRANNY_SIMD` (`sse2`, `avx2`, `avx512`) if the machine has it. Results are bit-identical with all of them.
pub fn simd_level() -> Level {
    named_level().1
}

/// Returns the name of [`simd_level`] in [`simd_levels`].
pub fn simd_level_name() -> &'static str {
    named_level().0
}

fn named_level() -> (&'static str, Level) {
    static LEVEL: OnceLock<(&str, Level)> = OnceLock::new();
    *LEVEL.get_or_init(|| {
        let levels = simd_levels();
        let asked = std::env::var("CRANNY_SIMD").ok();
        let named = asked.and_then(|asked| levels.iter().find(|(name, _)| *name == asked).copied());
        named.unwrap_or_else(|| (levels.last().map_or("widest", |(name, _)| name), Level::new()))
    })
}

/// Returns the instruction sets that lanes are compiled for and this machine has. With SSE4.2 alone a machine uses SSE2
/// (`.cargo/config.toml`); machines other than x86 have one level each.
pub fn simd_levels() -> Vec<(&'static str, Level)> {
    let best = Level::new();
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    let levels = [
        ("sse2", best.as_sse2().map(Level::Sse2)),
        ("avx2", best.as_avx2().map(Level::Avx2)),
        ("avx512", best.as_avx512().map(Level::Avx512)),
    ];
    #[cfg(not(any(target_arch = "x86", target_arch = "x86_64")))]
    let levels = [("widest", Some(best))];
    levels.into_iter().filter_map(|(name, level)| Some((name, level?))).collect()
}

/// Number of configurations computed at once: one register of the widest instruction set in use.
pub const LANES: usize = 16;

/// One number for each of [`LANES`] configurations, in memory.
pub type LaneArray = [f32; LANES];

/// Maximum absolute value of an angle whose sine and cosine are computed in lanes, in radians; the whole range is tested.
pub const MOST_TURN_IN_LANES_RAD: f64 = 1e3;

/// Maximum error of a sine or a cosine in lanes; tested on a grid of 6.4 million angles.
pub const SINE_ERROR_IN_LANES: f64 = 2e-7;

/// Returns sine and cosine of every lane, bit-identical under every instruction set, with an error of at most
/// [`SINE_ERROR_IN_LANES`] for angles up to ±[`MOST_TURN_IN_LANES_RAD`], and an unbounded error beyond. The angle is reduced to
/// ±π/4 by subtracting multiples of π/2, split into three terms (Cody & Waite 1980, ch. 8), then both polynomials are evaluated
/// (coefficients: Moshier, Cephes `sinf`).
#[inline(always)]
pub fn sin_cos_lanes<S: Simd>(simd: S, angle: f32x16<S>) -> (f32x16<S>, f32x16<S>) {
    let quarter_turns = (angle * std::f32::consts::FRAC_2_PI).round_ties_even();
    let reduced =
        angle - quarter_turns * 1.570_312_5 - quarter_turns * 4.837_513e-4 - quarter_turns * 7.549_79e-8;
    let square = reduced * reduced;
    let sine = (square * -1.951_529_6e-4 + 8.332_161e-3) * square + -1.666_665_5e-1;
    let sine = sine * square * reduced + reduced;
    let cosine = (square * 2.443_315_7e-5 + -1.388_731_6e-3) * square + 4.166_664_6e-2;
    let cosine = cosine * square * square - square * 0.5 + 1.0;
    let quadrant = i32x16::truncate_from(quarter_turns);
    let (one, two) = (i32x16::splat(simd, 1), i32x16::splat(simd, 2));
    let is_odd = (quadrant & one).simd_eq(one);
    let (sine, cosine) = (is_odd.select(cosine, sine), is_odd.select(sine, cosine));
    let sine = (quadrant & two).simd_eq(two).select(-sine, sine);
    let cosine = ((quadrant + one) & two).simd_eq(two).select(-cosine, cosine);
    (sine, cosine)
}

/// A vector or point of every lane, in metres. Its functions take no closures and must not be called inside one: a closure
/// would lose the instruction set of the enclosing function.
#[must_use]
#[derive(Clone, Copy, Debug)]
pub struct LaneVector<S: Simd> {
    /// Along x.
    pub x: f32x16<S>,
    /// Along y.
    pub y: f32x16<S>,
    /// Along z.
    pub z: f32x16<S>,
}

impl<S: Simd> LaneVector<S> {
    /// Returns one vector repeated in every lane.
    #[inline(always)]
    pub fn splat(simd: S, [x, y, z]: [f32; 3]) -> Self {
        Self { x: f32x16::splat(simd, x), y: f32x16::splat(simd, y), z: f32x16::splat(simd, z) }
    }

    /// Loads the lanes from memory, coordinate by coordinate.
    #[inline(always)]
    pub fn load(simd: S, [x, y, z]: &[LaneArray; 3]) -> Self {
        Self {
            x: f32x16::from_slice(simd, x),
            y: f32x16::from_slice(simd, y),
            z: f32x16::from_slice(simd, z),
        }
    }

    /// Stores the lanes to memory.
    #[inline(always)]
    pub fn store(self, [x, y, z]: &mut [LaneArray; 3]) {
        self.x.store_slice(x);
        self.y.store_slice(y);
        self.z.store_slice(z);
    }

    /// Returns the sum.
    #[inline(always)]
    pub fn plus(self, other: Self) -> Self {
        Self { x: self.x + other.x, y: self.y + other.y, z: self.z + other.z }
    }

    /// Returns the difference.
    #[inline(always)]
    pub fn minus(self, other: Self) -> Self {
        Self { x: self.x - other.x, y: self.y - other.y, z: self.z - other.z }
    }

    /// Returns the vector scaled by one factor for each lane.
    #[inline(always)]
    pub fn times(self, factor: f32x16<S>) -> Self {
        Self { x: self.x * factor, y: self.y * factor, z: self.z * factor }
    }

    /// Returns the absolute values of the coordinates.
    #[inline(always)]
    pub fn abs(self) -> Self {
        Self { x: self.x.abs(), y: self.y.abs(), z: self.z.abs() }
    }

    /// Returns the dot product with one vector.
    #[inline(always)]
    pub fn dot(self, [x, y, z]: [f32; 3]) -> f32x16<S> {
        self.x * x + self.y * y + self.z * z
    }

    /// Returns the cross product with another vector.
    #[inline(always)]
    pub fn cross(self, other: Self) -> Self {
        Self {
            x: self.y * other.z - self.z * other.y,
            y: self.z * other.x - self.x * other.z,
            z: self.x * other.y - self.y * other.x,
        }
    }

    /// Returns the squared length.
    #[inline(always)]
    pub fn norm_squared(self) -> f32x16<S> {
        self.x * self.x + self.y * self.y + self.z * self.z
    }
}

#[cfg(test)]
mod tests {
    use fearless_simd::dispatch;

    use super::*;

    #[test]
    fn lanes_agree_with_the_library_in_double_precision() {
        for step in -200_000..200_000 {
            let angles: LaneArray = std::array::from_fn(|lane| (step as f32 + lane as f32 / 16.0) * 5e-3);
            let (mut sines, mut cosines) = ([0.0; LANES], [0.0; LANES]);
            dispatch!(simd_level(), simd => {
                let (sine, cosine) = sin_cos_lanes(simd, f32x16::from_slice(simd, &angles));
                sine.store_slice(&mut sines);
                cosine.store_slice(&mut cosines);
            });
            for lane in 0..LANES {
                let (sine, cosine) = crate::sin_cos(f64::from(angles[lane]));
                let is_close = |lane: f32, exact: f64| (f64::from(lane) - exact).abs() < SINE_ERROR_IN_LANES;
                assert!(f64::from(angles[lane].abs()) <= MOST_TURN_IN_LANES_RAD + 0.01);
                assert!(is_close(sines[lane], sine), "sin {}", angles[lane]);
                assert!(is_close(cosines[lane], cosine), "cos {}", angles[lane]);
            }
        }
    }
}
