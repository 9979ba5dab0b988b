use crate::timing::path_curve::{Derivatives, PathCurve, Piece};
use crate::timing::piece_limits::PieceLimits;
use crate::timing::time_law::{PathState, TimeLaw};

/// Returns the fastest time law along `curve` under the limits of velocity and acceleration, at rest at every stop (TOPP-RA:
/// Pham & Pham 2018, §IV).
///
/// With `x = ṡ²` and `u = s̈` the acceleration of joint j is `q_j'(s)·u + q_j''(s)·x`. Over a stage of length Δ, `x` grows by
/// `2Δu`.
///
/// 1. The path is divided into stages: one per line, many per rounded corner.
/// 2. The backward pass finds the controllable sets: the values of `x` from which the end of a stage can be reached within its
///    own set. Since every limit is symmetric, rest is always among them, so a set is [0, `greatest`].
/// 3. The forward pass greedily takes the greatest `x` that stays controllable.
/// 4. If a limit can be exceeded within a stage, 1 to 3 are repeated with lower acceleration limits in corners.
///
/// On a line the limits of u are constant, so one stage has the whole optimum: accelerate, cruise, decelerate. Along a stage
/// of a corner the acceleration `a(s)` of a joint deviates by at most `Δ²/8·sup|d²a/ds²|` from the line between its values at
/// both ends, which keep the limits. The velocity limit is taken at the faster end of a stage, because `q'` is monotonic.
pub(crate) fn time_optimal(curve: &PathCurve, limits: &[PieceLimits]) -> TimeLaw {
    on_grid(curve, limits, STAGES_PER_CORNER)
}

pub(crate) fn on_grid(curve: &PathCurve, limits: &[PieceLimits], stages_per_corner: u32) -> TimeLaw {
    /// Maximum number of repetitions (4 of [`time_optimal`]), each with twice the reserve that was missing before.
    const MOST_REPETITIONS: usize = 4;
    let mut used = 1.0;
    let mut law = with_use(curve, limits, stages_per_corner, used);
    for _ in 0..MOST_REPETITIONS {
        let excess = excess(curve, limits, &law);
        if excess <= 0.0 {
            return law;
        }
        used *= 1.0 - (2.0 * excess).min(0.5);
        law = with_use(curve, limits, stages_per_corner, used);
    }
    let excess = excess(curve, limits, &law);
    if excess > 0.0 { law.slowed((1.0 + excess).sqrt()) } else { law }
}

/// Runs 1 to 3 of [`time_optimal`] with the share `used` of the acceleration limits in corners.
fn with_use(curve: &PathCurve, limits: &[PieceLimits], stages_per_corner: u32, used: f64) -> TimeLaw {
    // 1.
    let stages: Vec<Stage> = curve
        .pieces
        .iter()
        .enumerate()
        .flat_map(|(index, piece)| Stage::of_piece(index, piece, &limits[index], (stages_per_corner, used)))
        .collect();
    let mut cap = vec![f64::INFINITY; stages.len() + 1];
    for (index, stage) in stages.iter().enumerate() {
        cap[index] = cap[index].min(stage.cap);
        cap[index + 1] = cap[index + 1].min(stage.cap);
        if stage.after_stop {
            cap[index] = 0.0;
        }
    }
    cap[stages.len()] = 0.0;
    // 2.
    let mut greatest = cap;
    for (index, stage) in stages.iter().enumerate().rev() {
        greatest[index] = stage.greatest_begin(greatest[index], greatest[index + 1]);
    }
    // 3.
    let mut law = TimeLaw::default();
    let mut x = 0.0;
    for (stage, reachable) in stages.iter().zip(&greatest[1..]) {
        x = stage.run(x, *reachable, &mut law);
    }
    law
}

