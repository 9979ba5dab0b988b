//! An SRDF that does not lie beside a URDF under its name, but where packages of ROS have it.

use std::path::{Path, PathBuf};

use cranny_robot::{Robot, Srdf};

use crate::choice::Choice;
use crate::draft::read_text;

/// What was found.
pub(crate) struct NearSrdf {
    path: PathBuf,
    pub srdf: Srdf,
}

/// The SRDF of the folder `../srdf` that has most of the beginning of its name in common with the URDF, and all of one of
/// the two names; nothing where none can be read.
pub(crate) fn find(urdf: &Path) -> Option<NearSrdf> {
    let stem = urdf.file_stem()?.to_str()?;
    let folder = std::path::absolute(urdf).ok()?.parent()?.parent()?.join("srdf");
    let mut files: Vec<PathBuf> =
        std::fs::read_dir(folder).ok()?.filter_map(|file| Some(file.ok()?.path())).collect();
    files.sort();
    let in_common = |path: &PathBuf| -> Option<usize> {
        let name = path.file_name()?.to_str()?.strip_suffix(".srdf")?;
        (name.starts_with(stem) || stem.starts_with(name)).then(|| name.len().min(stem.len()))
    };
    // Of equals the shortest name: the robot itself, not one of its variants.
    let rank = |path: &PathBuf| Some((in_common(path)?, usize::MAX - path.as_os_str().len()));
    let path = files.into_iter().filter(|path| rank(path).is_some()).max_by_key(rank)?;
    let srdf = Srdf::parse(&read_text(&path).ok()?, &path.display().to_string()).ok()?;
    Some(NearSrdf { path, srdf })
}

impl NearSrdf {
    /// The pairs that it disables, of links that the robot has.
    pub fn pairs(&self, robot: &Robot) -> Vec<[String; 2]> {
        let is_known = |name: &String| robot.link_index(name).is_some();
        let known = self.srdf.disabled_pairs.iter().filter(|(a, b)| is_known(a) && is_known(b));
        known.map(|(a, b)| [a.clone(), b.clone()]).collect()
    }

    pub fn choice(&self) -> Choice {
        Choice::new(
            "SRDF",
            format!("pairs and states of {}", self.path.display()),
            "it lies where packages have it, and its name is that of the URDF",
            "--srdf FILE",
        )
    }
}
