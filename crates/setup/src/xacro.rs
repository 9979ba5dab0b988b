use std::ffi::OsString;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::thread;
use std::time::{Duration, Instant};

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
        let output = command(tool).and_then(|mut command| output_of(command.arg("--help"), PATIENCE));
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
        command.arg(path).args(&values).env(PACKAGES, &packages);
        let output = match output_of(&mut command, PATIENCE) {
            Ok(output) => output,
            Err(reason) if matches!(reason.kind(), io::ErrorKind::TimedOut | io::ErrorKind::FileTooLarge) => {
                return Err(failed(reason.to_string()));
            }
            Err(_) => continue,
        };
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

/// Maximum time of xacro: large robots take a few seconds, and a pipe that a file includes is never read to its end.
const PATIENCE: Duration = Duration::from_mins(1);

/// Maximum size of a text that xacro writes, as of a URDF.
const MOST_BYTES: u64 = 64 << 20;

/// Runs a command to its end; ends it after `patience`.
///
/// # Errors
/// [`io::ErrorKind::TimedOut`], [`io::ErrorKind::FileTooLarge`] for more than [`MOST_BYTES`] of output or of messages, and those
/// of the operating system.
fn output_of(command: &mut Command, patience: Duration) -> io::Result<Output> {
    // A closed pipe ends a program that writes more.
    fn reading(pipe: Option<impl Read + Send + 'static>) -> thread::JoinHandle<Vec<u8>> {
        thread::spawn(move || {
            let mut bytes = Vec::new();
            let _ = pipe.map(|pipe| pipe.take(MOST_BYTES + 1).read_to_end(&mut bytes));
            bytes
        })
    }
    let begin = Instant::now();
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn()?;
    let [stdout, stderr] = [reading(child.stdout.take()), reading(child.stderr.take())];
    let status = loop {
        match child.try_wait()? {
            Some(status) if stdout.is_finished() && stderr.is_finished() => break status,
            _ if begin.elapsed() > patience => {
                child.kill()?;
                child.wait()?;
                let message =
                    format!("it did not end within {} s (does it include a pipe?)", patience.as_secs());
                return Err(io::Error::new(io::ErrorKind::TimedOut, message));
            }
            _ => thread::sleep(Duration::from_millis(5)),
        }
    };
    let [stdout, stderr] = [stdout, stderr].map(|reading| reading.join().unwrap_or_default());
    if stdout.len().max(stderr.len()) as u64 > MOST_BYTES {
        let message = format!("it wrote more than {} MiB", MOST_BYTES >> 20);
        return Err(io::Error::new(io::ErrorKind::FileTooLarge, message));
    }
    Ok(Output { status, stdout, stderr })
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

    /// `cranny doctor` used to run the `xacro.py` of the current folder. Its programs are not found (`installed_command`).
    #[test]
    fn no_module_of_the_current_folder_is_run() {
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
        for tool in &TOOLS {
            let Ok(mut command) = command(tool) else { continue };
            command.current_dir(folder.path()).arg("--help").output().unwrap();
            assert!(!mark.exists(), "{}", tool.0);
        }
    }

    /// A file that includes a pipe blocked the setup for ever.
    #[cfg(unix)]
    #[test]
    fn a_program_that_does_not_end_is_ended() {
        let run = |script: &str| {
            let mut command = installed_command("sh").unwrap();
            output_of(command.args(["-c", script]), Duration::from_millis(500))
        };
        let output = run("echo a; echo b >&2; exit 3").unwrap();
        assert_eq!(
            (output.status.code(), &output.stdout[..], &output.stderr[..]),
            (Some(3), &b"a\n"[..], &b"b\n"[..])
        );
        // The last one leaves a program that holds its output open.
        for script in ["exec sleep 100", "exec >&- 2>&-; exec sleep 100", "sleep 2 &"] {
            let begin = Instant::now();
            assert_eq!(run(script).unwrap_err().kind(), io::ErrorKind::TimedOut, "{script}");
            assert!(begin.elapsed() < Duration::from_secs(2), "{script}");
        }
    }

    #[cfg(unix)]
    #[test]
    fn a_program_that_writes_without_end_is_ended() {
        let mut command = installed_command("sh").unwrap();
        let fault = output_of(command.args(["-c", "exec cat /dev/zero"]), PATIENCE).unwrap_err();
        assert_eq!(fault.to_string(), "it wrote more than 64 MiB");
    }

    #[cfg(unix)]
    #[test]
    fn a_file_that_includes_a_pipe_is_refused() {
        if !has_xacro() {
            return;
        }
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("robot.xacro");
        let text = "<robot name='a' xmlns:xacro='http://ros.org/wiki/xacro'><xacro:include filename='pipe'/></robot>";
        std::fs::write(&path, text).unwrap();
        let made = Command::new("mkfifo").arg(folder.path().join("pipe")).status().unwrap();
        assert!(made.success());
        let mut tool = TOOLS.iter().find_map(|tool| command(tool).ok()).unwrap();
        let fault =
            output_of(tool.arg(&path).env(PACKAGES, folder.path()), Duration::from_secs(3)).unwrap_err();
        assert_eq!(fault.kind(), io::ErrorKind::TimedOut);
    }
}
