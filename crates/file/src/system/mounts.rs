use std::ffi::OsString;
use std::fs;
use std::io;
use std::os::unix::ffi::OsStringExt as _;
use std::os::unix::fs::FileTypeExt as _;
use std::path::{Path, PathBuf};

use rustix::io::Errno;
use rustix::mount::{MountFlags, mount, mount_bind, mount_remount};

use crate::system::SHARED_MEMORY;

/// Folders of sockets on which services of the machine and of the user listen.
const SERVICES: [&str; 8] = [
    "/run/user",
    "/run/dbus",
    "/run/systemd",
    "/run/containerd",
    "/run/podman",
    "/run/libvirt",
    "/tmp/.X11-unix",
    "/tmp/.ICE-unix",
];

/// Makes all mounted file systems of this mount namespace read-only, apart from `folder` and a new [`SHARED_MEMORY`] of at most
/// `shared_memory_bytes`, and hides terminals and the sockets of services. Modes, times and attributes of files cannot be
/// changed either, which Landlock does not prevent.
///
/// # Errors
/// The error of the operating system; it names the path.
pub fn seal(folder: &Path, shared_memory_bytes: u64) -> io::Result<()> {
    let tight = MountFlags::NOSUID | MountFlags::NODEV;
    let named = |path: &Path| {
        let path = path.display().to_string();
        move |reason: Errno| io::Error::other(format!("{path}: {reason}"))
    };
    for service in SERVICES.iter().map(Path::new).filter(|service| service.is_dir()) {
        mount("cranny", service, "tmpfs", tight, Some(c"size=4k")).map_err(named(service))?;
    }
    for socket in sockets_in(Path::new("/run")) {
        mount_bind("/dev/null", &socket).map_err(named(&socket))?;
    }
    let terminals = Path::new("/dev/pts");
    if terminals.is_dir() {
        let options = Some(c"newinstance,ptmxmode=0666");
        mount("cranny", terminals, "devpts", MountFlags::NOSUID | MountFlags::NOEXEC, options)
            .map_err(named(terminals))?;
    }
    mount_bind(folder, folder).map_err(named(folder))?;
    // Further down, a mount of the same path hides the ones before it, and is the one that is changed.
    for (path, flags) in mounted()? {
        if path == folder || path == Path::new(SHARED_MEMORY) {
            continue;
        }
        match mount_remount(&path, MountFlags::BIND | MountFlags::RDONLY | flags, c"") {
            // A mount that is hidden below another one, or that this user cannot reach.
            Ok(()) | Err(Errno::NOENT | Errno::ACCESS | Errno::INVAL | Errno::NOTDIR) => {}
            Err(reason) => return Err(named(&path)(reason)),
        }
    }
    let memory = Path::new(SHARED_MEMORY);
    if memory.is_dir() {
        let options = std::ffi::CString::new(format!("size={shared_memory_bytes}"))?;
        mount("cranny", memory, "tmpfs", tight, Some(options.as_c_str())).map_err(named(memory))?;
    }
    Ok(())
}

/// Returns the sockets of a folder.
fn sockets_in(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let is_socket = |entry: &fs::DirEntry| entry.file_type().is_ok_and(|kind| kind.is_socket());
    entries.filter(is_socket).map(|entry| entry.path()).collect()
}

/// Returns the mount points of this namespace, with those flags that a remount must repeat: the kernel does not let a user
/// namespace remove them.
fn mounted() -> io::Result<Vec<(PathBuf, MountFlags)>> {
    const KEPT: [(&str, MountFlags); 7] = [
        ("nosuid", MountFlags::NOSUID),
        ("nodev", MountFlags::NODEV),
        ("noexec", MountFlags::NOEXEC),
        ("noatime", MountFlags::NOATIME),
        ("nodiratime", MountFlags::NODIRATIME),
        ("relatime", MountFlags::RELATIME),
        ("nosymfollow", MountFlags::NOSYMFOLLOW),
    ];
    let list = fs::read("/proc/self/mountinfo")?;
    let row = |line: &[u8]| {
        let mut fields = line.split(|byte| *byte == b' ').skip(4);
        let path = PathBuf::from(OsString::from_vec(unescaped(fields.next()?)));
        let options = String::from_utf8_lossy(fields.next()?).into_owned();
        let is_set = |name: &str| options.split(',').any(|option| option == name);
        let kept = KEPT.iter().filter(|(name, _)| is_set(name)).map(|(_, flag)| *flag);
        Some((path, kept.fold(MountFlags::empty(), |all, flag| all | flag)))
    };
    Ok(list.split(|byte| *byte == b'\n').filter_map(row).collect())
}

/// Replaces escapes such as `\040` by their bytes (proc(5)).
fn unescaped(field: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(field.len());
    let mut rest = field;
    while let Some((&first, others)) = rest.split_first() {
        let octal = |digits: &[u8]| {
            std::str::from_utf8(digits).ok().and_then(|digits| u8::from_str_radix(digits, 8).ok())
        };
        if let Some(byte) = others.get(..3).filter(|_| first == b'\\').and_then(octal) {
            bytes.push(byte);
            rest = &others[3..];
        } else {
            bytes.push(first);
            rest = others;
        }
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn escapes_of_mount_points_are_bytes() {
        assert_eq!(unescaped(br"/a\040b\134c"), br"/a b\c");
        assert_eq!(unescaped(br"/a\04"), br"/a\04");
        assert_eq!(unescaped(br"/a\999"), br"/a\999");
    }
}
