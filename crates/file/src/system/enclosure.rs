use std::io;
use std::path::{Path, PathBuf};
use std::process::ExitStatus;
use std::time::{Duration, Instant};

/// Restrictions that a process puts on itself before it starts a program that is not trusted.
#[derive(Clone, Copy, Debug)]
pub struct Restrictions<'a> {
    /// The only folder in which the program may write. With namespaces it is an empty one in memory for the program.
    pub folder: &'a Path,
    /// Folders and files that a program in namespaces does not see: folders are empty, files and sockets are a device without
    /// content. Missing ones are ignored.
    pub hidden: &'a [PathBuf],
    /// Folders within hidden ones that a program in namespaces can read nevertheless.
    pub kept: &'a [PathBuf],
    /// Maximum size of the program's files in its folder, and of its shared memory, in bytes.
    pub memory_bytes: u64,
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
/// it, no descendant can type into the terminal, and the kernel may share the processors between sessions (autogroups, Linux).
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

    use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};
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
        for (name, value) in KERNEL_LIMITS {
            let _ = fs::write(format!("/proc/sys/kernel/{name}"), value);
        }
        for buffer in ["tcp_rmem", "tcp_wmem"] {
            let _ = fs::write(format!("/proc/sys/net/ipv4/{buffer}"), "4096 65536 212992");
        }
        if has_own_process_ids() {
            let _ = fs::write("/proc/sys/kernel/pid_max", restrictions.tasks.to_string());
        }
        let Restrictions { folder, hidden, kept, memory_bytes, tasks, .. } = restrictions;
        mounts::seal(folder, memory_bytes, hidden, kept)?;
        // The present folder of this process is hidden by now.
        std::env::set_current_dir(folder)?;
        limit(Resource::Core, 0)?;
        limit(Resource::Rtprio, 0)?;
        limit(Resource::Nice, 0)?;
        limit(Resource::Nofile, OPEN_FILES)?;
        // The kernel counts the tasks of a user in each user namespace; it does not count those of root.
        limit(Resource::Nproc, tasks)?;
        for bit in 0..u64::BITS {
            if remove_capability_from_bounding_set(CapabilitySet::from_bits_retain(1 << bit)).is_err() {
                break;
            }
        }
        let empty = CapabilitySet::empty();
        set_capabilities(None, CapabilitySets { effective: empty, permitted: empty, inheritable: empty })?;
        Ok(set_no_new_privs(true)?)
    }

    /// Limits of System V objects, whose memory counts for no process: all shared memory, in pages (16 MiB of the usual pages);
    /// semaphores of a set, of all sets, operations of a call, and sets (2 MiB); queues (of 16 KiB). The default of the kernel is up
    /// to 64 GB.
    const KERNEL_LIMITS: [(&str, &str); 3] =
        [("shmall", "4096"), ("sem", "250 32000 32 128"), ("msgmni", "16")];

    /// Maximum number of open files of a process.
    const OPEN_FILES: u64 = 4096;

    /// Lowers a limit of this process and its descendants, unless it is lower already.
    fn limit(resource: Resource, most: u64) -> io::Result<()> {
        let lower = |limit: Option<u64>| Some(limit.map_or(most, |limit| limit.min(most)));
        let Rlimit { current, maximum } = getrlimit(resource);
        Ok(setrlimit(resource, Rlimit { current: lower(current), maximum: lower(maximum) })?)
    }

    /// Returns true if the limit of process ids belongs to a PID namespace (Linux 6.14); before, it is the machine's.
    fn has_own_process_ids() -> bool {
        let release = rustix::system::uname().release().to_string_lossy().into_owned();
        let mut numbers =
            release.split(|c: char| !c.is_ascii_digit()).map_while(|number| number.parse().ok());
        let version: (u32, u32) = (numbers.next().unwrap_or(0), numbers.next().unwrap_or(0));
        version >= (6, 14)
    }
}
