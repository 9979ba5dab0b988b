use std::io;
use std::path::Path;

/// Where a program finds shared memory by name (Linux).
pub const SHARED_MEMORY: &str = "/dev/shm";

/// Whether there can be namespaces; whether this user may make them only a trial tells.
pub fn can_have_namespaces() -> bool {
    cfg!(target_os = "linux")
}

/// How much of [`SHARED_MEMORY`] is in use, in bytes; 0 where there is none.
pub fn shared_memory_bytes() -> u64 {
    #[cfg(target_os = "linux")]
    if let Ok(facts) = rustix::fs::statvfs(SHARED_MEMORY) {
        return facts.f_blocks.saturating_sub(facts.f_bfree) * facts.f_frsize;
    }
    0
}

/// Whether [`write_only_in`] does what it says: the kernel has the first version of Landlock, and lets it be used.
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

/// Lets this thread, and all that it starts from now on, write in a folder, into devices and into [`SHARED_MEMORY`]
/// alone, as far as the kernel knows each kind of writing; and send signals to nobody who is not within the same walls
/// (Landlock; signals from Linux 6.12 on). Elsewhere nothing happens, as [`has_file_walls`] says.
///
/// # Errors
/// What the system says.
pub fn write_only_in(folder: &Path) -> io::Result<()> {
    #[cfg(target_os = "linux")]
    landlocked(folder).map_err(io::Error::other)?;
    #[cfg(not(target_os = "linux"))]
    let _ = folder;
    Ok(())
}

#[cfg(target_os = "linux")]
fn landlocked(folder: &Path) -> Result<(), landlock::RulesetError> {
    use landlock::{
        ABI, Access as _, AccessFs, PathBeneath, PathFd, Ruleset, RulesetAttr as _, RulesetCreated,
        RulesetCreatedAttr as _, Scope, path_beneath_rules,
    };
    let writing = AccessFs::from_write(ABI::V5);
    // A device is written and controlled, not made.
    let device = AccessFs::WriteFile | AccessFs::Truncate | AccessFs::IoctlDev;
    let rules: RulesetCreated = Ruleset::default()
        .handle_access(writing)?
        .scope(Scope::from_all(ABI::V6))?
        .create()?
        .add_rules(path_beneath_rules([folder, Path::new(SHARED_MEMORY)], writing))?;
    let rules = match PathFd::new("/dev") {
        Ok(devices) => rules.add_rule(PathBeneath::new(devices, device))?,
        Err(_) => rules,
    };
    rules.restrict_self().map(drop)
}
