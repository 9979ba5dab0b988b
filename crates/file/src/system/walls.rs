#[cfg(target_os = "linux")]
use std::fs;
use std::io;
use std::path::Path;

/// Folder of the named shared memory of programs (Linux).
pub const SHARED_MEMORY: &str = "/dev/shm";

/// Returns true if the system has namespaces; whether this user may create them shows only when it is tried.
pub fn can_have_namespaces() -> bool {
    cfg!(target_os = "linux")
}

/// Returns true if [`write_only_in`] has an effect: the kernel has the first version of Landlock and allows its use.
pub fn has_file_walls() -> bool {
    #[cfg(target_os = "linux")]
    let is_there = {
        use landlock::{ABI, AccessFs, CompatLevel, Compatible as _, Ruleset, RulesetAttr as _};
        Ruleset::default()
            .set_compatibility(CompatLevel::HardRequirement)
            .handle_access(AccessFs::from_write(ABI::V1))
            .and_then(Ruleset::create)
            .is_ok()
    };
    #[cfg(not(target_os = "linux"))]
    let is_there = false;
    is_there
}

/// Restricts this thread, and all processes and threads that it starts from now on (Landlock): they may write only in a folder,
/// to devices and in [`SHARED_MEMORY`], as far as the kernel knows the kind of writing, and signal only processes in the same
/// sandbox (from Linux 6.12 on). Elsewhere it does nothing (see [`has_file_walls`]).
///
/// # Errors
/// The error of the operating system.
pub fn write_only_in(folder: &Path) -> io::Result<()> {
    #[cfg(target_os = "linux")]
    landlocked(folder).map_err(io::Error::other)?;
    #[cfg(not(target_os = "linux"))]
    let _ = folder;
    Ok(())
}

/// Devices for all programs, terminals of their own, and graphics processors, which also compute. A program that can write to `zero`
/// has shared memory that no process owns.
#[cfg(target_os = "linux")]
const DEVICES: [&str; 9] = ["null", "full", "random", "urandom", "tty", "ptmx", "pts", "dri", "kfd"];

#[cfg(target_os = "linux")]
fn landlocked(folder: &Path) -> Result<(), landlock::RulesetError> {
    use landlock::{
        ABI, Access as _, AccessFs, PathBeneath, PathFd, Ruleset, RulesetAttr as _, RulesetCreated,
        RulesetCreatedAttr as _, Scope, path_beneath_rules,
    };
    let writing = AccessFs::from_write(ABI::V5);
    // These devices may be written and controlled, not created. Root could write to others, such as disks.
    let device = AccessFs::WriteFile | AccessFs::Truncate | AccessFs::IoctlDev;
    let devices = fs::read_dir("/dev").into_iter().flatten().flatten();
    let devices = devices.filter(|entry| {
        let name = entry.file_name().to_string_lossy().into_owned();
        DEVICES.contains(&name.as_str()) || name.starts_with("nvidia")
    });
    let rules: RulesetCreated = Ruleset::default()
        .handle_access(writing)?
        .scope(Scope::from_all(ABI::V6))?
        .create()?
        .add_rules(path_beneath_rules([folder, Path::new(SHARED_MEMORY)], writing))?;
    let rules = devices
        .filter_map(|entry| PathFd::new(entry.path()).ok())
        .try_fold(rules, |rules, path| rules.add_rule(PathBeneath::new(path, device)))?;
    rules.restrict_self().map(drop)
}
