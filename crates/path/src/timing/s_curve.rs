use std::ops::Range;

use crate::timing::path_curve::{PathCurve, Piece};
use crate::timing::piece_limits::PieceLimits;
use crate::timing::time_law::{PathState, TimeLaw};

/// Returns a fast time law along `curve` under the velocity, acceleration and jerk limits of each piece, at rest at every stop.
///
/// On a line the direction is constant, so the joint limits are limits of `ṡ`, `s̈` and `s⃛`, and the fastest motion between
/// two speeds is the double S (Biagiotti & Melchiorri 2008, §3.4). A rounded corner is passed at constant speed V, where joint
/// j has the velocity `q'V`, the acceleration `q''V²` and the jerk `q'''V³`. V is the greatest speed that keeps all limits at
/// the greatest derivatives of the piece. Acceleration is thus continuous, and every limit is satisfied in closed form.
///
/// 1. Neighbouring lines with the same limits form one span, each rounded corner another.
/// 2. The speeds at the nodes between spans are limited, forward and then backward, to those reachable along a span.
/// 3. Each span gets the double S between the speeds at its nodes.
///
/// The speeds at the nodes are as great as possible with zero acceleration there. The time optimum may accelerate in a corner.
pub(crate) fn s_curve(curve: &PathCurve, limits: &[PieceLimits]) -> TimeLaw {
    let mut law = TimeLaw::default();
    for run in curve.runs() {
        // 1.
        let spans = spans(curve, limits, run);
        // 2.
        let speeds = node_speeds(&spans);
        // 3.
        for (span, speeds) in spans.iter().zip(speeds.windows(2)) {
            span.append([speeds[0], speeds[1]], &mut law);
        }
    }
    law
}

/// Pieces between two nodes with zero acceleration.
#[derive(Clone, Debug)]
struct Span {
    pieces: Range<usize>,
    begin: f64,
    length: f64,
    is_rounded: bool,
    /// Maximum `ṡ`, `s̈` and `s⃛`.
    speed: f64,
    acceleration: f64,
    jerk: f64,
}

fn spans(curve: &PathCurve, limits: &[PieceLimits], run: Range<usize>) -> Vec<Span> {
    let mut spans: Vec<Span> = Vec::new();
    for index in run {
        let (piece, of_piece) = (&curve.pieces[index], &limits[index]);
        let span = Span::of_piece(index, piece, of_piece);
        match spans.last_mut() {
            Some(last) if !last.is_rounded && !span.is_rounded && limits[index - 1] == *of_piece => {
                last.pieces.end = span.pieces.end;
                last.length += span.length;
                last.speed = last.speed.min(span.speed);
                last.acceleration = last.acceleration.min(span.acceleration);
                last.jerk = last.jerk.min(span.jerk);
            }
            _ => spans.push(span),
        }
    }
    spans
}

fn node_speeds(spans: &[Span]) -> Vec<f64> {
    let mut speeds = vec![f64::INFINITY; spans.len() + 1];
    (speeds[0], speeds[spans.len()]) = (0.0, 0.0);
    for (index, span) in spans.iter().enumerate() {
        speeds[index] = speeds[index].min(span.speed);
        speeds[index + 1] = speeds[index + 1].min(span.speed);
    }
    for (index, span) in spans.iter().enumerate() {
        speeds[index + 1] = span.reached(speeds[index], speeds[index + 1]);
    }
    for (index, span) in spans.iter().enumerate().rev() {
        speeds[index] = span.reached(speeds[index + 1], speeds[index]);
    }
    speeds
}

/// Change of speed: two ramps of the acceleration, and an interval of constant acceleration between them.
#[derive(Clone, Copy, Debug)]
struct Change {
    from: f64,
    to: f64,
    ramp_s: f64,
    constant_s: f64,
    jerk: f64,
}

impl Change {
    fn duration_s(&self) -> f64 {
        2.0 * self.ramp_s + self.constant_s
    }

    fn length(&self) -> f64 {
        0.5 * (self.from + self.to) * self.duration_s()
    }

