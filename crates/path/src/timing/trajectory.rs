use cranny_task::TaskError;

use crate::PathError;
use crate::timing::motion_limits::{MotionLimits, TimingMethod};
use crate::timing::path_curve::PathCurve;
use crate::timing::piece_limits::PieceLimits;
use crate::timing::rounding::{CurvedPath, law};
use crate::timing::time_law::TimeLaw;

/// Path with timing: position, velocity and acceleration of every joint at any instant. It begins and ends at rest and keeps
/// every limit at every instant.
#[derive(Clone, Debug)]
pub struct Trajectory {
    method: TimingMethod,
    is_rounded: bool,
    joint_names: Vec<String>,
    first: Vec<f64>,
    last: Vec<f64>,
    curve: PathCurve,
    law: TimeLaw,
    waypoint_times_s: Vec<f64>,
}

/// State of a robot at one instant of a trajectory; one value per joint each.
#[derive(Clone, Debug, PartialEq)]
pub struct TrajectorySample {
    /// Time since the beginning, in seconds.
    pub time_s: f64,
    /// Joint values (m, rad).
    pub position: Vec<f64>,
    /// First derivative of the joint values (m/s, rad/s).
    pub velocity: Vec<f64>,
    /// Second derivative of the joint values (m/s², rad/s²). At a jump, the value right after it.
    pub acceleration: Vec<f64>,
}

/// Maximum sample rate of a trajectory, in Hz: ten times that of a robot controller.
pub const MAX_SAMPLE_RATE_HZ: f64 = 1e4;

impl Trajectory {
    /// Creates a fast trajectory exactly along the straight edges of `path` (m, rad; one value per joint), by the method of
    /// `limits`. It stops at each way point where the direction changes, and only there, so a proof of the edges is valid for
    /// the trajectory.
    ///
    /// # Errors
    /// [`PathError::EmptyPath`], [`TaskError::JointCount`] or [`TaskError::NotFinite`] for a path not of these joints.
    pub fn along(path: &[Vec<f64>], limits: &MotionLimits) -> Result<Self, PathError> {
        Self::along_curve(&CurvedPath::stopping(path), limits)
    }

    /// Creates a trajectory as [`Self::along`] does, but without stops in the rounded corners, whose curves it follows.
    ///
    /// # Errors
    /// As [`Self::along`]; [`PathError::NoCorner`] for a rounded corner where the path has none, [`PathError::Weight`] for a
    /// path on which the drives may be too weak to support the robot.
    pub fn along_curve(of: &CurvedPath<'_>, limits: &MotionLimits) -> Result<Self, PathError> {
        let path = of.waypoints;
        let (Some(first), Some(last)) = (path.first(), path.last()) else {
            return Err(PathError::EmptyPath);
        };
        let (what, expected) = ("way point", limits.joint_names.len());
        for q in path {
            if q.len() != expected {
                return Err(TaskError::JointCount { what, expected, actual: q.len() }.into());
            }
            if let Some(joint) = q.iter().position(|x| !x.is_finite()) {
                let joint = limits.joint_names[joint].clone();
                return Err(TaskError::NotFinite { what, joint }.into());
            }
        }
        let cuts = PathCurve::cuts_of(path, &limits.velocity, of.corners)?;
        let curve = PathCurve::along(path, &limits.velocity, &cuts);
        let mut of_pieces = PieceLimits::all_of(&curve, limits, of.paces, of.robot);
        if let Some((drives, robot)) = of.drives.zip(of.robot) {
            drives.limit(&curve, &mut of_pieces, robot)?;
        }
        let law = law(&curve, limits.method, &of_pieces);
        let mut waypoint_times_s: Vec<f64> =
            curve.waypoints.iter().map(|(piece, s)| law.time_of(*piece, *s)).collect();
        if let Some(time_s) = waypoint_times_s.last_mut() {
            *time_s = law.duration_s;
        }
        Ok(Self {
            method: limits.method,
            is_rounded: curve.pieces.iter().any(|piece| piece.turn.is_some()),
            joint_names: limits.joint_names.clone(),
            first: first.clone(),
            last: last.clone(),
            curve,
            law,
            waypoint_times_s,
        })
    }

    /// Returns the method of its timing.
    pub fn method(&self) -> TimingMethod {
        self.method
    }

