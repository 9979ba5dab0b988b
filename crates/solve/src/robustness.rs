use std::sync::Arc;

use cranny_collision::{Cell, PairGroup};
use cranny_plan::Problem;
use cranny_spatial::CONTACT_M;
use serde::{Deserialize, Serialize};

use crate::{Segment, TaskCells};

/// How far things may be from where a plan has them while every segment of it stays free of collision: each kind of error by
/// itself, and certified. It holds for pairs that must be apart: fingers on what they close on are none, nor is an object on
/// what it rests on until it is lifted off. `None`: however far, nothing is there to touch.
///
/// The law: whoever is moved by an error is moved by no more than the least distance of the pairs that it moves against each
/// other, which is measured along every segment.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Robustness {
    /// Of the object before the hand closes on it, about the middle of a ball around it.
    pub object: Option<PoseRadius>,
    /// Of the object in the hand from then on, where it is carried.
    pub slip: Option<PoseRadius>,
    /// Of the robot's root, about its origin, against all that stands around.
    pub base: Option<PoseRadius>,
    /// Of every joint, all at once.
    pub joints: Option<JointRadius>,
}

/// How far a pose may be off: moved by t and turned by θ where `t / translation_m + θ / rotation_rad ≤ 1`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PoseRadius {
    /// If it is not turned, in metres.
    pub translation_m: f64,
    /// If it is turned in place, in radians.
    pub rotation_rad: f64,
}

/// How far every joint may be from where the plan has it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct JointRadius {
    /// Those that slide, if no other is off, in metres; `None` where none slides.
    pub sliding_m: Option<f64>,
    /// Those that turn, if no other is off, in radians; `None` where none turns.
    pub turning_rad: Option<f64>,
}

/// What is measured may lie so far below the truth, as a share of it.
const SHARE: f64 = 0.05;

impl PoseRadius {
    /// Of something that may be moved so far, all of which is within `lever_m` of what it turns about.
    fn of(room_m: f64, lever_m: f64) -> Option<Self> {
        room_m.is_finite().then(|| Self { translation_m: room_m, rotation_rad: room_m / lever_m })
    }

    /// The smaller of two, one of which there may not be.
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
    /// Of a path that is proven; `None` under `paper`, which proves nothing.
    pub fn of(problem: &Problem, cells: Option<&TaskCells>, segments: &[Segment]) -> Option<Self> {
        let reach = problem.cell()?;
        let target = problem.target().and_then(|target| reach.world().bodies()[target].ball());
        let mut all = Self::default();
        for segment in segments {
            let cell = cells.and_then(|cells| cells.cell(segment.mode)).unwrap_or(reach);
            // A path of one way point is an edge of no length.
            let standing = [segment.waypoints.first()?.clone(), segment.waypoints.first()?.clone()];
            let path = if segment.waypoints.len() > 1 { &segment.waypoints[..] } else { &standing };
            let of_segment = Self::along(cell, path, target.map_or(0.0, |ball| ball.radius_m));
            let before = cells.is_none_or(|cells| cells.cell(segment.mode).is_none());
            let [object, slip] = if before { [of_segment.object, None] } else { [None, of_segment.object] };
            all = Self {
                object: PoseRadius::least(all.object, object),
                slip: PoseRadius::least(all.slip, slip),
                base: PoseRadius::least(all.base, of_segment.base),
                joints: JointRadius::least(all.joints, of_segment.joints),
            };
        }
        Some(all)
    }

    /// Along a path in one cell, with an object of this radius.
    fn along(cell: &Arc<Cell>, path: &[Vec<f64>], object_m: f64) -> Self {
        let mut scratch = cell.scratch();
        let mut room_m =
            |group| (cell.group_clearance(path, group, SHARE, &mut scratch) - CONTACT_M).max(0.0);
        let [links_m, around_m, object_room_m] =
            [PairGroup::Links, PairGroup::Around, PairGroup::Object].map(&mut room_m);
        let levers = cell.levers(path, &mut cell.scratch());
        let world_m = around_m.min(object_room_m);
        // What is held is among the links too, and against them.
        let rooms_m = [world_m, links_m.min(object_room_m)];
        let radius = |levers: [f64; 2]| {
            let each =
                rooms_m.iter().zip(levers).filter(|(room_m, lever)| room_m.is_finite() && *lever > 0.0);
            each.map(|(room_m, lever)| room_m / lever).reduce(f64::min)
        };
        let joints = JointRadius { sliding_m: radius(levers.sliding), turning_rad: radius(levers.turning_m) };
        Self {
            object: PoseRadius::of(object_room_m, object_m),
            slip: None,
            base: PoseRadius::of(world_m, levers.from_root_m),
            joints: (joints.sliding_m.is_some() || joints.turning_rad.is_some()).then_some(joints),
        }
    }
}
