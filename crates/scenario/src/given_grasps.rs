use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;

/// Which grasps a path may end at.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum GivenGrasps {
    /// Those that the scenario comes with.
    #[default]
    Own,
    /// Those of a file, in the planning frame.
    File(PathBuf),
    /// No set is given: whoever plans makes a grasp of its own.
    None,
}

/// What flags and files call it if no set is given; a file of that name is `./none`.
const NONE: &str = "none";

impl GivenGrasps {
    /// What a file says of it; nothing of those that the scenario comes with.
    pub fn text(&self) -> Option<String> {
        match self {
            Self::Own => None,
            Self::File(_) | Self::None => Some(self.to_string()),
        }
    }

    /// What a file says, in words that [`Self::text`] would use.
    pub fn of_text(text: Option<&str>) -> Self {
        match text {
            None => Self::Own,
            Some(NONE) => Self::None,
            Some(file) => Self::File(file.into()),
        }
    }

    /// These; where they are the scenario's own, the others.
    #[must_use]
    pub fn or(self, other: Self) -> Self {
        if self == Self::Own { other } else { self }
    }
}

impl FromStr for GivenGrasps {
    type Err = std::convert::Infallible;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        Ok(Self::of_text(Some(text)))
    }
}

impl fmt::Display for GivenGrasps {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Own => write!(f, "the scenario's own"),
            Self::File(file) => write!(f, "{}", file.display()),
            Self::None => write!(f, "{NONE}"),
        }
    }
}
