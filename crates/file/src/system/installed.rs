use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, io};

/// Environment variables that list folders of programs, of Python's modules and of libraries.
const SEARCH_PATHS: [&str; 3] = ["PATH", "PYTHONPATH", "LD_LIBRARY_PATH"];

/// Finds a program by its name in the folders of `PATH`. Relative and empty entries are ignored: they name the current folder, whose
/// files may come from anybody.
pub fn installed_program(name: &str) -> Option<PathBuf> {
    let file = format!("{name}{}", env::consts::EXE_SUFFIX);
    let folders = env::split_paths(&absolute_entries(&env::var_os("PATH")?)?).collect::<Vec<_>>();
    folders.iter().flat_map(|folder| [folder.join(name), folder.join(&file)]).find(|path| is_program(path))
}

/// Returns a command that runs a program of `PATH` as [`installed_program`] finds it. The program, and those that it starts, search
/// for programs, Python modules and libraries in absolute folders alone.
///
/// # Errors
/// [`io::ErrorKind::NotFound`].
pub fn installed_command(name: &str) -> io::Result<Command> {
    let mut command = Command::new(installed_program(name).ok_or(io::ErrorKind::NotFound)?);
    for variable in SEARCH_PATHS {
        if let Some(value) = env::var_os(variable) {
            match absolute_entries(&value) {
                Some(absolute) => command.env(variable, absolute),
                None => command.env_remove(variable),
            };
        }
    }
    Ok(command)
}

/// Returns the absolute entries of a search path; `None` if it has none.
fn absolute_entries(search_path: &OsStr) -> Option<OsString> {
    let absolute = env::split_paths(search_path).filter(|folder| folder.is_absolute());
    env::join_paths(absolute).ok().filter(|joined| !joined.is_empty())
}

fn is_program(path: &Path) -> bool {
    let Ok(found) = path.metadata() else { return false };
    #[cfg(unix)]
    let may_run = std::os::unix::fs::PermissionsExt::mode(&found.permissions()) & 0o111 != 0;
    #[cfg(not(unix))]
    let may_run = true;
    found.is_file() && may_run
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(unix)]
    #[test]
    fn only_absolute_folders_are_searched() {
        let entries = |search_path: &str| absolute_entries(OsStr::new(search_path));
        for path in ["", ":", ".", "bin:./sbin:../a"] {
            assert_eq!(entries(path), None, "{path}");
        }
        let absolute = Some(OsString::from("/usr/bin:/bin"));
        for path in ["/usr/bin:/bin", ":/usr/bin:/bin", "/usr/bin::/bin:", ".:/usr/bin:bin:/bin:.."] {
            assert_eq!(entries(path), absolute, "{path}");
        }
        assert!(installed_program("sh").is_some_and(|path| path.is_absolute()));
        assert_eq!(installed_program("no such program"), None);
        let fault = installed_command("no such program").unwrap_err();
        assert_eq!(fault.kind(), io::ErrorKind::NotFound);
    }
}
