use std::ffi::OsString;
use std::io;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use cranny_file::system::installed_command;

use crate::{SetupError, SetupOptions};

/// Python code that runs xacro with [`PACKAGES`] as the folders of packages: `$(find P)` needs a ROS module, which most xacro
/// users do not have, only for other packages. An argument that the file does not declare is an error.
///
/// With `-c`, Python before 3.11 puts the current folder in front of its search path; `xacro.py` or `os.py` there may come from
/// anybody. The first lines remove it before anything else is imported.
const RUN: &str = "
import sys
sys.path[:] = [folder for folder in sys.path if folder]
import importlib.machinery, importlib.util, os, types
NAME = 'ament_index_python.packages'
def share(name):
    for folder in os.environ['CRANNY_XACRO_PACKAGES'].split(os.pathsep):
        if os.path.isdir(os.path.join(folder, name)):
            return os.path.join(folder, name)
        if os.path.basename(folder) == name:
            return folder
    for module in (NAME, 'ament_index_python'):
        del sys.modules[module]
    try:
        from ament_index_python.packages import get_package_share_directory
        return get_package_share_directory(name)
    except ImportError:
        raise LookupError('package ' + name + ' is in no folder above the file, and in none given by --package')
    finally:
        stand_in()
def stand_in():
    sys.modules['ament_index_python'] = types.ModuleType('ament_index_python')
    sys.modules[NAME] = types.ModuleType(NAME)
    sys.modules[NAME].get_package_share_directory = share
stand_in()
import xacro
asked = set()
class Arguments(dict):
    def __contains__(self, name):
        asked.add(name)
        return dict.__contains__(self, name)
    def __getitem__(self, name):
        asked.add(name)
        return dict.__getitem__(self, name)
process_doc = xacro.process_doc
def process(doc, mappings=None, **options):
    process_doc(doc, Arguments(mappings or {}), **options)
    for name in mappings or {}:
        if name not in asked:
            known = ', '.join(sorted(asked)) or 'none'
            sys.exit('the file asks for no argument ' + name + ' (it asks for: ' + known + ')')
xacro.process_doc = process
sys.argv[0] = 'xacro'
xacro.main()
";

/// Environment variable with the folders that [`RUN`] searches for packages.
const PACKAGES: &str = "CRANNY_XACRO_PACKAGES";

/// Commands that run xacro: the first finds packages, the second is for a standalone installation of xacro.
const TOOLS: [(&str, &[&str]); 2] = [("python3", &["-c", RUN]), ("xacro", &[])];

/// Returns true if Python's `xacro` is installed, which is required for robots in `.xacro` files.
pub fn has_xacro() -> bool {
    TOOLS.iter().any(|tool| {
        let output = command(tool).and_then(|mut command| command.arg("--help").output());
        output.is_ok_and(|output| output.status.success())
    })
}

/// Returns a command of [`TOOLS`], which runs nothing from the current folder.
fn command((program, arguments): &(&str, &[&str])) -> io::Result<Command> {
    let mut command = installed_command(program)?;
    // As the first lines of `RUN`, for modules that Python 3.11 or later imports before.
    command.args(*arguments).env("PYTHONSAFEPATH", "1").stdin(Stdio::null());
    Ok(command)
}

/// Expands a file with Python's `xacro`, with arguments and packages of the options. Returns the URDF, and warnings in a line.
///
/// # Errors
/// [`SetupError::Xacro`] if it is not installed, or fails, and for an argument that is not of the form `NAME=VALUE`.
pub(crate) fn expand(path: &Path, options: &SetupOptions) -> Result<(String, String), SetupError> {
    let failed = |reason: String| SetupError::Xacro { path: path.to_owned(), reason };
    let mut names: Vec<&str> = Vec::new();
    let mut values = Vec::new();
    for argument in &options.xacro {
        let (name, value) = argument
            .split_once('=')
            .filter(|(name, _)| !name.is_empty())
            .ok_or_else(|| failed(format!("the argument `{argument}` is not of the form NAME=VALUE")))?;
        let name = name.trim_end_matches(':');
        if names.contains(&name) {
            return Err(failed(format!("the argument `{name}` is given twice")));
        }
        names.push(name);
        values.push(format!("{name}:={value}"));
    }
    let packages = packages(path, &options.packages);
    for tool in &TOOLS {
        let Ok(mut command) = command(tool) else { continue };
        let Ok(output) = command.arg(path).args(&values).env(PACKAGES, &packages).output() else { continue };
        let said = String::from_utf8_lossy(&output.stderr);
        if output.status.success() {
            let urdf = String::from_utf8(output.stdout)
                .map_err(|_| failed("the output of xacro is not UTF-8".to_owned()))?;
            return Ok((urdf, if said.trim().is_empty() { String::new() } else { whole(&said) }));
        }
        if !said.contains("No module named 'xacro'") {
            return Err(failed(whole(&said)));
        }
    }
    Err(failed("xacro is not installed (`pip install xacro`)".to_owned()))
}

/// Returns the given folders, then those above the file, joined as a search path.
fn packages(path: &Path, given: &[PathBuf]) -> OsString {
    let file = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    let given = given.iter().map(|folder| std::path::absolute(folder).unwrap_or_else(|_| folder.clone()));
    let above = file.ancestors().skip(1).map(Path::to_owned);
    // A folder name that contains the separator cannot be in a search path.
    let separable = given.chain(above).filter(|folder| std::env::join_paths([folder]).is_ok());
    std::env::join_paths(separable).unwrap_or_default()
}

/// Returns the whole error output of xacro in one line, without repeated lines.
fn whole(said: &str) -> String {
    let mut lines: Vec<&str> = Vec::new();
    for line in said.lines().map(str::trim).filter(|line| !line.is_empty()) {
        if !lines.contains(&line) {
            lines.push(line);
        }
    }
    if lines.is_empty() { "xacro failed without an error message".to_owned() } else { lines.join("; ") }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `cranny doctor` used to run the `xacro.py` of the current folder.
    #[cfg(unix)]
    #[test]
    fn nothing_of_the_current_folder_is_run() {
        use std::os::unix::fs::PermissionsExt as _;
        let folder = tempfile::tempdir().unwrap();
        let mark = folder.path().join("was_run");
        let python = format!("open({:?}, 'w').close()\nraise SystemExit(0)\n", mark.to_str().unwrap());
        for module in [
            "xacro",
            "os",
            "types",
            "importlib",
            "sitecustomize",
            "usercustomize",
            "site",
            "ament_index_python",
        ] {
            std::fs::write(folder.path().join(format!("{module}.py")), &python).unwrap();
        }
        for program in ["python3", "xacro", "env"] {
            let path = folder.path().join(program);
            std::fs::write(&path, format!("#!/bin/sh\n: > {}\n", mark.display())).unwrap();
            std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o755)).unwrap();
        }
        for tool in &TOOLS {
            let Ok(mut command) = command(tool) else { continue };
            command.current_dir(folder.path()).arg("--help").output().unwrap();
            assert!(!mark.exists(), "{}", tool.0);
        }
    }
}
