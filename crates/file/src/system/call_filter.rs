use std::io;

/// Returns true if the kernel filters system calls on this processor (seccomp).
pub fn has_call_filter() -> bool {
    #[cfg(target_os = "linux")]
    let is_there = seccompiler::TargetArch::try_from(std::env::consts::ARCH).is_ok()
        && std::path::Path::new("/proc/sys/kernel/seccomp/actions_avail").exists();
    #[cfg(not(target_os = "linux"))]
    let is_there = false;
    is_there
}

/// Denies system calls to this thread, and to all processes and threads that it starts from now on. They fail with EPERM:
///
/// - keys of the kernel, which outlive a process, and typing into a terminal;
/// - memory in files without a name and shared memory without a file, which are not attributed to a process;
/// - leases, by which a reader of a file can delay everybody who opens it;
/// - hints of files and questions about their pages in memory, by which a program can leave notes for the next one;
/// - sockets of families that no network namespace separates, such as `AF_VSOCK`;
/// - scheduling attributes, and rings of calls (`io_uring`), which no filter sees.
///
/// These calls do nothing and return 0, so that a program continues:
///
/// - `setsid`: the kernel shares the processors between sessions, so that many sessions would have many shares;
/// - advice to drop pages of files from memory, which another program would have to read again;
/// - larger buffers of sockets, whose memory counts for no process.
///
/// Calls of other interfaces of the same processor (x32) are unknown
/// (ENOSYS); those of 32 bits end the process.
///
/// # Errors
/// The error of the operating system.
pub fn filter_calls() -> io::Result<()> {
    #[cfg(target_os = "linux")]
    linux::filter().map_err(io::Error::other)?;
    Ok(())
}

#[cfg(target_os = "linux")]
mod linux {
    use std::collections::BTreeMap;
    use std::error::Error;

    use seccompiler::{
        BackendError, BpfProgram, SeccompAction, SeccompCmpArgLen, SeccompCmpOp, SeccompCondition,
        SeccompFilter, SeccompRule, TargetArch, apply_filter,
    };

    /// Calls that are denied with any arguments.
    const DENIED: [libc::c_long; 11] = [
        libc::SYS_add_key,
        libc::SYS_keyctl,
        libc::SYS_request_key,
        libc::SYS_memfd_create,
        libc::SYS_memfd_secret,
        libc::SYS_sched_setattr,
        libc::SYS_io_uring_setup,
        libc::SYS_mincore,
        CACHESTAT,
        libc::SYS_process_madvise,
        libc::SYS_syslog,
    ];

    /// `cachestat` of Linux 6.5, the same number on all processors.
    const CACHESTAT: libc::c_long = 451;

    /// Hints of the lifetime of data, of a file and of an open one (`fcntl(2)`).
    const HINTS: [u64; 2] = [1036, 1038];

    /// Advice that takes pages of files from memory: of a file, and of mapped memory (`MADV_COLD`, `MADV_PAGEOUT`).
    const FILE_UNUSED: u64 = libc::POSIX_FADV_DONTNEED.unsigned_abs() as u64;
    const UNUSED: [u64; 2] = [20, 21];

    /// Sizes of the buffers of a socket, also beyond the limits.
    const BUFFERS: [i32; 4] = [libc::SO_SNDBUF, libc::SO_RCVBUF, libc::SO_SNDBUFFORCE, libc::SO_RCVBUFFORCE];

    /// Families of sockets that network namespaces separate, or that have paths.
    const FAMILIES: [i32; 4] = [libc::AF_UNIX, libc::AF_INET, libc::AF_INET6, libc::AF_NETLINK];

    type Rules = BTreeMap<i64, Vec<SeccompRule>>;

