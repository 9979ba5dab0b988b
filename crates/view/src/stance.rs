use std::borrow::Cow;

use cranny_robot::{Hold, Link, LinkFrames, Robot};
use cranny_spatial::{Point, Pose};

use crate::ShownCarry;

/// A robot along a path, and with it what it carries away.
pub(crate) struct Stance<'a> {
    robot: Cow<'a, Robot>,
    frames: LinkFrames,
    carry: Option<Carrying<'a>>,
}

struct Carrying<'a> {
    shown: &'a ShownCarry,
    /// What is held is all of the planning frame, as it lies in the hand that closes: where it is later is by how much the
    /// object has moved.
    tip_from_held: Pose,
    held: usize,
    /// By how much the object has moved once it is put down.
    placed: Option<Pose>,
}

/// Where it is at an instant.
pub(crate) struct Placed {
    /// Each link, by link: `parent_from_link`.
    pub local: Vec<Pose>,
    /// The origin of the gripper frame.
    pub tip: Point,
    /// By how much what is carried has moved, in the planning frame.
    pub carried: Option<Pose>,
}

impl<'a> Stance<'a> {
    pub fn of(robot: &'a Robot, carry: Option<&'a ShownCarry>) -> Self {
        let holding = carry.map(|carry| robot.holding(&carry.object));
        let held = holding.as_ref().and_then(Robot::held_link);
        let carry = carry.zip(held).map(|(shown, held)| {
            let tip_from_held = robot.frames_at(&shown.grasp).link(robot.tip()).inverse();
            let put_down = |q: &Vec<f64>| robot.frames_at(q).link(robot.tip()) * tip_from_held;
            Carrying { shown, tip_from_held, held, placed: shown.placed.as_ref().map(put_down) }
        });
        let robot = holding.map_or(Cow::Borrowed(robot), Cow::Owned);
        Self { frames: robot.frames(), robot, carry }
    }

    /// At a configuration and an instant in seconds.
    pub fn at(&mut self, q: &[f64], time_s: f64) -> Placed {
        let Self { robot, frames, carry } = self;
        if let Some(Carrying { shown, tip_from_held, .. }) = carry {
            let hold = Hold { tip_from_held: *tip_from_held, closing: shown.closing_at(time_s) };
            robot.place_held(&hold, frames);
        }
        robot.forward_kinematics(q, frames);
        let local = |(index, link): (usize, &Link)| match link.parent {
            Some(parent) => frames.link(parent).inv_mul(frames.link(index)),
            None => *frames.link(index),
        };
        let moved = |Carrying { shown, held, placed, .. }: &Carrying| match placed {
            Some(placed) if shown.is_placed_at(time_s) => *placed,
            _ if shown.is_held_at(time_s) => *frames.link(*held),
            _ => Pose::identity(),
        };
        Placed {
            local: robot.links().iter().enumerate().map(local).collect(),
            tip: frames.link(robot.tip()).translation.vector.into(),
            carried: carry.as_ref().map(moved),
        }
    }

    /// The links that move while the hand closes.
    pub fn fingers(&self) -> impl Iterator<Item = usize> {
        let held = self.robot.held_link();
        self.robot.loose_links().filter(move |link| Some(*link) != held)
    }
}
