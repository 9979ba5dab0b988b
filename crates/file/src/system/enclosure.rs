use std::io;
use std::path::Path;
use std::process::ExitStatus;
use std::time::{Duration, Instant};

/// Restrictions that a process puts on itself before it starts a program that is not trusted.
#[derive(Clone, Copy, Debug)]
pub struct Restrictions<'a> {
    /// The only folder in which the program may write.
    pub folder: &'a Path,
    /// Maximum size of the program's shared memory, in bytes.
    pub shared_memory_bytes: u64,
    /// Maximum number of processes and threads at a time.
    pub tasks: u64,
    /// True if this process is the first one of namespaces of its own (user, PID, IPC, mount and network).
    pub namespaces: bool,
    /// True if Landlock restricts the program.
    pub landlock: bool,
    /// True if calls of the system are filtered.
    pub call_filter: bool,
}

/// Restricts this process, and all processes that it starts from now on. It becomes the leader of a session without a
/// terminal, and the parent of orphaned descendants; it ends when the thread ends that started it (Linux).
///
/// # Errors
/// The error of the operating system.
pub fn restrict_self(restrictions: Restrictions) -> io::Result<()> {
    begin_session();
    #[cfg(target_os = "linux")]
    {
        let die = Some(rustix::process::Signal::KILL);
        rustix::process::set_parent_process_death_signal(die)?;
        crate::system::adopt_orphans();
        if restrictions.namespaces {
            linux::close_namespaces(restrictions)?;
        }
        crate::system::close_to_others();
        if restrictions.landlock {
            crate::system::write_only_in(restrictions.folder)?;
        }
        if restrictions.call_filter {
            crate::system::filter_calls()?;
        }
    }
    let _ = restrictions;
    Ok(())
}

/// Makes this process the leader of a session and process group of its own, without a terminal (Unix): Ctrl-C does not reach
/// it, no descendant can type into the terminal, and the kernel shares the processors between sessions (autogroups, Linux).
pub fn begin_session() {
    // The leader of a group cannot begin a session.
    #[cfg(unix)]
    let _ = rustix::process::setsid();
}

/// Waits until something can be read from the standard input, or until it is closed (Unix).
pub fn wait_for_input() {
    #[cfg(unix)]
    {
        use rustix::event::{PollFd, PollFlags, poll};
        let stdin = io::stdin();
        let mut polled = [PollFd::new(&stdin, PollFlags::IN)];
        // A signal interrupts the wait.
        while poll(&mut polled, None) == Err(rustix::io::Errno::INTR) {}
    }
}

/// Waits for the end of the child `process`, while reaping all other children, and then at most `patience` for the end of the
/// other children. Returns the exit code of a shell: 128 + n for an end by signal n; `None` without this child (Unix).
pub fn wait_for(process: u32, patience: Duration) -> Option<i32> {
    #[cfg(unix)]
    {
        use rustix::process::{WaitOptions, wait};
        let code = loop {
            match wait(WaitOptions::empty()) {
                Ok(Some((id, status))) if id.as_raw_pid().unsigned_abs() == process => {
                    break status.exit_status().or_else(|| Some(128 + status.terminating_signal()?))?;
                }
                Ok(_) | Err(rustix::io::Errno::INTR) => {}
                Err(_) => return None,
            }
        };
        let begin = Instant::now();
        while begin.elapsed() < patience && wait(WaitOptions::NOHANG).is_ok() {
            std::thread::sleep(Duration::from_millis(2));
        }
        Some(code)
    }
    #[cfg(not(unix))]
    {
        let _ = (process, patience, Instant::now());
        None
    }
}

/// Returns the status of a program from the exit code of a shell ([`wait_for`]).
pub fn status_of_shell(status: ExitStatus) -> ExitStatus {
    #[cfg(unix)]
    if let Some(signal) = status.code().filter(|code| (129..=192).contains(code)).map(|code| code - 128) {
        return std::os::unix::process::ExitStatusExt::from_raw(signal);
    }
    status
}

#[cfg(target_os = "linux")]
mod linux {
    use std::fs;
    use std::io;
    use std::process::Stdio;

    use rustix::process::{Resource, Rlimit, setrlimit};
    use rustix::thread::{
        CapabilitySet, CapabilitySets, remove_capability_from_bounding_set, set_capabilities,
        set_no_new_privs,
    };

    use crate::system::enclosure::Restrictions;
    use crate::system::{installed_command, mounts};

    /// Completes namespaces that this process is the first one of, and drops all rights within them.
    pub fn close_namespaces(restrictions: Restrictions) -> io::Result<()> {
        // Without the tool there is no network at all, which only a program with several processes may miss.
        if let Ok(mut ip) = installed_command("ip") {
            let _ = ip
                .args(["link", "set", "lo", "up"])
                .stdin(Stdio::null())
                .stdout(Stdio::null())
                .stderr(Stdio::null())
                .status();
        }
        // Before the file systems become read-only. An older kernel lacks one of them: then the other limits apply.
        let _ = fs::write("/proc/sys/user/max_user_namespaces", "0");
        let _ = fs::write("/proc/sys/kernel/shmall", SHARED_PAGES);
        if has_own_process_ids() {
            let _ = fs::write("/proc/sys/kernel/pid_max", restrictions.tasks.to_string());
        }
        mounts::seal(restrictions.folder, restrictions.shared_memory_bytes)?;
        let none = |resource| setrlimit(resource, Rlimit { current: Some(0), maximum: Some(0) });
        none(Resource::Core)?;
        none(Resource::Rtprio)?;
        // The kernel counts the tasks of a user in each user namespace; it does not count those of root.
        let tasks = Some(restrictions.tasks);
        setrlimit(Resource::Nproc, Rlimit { current: tasks, maximum: tasks })?;
        for bit in 0..u64::BITS {
            if remove_capability_from_bounding_set(CapabilitySet::from_bits_retain(1 << bit)).is_err() {
                break;
            }
        }
        let empty = CapabilitySet::empty();
        set_capabilities(None, CapabilitySets { effective: empty, permitted: empty, inheritable: empty })?;
        Ok(set_no_new_privs(true)?)
    }

    /// Maximum size of all System V shared memory, in pages: 16 MiB of the usual pages. It does not count as memory of a process
    /// until it is mapped.
    const SHARED_PAGES: &str = "4096";

    /// Returns true if the limit of process ids belongs to a PID namespace (Linux 6.14); before, it is the machine's.
    fn has_own_process_ids() -> bool {
        let release = rustix::system::uname().release().to_string_lossy().into_owned();
        let mut numbers =
            release.split(|c: char| !c.is_ascii_digit()).map_while(|number| number.parse().ok());
        let version: (u32, u32) = (numbers.next().unwrap_or(0), numbers.next().unwrap_or(0));
        version >= (6, 14)
    }
}