    pub fn filter() -> Result<(), Box<dyn Error + Send + Sync>> {
        use SeccompCmpOp::{Eq, MaskedEq, Ne};
        let second = |value: u64| SeccompRule::new(vec![argument(1, Eq, value)?]);
        let typing = vec![second(libc::TIOCSTI)?, second(libc::TIOCLINUX)?];
        let leases = u64::from(libc::F_SETLEASE.unsigned_abs());
        let of_files = HINTS.into_iter().chain([leases]).map(second).collect::<Result<_, _>>()?;
        let no_wait = u64::from(libc::RWF_NOWAIT.unsigned_abs());
        let of_pages = vec![SeccompRule::new(vec![argument(5, MaskedEq(no_wait), no_wait)?])?];
        let others = FAMILIES.iter().map(|family| argument(0, Ne, u64::from(family.unsigned_abs())));
        let others = vec![SeccompRule::new(others.collect::<Result<_, _>>()?)?];
        let unnamed = u64::from((libc::MAP_SHARED | libc::MAP_ANONYMOUS).unsigned_abs());
        let unnamed = vec![SeccompRule::new(vec![argument(3, MaskedEq(unnamed), unnamed)?])?];
        let mut denied: Rules = DENIED.into_iter().map(|call| (call, Vec::new())).collect();
        denied.extend([
            (libc::SYS_ioctl, typing),
            (libc::SYS_fcntl, of_files),
            (libc::SYS_preadv2, of_pages),
            (libc::SYS_mmap, unnamed),
            (libc::SYS_socket, others.clone()),
            (libc::SYS_socketpair, others),
        ]);
        #[cfg(target_arch = "x86_64")]
        apply_filter(&other_interface())?;
        answer(denied, libc::EPERM.unsigned_abs())?;
        let third = |value: u64| SeccompRule::new(vec![argument(2, Eq, value)?]);
        let buffer = |name: i32| {
            let level = argument(1, Eq, u64::from(libc::SOL_SOCKET.unsigned_abs()))?;
            SeccompRule::new(vec![level, argument(2, Eq, u64::from(name.unsigned_abs()))?])
        };
        let ignored = Rules::from([
            (libc::SYS_setsid, Vec::new()),
            (libc::SYS_fadvise64, vec![SeccompRule::new(vec![argument(3, Eq, FILE_UNUSED)?])?]),
            (libc::SYS_madvise, UNUSED.into_iter().map(third).collect::<Result<_, _>>()?),
            (libc::SYS_setsockopt, BUFFERS.into_iter().map(buffer).collect::<Result<_, _>>()?),
        ]);
        answer(ignored, 0)
    }

    /// Answers these calls with an error, or with the result 0.
    fn answer(rules: Rules, error: u32) -> Result<(), Box<dyn Error + Send + Sync>> {
        let filter = SeccompFilter::new(
            rules,
            SeccompAction::Allow,
            SeccompAction::Errno(error),
            TargetArch::try_from(std::env::consts::ARCH)?,
        )?;
        Ok(apply_filter(&BpfProgram::try_from(filter)?)?)
    }

    /// Returns a condition on the lower half of an argument; the kernel reads no more of these arguments.
    fn argument(index: u8, is: SeccompCmpOp, value: u64) -> Result<SeccompCondition, BackendError> {
        SeccompCondition::new(index, SeccompCmpArgLen::Dword, is, value)
    }

    /// Returns the filter of x32 calls: they have the architecture of 64 bits, and numbers of their own with this bit.
    #[cfg(target_arch = "x86_64")]
    fn other_interface() -> [seccompiler::sock_filter; 4] {
        use seccompiler::sock_filter;
        /// `__X32_SYSCALL_BIT` of the kernel.
        const X32: u32 = 0x4000_0000;
        let code = |code: u32| u16::try_from(code).unwrap_or_default();
        let returns = |action: SeccompAction| sock_filter {
            code: code(libc::BPF_RET | libc::BPF_K),
            jt: 0,
            jf: 0,
            k: action.into(),
        };
        [
            // The number of a call is the first field of its description (seccomp(2)).
            sock_filter { code: code(libc::BPF_LD | libc::BPF_W | libc::BPF_ABS), jt: 0, jf: 0, k: 0 },
            sock_filter { code: code(libc::BPF_JMP | libc::BPF_JGE | libc::BPF_K), jt: 0, jf: 1, k: X32 },
            returns(SeccompAction::Errno(libc::ENOSYS.unsigned_abs())),
            returns(SeccompAction::Allow),
        ]
    }
}
