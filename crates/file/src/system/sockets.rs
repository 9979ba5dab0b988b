use std::path::PathBuf;

/// Returns the paths of all sockets of the Unix domain in the network namespace of this process, except for relative paths and
/// abstract names (Linux); empty elsewhere.
pub fn socket_paths() -> Vec<PathBuf> {
    #[cfg(target_os = "linux")]
    {
        let table = std::fs::read("/proc/net/unix").unwrap_or_default();
        let mut paths: Vec<PathBuf> = table.split(|byte| *byte == b'\n').filter_map(socket_path).collect();
        // A listener has a row for each connection, too.
        paths.sort();
        paths.dedup();
        paths
    }
    #[cfg(not(target_os = "linux"))]
    Vec::new()
}

/// Returns the path in a row of `/proc/net/unix`: the eighth column (`proc_net`(5)), which may contain blanks.
#[cfg(target_os = "linux")]
fn socket_path(row: &[u8]) -> Option<PathBuf> {
    let mut rest = row;
    for _ in 0..7 {
        rest = rest.trim_ascii_start();
        rest = &rest[rest.iter().position(|byte| *byte == b' ')?..];
    }
    let path = std::str::from_utf8(&rest[1..]).ok().filter(|path| path.starts_with('/'))?;
    Some(PathBuf::from(path))
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;

    #[test]
    fn a_socket_is_found_by_its_path() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a socket with blanks");
        let _listener = std::os::unix::net::UnixListener::bind(&path).unwrap();
        assert!(socket_paths().contains(&path));
        let row = |end: &str| format!("0000000000000000: 00000002 00000000 00010000 0001 01    38{end}");
        for end in ["", " @a /b", " c /d"] {
            assert_eq!(socket_path(row(end).as_bytes()), None, "{end}");
        }
        assert_eq!(socket_path(row(" /e f").as_bytes()), Some("/e f".into()));
    }
}
