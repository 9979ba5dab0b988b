use std::path::PathBuf;

/// Returns the paths of all sockets of the Unix domain in the network namespaces of all visible processes, except for abstract
/// names, and of all sockets in their folders, which may have another name now (Linux); empty elsewhere. A relative name is looked
/// for in the present folders of these processes.
pub fn socket_paths() -> Vec<PathBuf> {
    #[cfg(target_os = "linux")]
    return linux::socket_paths();
    #[cfg(not(target_os = "linux"))]
    Vec::new()
}

#[cfg(target_os = "linux")]
mod linux {
    use std::collections::BTreeSet;
    use std::fs;
    use std::os::unix::fs::FileTypeExt as _;
    use std::path::{Path, PathBuf};

    pub fn socket_paths() -> Vec<PathBuf> {
        let names = fs::read_dir("/proc").into_iter().flatten().flatten();
        let is_process = |folder: &PathBuf| {
            folder.file_name().is_some_and(|name| name.as_encoded_bytes().iter().all(u8::is_ascii_digit))
        };
        let processes: Vec<PathBuf> = names.map(|entry| entry.path()).filter(is_process).collect();
        let mut namespaces = BTreeSet::new();
        // The table of this process comes first: it is readable.
        let own = [PathBuf::from("/proc/self")];
        let of_each = own.iter().chain(&processes).filter(|process| {
            fs::read_link(process.join("ns/net")).is_ok_and(|namespace| namespaces.insert(namespace))
        });
        let mut paths = BTreeSet::new();
        for process in of_each {
            let table = fs::read(process.join("net/unix")).unwrap_or_default();
            // A listener has a row for each connection, too.
            paths.extend(table.split(|byte| *byte == b'\n').filter_map(socket_path));
        }
        let (mut found, relative): (Vec<PathBuf>, Vec<PathBuf>) =
            paths.into_iter().partition(|path| path.is_absolute());
        if !relative.is_empty() {
            let folders: BTreeSet<PathBuf> =
                processes.iter().filter_map(|process| fs::read_link(process.join("cwd")).ok()).collect();
            let below = folders.iter().flat_map(|folder| relative.iter().map(|path| folder.join(path)));
            found.extend(below);
        }
        let folders: BTreeSet<&Path> = found.iter().filter_map(|path| path.parent()).collect();
        let entries =
            folders.into_iter().flat_map(|folder| fs::read_dir(folder).into_iter().flatten().flatten());
        let sockets = entries.filter(|entry| entry.file_type().is_ok_and(|kind| kind.is_socket()));
        let beside: Vec<PathBuf> = sockets.map(|entry| entry.path()).collect();
        // A folder that cannot be listed may be passed through.
        found.retain(|path| fs::symlink_metadata(path).is_ok_and(|facts| facts.file_type().is_socket()));
        found.extend(beside);
        found.sort();
        found.dedup();
        found
    }

    /// Returns the path in a row of `/proc/net/unix`: the eighth column (`proc_net`(5)), which may contain blanks.
    fn socket_path(row: &[u8]) -> Option<PathBuf> {
        let mut rest = row;
        for _ in 0..7 {
            rest = rest.trim_ascii_start();
            rest = &rest[rest.iter().position(|byte| *byte == b' ')?..];
        }
        let is_path = |path: &&str| !path.is_empty() && !path.starts_with('@') && *path != "Path";
        std::str::from_utf8(&rest[1..]).ok().filter(is_path).map(PathBuf::from)
    }

    #[cfg(test)]
    mod tests {
        use super::*;

        #[test]
        fn a_socket_is_found_by_its_path() {
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join("a socket with blanks");
            let _listener = std::os::unix::net::UnixListener::bind(&path).unwrap();
            assert!(socket_paths().contains(&path));
            let row = |end: &str| format!("0000000000000000: 00000002 00000000 00010000 0001 01    38{end}");
            for end in ["", " @a /b"] {
                assert_eq!(socket_path(row(end).as_bytes()), None, "{end}");
            }
            for path in ["/e f", "c /d", "a.sock"] {
                assert_eq!(socket_path(row(&format!(" {path}")).as_bytes()), Some(path.into()));
            }
        }

        #[test]
        fn a_socket_with_a_relative_name_is_found_where_its_program_runs() {
            let folder = tempfile::tempdir().unwrap();
            let bind = "import socket, time; s = socket.socket(socket.AF_UNIX); s.bind('a.sock'); print(flush=True); time.sleep(60)";
            let mut program = std::process::Command::new("python3");
            program.args(["-c", bind]).current_dir(folder.path()).stdout(std::process::Stdio::piped());
            let Ok(mut program) = program.spawn() else { return };
            let mut line = String::new();
            let mut output = std::io::BufReader::new(program.stdout.take().unwrap());
            std::io::BufRead::read_line(&mut output, &mut line).unwrap();
            let path = folder.path().canonicalize().unwrap().join("a.sock");
            let is_found = socket_paths().contains(&path);
            program.kill().unwrap();
            program.wait().unwrap();
            assert!(is_found);
        }
    }
}
