//! Straight motions of the hand along the z axis of the gripper frame.

use cranny_collision::{Cell, CollisionError, Motion, ToolBound, ToolRegion};
use cranny_robot::{IkSettings, IkSolver, Robot};
use cranny_spatial::{EXACT_ROTATION_RAD, EXACT_TRANSLATION_M, Point, Pose, Vector};

use crate::stages::segment::{Mode, Segment};
use crate::stages::stage::{MOST_STRAIGHT_M, PlaceAt, Stage};

/// Distance between two consecutive configurations of a straight motion, in metres.
const RUNG_M: f64 = 0.01;

/// Excess over the required length, in metres: more than the errors of inverse kinematics.
const BEYOND_M: f64 = 1e-5;

/// A straight line from a pose against its own z axis, on which the gripper frame stays within 1 mm and 1°.
pub struct StraightLine {
    world_from_end: Pose,
    length_m: f64,
}

impl StraightLine {
    /// Creates the line from the pose of the gripper frame at `end`, as far as `far` (m, rad; one value per joint each).
    pub fn between(robot: &Robot, end: &[f64], far: &[f64]) -> Self {
        let [world_from_end, world_from_far] = [end, far].map(|q| *robot.frames_at(q).link(robot.tip()));
        let length_m = (-(world_from_end.inverse() * world_from_far).translation.z).max(0.0);
        Self { world_from_end, length_m }
    }

    /// Length of the line, in metres.
    pub fn length_m(&self) -> f64 {
        self.length_m
    }

    /// Returns a cell in which the gripper frame keeps to the line along every motion.
    ///
    /// # Errors
    /// [`CollisionError::ToolBound`] for an invalid pose.
    pub fn keeping(&self, cell: &Cell) -> Result<Cell, CollisionError> {
        /// Half edge of a box whose corners are 1 mm from its middle line, and its extent beyond the ends.
        const ACROSS_M: f64 = EXACT_TRANSLATION_M * std::f64::consts::FRAC_1_SQRT_2;
        let half_m = Vector::new(ACROSS_M, ACROSS_M, 0.5 * self.length_m + ACROSS_M);
        let world_from_box = self.world_from_end * Pose::translation(0.0, 0.0, -0.5 * self.length_m);
        let on_line = ToolRegion::Box { point_in_link: Point::origin(), world_from_box, half_m };
        // For the whole turn, 1 − cos is at most the sum of 1 − cos over the angles by which two of the axes turn.
        let most_rad = libm::acos(0.5 * (1.0 + libm::cos(EXACT_ROTATION_RAD)));
        let cone = |axis_in_link: Vector| {
            let toward = self.world_from_end.rotation * axis_in_link;
            ToolRegion::Cone { axis_in_link, toward, most_rad }
        };
        let regions = [on_line, cone(Vector::z()), cone(Vector::x())];
        let bound = |region| ToolBound { name: "straight line".to_owned(), link: None, region };
        cell.with_further_bounds(&regions.map(bound))
    }
}

/// Returns the line that the hand keeps to along a segment of a stage: an approach, or a retreat that must be straight.
pub fn straight_line(robot: &Robot, stage: Option<&Stage>, segment: &Segment) -> Option<StraightLine> {
    let (first, last) = (segment.waypoints.first()?, segment.waypoints.last()?);
    let is_straight = |place: &PlaceAt| place.retreat_m > 0.0;
    match stage {
        _ if segment.mode == Mode::APPROACH => Some(StraightLine::between(robot, last, first)),
        Some(Stage::Place(place)) if segment.mode == Mode::RETREAT && is_straight(place) => {
            Some(StraightLine::between(robot, first, last))
        }
        _ => None,
    }
}

/// The end of a straight motion that is farther from the object.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FarEnd {
    /// The first way point: the hand approaches.
    First,
    /// The last way point: the hand retreats.
    Last,
}

/// Computes a path of way points (m, rad; one value per joint) on a [`StraightLine`] from `q`, at least `least_m` (m) long and
/// until `is_far` is true at its end, in straight edges of joint space, each of them proven in the direction of travel.
///
/// # Errors
/// The pair that blocks it; `None` if the arm, a bound or [`MOST_STRAIGHT_M`] does.
pub(crate) fn straight_path(
    cell: &Cell,
    q: &[f64],
    (least_m, far_end): (f64, FarEnd),
    mut is_far: impl FnMut(&[f64]) -> bool,
) -> Result<Vec<Vec<f64>>, Option<[String; 2]>> {
    let robot = cell.robot();
    let world_from_tip = *robot.frames_at(q).link(robot.tip());
    // The rest of the pose tolerance is left for the straight edges between the solutions.
    let settings =
        IkSettings { translation_tolerance_m: 1e-6, rotation_tolerance_rad: 1e-5, ..IkSettings::default() };
    let mut solver = IkSolver::new(robot, settings);
    let (mut rungs, mut gone_m) = (vec![q.to_vec()], 0.0);
    let enough_m = least_m + BEYOND_M;
    while gone_m < enough_m || !is_far(&rungs[rungs.len() - 1]) {
        if gone_m >= MOST_STRAIGHT_M {
            return Err(None);
        }
        gone_m = if gone_m < enough_m { (gone_m + RUNG_M).min(enough_m) } else { gone_m + RUNG_M };
        let target = world_from_tip * Pose::translation(0.0, 0.0, -gone_m);
        rungs.push(solver.step_from(&target, &rungs[rungs.len() - 1]).ok_or(None)?);
    }
    let line = StraightLine::between(robot, q, &rungs[rungs.len() - 1]);
    let keeping = line.keeping(cell).map_err(|_| None)?;
    if far_end == FarEnd::First {
        rungs.reverse();
    }
    in_long_edges(&keeping, &rungs)
}

/// Returns a path through some of these way points (m, rad; one value per joint), in long edges that are proven in a cell.
fn in_long_edges(cell: &Cell, rungs: &[Vec<f64>]) -> Result<Vec<Vec<f64>>, Option<[String; 2]>> {
    let mut scratch = cell.scratch();
    let (mut path, mut at) = (rungs[..1].to_vec(), 0);
    while at + 1 < rungs.len() {
        let mut step = rungs.len() - 1 - at;
        loop {
            let stopped = match cell.motion_is_free(&rungs[at], &rungs[at + step], &mut scratch) {
                Motion::Proven => break,
                Motion::Contact { contact, .. } | Motion::Unresolved { contact, .. } => {
                    Some(contact.names(cell))
                }
                Motion::OutOfLimits { .. } | Motion::OutOfBounds { .. } => None,
            };
            if step == 1 {
                return Err(stopped);
            }
            step /= 2;
        }
        at += step;
        path.push(rungs[at].clone());
    }
    Ok(path)
}
