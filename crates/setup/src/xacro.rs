use std::path::Path;
use std::process::{Command, Stdio};

use crate::SetupError;

/// How it is called.
const TOOLS: [(&str, &[&str]); 2] = [("xacro", &[]), ("python3", &["-m", "xacro"])];

/// Whether Python's `xacro` is installed, which robots in `.xacro` files need.
pub fn has_xacro() -> bool {
    let answers = |(program, arguments): &(&str, &[&str])| {
        let mut command = Command::new(program);
        command.args(*arguments).arg("--help").stdin(Stdio::null());
        command.output().is_ok_and(|output| output.status.success())
    };
    TOOLS.iter().any(answers)
}

/// What Python's `xacro` makes of a file.
///
/// # Errors
/// [`SetupError::Xacro`] where it is not installed, or fails.
pub(crate) fn expand(path: &Path) -> Result<String, SetupError> {
    let failed = |reason: String| SetupError::Xacro { path: path.to_owned(), reason };
    for (program, arguments) in TOOLS {
        let run = Command::new(program).args(arguments).arg(path).stdin(Stdio::null()).output();
        let Ok(output) = run else { continue };
        let said = String::from_utf8_lossy(&output.stderr);
        if output.status.success() {
            return String::from_utf8(output.stdout).map_err(|_| failed("it writes no UTF-8".to_owned()));
        }
        if !said.contains("No module named xacro") {
            // What is wrong stands before the files that it was met in.
            let is_reason = |line: &&str| {
                let line = line.trim();
                !line.is_empty()
                    && !["when ", "included ", "in file"].iter().any(|begin| line.starts_with(begin))
            };
            let last = said.lines().rev().find(is_reason).unwrap_or("it fails");
            return Err(failed(cranny_file::excerpt(last)));
        }
    }
    Err(failed("xacro is not installed (`pip install xacro`)".to_owned()))
}
