use std::borrow::Cow;
use std::collections::HashMap;

use cranny_robot::{Hold, Link, LinkFrames, Robot};
use cranny_spatial::{Point, Pose};

use crate::CarriedObjectMotion;

/// Robot along a path with the objects it carries.
pub(crate) struct Stance<'a> {
    robot: Cow<'a, Robot>,
    frames: LinkFrames,
    carries: Vec<Carrying<'a>>,
}

struct Carrying<'a> {
    shown: &'a CarriedObjectMotion,
    /// Pose of the planning frame in the tip frame at the grasp; with the tip, it becomes the displacement of the object.
    tip_from_held: Pose,
    /// Displacement of the object after the set-down.
    placed: Option<Pose>,
    /// Index of the previous carry of the same object.
    before: Option<usize>,
}

/// Poses of robot and objects at an instant.
pub(crate) struct Placed {
    /// `parent_from_link` of each link, in order of the links.
    pub local: Vec<Pose>,
    /// Origin of the gripper frame.
    pub tip: Point,
    /// Displacement of each carried object, in the planning frame.
    pub carried: Vec<Pose>,
}

impl<'a> Stance<'a> {
    pub fn of(robot: &'a Robot, carries: &'a [CarriedObjectMotion]) -> Self {
        let mut known: HashMap<&str, usize> = HashMap::new();
        let carrying = |(index, shown): (usize, &'a CarriedObjectMotion)| {
            let tip_from_held = robot.frames_at(&shown.grasp).link(robot.tip()).inverse();
            let put_down = |q: &Vec<f64>| robot.frames_at(q).link(robot.tip()) * tip_from_held;
            let before = known.insert(&shown.object, index);
            Carrying { shown, tip_from_held, placed: shown.placed.as_ref().map(put_down), before }
        };
        let all = carries.iter().enumerate().map(carrying).collect();
        let robot =
            carries.first().map_or(Cow::Borrowed(robot), |carry| Cow::Owned(robot.holding(&carry.object)));
        Self { frames: robot.frames(), robot, carries: all }
    }

    /// Computes the poses at a configuration (m, rad; one per joint) and an instant in seconds.
    pub fn at(&mut self, q: &[f64], time_s: f64) -> Placed {
        let Self { robot, frames, carries } = self;
        // Only one object is held at a time.
        let at_hand = carries.iter().rfind(|carrying| time_s >= carrying.shown.closes_s()[0]);
        if let Some(Carrying { shown, tip_from_held, .. }) = at_hand.or(carries.first()) {
            let hold = Hold { tip_from_held: *tip_from_held, closing: shown.closing_at(time_s) };
            robot.place_held(&hold, frames);
        }
        robot.forward_kinematics(q, frames);
        let local = |(index, link): (usize, &Link)| match link.parent {
            Some(parent) => frames.link(parent).inv_mul(frames.link(index)),
            None => *frames.link(index),
        };
        let held = robot.held_link().map(|held| *frames.link(held));
        let moved = |Carrying { shown, placed, .. }: &Carrying| match (placed, held) {
            (Some(placed), _) if shown.is_placed_at(time_s) => *placed,
            (_, Some(held)) if shown.is_held_at(time_s) => held,
            _ => Pose::identity(),
        };
        Placed {
            local: robot.links().iter().enumerate().map(local).collect(),
            tip: frames.link(robot.tip()).translation.vector.into(),
            carried: {
                let mut carried: Vec<Pose> = carries.iter().map(moved).collect();
                // An object that is carried again begins where it was set down before.
                for (later, Carrying { before, .. }) in carries.iter().enumerate() {
                    if let Some(before) = before {
                        let moved_before = carried[*before];
                        carried[later] *= moved_before;
                    }
                }
                carried
            },
        }
    }

    /// Returns the links that move while the hand closes.
    pub fn fingers(&self) -> impl Iterator<Item = usize> {
        let held = self.robot.held_link();
        self.robot.loose_links().filter(move |link| Some(*link) != held)
    }
}
