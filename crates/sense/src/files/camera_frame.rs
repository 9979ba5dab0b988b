/// Frames of cameras.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum CameraFrame {
    /// The planning frame, which is the frame of the robot's root link.
    World,
    /// A link of the robot.
    Link(String),
}

impl CameraFrame {
    pub(crate) fn parse(text: &str) -> Option<Self> {
        match text.trim().split_once(char::is_whitespace) {
            None if text.trim() == "world" => Some(Self::World),
            Some(("link", name)) => Some(Self::Link(name.trim().to_owned())),
            _ => None,
        }
    }
}
