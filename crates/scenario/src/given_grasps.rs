use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;

/// Grasps at which a path may end.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum GivenGrasps {
    /// Grasps of the scenario.
    #[default]
    Own,
    /// Grasps of a file, in the planning frame.
    File(PathBuf),
    /// No given grasps: the planner computes its own.
    None,
}

/// Text in flags and files if no set is given; a file of that name is written as `./none`.
const NONE: &str = "none";

impl GivenGrasps {
    /// Returns the text that files store; `None` for the scenario's own grasps.
    pub fn text(&self) -> Option<String> {
        match self {
            Self::Own => None,
            Self::File(_) | Self::None => Some(self.to_string()),
        }
    }

    /// Parses the text that [`Self::text`] returns.
    pub fn of_text(text: Option<&str>) -> Self {
        match text {
            None => Self::Own,
            Some(NONE) => Self::None,
            Some(file) => Self::File(file.into()),
        }
    }

    /// Returns `self`, or `other` if `self` is the scenario's own set.
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
