use cranny_collision::{Cell, Chords, Levers, PairGroup, StandingClearance};
use cranny_spatial::CONTACT_M;
use cranny_task::{Segment, StateSequence};
use serde::{Deserialize, Serialize};

/// Certified distances by which things may deviate from a plan while all its motions stay free of collision, for each kind of
/// error by itself. `None`: unlimited, there is nothing to touch.
///
/// The law: an error within these radii moves nothing farther than the least distance of the pairs that the error moves against
/// each other. The measure covers all edges, the curve of every rounded corner, and, if the object is carried, the fingers
/// while the hand closes and opens.
///
/// | error of | pairs | during |
/// |---|---|---|
/// | object | object, at its initial pose, with every link, moved by a joint or not | motions with the empty hand |
/// | slip | object with every link that moves against it, and with the world; after put-down, with every link | motions with the object in the hand, and after |
/// | base | every link, moved by a joint or not, and the held object, with the world | all motions |
/// | joints | every moving link, and the held object, with the world and with each other | all motions |
///
/// Pairs that may or must touch are excluded: fingers with the object that they close on, an object with its support until the
/// lift-off, and pairs that every answer names as not compared, such as a fixed link and the body on which it stands. The
/// closing of the hand is measured for an object at its planned pose.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Robustness {
    /// Error of the object before the hand closes on it, about the centre of a ball around it.
    pub object: Option<PoseRadius>,
    /// Error of the object in the hand from then on, if it is carried.
    pub slip: Option<PoseRadius>,
    /// Error of the robot's root, about its origin, against all surroundings.
    pub base: Option<PoseRadius>,
    /// Error of every joint, all at once.
    pub joints: Option<JointRadius>,
}

/// Tolerated error of a pose: translation t and rotation θ with `t / translation_m + θ / rotation_rad ≤ 1`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PoseRadius {
    /// Translation without rotation, in metres.
    pub translation_m: f64,
    /// Rotation without translation, in radians.
    pub rotation_rad: f64,
}

/// Tolerated error of every joint.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct JointRadius {
    /// Error of all sliding joints while the turning joints are exact, in metres; `None` if nothing limits it.
    pub sliding_m: Option<f64>,
    /// Error of all turning joints while the sliding joints are exact, in radians; `None` if nothing limits it.
    pub turning_rad: Option<f64>,
}

/// Relative slack of the lower bound of the clearance.
const SHARE: f64 = 0.05;

impl PoseRadius {
    /// Creates the radius of a thing within `lever_m` (m) of its centre of rotation that may move by `room_m` (m), if finite.
    fn of(room_m: f64, lever_m: f64) -> Option<Self> {
        room_m.is_finite().then(|| Self { translation_m: room_m, rotation_rad: room_m / lever_m })
    }

    /// Returns the smaller of two optional radii, component by component.
    fn least(a: Option<Self>, b: Option<Self>) -> Option<Self> {
        let smaller = |a: Self, b: Self| Self {
            translation_m: a.translation_m.min(b.translation_m),
            rotation_rad: a.rotation_rad.min(b.rotation_rad),
        };
        a.into_iter().chain(b).reduce(smaller)
    }
}

impl JointRadius {
    fn least(a: Option<Self>, b: Option<Self>) -> Option<Self> {
        let least = |a: Option<f64>, b: Option<f64>| a.into_iter().chain(b).reduce(f64::min);
        let smaller = |a: Self, b: Self| Self {
            sliding_m: least(a.sliding_m, b.sliding_m),
            turning_rad: least(a.turning_rad, b.turning_rad),
        };
        a.into_iter().chain(b).reduce(smaller)
    }
}