/// Returns the greatest relative excess of accelerations over their limits in corners; negative if there is none.
fn excess(curve: &PathCurve, limits: &[PieceLimits], law: &TimeLaw) -> f64 {
    let mut most = -1.0_f64;
    for phase in &law.phases {
        let index = phase.pieces.start;
        let piece = &curve.pieces[index];
        let Some(turn) = &piece.turn else { continue };
        let ends = [phase.state, phase.state.after(phase.duration_s, 0.0)];
        let (width, u) = (ends[1].s - ends[0].s, phase.state.acceleration);
        let x = ends[0].speed.max(ends[1].speed).powi(2);
        for (joint, limit) in limits[index].acceleration.iter().enumerate() {
            let at = ends.map(|end| piece.derivatives(joint, end.s));
            let end = |k: usize| (at[k].first * u + at[k].second * ends[k].speed.powi(2)).abs();
            // The third derivative is linear.
            let fourth = 12.0 * turn[joint].abs() / piece.length.powi(3);
            let bend = 5.0 * u.abs() * at[0].third.abs().max(at[1].third.abs()) + fourth * x;
            most = most.max((end(0).max(end(1)) + 0.125 * width * width * bend) / limit - 1.0);
        }
    }
    most
}

/// Number of stages per rounded corner. The time lost against an infinitely fine grid is below a hundredth for corners of
/// maximum size, and falls with the number of stages.
const STAGES_PER_CORNER: u32 = 256;

/// Slope, relative to its change over a stage, that counts as zero. Near such a turning point of a joint, its row gives bounds
/// of u that are differences of large numbers. The error is a hundredth of the reserve kept by the limits.
const NO_SLOPE: f64 = 1e-7;

/// Interval of the path with its limits.
struct Stage {
    piece: usize,
    after_stop: bool,
    begin: f64,
    length: f64,
    /// Greatest `x` that the velocity limits allow on it.
    cap: f64,
    rows: Rows,
}

enum Rows {
    /// Line: `|u| ≤ acceleration`.
    Line { acceleration: f64 },
    /// Rounded corner: constraints at both ends of the stage.
    Corner(Vec<Row>),
}

/// Constraint `|bend·x + slope·u| ≤ limit`, with `slope` ≥ 0.
#[derive(Clone, Copy, Debug)]
struct Row {
    bend: f64,
    slope: f64,
    limit: f64,
}

/// Bound of u that is linear in x: its value at the current x, and its slope.
#[derive(Clone, Copy, Debug)]
struct Bound {
    value: f64,
    slope: f64,
}

impl Stage {
    fn of_piece(index: usize, piece: &Piece, limits: &PieceLimits, (stages, used): (u32, f64)) -> Vec<Self> {
        let joints = 0..limits.velocity.len();
        let least = |limits: &[f64]| {
            joints.clone().map(|j| limits[j] / piece.slope[j].abs()).fold(f64::INFINITY, f64::min)
        };
        let most_x = limits.most_speed.powi(2);
        if piece.turn.is_none() {
            return vec![Self {
                piece: index,
                after_stop: piece.after_stop,
                begin: piece.begin,
                length: piece.length,
                cap: least(&limits.velocity).powi(2).min(most_x),
                rows: Rows::Line { acceleration: least(&limits.acceleration).min(limits.most_acceleration) },
            }];
        }
        let step = piece.length / f64::from(stages);
        let stage = |k: u32| {
            let begin = piece.begin + f64::from(k) * step;
            let mut cap = most_x;
            let mut rows = Vec::with_capacity(2 * joints.len() + 1);
            if limits.most_acceleration.is_finite() {
                rows.push(Row { bend: 0.0, slope: 1.0, limit: limits.most_acceleration });
            }
            for j in joints.clone() {
                let [at_begin, at_end] = [begin, begin + step].map(|s| piece.derivatives(j, s));
                cap = cap.min((limits.velocity[j] / at_begin.first.abs().max(at_end.first.abs())).powi(2));
                // At the end `x` has grown by `2·step·u`.
                let grown = at_end.first + 2.0 * step * at_end.second;
                for (slope, Derivatives { second, .. }) in [(at_begin.first, at_begin), (grown, at_end)] {
                    let is_flat = slope.abs() <= NO_SLOPE * step * second.abs();
                    let bend = if slope < 0.0 { -second } else { second };
                    let slope = if is_flat { 0.0 } else { slope.abs() };
                    rows.push(Row { bend, slope, limit: used * limits.acceleration[j] });
                }
            }
            let after_stop = piece.after_stop && k == 0;
            Self { piece: index, after_stop, begin, length: step, cap, rows: Rows::Corner(rows) }
        };
        (0..stages).map(stage).collect()
    }

