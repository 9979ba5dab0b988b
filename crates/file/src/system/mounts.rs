use std::ffi::{CString, OsString};
use std::fs::{self, File};
use std::io;
use std::os::fd::AsRawFd as _;
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

/// Makes all mounted file systems of this mount namespace read-only, apart from two new ones in memory: the folder of the program
/// and [`SHARED_MEMORY`], each of at most `memory_bytes`. Modes, times and attributes of files cannot be changed either, which
/// Landlock does not prevent. Hides terminals, the sockets of services, and the `hidden` paths except for the folders `kept`.
///
/// 1. Open the folders that stay readable: others will hide them.
/// 2. Hide shared memory, services, terminals and the hidden paths.
/// 3. Bring the readable folders back, and mount the folder of the program.
/// 4. Make everything else read-only.
///
/// # Errors
/// The error of the operating system; it names the path.
pub fn seal(folder: &Path, memory_bytes: u64, hidden: &[PathBuf], kept: &[PathBuf]) -> io::Result<()> {
    let named = |path: &Path| {
        let path = path.display().to_string();
        move |reason: io::Error| io::Error::new(reason.kind(), format!("{path}: {reason}"))
    };
    // The kernel lists mounts by their paths without links.
    let real = |path: &Path| fs::canonicalize(path).map_err(named(path));
    // 1.
    let folder = real(folder)?;
    let mut opened = Vec::new();
    for path in kept {
        let path = real(path)?;
        opened.push((File::open(&path).map_err(named(&path))?, path));
    }
    // 2.
    let memory = fs::canonicalize(SHARED_MEMORY).ok();
    if let Some(memory) = &memory {
        mount_memory(memory, memory_bytes).map_err(named(memory))?;
    }
    let services = SERVICES.iter().map(PathBuf::from);
    for path in services.chain(sockets_in(Path::new("/run"))).chain(hidden.iter().cloned()) {
        hide(&path).map_err(named(&path))?;
    }
    let terminals = Path::new("/dev/pts");
    if terminals.is_dir() {
        let options = Some(c"newinstance,ptmxmode=0666");
        mount("cranny", terminals, "devpts", MountFlags::NOSUID | MountFlags::NOEXEC, options)
            .map_err(|reason| named(terminals)(reason.into()))?;
    }
    // 3.
    for (descriptor, path) in &opened {
        bring_back(descriptor, path).map_err(named(path))?;
    }
    fs::create_dir_all(&folder).and_then(|()| mount_memory(&folder, memory_bytes)).map_err(named(&folder))?;
    // 4. Further down, a mount of the same path hides the ones before it, and is the one that is changed.
    for (path, flags) in mounted()? {
        if path == folder || Some(&path) == memory.as_ref() {
            continue;
        }
        match mount_remount(&path, MountFlags::BIND | MountFlags::RDONLY | flags, c"") {
            // A mount that is hidden below another one, that was removed, or that this user cannot reach.
            Ok(()) | Err(Errno::NOENT | Errno::ACCESS | Errno::INVAL | Errno::NOTDIR) => {}
            Err(reason) => return Err(named(&path)(reason.into())),
        }
    }
    Ok(())
}

/// Mounts a file system in memory of at most `bytes`.
fn mount_memory(folder: &Path, bytes: u64) -> io::Result<()> {
    /// Least memory of a file for each entry: the kernel needs about 1 KiB for an entry, which does not count.
    const BYTES_PER_ENTRY: u64 = 16 << 10;
    /// Programs in many files, with small limits.
    const LEAST_ENTRIES: u64 = 4096;
    let entries = (bytes / BYTES_PER_ENTRY).max(LEAST_ENTRIES);
    let options = CString::new(format!("size={bytes},nr_inodes={entries},mode=0700"))?;
    Ok(mount("cranny", folder, "tmpfs", MEMORY, Some(options.as_c_str()))?)
}

/// Flags of file systems in memory.
const MEMORY: MountFlags = MountFlags::NOSUID.union(MountFlags::NODEV);

/// Hides the content of a folder, or puts a device in the place of a file or socket. A missing path is ignored, and one that this
/// user cannot reach.
fn hide(path: &Path) -> io::Result<()> {
    let Ok(facts) = fs::symlink_metadata(path) else { return Ok(()) };
    let mounted = if facts.is_dir() {
        mount("cranny", path, "tmpfs", MEMORY, Some(c"size=4k"))
    } else {
        mount_bind("/dev/null", path)
    };
    match mounted {
        Ok(()) | Err(Errno::NOENT | Errno::ACCESS | Errno::NOTDIR) => Ok(()),
        Err(reason) => Err(reason.into()),
    }
}

/// Mounts a folder, known by its descriptor, at its path, which other mounts hide.
fn bring_back(folder: &File, path: &Path) -> io::Result<()> {
    fs::create_dir_all(path)?;
    Ok(mount_bind(format!("/proc/self/fd/{}", folder.as_raw_fd()), path)?)
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