impl Robustness {
    /// Computes the robustness of proven segments, rounded corners included, with the state along each; `None` if a segment has
    /// no way point.
    pub fn of(along: &StateSequence, segments: &[Segment]) -> Option<Self> {
        let mut all = Self::default();
        let states = || along.states.iter();
        for (index, (segment, state)) in segments.iter().zip(states()).enumerate() {
            let (first, last) = (segment.waypoints.first()?, segment.waypoints.last()?);
            // A path of one way point is an edge of zero length.
            let standing = [first.clone(), first.clone()];
            let path = if segment.waypoints.len() > 1 { &segment.waypoints[..] } else { &standing };
            let cell = state.cell();
            let mut rooms = vec![ErrorClearances::along(cell, path, 0.0)];
            rooms.extend(rounded_corners(cell, segment).map(|Chords { waypoints, deviation_m }| {
                ErrorClearances::along(cell, &waypoints, deviation_m)
            }));
            // If the hand closes or opens before the next segment, check this in the cell of the segment with the held object.
            let next = states().nth(index + 1).filter(|next| next.held().is_some() != state.held().is_some());
            let sweeping = next.map(|next| if next.held().is_some() { next.cell() } else { cell });
            rooms.extend(sweeping.map(|cell| ErrorClearances::while_closing(cell, last)));
            let object = cell.grasp_body().and_then(|body| cell.world().bodies()[body].ball());
            let object_m = object.map_or(0.0, |ball| ball.radius_m);
            for of_rooms in rooms.iter().map(|rooms| rooms.robustness(object_m)) {
                let is_touched = state.held().is_some()
                    || state.let_go().is_some_and(|(body, _)| cell.grasp_body() == Some(body));
                let (object, slip) =
                    if is_touched { (None, of_rooms.object) } else { (of_rooms.object, None) };
                all = Self {
                    object: PoseRadius::least(all.object, object),
                    slip: PoseRadius::least(all.slip, slip),
                    base: PoseRadius::least(all.base, of_rooms.base),
                    joints: JointRadius::least(all.joints, of_rooms.joints),
                };
            }
        }
        Some(all)
    }
}

/// Returns the rounded corners of a segment as chords, finer where obstacles are nearer.
fn rounded_corners(cell: &Cell, segment: &Segment) -> impl Iterator<Item = Chords> {
    /// Deviation as a share of the clearance, and its bounds, in metres.
    const DEVIATION: f64 = 0.02;
    const DEVIATIONS_M: [f64; 2] = [1e-5, 2e-3];
    let reach = cell.reach();
    segment.corners.iter().map(move |corner| {
        let clearance_m = segment.clearances_m.get(corner.waypoint).copied().flatten();
        let tolerance_m = clearance_m.map_or(DEVIATIONS_M[1], |clearance_m| DEVIATION * clearance_m);
        Cell::chords_of(&corner.control_points, tolerance_m.clamp(DEVIATIONS_M[0], DEVIATIONS_M[1]), &reach)
    })
}

/// Clearances, in metres and less the contact distance, of the pairs that an error moves against each other during a motion,
/// and the levers of the errors.
struct ErrorClearances {
    /// Moving links against each other.
    links_m: f64,
    /// Moving links and the held object against the world.
    around_m: f64,
    /// Object against all that it may not touch.
    object_m: f64,
    /// Links that no joint moves, against the world.
    standing: StandingClearance,
    levers: Levers,
}

impl ErrorClearances {
    /// Computes the clearances along a path, or a curve within `deviation_m` (m) of it.
    fn along(cell: &Cell, path: &[Vec<f64>], deviation_m: f64) -> Self {
        let scratch = &mut cell.scratch();
        let groups = [PairGroup::Links, PairGroup::Around, PairGroup::Object];
        let room_m = |group| cell.group_clearance(path, group, SHARE, scratch) - deviation_m;
        let [links_m, around_m, object_m] = groups.map(room_m);
        let mut levers = cell.levers(path, scratch);
        // The curve lies between edges of the path, so the levers of the joints are no longer than along these.
        levers.from_root_m += deviation_m;
        Self::of([links_m, around_m, object_m], cell, levers)
    }

    /// Computes the clearances while the hand closes from fully open on the held object of a cell at a configuration, or opens
    /// there: fingers against all but the object.
    fn while_closing(cell: &Cell, q: &[f64]) -> Self {
        let scratch = &mut cell.scratch();
        let [links_m, around_m] =
            [PairGroup::Links, PairGroup::Around].map(|group| cell.closing_clearance(q, group, scratch));
        Self::of([links_m, around_m, f64::INFINITY], cell, cell.closing_levers(q, scratch))
    }

