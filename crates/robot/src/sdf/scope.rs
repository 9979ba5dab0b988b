use crate::sdf::frames::WORLD;

/// Scope of names: a model, or the world.
#[derive(Clone)]
pub(crate) struct Scope {
    /// Scopes of its names, each followed by `::`; empty for the world and for the model of a model file.
    pub(crate) prefix: String,
    /// Frame of its model, which poses are relative to by default.
    pub(crate) model_frame: String,
    pub(crate) is_static: bool,
    /// True in a model of a world, whose links move freely unless joints hold them.
    pub(crate) is_in_world: bool,
    /// Version of the SDF: major and minor.
    pub(crate) version: [u32; 2],
    pub(crate) depth: usize,
}

impl Scope {
    /// Returns the name of an element of this scope with those of the scopes around it.
    pub(crate) fn name(&self, name: &str) -> String {
        format!("{}{name}", self.prefix)
    }

    /// Returns the frame of a joint. Until version 1.6 nothing is relative to a joint, and a link may have its name.
    pub(crate) fn joint_frame(&self, joint: &str) -> String {
        if self.version < [1, 7] { format!("{}{joint}::__joint__", self.prefix) } else { self.name(joint) }
    }

    /// Returns the frame that a name in this scope denotes.
    pub(crate) fn frame(&self, name: &str) -> String {
        match name {
            "__model__" => self.model_frame.clone(),
            "world" if self.model_frame == WORLD => WORLD.to_owned(),
            _ => self.name(name.strip_suffix("::__model__").unwrap_or(name)),
        }
    }
}
