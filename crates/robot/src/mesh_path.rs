use std::path::{Path, PathBuf};

/// The files that a mesh name of a URDF may mean, in the order in which they are tried.
///
/// - `package://P/rest`: in every folder of `packages`, then in every folder above the URDF, `P/rest`, and
///   `rest` where the folder itself is called `P`.
/// - `file:///path`, or an absolute path: that file.
/// - anything else: relative to the URDF's folder.
pub fn candidates(filename: &str, base_dir: Option<&Path>, packages: &[PathBuf]) -> Vec<PathBuf> {
    if let Some(name) = filename.strip_prefix("package://") {
        let (package, rest) = name.split_once('/').unwrap_or((name, ""));
        let base_dir = base_dir.map(absolute);
        let above = base_dir.iter().flat_map(|base| base.ancestors());
        let mut found: Vec<PathBuf> = Vec::new();
        for folder in packages.iter().map(PathBuf::as_path).chain(above) {
            found.push(folder.join(package).join(rest));
            if folder.file_name().is_some_and(|folder_name| folder_name == package) {
                found.push(folder.join(rest));
            }
        }
        return found;
    }
    let path = Path::new(filename.strip_prefix("file://").unwrap_or(filename));
    match base_dir {
        _ if path.is_absolute() => vec![path.to_owned()],
        Some(base) => vec![base.join(path)],
        None => Vec::new(),
    }
}

/// Whether something is there that is no folder: what cannot be read of it, the opener says.
pub(crate) fn is_file_like(path: &Path) -> bool {
    path.exists() && !path.is_dir()
}

/// So that the folders above `.` can be named; a path that cannot be made absolute stays as it is.
fn absolute(path: &Path) -> PathBuf {
    std::path::absolute(path).unwrap_or_else(|_| path.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_package_is_looked_for_in_given_folders_first_and_then_above_the_urdf() {
        let tried = candidates(
            "package://arm/meshes/a.stl",
            Some(Path::new("/robots/arm/urdf")),
            &[PathBuf::from("/given")],
        );
        let tried: Vec<_> = tried.iter().map(|path| path.to_str().unwrap()).collect();
        assert_eq!(tried[0], "/given/arm/meshes/a.stl");
        assert!(tried.contains(&"/robots/arm/meshes/a.stl"), "{tried:?}");
        assert!(tried.iter().position(|path| *path == "/robots/arm/urdf/arm/meshes/a.stl") == Some(1));
    }

    #[test]
    fn a_bare_name_lies_beside_the_urdf() {
        assert_eq!(candidates("m/a.stl", Some(Path::new("/r")), &[]), [PathBuf::from("/r/m/a.stl")]);
        assert_eq!(candidates("file:///m/a.stl", Some(Path::new("/r")), &[]), [PathBuf::from("/m/a.stl")]);
        assert!(candidates("m/a.stl", None, &[]).is_empty());
    }
}
