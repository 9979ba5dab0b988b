use crate::timing::motion_limits::MotionLimits;
use crate::timing::path_curve::PathCurve;
use crate::timing::time_law::{PathState, TimeLaw};

/// The fastest way along `curve`, whose pieces are lines, under the limits of velocity, acceleration and
/// jerk, at rest at every stop.
///
/// Between two stops the direction is constant, so the limits of the joints are limits of `ṡ`, `s̈` and
/// `s⃛` (`|q_j'|·ṡ ≤ v_j`, and so on), and the fastest motion from rest to rest is the double S of up to
/// seven phases (Biagiotti & Melchiorri 2008, §3.4).
pub(crate) fn jerk_limited(curve: &PathCurve, limits: &MotionLimits) -> TimeLaw {
    let mut law = TimeLaw::default();
    for run in curve.runs() {
        let pieces = &curve.pieces[run.clone()];
        let least = |limits: &[f64]| {
            let of_piece =
                |slope: &[f64]| slope.iter().zip(limits).map(|(q, l)| l / q.abs()).fold(f64::MAX, f64::min);
            pieces.iter().map(|piece| of_piece(&piece.slope)).fold(f64::MAX, f64::min)
        };
        let double_s = DoubleS::new(
            pieces[pieces.len() - 1].end_s(),
            least(&limits.velocity),
            least(&limits.acceleration),
            least(&limits.jerk),
        );
        double_s.append(&mut law, &run);
    }
    law
}

/// A motion from rest to rest: ramps of jerk, a stretch of constant acceleration, one of constant speed, and
/// the mirror image.
#[derive(Clone, Copy, Debug)]
struct DoubleS {
    length: f64,
    jerk: f64,
    /// Seconds of one ramp of the acceleration.
    ramp_s: f64,
    /// Seconds from rest to the greatest speed, both ramps included.
    rise_s: f64,
    /// Seconds at the greatest speed.
    cruise_s: f64,
}

impl DoubleS {
    fn new(length: f64, speed: f64, acceleration: f64, jerk: f64) -> Self {
        // If the greatest speed is reached.
        let (ramp_s, rise_s) = if speed * jerk < acceleration * acceleration {
            let ramp_s = (speed / jerk).sqrt();
            (ramp_s, 2.0 * ramp_s)
        } else {
            let ramp_s = acceleration / jerk;
            (ramp_s, ramp_s + speed / acceleration)
        };
        // The two rises together cover `speed · rise`.
        let cruise_s = length / speed - rise_s;
        if cruise_s >= 0.0 {
            return Self { length, jerk, ramp_s, rise_s, cruise_s };
        }
        // If not: the greatest acceleration may be reached, or not even that.
        let ramp_s = acceleration / jerk;
        let (ramp_s, rise_s) = if length >= 2.0 * acceleration * ramp_s * ramp_s {
            let half = 0.5 * ramp_s;
            (ramp_s, half + (half * half + length / acceleration).sqrt())
        } else {
            let ramp_s = libm::cbrt(length / (2.0 * jerk));
            (ramp_s, 2.0 * ramp_s)
        };
        Self { length, jerk, ramp_s, rise_s, cruise_s: 0.0 }
    }

    /// The phases of the rise run forward from the beginning, those of the fall backward from the end, so
    /// that both ends are exact.
    fn append(&self, law: &mut TimeLaw, run: &std::ops::Range<usize>) {
        let Self { length, jerk, ramp_s, rise_s, cruise_s } = *self;
        let constant_s = (rise_s - 2.0 * ramp_s).max(0.0);
        let rest = PathState::default();
        let ramped = rest.after(ramp_s, jerk);
        let pushed = ramped.after(constant_s, 0.0);
        let risen = PathState { acceleration: 0.0, ..pushed.after(ramp_s, -jerk) };
        let mirrored = |state: PathState| PathState {
            s: length - state.s,
            speed: state.speed,
            acceleration: -state.acceleration,
        };
        let mut push = |duration_s: f64, state: PathState, jerk: f64| {
            law.push(run.clone(), duration_s, state, jerk);
        };
        push(ramp_s, rest, jerk);
        push(constant_s, ramped, 0.0);
        push(ramp_s, pushed, -jerk);
        push(cruise_s, risen, 0.0);
        push(ramp_s, mirrored(risen), -jerk);
        push(constant_s, mirrored(pushed), 0.0);
        push(ramp_s, mirrored(ramped), jerk);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn duration_s(length: f64, speed: f64, acceleration: f64, jerk: f64) -> f64 {
        let mut law = TimeLaw::default();
        DoubleS::new(length, speed, acceleration, jerk).append(&mut law, &(0..1));
        law.duration_s
    }

    /// Published: Biagiotti & Melchiorri 2008, example 3.9 comes to rest within the same limits (`h = 10`,
    /// `v = 5`, `a = 10`, `j = 30`) with `T_j = 0.333` and `T_d = 0.833`; from rest to rest the rise takes as
    /// long.
    #[test]
    fn the_double_s_has_the_phases_of_the_closed_form() {
        let full = DoubleS::new(10.0, 5.0, 10.0, 30.0);
        assert!((full.ramp_s - 1.0 / 3.0).abs() < 1e-12);
        assert!((full.rise_s - 5.0 / 6.0).abs() < 1e-12 && (full.cruise_s - 7.0 / 6.0).abs() < 1e-12);
        // Jerk alone: four ramps of ∛(L/2j).
        assert!((duration_s(2.0, 1e9, 1e9, 1.0) - 4.0).abs() < 1e-12);
        // With jerk without limit the trapezoid is left: L/v + v/a.
        assert!((duration_s(3.0, 1.0, 2.0, 1e9) - 3.5).abs() < 1e-6);
    }

    #[test]
    fn neighbouring_phases_meet_in_every_regime() {
        for length in [1e-9, 1e-3, 0.05, 0.2, 0.5, 1.0, 10.0] {
            for (speed, acceleration, jerk) in [(1.0, 1.0, 1.0), (1.0, 2.0, 50.0), (0.1, 5.0, 3.0)] {
                let mut law = TimeLaw::default();
                DoubleS::new(length, speed, acceleration, jerk).append(&mut law, &(0..1));
                let rest = PathState { s: length, ..PathState::default() };
                for (index, phase) in law.phases.iter().enumerate() {
                    let end = phase.state.after(phase.duration_s, phase.jerk);
                    let next = law.phases.get(index + 1).map_or(rest, |next| next.state);
                    assert!((end.s - next.s).abs() < 1e-12 * length.max(1.0), "{length} {end:?} {next:?}");
                    assert!((end.speed - next.speed).abs() < 1e-9, "{length} {end:?} {next:?}");
                    assert!((end.acceleration - next.acceleration).abs() < 1e-7);
                    assert!(end.speed <= speed * (1.0 + 1e-12));
                    assert!(end.acceleration.abs() <= acceleration * (1.0 + 1e-12));
                }
            }
        }
    }
}
