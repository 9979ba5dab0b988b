/// Scale of an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// Equal differences have equal lengths.
    Linear,
    /// Equal ratios have equal lengths.
    Logarithmic,
}

/// Axis with its finite range and its labelled ticks.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// Label, with the unit.
    pub label: String,
    /// Least value.
    pub low: f64,
    /// Greatest value.
    pub high: f64,
    /// Scale.
    pub scale: Scale,
    /// Values with their labels.
    pub ticks: Vec<(f64, String)>,
    /// Values of ticks without labels.
    pub minor_ticks: Vec<f64>,
}

/// Ratio of the greatest to the least value above which the scale is logarithmic.
const WIDE: f64 = 30.0;

/// Maximum number of decades with minor ticks.
const MOST_DIVIDED: f64 = 8.0;

/// Share of an axis that stays free at its high end.
const ROOM: f64 = 0.03;

impl Axis {
    /// Creates an axis from 0 to 100 %, with space for curves at both ends.
    pub fn share(label: &str) -> Self {
        let ticks = (0..=5).map(|fifth| (f64::from(fifth) * 0.2, format!("{}", fifth * 20))).collect();
        Self {
            label: label.to_owned(),
            low: -0.02,
            high: 1.03,
            scale: Scale::Linear,
            ticks,
            minor_ticks: Vec::new(),
        }
    }

    /// Creates a logarithmic axis from the power of ten up to `least` (default: a decade below) to `greatest`; both positive.
    pub fn decades(label: &str, least: Option<f64>, greatest: f64) -> Self {
        let greatest = if greatest > 0.0 { greatest } else { 1.0 };
        Self::logarithmic(label, least.unwrap_or(greatest).min(0.5 * greatest), greatest)
    }

    /// Creates an axis with one unit interval for each name, from 0 on.
    pub fn names(names: &[&str]) -> Self {
        let ticks = names.iter().enumerate().map(|(i, name)| (i as f64 + 0.5, (*name).to_owned())).collect();
        let high = names.len() as f64;
        Self { label: String::new(), low: 0.0, high, scale: Scale::Linear, ticks, minor_ticks: Vec::new() }
    }

    /// Creates an axis of non-negative amounts that covers `values` and `high`: linear from zero, or logarithmic if wide.
    pub fn amounts(label: &str, values: impl Iterator<Item = f64> + Clone, high: f64) -> Self {
        let greatest = values.clone().fold(high, f64::max);
        let least = values.filter(|&value| value > 0.0).fold(f64::INFINITY, f64::min);
        if least.is_finite() && greatest > WIDE * least {
            Self::logarithmic(label, least, greatest)
        } else {
            Self::linear(label, 0.0, if greatest > 0.0 { greatest } else { 1.0 })
        }
    }

    /// Creates a linear axis from `low` to `high`, with ticks at round numbers.
    pub fn linear(label: &str, low: f64, high: f64) -> Self {
        let step = round_step((high - low) / 5.0);
        let count = (((high - low) / step) + 1e-9).floor();
        let first = (low / step - 1e-9).ceil();
        let mut ticks = Vec::new();
        let mut index = 0.0;
        while index <= count && (first + index) * step <= high + 1e-9 * step {
            let value = (first + index) * step;
            ticks.push((value, decimal(value, step)));
            index += 1.0;
        }
        Self { label: label.to_owned(), low, high, scale: Scale::Linear, ticks, minor_ticks: Vec::new() }
    }

    /// Creates a logarithmic axis that begins at a power of ten; both values are positive.
    fn logarithmic(label: &str, least: f64, greatest: f64) -> Self {
        let low = 10.0_f64.powf(least.log10().floor());
        let decades = (greatest / low).log10();
        let every = (decades / 7.0).ceil().max(1.0);
        let mut ticks = Vec::new();
        let mut exponent = low.log10().round();
        while exponent <= greatest.log10() + 1e-9 {
            ticks.push((10.0_f64.powf(exponent), power_of_ten(exponent)));
            exponent += every;
        }
        let mut minor_ticks = Vec::new();
        let mut decade = low;
        // With many decades the minor ticks would merge to a grey bar.
        while decade < greatest && decades <= MOST_DIVIDED {
            let between = (2..10).map(|times| f64::from(times) * decade);
            minor_ticks.extend(between.filter(|value| *value <= greatest));
            decade *= 10.0;
        }
        Self { label: label.to_owned(), low, high: greatest, scale: Scale::Logarithmic, ticks, minor_ticks }
    }

