//! Process between a worker and an external program: it restricts itself, starts the program, and ends with it.

use std::collections::BTreeMap;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use cranny_file::system::{self, Restrictions};
use serde::{Deserialize, Serialize};

use crate::foreign::sandbox::Isolation;

/// Request to enclose a program instead of serving trials.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Enclosure {
    /// The program and its arguments.
    pub command: Vec<String>,
    /// Its working folder, the only one in which it may write.
    pub folder: PathBuf,
    /// Environment variables that it does not inherit.
    pub environment: BTreeMap<String, String>,
    pub isolation: Isolation,
    /// Maximum size of its shared memory, in bytes.
    pub shared_memory_bytes: u64,
}

/// First line of input of a process that encloses a program.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum Start {
    Enclose(Enclosure),
}

/// Line by which an enclosure reports that the program starts with the next byte of input.
pub const READY: &str = "ready";

/// Maximum number of processes of a program, and of its processes and threads. The first limit is checked every few
/// milliseconds, the second one belongs to the kernel.
pub const MOST_PROCESSES: usize = 256;
const MOST_TASKS: u64 = 4096;

/// Time for which processes that a program leaves behind may continue to print.
const AFTER_THE_END: Duration = Duration::from_millis(200);

/// Exit code of a shell for a program that it cannot run.
const NOT_EXECUTABLE: i32 = 126;

impl Enclosure {
    /// Runs the program in this process's place: its input, output and exit code are those of this process.
    ///
    /// 1. Restrict this process, and answer [`READY`] or the reason against it.
    /// 2. Start the program when its input arrives, so that the restrictions take none of its time.
    /// 3. Wait for its end.
    pub fn run(&self, output: &mut impl Write) -> i32 {
        // 1.
        let ready = self.restrict();
        let answer = ready.as_ref().map_or_else(ToString::to_string, |_| READY.to_owned());
        // An error means that the worker has ended, and this process ends with it.
        let _ = writeln!(output, "{}", answer.replace('\n', " ")).and_then(|()| output.flush());
        let Ok(mut command) = ready else { return NOT_EXECUTABLE };
        // 2.
        system::wait_for_input();
        let mut child = match command.spawn() {
            Ok(child) => child,
            Err(reason) => {
                let _ = writeln!(io::stderr(), "it cannot be executed: {reason}");
                return NOT_EXECUTABLE;
            }
        };
        // 3.
        let code = system::wait_for(child.id(), AFTER_THE_END);
        code.or_else(|| child.wait().ok()?.code()).unwrap_or(NOT_EXECUTABLE)
    }

    /// Restricts this process and returns the command of the program.
    fn restrict(&self) -> io::Result<Command> {
        let Isolation { landlock, namespaces, call_filter } = self.isolation;
        let (program, arguments) = self.command.split_first().ok_or(io::ErrorKind::InvalidInput)?;
        system::restrict_self(Restrictions {
            folder: &self.folder,
            shared_memory_bytes: self.shared_memory_bytes,
            tasks: MOST_TASKS,
            namespaces,
            landlock,
            call_filter,
        })?;
        check_executable(program, &self.folder)?;
        let mut command = Command::new(program);
        command.args(arguments).current_dir(&self.folder).envs(&self.environment);
        Ok(command)
    }
}

/// Returns the error of a shell if there is no such program: a path, or a name in one of the folders of `PATH`.
fn check_executable(program: &str, folder: &Path) -> io::Result<()> {
    let folders = std::env::var_os("PATH").unwrap_or_default();
    let candidates: Vec<PathBuf> = if Path::new(program).components().count() > 1 {
        vec![folder.join(program)]
    } else {
        std::env::split_paths(&folders).map(|folder| folder.join(program)).collect()
    };
    if candidates.iter().any(|path| path.is_file()) { Ok(()) } else { Err(io::ErrorKind::NotFound.into()) }
}
