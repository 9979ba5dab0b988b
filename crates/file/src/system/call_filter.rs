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

/// Denies system calls to this thread, and to all processes and threads that it starts from now on: keys of the kernel, which
/// outlive a process; typing into a terminal; and memory in files without a name, which is not attributed to a process. They
/// fail with EPERM.
///
/// # Errors
/// The error of the operating system.
pub fn filter_calls() -> io::Result<()> {
    #[cfg(target_os = "linux")]
    filtered().map_err(io::Error::other)?;
    Ok(())
}

#[cfg(target_os = "linux")]
fn filtered() -> Result<(), Box<dyn std::error::Error + Send + Sync>> {
    use seccompiler::{
        BpfProgram, SeccompAction, SeccompCmpArgLen, SeccompCmpOp, SeccompCondition, SeccompFilter,
        SeccompRule, TargetArch, apply_filter,
    };
    let denied = [
        libc::SYS_add_key,
        libc::SYS_keyctl,
        libc::SYS_request_key,
        libc::SYS_memfd_create,
        libc::SYS_memfd_secret,
    ];
    // The kernel reads the lower half of a request alone.
    let request = |request: u64| -> Result<SeccompRule, seccompiler::BackendError> {
        SeccompRule::new(vec![SeccompCondition::new(1, SeccompCmpArgLen::Dword, SeccompCmpOp::Eq, request)?])
    };
    let typing = vec![request(libc::TIOCSTI)?, request(libc::TIOCLINUX)?];
    let rules = denied.into_iter().map(|call| (call, Vec::new())).chain([(libc::SYS_ioctl, typing)]);
    let filter = SeccompFilter::new(
        rules.collect(),
        SeccompAction::Allow,
        SeccompAction::Errno(libc::EPERM.unsigned_abs()),
        TargetArch::try_from(std::env::consts::ARCH)?,
    )?;
    Ok(apply_filter(&BpfProgram::try_from(filter)?)?)
}
