use cranny_solve::Paces;
use cranny_task::{Mode, Segment};

/// Row of a query and its answer.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Demonstration {
    /// Index of the row in the whole set.
    pub row: u64,
    /// Index of its scene.
    pub scene: u64,
    /// Task.
    pub task: String,
    /// Outcome of the search; `solved` only with a path that is proven. `no-scene` if no sound scene was found.
    pub outcome: String,
    /// Seed of the search.
    pub seed: u64,
    /// Start configuration (m, rad; one per joint).
    pub start: Vec<f64>,
    /// Way points (m, rad), one after another, each with one value per joint; empty unless solved.
    pub waypoints: Vec<f64>,
    /// Times at which the way points are passed, in seconds, one per way point.
    pub times_s: Vec<f64>,
    /// Motions between those of the fingers, three numbers each: stage, mode ([`MODES`]), number of way points; the last way
    /// point of one is the first of the next.
    pub segments: Vec<i32>,
    /// Distances of the fingers on each segment, in metres; −1 for the open hand.
    pub openings_m: Vec<f64>,
    /// Share of the speed limits on each segment that keeps the hold firm; 1 for the full limits.
    pub speeds: Vec<f64>,
    /// Travel of the last finger after the first touches, on each segment, in metres; −1 for an empty hand.
    pub uneven_m: Vec<f64>,
    /// Index of the grasp in the set of the scene; −1 without a path.
    pub grasp: i64,
    /// Pose of the gripper frame at the grasp, in the planning frame: position (m) and unit quaternion (w, x, y, z).
    pub grasp_pose: Vec<f64>,
    /// Factor by which gravity may grow before a pad slips at this grasp; not a number if it is not known.
    pub load: f64,
    /// Proven lower bound of the clearance along the path, in metres, without the contact of a carried object with its support;
    /// at least [`KEPT_SHARE`](crate::KEPT_SHARE) of the true one. Infinite if nothing can collide.
    pub clearance_m: f64,
    /// Length of the path in the plain norm of `q` (m and rad alike).
    pub path_length: f64,
    /// Duration of the trajectory, in seconds; not a number for a robot without limits of acceleration.
    pub duration_s: f64,
    /// True if the hold on the carried object was checked along the motion, and is firm.
    pub hold_checked: bool,
    /// Factor by which loads may grow along the motion before the object slips; not a number if not checked.
    pub hold_factor: f64,
    /// Commonest reason for the failure of grasps, as a name of the plan file; empty if solved.
    pub reason: String,
}

/// Modes of a segment, in the order of their numbers in [`Demonstration::segments`].
pub const MODES: [Mode; 7] = Mode::ALL;

impl Demonstration {
    /// Creates a row without an answer.
    pub(crate) fn empty() -> Self {
        let unknown = f64::NAN;
        Self {
            grasp: -1,
            load: unknown,
            clearance_m: unknown,
            path_length: unknown,
            duration_s: unknown,
            hold_factor: unknown,
            ..Self::default()
        }
    }

    /// Returns true for a row with a proven path.
    pub fn is_solved(&self) -> bool {
        self.outcome == "solved"
    }

    /// Writes segments into the row.
    pub(crate) fn set_segments(&mut self, segments: &[Segment]) {
        for (index, segment) in segments.iter().enumerate() {
            let mode = MODES.iter().position(|mode| *mode == segment.mode).unwrap_or(0);
            let numbers = [segment.stage, mode, segment.waypoints.len()];
            self.segments.extend(numbers.map(|number| i32::try_from(number).unwrap_or(i32::MAX)));
            self.openings_m.push(segment.opening_m.unwrap_or(-1.0));
            self.speeds.push(segment.speed.unwrap_or(1.0));
            self.uneven_m.push(segment.uneven_m.unwrap_or(-1.0));
            let first = usize::from(index > 0);
            self.waypoints.extend(segment.waypoints.iter().skip(first).flatten());
        }
    }

    /// Returns the segments of a robot with `dof` joints whose hand holds the object of this name, at the default pace; `None` for a
    /// damaged row.
    pub(crate) fn read_segments(&self, dof: usize, object: &str) -> Option<Vec<Segment>> {
        let (numbers, rest) = self.segments.as_chunks::<3>();
        let same = [self.openings_m.len(), self.speeds.len(), self.uneven_m.len()];
        let is_even = self.waypoints.len().is_multiple_of(dof.max(1));
        if !rest.is_empty() || dof == 0 || !is_even || same.iter().any(|count| *count != numbers.len()) {
            return None;
        }
        let waypoints: Vec<Vec<f64>> = self.waypoints.chunks(dof).map(<[f64]>::to_vec).collect();
        let (mut segments, mut at) = (Vec::new(), 0_usize);
        for (index, of_segment) in numbers.iter().enumerate() {
            let [stage, mode, count] = of_segment.map(|number| usize::try_from(number).ok());
            let mode = *MODES.get(mode?)?;
            let begin = at.saturating_sub(usize::from(index > 0));
            at = begin.checked_add(count?)?;
            let given = |value: f64| (value >= 0.0).then_some(value);
            segments.push(Segment {
                attached: mode.holds.then(|| object.to_owned()),
                opening_m: given(self.openings_m[index]),
                uneven_m: given(self.uneven_m[index]),
                pace: Paces::default().of(mode),
                speed: Some(self.speeds[index]).filter(|share| *share < 1.0),
                ..Segment::empty(stage?, mode, waypoints.get(begin..at)?.to_vec())
            });
        }
        (at == waypoints.len()).then_some(segments)
    }
}
