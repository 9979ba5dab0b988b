use std::path::Path;

use crate::failure::Failure;
use crate::file_kind::FileKind;
use crate::output_file;

/// What a file's ending asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    Png,
    Gif,
    Apng,
    Glb,
    Html,
    Folder,
}

impl Format {
    /// What the name of the output says.
    pub fn of(file: &Path) -> Result<Self, Failure> {
        if output_file::is_folder(file) {
            return Ok(Self::Folder);
        }
        let ending = file.extension().unwrap_or_default().to_string_lossy().to_lowercase();
        match ending.as_str() {
            "png" => Ok(Self::Png),
            "gif" => Ok(Self::Gif),
            "apng" => Ok(Self::Apng),
            "glb" => Ok(Self::Glb),
            "html" => Ok(Self::Html),
            _ => {
                let text = file.display();
                let problem =
                    format!("'{text}' ends in none of .png, .gif, .apng, .glb, .html and / (a folder)");
                Err(Failure::Flag { flag: "output", problem })
            }
        }
    }

    /// Nothing for a folder, which is no file.
    pub fn kind(self) -> Option<FileKind> {
        match self {
            Self::Png | Self::Apng => Some(FileKind::Png),
            Self::Gif => Some(FileKind::Gif),
            Self::Glb => Some(FileKind::Glb),
            Self::Html => Some(FileKind::ViewerPage),
            Self::Folder => None,
        }
    }

    /// Whether it is many pictures.
    pub fn is_moving(self) -> bool {
        matches!(self, Self::Gif | Self::Apng | Self::Folder)
    }
}