    /// Returns the phases forward from `s`, with growing speed.
    fn phases(&self, s: f64) -> [(f64, PathState, f64); 3] {
        let begin = PathState { s, speed: self.from, acceleration: 0.0 };
        let ramped = begin.after(self.ramp_s, self.jerk);
        let pushed = ramped.after(self.constant_s, 0.0);
        [(self.ramp_s, begin, self.jerk), (self.constant_s, ramped, 0.0), (self.ramp_s, pushed, -self.jerk)]
    }
}

impl Span {
    fn of_piece(index: usize, piece: &Piece, limits: &PieceLimits) -> Self {
        let mut span = Self {
            pieces: index..index + 1,
            begin: piece.begin,
            length: piece.length,
            is_rounded: piece.turn.is_some(),
            speed: limits.most_speed,
            acceleration: limits.most_acceleration,
            jerk: f64::INFINITY,
        };
        for joint in 0..limits.velocity.len() {
            let most = piece.greatest(joint);
            let [velocity, acceleration, jerk] = limits.of_joint(joint);
            span.speed = span.speed.min(velocity / most.first);
            if span.is_rounded {
                span.speed = span.speed.min((acceleration / most.second).sqrt());
                span.speed = span.speed.min(libm::cbrt(jerk / most.third));
            } else {
                span.acceleration = span.acceleration.min(acceleration / most.first);
                span.jerk = span.jerk.min(jerk / most.first);
            }
        }
        span
    }

    /// Returns the fastest change between two speeds.
    fn change(&self, from: f64, to: f64) -> Change {
        let difference = to - from;
        let (jerk, acceleration) = (self.jerk, self.acceleration);
        let (ramp_s, constant_s) = if difference * jerk < acceleration * acceleration {
            ((difference / jerk).sqrt(), 0.0)
        } else {
            (acceleration / jerk, difference / acceleration - acceleration / jerk)
        };
        Change { from, to, ramp_s, constant_s, jerk }
    }

    /// Returns the greatest speed up to `most` at one node if the speed at the other is `from`.
    fn reached(&self, from: f64, most: f64) -> f64 {
        if most <= from || self.is_rounded {
            return most.min(from);
        }
        greatest(from, most, |to| self.change(from, to).length() / self.length - 1.0)
    }

    fn append(&self, [from, to]: [f64; 2], law: &mut TimeLaw) {
        let mut push = |(duration_s, state, jerk): (f64, PathState, f64)| {
            law.push(self.pieces.clone(), duration_s, state, jerk);
        };
        if self.is_rounded {
            let state = PathState { s: self.begin, speed: from, acceleration: 0.0 };
            return push((self.length / from, state, 0.0));
        }
        let needed = |peak: f64| self.change(from, peak).length() + self.change(to, peak).length();
        let peak = greatest(from.max(to), self.speed, |peak| needed(peak) / self.length - 1.0);
        let (rise, fall) = (self.change(from, peak), self.change(to, peak));
        rise.phases(self.begin).into_iter().for_each(&mut push);
        let cruise = self.length - rise.length() - fall.length();
        let risen = PathState { s: self.begin + rise.length(), speed: peak, acceleration: 0.0 };
        // A remainder due to rounding is not a phase.
        if cruise > 1e-12 * self.length {
            push((cruise / peak, risen, 0.0));
        }
        // The fall is a rise backward from the end, so that both ends are exact.
        let end = self.begin + self.length;
        for (duration_s, state, jerk) in fall.phases(0.0).into_iter().rev() {
            let last = state.after(duration_s, jerk);
            let mirrored = PathState { s: end - last.s, speed: last.speed, acceleration: -last.acceleration };
            push((duration_s, mirrored, jerk));
        }
    }
}

