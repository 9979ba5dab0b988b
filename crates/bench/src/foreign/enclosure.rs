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
    /// Folders, files and sockets that it does not see, and folders within that it can read, in namespaces.
    pub hidden: Vec<PathBuf>,
    pub kept: Vec<PathBuf>,
    /// Maximum size of its files and of its shared memory, in bytes, in namespaces.
    pub memory_bytes: u64,
}

/// First line of input of a process that encloses a program.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum Start {
    Enclose(Enclosure),
}

/// First line of output of an enclosure, as JSON.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum Prepared {
    /// The program starts with the next byte of input.
    Ready,
    /// The program cannot be enclosed now, for lack of resources; with the reason.
    Short(String),
    /// The program cannot be enclosed; with the reason.
    Refused(String),
}

/// Maximum number of processes of a program, and of its processes and threads. The first limit is checked every few
/// milliseconds, the second one belongs to the kernel.
pub const MOST_PROCESSES: usize = 256;
const MOST_TASKS: u64 = 1024;

/// Time for which processes that a program leaves behind may continue to print.
const AFTER_THE_END: Duration = Duration::from_millis(200);

/// Exit code of a shell for a program that it cannot run.
const NOT_EXECUTABLE: i32 = 126;

impl Enclosure {
    /// Runs the program in this process's place: its input, output and exit code are those of this process.
    ///
    /// 1. Restrict this process, and answer [`Prepared`].
    /// 2. Start the program when its input arrives, so that the restrictions take none of its time.
    /// 3. Wait for its end.
    pub fn run(&self, output: &mut impl Write) -> i32 {
        // 1.
        let ready = self.restrict();
        let answer = match &ready {
            Ok(_) => Prepared::Ready,
            Err(reason) if system::is_shortage(reason) => Prepared::Short(reason.to_string()),
            Err(reason) => Prepared::Refused(reason.to_string()),
        };
        // An error means that the worker has ended, and this process ends with it.
        let _ = serde_json::to_string(&answer)
            .map_err(io::Error::other)
            .and_then(|line| writeln!(output, "{line}").and_then(|()| output.flush()));
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
            hidden: &self.hidden,
            kept: &self.kept,
            memory_bytes: self.memory_bytes,
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