    fn of(clearances_m: [f64; 3], cell: &Cell, levers: Levers) -> Self {
        let room_m = |clearance_m: f64| (clearance_m - CONTACT_M).max(0.0);
        let [links_m, around_m, object_m] = clearances_m.map(room_m);
        let StandingClearance { around_m: standing_m, object_m: to_object_m } = cell.standing_clearance();
        let standing = StandingClearance { around_m: room_m(standing_m), object_m: room_m(to_object_m) };
        Self { links_m, around_m, object_m, standing, levers }
    }

    /// Returns the radii; that of the object is about the centre of a ball around it of radius `object_radius_m` (m).
    fn robustness(&self, object_radius_m: f64) -> Robustness {
        let Self { links_m, around_m, object_m, standing, levers } = self;
        let world_m = around_m.min(*object_m);
        // A held object moves with the links and against them, so its distance limits both levers. Fixed links do not count.
        let rooms_m = [world_m, links_m.min(*object_m)];
        let radius = |levers: [f64; 2]| {
            let each =
                rooms_m.iter().zip(levers).filter(|(room_m, lever)| room_m.is_finite() && *lever > 0.0);
            each.map(|(room_m, lever)| room_m / lever).reduce(f64::min)
        };
        let joints = JointRadius { sliding_m: radius(levers.sliding), turning_rad: radius(levers.turning_m) };
        let object_m = object_m.min(standing.object_m);
        Robustness {
            object: PoseRadius::of(object_m, object_radius_m),
            slip: None,
            base: PoseRadius::of(world_m.min(object_m).min(standing.around_m), levers.from_root_m),
            joints: (joints.sliding_m.is_some() || joints.turning_rad.is_some()).then_some(joints),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use cranny_collision::{Body, Margins, World};
    use cranny_robot::{Robot, RobotOptions};
    use cranny_task::{Goal, Problem, Stage};

    use super::*;

    /// A box that never moves, and a ball that slides 0.5 m above the ground.
    const CRANE: &str = r#"<robot name="crane">
      <link name="base"><collision><geometry><box size="0.2 0.2 0.2"/></geometry></collision></link>
      <link name="ball"><collision><geometry><sphere radius="0.05"/></geometry></collision></link>
      <joint name="x" type="prismatic"><parent link="base"/><child link="ball"/><origin xyz="0.5 0 0.5"/><axis xyz="1 0 0"/>
        <limit lower="-1" upper="1" velocity="1" effort="1"/></joint>
    </robot>"#;

    fn along(floor_m: f64) -> Robustness {
        let robot =
            Robot::from_urdf_text(CRANE, "crane.urdf", None, &RobotOptions::default()).expect("a URDF");
        let world = World::new(vec![Body::floor(floor_m)]).expect("a floor");
        let (start, end) = (vec![0.0], vec![0.5]);
        let goal = Goal::Configurations(vec![end.clone()]);
        let problem = Problem::exact(Arc::new(robot), world, None, start.clone(), goal, Margins::default());
        let segments = [Segment::reach(vec![start, end], Vec::new())];
        let along = StateSequence::of(&problem.expect("a problem"), &[Stage::home()], &segments);
        Robustness::of(&along.expect("states").expect("a cell"), &segments).expect("way points")
    }

    #[test]
    fn the_base_takes_the_links_along_that_never_move() {
        let near = along(-0.1005);
        let base = near.base.expect("a floor");
        assert!((base.translation_m - (0.0005 - CONTACT_M)).abs() < 1e-7, "{base:?}");
        // Errors of the joints do not move the fixed links.
        let sliding_m = near.joints.and_then(|joints| joints.sliding_m).expect("a joint that slides");
        assert!(sliding_m > 0.4, "{sliding_m}");
        // A fixed link that touches the floor is not compared; every answer names that pair instead.
        let standing = along(-0.1).base.expect("a floor");
        assert!(standing.translation_m > 0.4, "{standing:?}");
    }
}