/// Returns the greatest value from `low` to `high` at which the increasing function `excess` is not above 0, as it is at `low`,
/// by regula falsi (Illinois) within brackets.
fn greatest(low: f64, high: f64, excess: impl Fn(f64) -> f64) -> f64 {
    const MOST_STEPS: u32 = 100;
    /// Excess that counts as zero, due to rounding.
    const NONE: f64 = 1e-14;
    let mut above = excess(high);
    if above <= 0.0 {
        return high;
    }
    let (mut low, mut high, mut below) = (low, high, excess(low));
    let mut was_below = None;
    for _ in 0..MOST_STEPS {
        let secant = high - above * (high - low) / (above - below);
        let middle = if secant > low && secant < high { secant } else { 0.5 * (low + high) };
        if middle <= low || middle >= high {
            break;
        }
        let found = excess(middle);
        let is_below = found <= 0.0;
        // An end that is kept a second time counts half, otherwise it could stay forever.
        let half = if was_below == Some(is_below) { 0.5 } else { 1.0 };
        if is_below {
            (low, below, above) = (middle, found, half * above);
        } else {
            (high, above, below) = (middle, found, half * below);
        }
        was_below = Some(is_below);
        if is_below && found >= -NONE {
            break;
        }
    }
    low
}

#[cfg(test)]
mod tests {
    use super::*;

    fn span(length: f64, speed: f64, acceleration: f64, jerk: f64) -> Span {
        Span { pieces: 0..1, begin: 0.0, length, is_rounded: false, speed, acceleration, jerk }
    }

    fn law(span: &Span, ends: [f64; 2]) -> TimeLaw {
        let mut law = TimeLaw::default();
        span.append(ends, &mut law);
        law
    }

    fn duration_s(length: f64, speed: f64, acceleration: f64, jerk: f64) -> f64 {
        law(&span(length, speed, acceleration, jerk), [0.0, 0.0]).duration_s
    }

    /// Compares with published values: Biagiotti & Melchiorri 2008, example 3.9 comes to rest within the same limits (`h = 10`,
    /// `v = 5`, `a = 10`, `j = 30`) with `T_j = 0.333` and `T_d = 0.833`; from rest the rise takes as long.
    #[test]
    fn the_double_s_has_the_phases_of_the_closed_form() {
        let rise = span(10.0, 5.0, 10.0, 30.0).change(0.0, 5.0);
        assert!((rise.ramp_s - 1.0 / 3.0).abs() < 1e-12 && (rise.duration_s() - 5.0 / 6.0).abs() < 1e-12);
        assert!((duration_s(10.0, 5.0, 10.0, 30.0) - (5.0 / 3.0 + 7.0 / 6.0)).abs() < 1e-12);
        // Jerk alone: four ramps of ∛(L/2j).
        assert!((duration_s(2.0, 1e9, 1e9, 1.0) - 4.0).abs() < 1e-9);
        // Without a jerk limit the trapezoid remains: L/v + v/a.
        assert!((duration_s(3.0, 1.0, 2.0, 1e9) - 3.5).abs() < 1e-6);
    }

    #[test]
    fn neighbouring_phases_meet_in_every_regime() {
        for length in [1e-9, 1e-3, 0.05, 0.2, 0.5, 1.0, 10.0] {
            for (speed, acceleration, jerk) in [(1.0, 1.0, 1.0), (1.0, 2.0, 50.0), (0.1, 5.0, 3.0)] {
                let span = span(length, speed, acceleration, jerk);
                for ends in [[0.0, 0.0], [0.0, 0.5 * speed], [0.7 * speed, 0.2 * speed], [speed, speed]] {
                    let ends = [ends[0].min(span.reached(ends[1], ends[0])), ends[1]];
                    let ends = [ends[0], span.reached(ends[0], ends[1])];
                    let law = law(&span, ends);
                    let last = PathState { s: length, speed: ends[1], acceleration: 0.0 };
                    for (index, phase) in law.phases.iter().enumerate() {
                        let end = phase.state.after(phase.duration_s, phase.jerk);
                        let next = law.phases.get(index + 1).map_or(last, |next| next.state);
                        assert!((end.s - next.s).abs() < 1e-9 * length.max(1.0), "{length} {end:?} {next:?}");
                        assert!((end.speed - next.speed).abs() < 1e-7, "{length} {end:?} {next:?}");
                        assert!((end.acceleration - next.acceleration).abs() < 1e-6);
                        assert!(end.speed <= speed * (1.0 + 1e-12));
                        assert!(end.acceleration.abs() <= acceleration * (1.0 + 1e-12));
                    }
                }
            }
        }
    }
}