    /// Returns the greatest `x` up to `cap` at the beginning from which some admissible u leads to at most `end`.
    fn greatest_begin(&self, cap: f64, end: f64) -> f64 {
        let rows = match &self.rows {
            Rows::Line { acceleration } => return cap.min(end + 2.0 * acceleration * self.length),
            Rows::Corner(rows) => rows,
        };
        let flat = rows.iter().filter(|row| row.slope <= 0.0 && row.bend != 0.0);
        let mut x = flat.map(|row| row.limit / row.bend.abs()).fold(cap, f64::min);
        // The gap between the bounds of u is concave in x and not negative at 0. Newton's method from above reaches its root
        // after at most one step per row.
        for _ in 0..2 * rows.len() + 2 {
            let (lower, upper) = self.bounds(rows, x, end);
            let gap = upper.value - lower.value;
            let slope = upper.slope - lower.slope;
            if gap >= 0.0 || slope >= 0.0 {
                break;
            }
            x = (x - gap / slope).max(0.0);
        }
        x
    }

    /// Returns the bounds of u at `x`, with `x + 2Δu` in [0, `end`].
    fn bounds(&self, rows: &[Row], x: f64, end: f64) -> (Bound, Bound) {
        let slope = -0.5 / self.length;
        let mut lower = Bound { value: slope * x, slope };
        let mut upper = Bound { value: (end - x) * -slope, slope };
        for row in rows.iter().filter(|row| row.slope > 0.0) {
            let slope = -row.bend / row.slope;
            let (middle, half) = (slope * x, row.limit / row.slope);
            if middle - half > lower.value {
                lower = Bound { value: middle - half, slope };
            }
            if middle + half < upper.value {
                upper = Bound { value: middle + half, slope };
            }
        }
        (lower, upper)
    }

    /// Runs the stage from `x` to the greatest value up to `end`, and returns that value.
    fn run(&self, x: f64, end: f64, law: &mut TimeLaw) -> f64 {
        match &self.rows {
            Rows::Line { acceleration } => self.run_line(x, end, *acceleration, law),
            Rows::Corner(rows) => {
                let (_, upper) = self.bounds(rows, x, end);
                let reached = (x + 2.0 * self.length * upper.value).clamp(0.0, end);
                self.push(law, 0.0, self.length, (x, reached));
                reached
            }
        }
    }

    fn run_line(&self, x: f64, end: f64, acceleration: f64, law: &mut TimeLaw) -> f64 {
        let reached = end.min(x + 2.0 * acceleration * self.length);
        let least = 0.5 * (reached - x) / acceleration;
        // Value at which acceleration and deceleration meet, unless the velocity limit comes first.
        let peak = 0.5 * (x + reached) + acceleration * self.length;
        let (peak, rise, fall) = if peak > self.cap {
            (self.cap, 0.5 * (self.cap - x) / acceleration, 0.5 * (self.cap - reached) / acceleration)
        } else {
            (peak, 0.5 * (self.length + least), 0.5 * (self.length - least))
        };
        let (rise, fall) = (rise.clamp(0.0, self.length), fall.clamp(0.0, self.length));
        self.push(law, 0.0, rise, (x, peak));
        self.push(law, rise, self.length - rise - fall, (peak, peak));
        self.push(law, self.length - fall, fall, (peak, reached));
        reached
    }

    /// Appends a phase from `offset` on over `length`, with `x` at its ends.
    fn push(&self, law: &mut TimeLaw, offset: f64, length: f64, (from, to): (f64, f64)) {
        /// Length in seconds at full speed up to which a phase is a rounding error.
        const SHORTEST: f64 = 1e-18;
        if length > SHORTEST {
            let speed = from.max(0.0).sqrt();
            let duration_s = 2.0 * length / (speed + to.max(0.0).sqrt());
            let acceleration = 0.5 * (to - from) / length;
            let state = PathState { s: self.begin + offset, speed, acceleration };
            law.push(self.piece..self.piece + 1, duration_s, state, 0.0);
        }
    }
}
