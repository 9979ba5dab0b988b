use std::ops::Range;

use crate::timing::path_curve::PathCurve;

/// Time law `s(t)` along a path: a cubic polynomial per phase.
#[derive(Clone, Debug, Default)]
pub(crate) struct TimeLaw {
    pub phases: Vec<Phase>,
    pub duration_s: f64,
}

/// Time interval of constant jerk.
#[derive(Clone, Debug)]
pub(crate) struct Phase {
    /// Pieces of the curve that it covers.
    pub pieces: Range<usize>,
    pub begin_s: f64,
    pub duration_s: f64,
    /// State at the beginning.
    pub state: PathState,
    /// `d³s/dt³`.
    pub jerk: f64,
}

/// State on a path: `s` (from the last stop), `ds/dt`, `d²s/dt²`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct PathState {
    pub s: f64,
    pub speed: f64,
    pub acceleration: f64,
}

impl PathState {
    /// Returns the state after `t` seconds of constant `jerk`.
    pub fn after(&self, t: f64, jerk: f64) -> Self {
        Self {
            s: self.s + t * (self.speed + t * (0.5 * self.acceleration + t * jerk / 6.0)),
            speed: self.speed + t * (self.acceleration + 0.5 * t * jerk),
            acceleration: self.acceleration + t * jerk,
        }
    }
}

impl TimeLaw {
    /// Appends a phase; a phase of zero duration is left out.
    pub fn push(&mut self, pieces: Range<usize>, duration_s: f64, state: PathState, jerk: f64) {
        if duration_s > 0.0 {
            self.phases.push(Phase { pieces, begin_s: self.duration_s, duration_s, state, jerk });
            self.duration_s += duration_s;
        }
    }

    /// Returns this law slowed down by `factor`.
    pub fn slowed(mut self, factor: f64) -> Self {
        self.duration_s *= factor;
        for phase in &mut self.phases {
            phase.begin_s *= factor;
            phase.duration_s *= factor;
            phase.state.speed /= factor;
            phase.state.acceleration /= factor * factor;
            phase.jerk /= factor * factor * factor;
        }
        self
    }

    /// Returns the piece and the state at time `t`, clamped to the pieces of the phase; `None` outside [0, duration).
    pub fn at(&self, t: f64, curve: &PathCurve) -> Option<(usize, PathState)> {
        if !(0.0..self.duration_s).contains(&t) {
            return None;
        }
        let phase = &self.phases[self.phases.partition_point(|phase| phase.begin_s <= t).saturating_sub(1)];
        let mut state = phase.state.after((t - phase.begin_s).min(phase.duration_s), phase.jerk);
        let pieces = &curve.pieces[phase.pieces.clone()];
        let piece = pieces.partition_point(|piece| piece.end_s() <= state.s).min(pieces.len() - 1);
        state.s = state.s.clamp(pieces[0].begin, pieces[pieces.len() - 1].end_s());
        state.speed = state.speed.max(0.0);
        Some((phase.pieces.start + piece, state))
    }

    /// Returns the time at which `s` on piece `piece` is reached, in seconds.
    pub fn time_of(&self, piece: usize, s: f64) -> f64 {
        // The last phase that begins at or before that point.
        let is_before = |phase: &Phase| {
            phase.pieces.end <= piece || (phase.pieces.contains(&piece) && phase.state.s <= s)
        };
        let Some(phase) = self.phases[..self.phases.partition_point(is_before)].last() else { return 0.0 };
        let (mut low, mut high) = (0.0, phase.duration_s);
        if phase.state.s >= s {
            return phase.begin_s;
        }
        // After this number of halvings only neighbouring numbers are left.
        const HALVINGS: u32 = 60;
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if phase.state.after(middle, phase.jerk).s < s { low = middle } else { high = middle }
        }
        phase.begin_s + high
    }
}
