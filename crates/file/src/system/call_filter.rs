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
/// - memory in files without a name, which is not attributed to a process;
/// - leases, by which a reader of a file can delay everybody who opens it;
/// - sockets of families that no network namespace separates, such as `AF_VSOCK`;
/// - scheduling attributes, and rings of calls (`io_uring`), which no filter sees.
///
/// `setsid` does nothing and returns 0: the kernel shares the processors between sessions, so that many sessions would have many
/// shares. A program that makes a daemon of itself continues. Calls of other interfaces of the same processor (x32) are unknown
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
    const DENIED: [libc::c_long; 7] = [
        libc::SYS_add_key,
        libc::SYS_keyctl,
        libc::SYS_request_key,
        libc::SYS_memfd_create,
        libc::SYS_memfd_secret,
        libc::SYS_sched_setattr,
        libc::SYS_io_uring_setup,
    ];

    /// Families of sockets that network namespaces separate, or that have paths.
    const FAMILIES: [i32; 4] = [libc::AF_UNIX, libc::AF_INET, libc::AF_INET6, libc::AF_NETLINK];

    type Rules = BTreeMap<i64, Vec<SeccompRule>>;

    pub fn filter() -> Result<(), Box<dyn Error + Send + Sync>> {
        use SeccompCmpOp::{Eq, Ne};
        let second = |value: u64| SeccompRule::new(vec![argument(1, Eq, value)?]);
        let typing = vec![second(libc::TIOCSTI)?, second(libc::TIOCLINUX)?];
        let leases = vec![second(u64::from(libc::F_SETLEASE.unsigned_abs()))?];
        let others = FAMILIES.iter().map(|family| argument(0, Ne, u64::from(family.unsigned_abs())));
        let others = vec![SeccompRule::new(others.collect::<Result<_, _>>()?)?];
        let mut denied: Rules = DENIED.into_iter().map(|call| (call, Vec::new())).collect();
        denied.extend([
            (libc::SYS_ioctl, typing),
            (libc::SYS_fcntl, leases),
            (libc::SYS_socket, others.clone()),
            (libc::SYS_socketpair, others),
        ]);
        #[cfg(target_arch = "x86_64")]
        apply_filter(&other_interface())?;
        answer(denied, libc::EPERM.unsigned_abs())?;
        answer(Rules::from([(libc::SYS_setsid, Vec::new())]), 0)
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
