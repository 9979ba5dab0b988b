use std::path::Path;

use crate::failure::Failure;
use crate::file_kind::FileKind;
use crate::output_file;

/// Output format, from the extension of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    Png,
    Gif,
    Apng,
    Mp4,
    Glb,
    Html,
    Folder,
}

impl Format {
    /// Returns the format for the name of the output.
    pub fn of(file: &Path) -> Result<Self, Failure> {
        if output_file::is_folder(file) {
            return Ok(Self::Folder);
        }
        let ending = file.extension().unwrap_or_default().to_string_lossy().to_lowercase();
        match ending.as_str() {
            "png" => Ok(Self::Png),
            "gif" => Ok(Self::Gif),
            "apng" => Ok(Self::Apng),
            "mp4" => Ok(Self::Mp4),
            "glb" => Ok(Self::Glb),
            "html" => Ok(Self::Html),
            _ => {
                let text = file.display();
                let problem = format!(
                    "unknown ending of '{text}' (known: .png, .gif, .apng, .mp4, .glb, .html and / for a folder)"
                );
                Err(Failure::Flag { flag: "output", problem })
            }
        }
    }

    /// Returns the kind of file; `None` for a folder.
    pub fn kind(self) -> Option<FileKind> {
        match self {
            Self::Png | Self::Apng => Some(FileKind::Png),
            Self::Gif => Some(FileKind::Gif),
            Self::Mp4 => Some(FileKind::Mp4),
            Self::Glb => Some(FileKind::Glb),
            Self::Html => Some(FileKind::ViewerPage),
            Self::Folder => None,
        }
    }

    /// Returns true if the output has several frames.
    pub fn is_moving(self) -> bool {
        matches!(self, Self::Gif | Self::Apng | Self::Mp4 | Self::Folder)
    }
}
