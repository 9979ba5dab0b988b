/// Colour in linear light: red, green, blue, 0 to 1 for reflecting surfaces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Colour(pub [f32; 3]);

impl Colour {
    /// White.
    pub const WHITE: Self = Self([1.0; 3]);

    /// Converts screen values (sRGB, IEC 61966-2-1), as in `#rrggbb`.
    pub fn hex(rgb: u32) -> Self {
        let channel = |shift: u32| f64::from((rgb >> shift) & 0xff) / 255.0;
        Self::srgb([channel(16), channel(8), channel(0)])
    }

    /// Converts screen values from 0 to 1 (sRGB).
    pub fn srgb(channels: [f64; 3]) -> Self {
        #[allow(clippy::cast_possible_truncation, reason = "the precision of graphics")]
        Self(channels.map(|value| linear(value.clamp(0.0, 1.0)) as f32))
    }

    /// Returns the screen values from 0 to 1 (sRGB): `srgb(c.to_srgb()) = c`.
    pub fn to_srgb(self) -> [f64; 3] {
        self.0.map(|light| screen(f64::from(light.clamp(0.0, 1.0))))
    }

    /// Interpolates towards `other`: `mix(other, 0) = self`, `mix(other, 1) = other`.
    #[must_use]
    pub fn mix(self, other: Self, share: f32) -> Self {
        Self([0, 1, 2].map(|i| self.0[i] + (other.0[i] - self.0[i]) * share))
    }
}

/// Returns the linear light of a screen value.
fn linear(value: f64) -> f64 {
    if value <= 0.04045 { value / 12.92 } else { libm::pow((value + 0.055) / 1.055, 2.4) }
}

/// Returns the screen value of linear light, both 0 to 1.
fn screen(light: f64) -> f64 {
    if light <= 0.0031308 { 12.92 * light } else { 1.055 * libm::pow(light, 1.0 / 2.4) - 0.055 }
}

/// Table that converts linear light to screen values, 0 to 255: fast, and equal on every machine.
pub(crate) struct ScreenTable {
    values: Vec<u8>,
}

/// Number of entries: neighbouring dark entries differ by at most one screen value.
const TABLE_STEPS: usize = 1 << 14;

impl ScreenTable {
    pub fn new() -> Self {
        let value = |step: usize| {
            let screen = screen(step as f64 / (TABLE_STEPS - 1) as f64);
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "between 0 and 255")]
            (libm::round(255.0 * screen) as u8)
        };
        Self { values: (0..TABLE_STEPS).map(value).collect() }
    }

    /// Returns the screen value of linear light; values above 1 are white.
    pub fn screen(&self, light: f32) -> u8 {
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped to the table")]
        let step = (light.clamp(0.0, 1.0) * (TABLE_STEPS - 1) as f32 + 0.5) as usize;
        self.values[step]
    }
}

/// Returns the colour of a score between 0 and 1, from violet over green to yellow, distinguishable also with colour blindness
/// and in grey print, after viridis (Smith & van der Walt 2015, "A better default colormap for Matplotlib", whole) but lighter
/// at the low end. Grey without a score.
pub(crate) fn of_score(score: Option<f64>) -> Colour {
    const STOPS: [u32; 6] = [0x004b_3ca8, 0x003a_6fd0, 0x002f_a1c4, 0x003c_c88f, 0x00a6_e04a, 0x00ff_e52b];
    let Some(score) = score else { return Colour::hex(0x9a_9a9a) };
    let place = score.clamp(0.0, 1.0) * (STOPS.len() - 1) as f64;
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "at most the number of stops")]
    let index = (place as usize).min(STOPS.len() - 2);
    #[allow(clippy::cast_possible_truncation, reason = "single precision is what is meant")]
    let share = (place - index as f64) as f32;
    Colour::hex(STOPS[index]).mix(Colour::hex(STOPS[index + 1]), share)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn screen_values_come_back() {
        let table = ScreenTable::new();
        for value in 0..=255_u32 {
            let Colour([red, green, blue]) = Colour::hex(value << 16 | (255 - value) << 8 | 7);
            assert_eq!(u32::from(table.screen(red)), value);
            assert_eq!(u32::from(table.screen(green)), 255 - value);
            assert_eq!(table.screen(blue), 7);
        }
    }

    #[test]
    fn higher_scores_are_brighter_and_none_is_grey() {
        let brightness = |score| of_score(score).0.iter().sum::<f32>();
        let scores = [0.0, 0.25, 0.5, 0.75, 1.0].map(|score| brightness(Some(score)));
        assert!(scores.windows(2).all(|pair| pair[0] < pair[1]), "{scores:?}");
        let Colour([red, green, blue]) = of_score(None);
        assert!((red - green).abs() + (green - blue).abs() < 1e-6);
    }
}
