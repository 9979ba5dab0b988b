use std::path::{Path, PathBuf};

/// Returns the files that a mesh name of a URDF may refer to, in the order in which they are tried.
///
/// - `package://P/rest`, `model://P/rest` or xacro's `$(find P)/rest`: in every folder of `packages`, then in every folder
///   above the URDF, `P/rest`, and `rest` if the folder itself is named `P`.
/// - `file:///path`, or an absolute path: that file.
/// - anything else: relative to the URDF's folder.
///
/// The literal name is tried first, then the name with percent-encoding decoded (`%20` is a blank), then with backslashes of
/// Windows replaced.
pub fn candidates(filename: &str, base_dir: Option<&Path>, packages: &[PathBuf]) -> Vec<PathBuf> {
    let mut names = vec![filename.to_owned()];
    names.extend(percent_decoded(filename));
    names.extend(filename.contains('\\').then(|| filename.replace('\\', "/")));
    names.iter().flat_map(|name| places(name, base_dir, packages)).collect()
}

fn places(name: &str, base_dir: Option<&Path>, packages: &[PathBuf]) -> Vec<PathBuf> {
    if let Some((package, rest)) = in_package(name) {
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
    let path = Path::new(name.strip_prefix("file://").or_else(|| name.strip_prefix("file:")).unwrap_or(name));
    match base_dir {
        _ if path.is_absolute() => vec![path.to_owned()],
        Some(base) => vec![base.join(path)],
        None => Vec::new(),
    }
}

/// Splits a name into its package and the path inside the package.
fn in_package(name: &str) -> Option<(&str, &str)> {
    let found = ["package://", "model://"].iter().find_map(|scheme| name.strip_prefix(scheme));
    let (package, rest) = match found {
        Some(inside) => inside.trim_start_matches('/').split_once('/').unwrap_or((inside, "")),
        None => name.strip_prefix("$(find ")?.split_once(')')?,
    };
    // With a leading slash it would be an absolute path.
    Some((package.trim(), rest.trim_start_matches('/')))
}

/// Decodes the percent-encoding of a name (RFC 3986, §2.1); `None` if it has none.
fn percent_decoded(name: &str) -> Option<String> {
    let mut bytes = Vec::with_capacity(name.len());
    let mut parts = name.split('%');
    bytes.extend(parts.next()?.as_bytes());
    for part in parts {
        let (digits, rest) = part.split_at_checked(2)?;
        bytes.push(u8::from_str_radix(digits, 16).ok()?);
        bytes.extend(rest.as_bytes());
    }
    String::from_utf8(bytes).ok().filter(|decoded| decoded != name)
}

/// Returns true if `path` exists and is not a folder. Other problems are reported on opening the file.
pub(crate) fn is_file_like(path: &Path) -> bool {
    path.exists() && !path.is_dir()
}

/// Makes a path absolute so that the folders above `.` can be named; returns it unchanged if that fails.
fn absolute(path: &Path) -> PathBuf {
    // An empty path is the folder of a file named without one.
    let path = if path.as_os_str().is_empty() { Path::new(".") } else { path };
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
    fn a_package_is_found_from_its_own_folder_in_every_spelling() {
        let here = std::env::current_dir().unwrap();
        let own = here.file_name().unwrap().to_str().unwrap();
        for spelling in [
            format!("package://{own}/meshes/a b.stl"),
            format!("package://{own}//meshes//a b.stl"),
            format!("model://{own}/meshes/a%20b.stl"),
            format!("$(find {own})/meshes/a b.stl"),
            format!("package://{own}\\meshes\\a b.stl"),
        ] {
            // The parent folder of `arm.urdf` is the empty path.
            for base in ["", ".", "./"] {
                let tried = candidates(&spelling, Some(Path::new(base)), &[]);
                assert!(tried.contains(&here.join("meshes/a b.stl")), "{spelling} from {base:?}: {tried:?}");
            }
        }
        assert_eq!(percent_decoded("100%"), None);
    }

    #[test]
    fn a_bare_name_lies_beside_the_urdf() {
        assert_eq!(candidates("m/a.stl", Some(Path::new("/r")), &[]), [PathBuf::from("/r/m/a.stl")]);
        assert_eq!(candidates("file:///m/a.stl", Some(Path::new("/r")), &[]), [PathBuf::from("/m/a.stl")]);
        assert!(candidates("m/a.stl", None, &[]).is_empty());
    }
}
