use std::collections::HashMap;

use cranny_file::nearest_names;
use cranny_spatial::Pose;

use crate::{Location, RobotError};

/// Identifier of the world frame. Others are names with their scopes, such as `cabinet::drawer`.
pub(crate) const WORLD: &str = "";

/// Maximum number of frames; a pose is found by a walk over those that it depends on.
const MOST_FRAMES: usize = 10_000;

/// Frames of a model or world: those of its models, links, joints and `<frame>` elements.
#[derive(Default)]
pub(crate) struct Frames {
    frames: HashMap<String, Frame>,
}

pub(crate) struct Frame {
    pub(crate) at: Location,
    /// Frame that `pose` is relative to.
    pub(crate) relative_to: String,
    pub(crate) pose: Pose,
    /// Frame that it is attached to; `None` for a link.
    pub(crate) attached_to: Option<String>,
}

impl Frames {
    /// # Errors
    /// [`RobotError::DefinedTwice`], [`RobotError::TooMany`].
    pub(crate) fn add(&mut self, name: String, frame: Frame) -> Result<(), RobotError> {
        let at = frame.at.clone();
        let (actual, most) = (self.frames.len() + 1, MOST_FRAMES);
        if actual > most {
            return Err(RobotError::TooMany { at, what: "frames in one model", most, actual });
        }
        match self.frames.insert(name.clone(), frame) {
            None => Ok(()),
            Some(first) => {
                Err(RobotError::DefinedTwice { at, kind: "frame", name, first_line: first.at.line })
            }
        }
    }

    /// Returns the frame of that name; `at` is the location of its mention.
    pub(crate) fn get(&self, name: &str, at: &Location) -> Result<&Frame, RobotError> {
        self.frames.get(name).ok_or_else(|| RobotError::UnknownName {
            place: at.to_string(),
            kind: "frame",
            name: name.to_owned(),
            nearest: nearest_names(name, self.frames.keys().map(String::as_str)),
        })
    }

    /// Returns the pose of a frame in the world.
    ///
    /// # Errors
    /// [`RobotError::UnknownName`]; [`RobotError::NotSupported`] for frames that are relative to each other in a loop.
    pub(crate) fn world_from(&self, name: &str, at: &Location) -> Result<Pose, RobotError> {
        self.between(WORLD, name, at)
    }

    /// Returns the pose of the frame `inner` in the frame `outer`, which need not be known yet.
    ///
    /// # Errors
    /// As [`Self::world_from`], also if `inner` does not depend on `outer`.
    pub(crate) fn between(&self, outer: &str, inner: &str, at: &Location) -> Result<Pose, RobotError> {
        let (mut name, mut outer_from_frame, mut at) = (inner, Pose::identity(), at);
        for _ in 0..=self.frames.len() {
            if name == outer {
                return Ok(outer_from_frame);
            }
            let frame = self.get(name, at)?;
            outer_from_frame = frame.pose * outer_from_frame;
            (name, at) = (&frame.relative_to, &frame.at);
        }
        Err(looped(at, name))
    }

    /// Returns the link that a frame is attached to, or [`WORLD`].
    ///
    /// # Errors
    /// As [`Self::world_from`].
    pub(crate) fn link_of<'f>(&'f self, name: &'f str, at: &'f Location) -> Result<&'f str, RobotError> {
        let (mut name, mut at) = (name, at);
        for _ in 0..=self.frames.len() {
            if name == WORLD {
                return Ok(WORLD);
            }
            let frame = self.get(name, at)?;
            let Some(next) = &frame.attached_to else { return Ok(name) };
            (name, at) = (next, &frame.at);
        }
        Err(looped(at, name))
    }
}

fn looped(at: &Location, name: &str) -> RobotError {
    let (at, what) = (at.clone(), format!("frame `{name}`, which leads back to itself,"));
    RobotError::NotSupported { at, what, hint: "make one of the frames relative to its model" }
}