    /// Returns true if it rounds a corner of its path instead of stopping there.
    pub fn is_rounded(&self) -> bool {
        self.is_rounded
    }

    /// Returns the names of the joints, in the order of every sample.
    pub fn joint_names(&self) -> &[String] {
        &self.joint_names
    }

    /// Returns the duration in seconds.
    pub fn duration_s(&self) -> f64 {
        self.law.duration_s
    }

    /// Returns the times at which the way points of the path are passed (a rounded corner: its middle), one per way point, in
    /// seconds; ascending, from 0 to the duration.
    pub fn waypoint_times_s(&self) -> &[f64] {
        &self.waypoint_times_s
    }

    /// Returns the state at `time_s` (s): at rest at the first way point before the beginning, at the last one from the end on.
    pub fn sample(&self, time_s: f64) -> TrajectorySample {
        let Some((index, state)) = self.law.at(time_s, &self.curve) else {
            let position = if time_s < self.duration_s() { &self.first } else { &self.last };
            let rest = vec![0.0; position.len()];
            return TrajectorySample {
                time_s,
                position: position.clone(),
                velocity: rest.clone(),
                acceleration: rest,
            };
        };
        let piece = &self.curve.pieces[index];
        let derivatives = (0..self.first.len()).map(|joint| piece.derivatives(joint, state.s));
        let (velocity, acceleration) = derivatives
            .map(|q| (q.first * state.speed, q.first * state.acceleration + q.second * state.speed.powi(2)))
            .unzip();
        TrajectorySample { time_s, position: piece.position(state.s), velocity, acceleration }
    }

    /// Returns the instants at which a derivative of the motion may jump, in order, with its begin and end (s; one per instant):
    /// between two of them all joints move smoothly.
    pub fn switches_s(&self) -> Vec<f64> {
        let phases = self.law.phases.iter().map(|phase| phase.begin_s);
        let pieces = self.curve.pieces.iter().enumerate();
        let pieces = pieces.map(|(index, piece)| self.law.time_of(index, piece.begin));
        let mut times: Vec<f64> = phases.chain(pieces).chain([0.0, self.duration_s()]).collect();
        times.sort_by(f64::total_cmp);
        times.dedup_by(|later, time| *later - *time < 1e-9);
        times
    }

    /// Returns samples at 0, 1/`rate_hz`, 2/`rate_hz`, … and at the end.
    ///
    /// # Errors
    /// [`PathError::SampleRate`] if the rate is not above 0 and at most [`MAX_SAMPLE_RATE_HZ`], [`PathError::TooManySamples`].
    pub fn samples(
        &self,
        rate_hz: f64,
    ) -> Result<impl Iterator<Item = TrajectorySample> + use<'_>, PathError> {
        Ok(sample_times(self.duration_s(), rate_hz)?.map(|time_s| self.sample(time_s)))
    }
}

/// Maximum number of samples of a trajectory: some gigabytes of text.
const MAX_SAMPLES: f64 = 1e7;

/// Returns the instants 0, 1/`rate_hz`, 2/`rate_hz`, … and the end, in seconds.
///
/// # Errors
/// [`PathError::SampleRate`] if the rate is not above 0 and at most [`MAX_SAMPLE_RATE_HZ`], [`PathError::TooManySamples`].
pub fn sample_times(duration_s: f64, rate_hz: f64) -> Result<impl Iterator<Item = f64>, PathError> {
    if !(rate_hz > 0.0 && rate_hz <= MAX_SAMPLE_RATE_HZ) {
        return Err(PathError::SampleRate { rate_hz, greatest_hz: MAX_SAMPLE_RATE_HZ });
    }
    let count = duration_s * rate_hz;
    if count > MAX_SAMPLES {
        return Err(PathError::TooManySamples { duration_s, rate_hz, greatest: MAX_SAMPLES });
    }
    // A sample this close to the end, as a share of the interval, is the end.
    const SAME_INSTANT: f64 = 1e-6;
    let latest_s = duration_s - (SAME_INSTANT / rate_hz).min(0.5 * duration_s);
    let times = (0_u32..).map(move |k| f64::from(k) / rate_hz).take_while(move |t| *t < latest_s);
    Ok(times.chain(std::iter::once(duration_s)))
}