    /// Returns the axis with a label at its high end, if that is far enough from the last tick.
    #[must_use]
    pub fn with_tick_at_end(mut self) -> Self {
        let last = self.ticks.last().map_or(0.0, |(value, _)| self.share_of(*value));
        if last < 0.9 {
            self.ticks.push((self.high, self.high.to_string()));
        }
        self
    }

    /// Returns the axis with free space above the greatest value, so that its marks do not touch the edge.
    #[must_use]
    pub fn with_room(mut self) -> Self {
        self.high = match self.scale {
            Scale::Linear => self.high + ROOM * (self.high - self.low),
            Scale::Logarithmic => self.high * (self.high / self.low).powf(ROOM),
        };
        self
    }

    /// Returns the relative position of a value: 0 at the low end, 1 at the high end, clamped outside.
    pub fn share_of(&self, value: f64) -> f64 {
        let share = match self.scale {
            Scale::Linear => (value - self.low) / (self.high - self.low),
            Scale::Logarithmic if value <= self.low => 0.0,
            Scale::Logarithmic => (value / self.low).ln() / (self.high / self.low).ln(),
        };
        share.clamp(0.0, 1.0)
    }
}

/// Returns 1, 2 or 5 times a power of ten, not below `step`.
fn round_step(step: f64) -> f64 {
    let power = 10.0_f64.powf(step.log10().floor());
    let times = [1.0, 2.0, 5.0, 10.0].into_iter().find(|times| times * power >= step * (1.0 - 1e-9));
    times.unwrap_or(10.0) * power
}

/// Formats a value with the number of decimals of the tick interval.
#[allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a count that is not negative and small"
)]
fn decimal(value: f64, step: f64) -> String {
    if value.abs() >= 1e4 && step >= 1e3 {
        return format!("{}k", value / 1e3);
    }
    let decimals = (-step.log10().floor()).max(0.0) as usize;
    format!("{:.decimals$}", value + 0.0)
}

fn power_of_ten(exponent: f64) -> String {
    match exponent {
        e if e >= 6.0 => format!("{}M", 10.0_f64.powf(e - 6.0)),
        e if e >= 3.0 => format!("{}k", 10.0_f64.powf(e - 3.0)),
        e if e >= -4.0 => format!("{}", (10.0_f64.powf(e) * 1e4).round() / 1e4),
        e => format!("1e{e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texts(axis: &Axis) -> Vec<&str> {
        axis.ticks.iter().map(|(_, text)| text.as_str()).collect()
    }

    #[test]
    fn ticks_stand_at_round_numbers() {
        assert_eq!(texts(&Axis::linear("s", 0.0, 30.0)), ["0", "10", "20", "30"]);
        assert_eq!(texts(&Axis::linear("m", 0.113, 0.513)), ["0.2", "0.3", "0.4", "0.5"]);
        assert_eq!(texts(&Axis::linear("s", 0.0, 120.0)), ["0", "50", "100"]);
        assert_eq!(texts(&Axis::linear("", 0.0, 60000.0)), ["0", "20k", "40k", "60k"]);
    }

    #[test]
    fn decades_begin_at_a_power_of_ten_and_end_at_the_limit() {
        let axis = Axis::decades("s", Some(0.0042), 30.0);
        assert_eq!(texts(&axis), ["0.001", "0.01", "0.1", "1", "10"]);
        assert!((axis.low - 0.001).abs() < 1e-15 && (axis.high - 30.0).abs() < 1e-12);
        assert_eq!(axis.minor_ticks.len(), 4 * 8 + 2, "20 and 30 are the last");
        assert_eq!(texts(&Axis::decades("s", None, 30.0)), ["10"]);
        assert_eq!(texts(&Axis::decades("s", Some(50.0), 30.0)), ["10"]);
    }

    #[test]
    fn amounts_far_apart_are_shown_by_their_ratios() {
        let axis = Axis::amounts("s", [0.004, 20.0].into_iter(), 120.0);
        assert_eq!(axis.scale, Scale::Logarithmic);
        assert_eq!(texts(&axis), ["0.001", "0.01", "0.1", "1", "10", "100"]);
        assert!((axis.share_of(0.001) - 0.0).abs() < 1e-12 && (axis.share_of(120.0) - 1.0).abs() < 1e-12);
        assert!(axis.share_of(0.0).abs() < 1e-12);
        assert_eq!(Axis::amounts("s", [8.0, 20.0].into_iter(), 20.0).scale, Scale::Linear);
        assert!((Axis::amounts("s", std::iter::empty(), 0.0).high - 1.0).abs() < 1e-12);
    }
}
