//! Search for an SRDF that is not beside its URDF, but in the usual location in ROS packages.

use std::path::{Path, PathBuf};

use cranny_robot::{Robot, RobotError, Srdf};

use crate::choice::Choice;
use crate::draft::{read_text, robot_name};

/// SRDF that was found.
pub(crate) struct NearSrdf {
    path: PathBuf,
    srdf: Result<Srdf, RobotError>,
}

/// Finds the SRDF in `../srdf` with the longest prefix shared with the URDF's name, where one name is a prefix of the other.
pub(crate) fn find(urdf: &Path) -> Option<NearSrdf> {
    let stem = &*robot_name(urdf);
    let folder = std::path::absolute(urdf).ok()?.parent()?.parent()?.join("srdf");
    let mut files: Vec<PathBuf> =
        std::fs::read_dir(folder).ok()?.filter_map(|file| Some(file.ok()?.path())).collect();
    files.sort();
    let in_common = |path: &PathBuf| -> Option<usize> {
        let name = path.file_name()?.to_str()?.strip_suffix(".srdf")?;
        (name.starts_with(stem) || stem.starts_with(name)).then(|| name.len().min(stem.len()))
    };
    // Ties are broken by the shortest name, which is the robot itself and not one of its variants.
    let rank = |path: &PathBuf| Some((in_common(path)?, usize::MAX - path.as_os_str().len()));
    let path = files.into_iter().filter(|path| rank(path).is_some()).max_by_key(rank)?;
    let srdf = read_text(&path).and_then(|text| Srdf::parse(&text, &path.display().to_string()));
    Some(NearSrdf { path, srdf })
}

impl NearSrdf {
    /// Parsed SRDF, if it is readable.
    pub fn srdf(&self) -> Option<&Srdf> {
        self.srdf.as_ref().ok()
    }

    /// Returns the disabled pairs of links that the robot has.
    pub fn pairs(&self, robot: &Robot) -> Vec<[String; 2]> {
        let is_known = |name: &String| robot.link_index(name).is_some();
        let pairs = self.srdf().into_iter().flat_map(|srdf| &srdf.disabled_pairs);
        pairs.filter(|(a, b)| is_known(a) && is_known(b)).map(|(a, b)| [a.clone(), b.clone()]).collect()
    }

    pub fn choice(&self) -> Choice {
        let path = self.path.display();
        let (chosen, why) = match &self.srdf {
            Ok(_) => (
                format!("pairs and states of {path}"),
                "it is in the usual folder of a package and has the name of the URDF".to_owned(),
            ),
            Err(fault) => ("none".to_owned(), format!("{path} cannot be read: {fault}")),
        };
        Choice::new("SRDF", chosen, &why, "--srdf FILE")
    }
}
