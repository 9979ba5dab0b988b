//! Tests of which files are read, and of the errors for the others.

use std::fs;
use std::path::Path;

use cranny_file::{FileFault, MESH, TABLE, TEXT, accept_streams, head, is_there};

fn fault(result: std::io::Result<impl std::fmt::Debug>) -> FileFault {
    let error = result.unwrap_err();
    error.get_ref().and_then(|reason| reason.downcast_ref::<FileFault>()).cloned().expect("a fault of ours")
}

#[test]
fn a_file_is_read_also_through_a_link() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.yaml");
    fs::write(&file, "x: 1\n").unwrap();
    assert_eq!(TEXT.text(&file).unwrap(), "x: 1\n");
    #[cfg(unix)]
    {
        let link = folder.path().join("b.yaml");
        std::os::unix::fs::symlink(&file, &link).unwrap();
        assert_eq!(TEXT.text(&link).unwrap(), "x: 1\n");
    }
}

#[test]
fn what_is_no_file_is_said_in_words() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a");
    fs::write(&file, b"one\ntwo \xff\n").unwrap();
    assert_eq!(fault(TEXT.text(&file)), FileFault::NotText { line: 2 });
    assert_eq!(fault(TEXT.bytes(folder.path())), FileFault::Folder);
    let missing = |near: &[&str]| FileFault::Missing {
        near: near.iter().map(|near| folder.path().join(near).display().to_string()).collect(),
    };
    assert_eq!(fault(TEXT.bytes(&folder.path().join("none"))), missing(&[]));
    assert_eq!(fault(TEXT.bytes(&file.join("none"))), missing(&[]));
    fs::write(folder.path().join("kitchen.yaml"), "").unwrap();
    let slip = fault(TEXT.bytes(&folder.path().join("kichen.yaml")));
    assert_eq!(slip, missing(&["kitchen.yaml"]));
    assert!(slip.to_string().contains("did you mean"), "{slip}");
    assert!(!is_there(&file.join("none")).unwrap() && is_there(&file).unwrap());
}

#[cfg(unix)]
fn pipe(path: &Path) {
    rustix::fs::mkfifoat(rustix::fs::CWD, path, rustix::fs::Mode::RUSR | rustix::fs::Mode::WUSR).unwrap();
}

/// A pipe named as a mesh would block a command for ever, and `/dev/zero` would take all memory.
#[cfg(unix)]
#[test]
fn pipes_and_devices_are_read_only_where_a_person_names_them() {
    let folder = tempfile::tempdir().unwrap();
    let (given, other) = (folder.path().join("pipe.csv"), folder.path().join("pipe.obj"));
    pipe(&given);
    pipe(&other);
    accept_streams(vec!["/dev/zero".into(), given.clone()]);
    for kind in [TEXT, TABLE, MESH] {
        assert_eq!(fault(kind.bytes(&other)), FileFault::NotRegular { kind: "a pipe" });
        assert_eq!(fault(kind.bytes(Path::new("/dev/null"))), FileFault::NotRegular { kind: "a device" });
    }
    // The head of a file is read before the file is replaced, and never that of a pipe.
    assert_eq!(fault(head(&given, 10)), FileFault::NotRegular { kind: "a pipe" });
    let writer = std::thread::spawn({
        let given = given.clone();
        move || fs::write(given, "0,1\n")
    });
    assert_eq!(TABLE.text(&given).unwrap(), "0,1\n");
    writer.join().unwrap().unwrap();
    // An endless device is read up to the limit.
    let said = fault(TEXT.bytes(Path::new("/dev/zero")));
    assert!(matches!(said, FileFault::TooLarge { size: None, .. }), "{said:?}");
}

/// A socket is no stream that can be read, and a link to one is no file.
#[cfg(unix)]
#[test]
fn sockets_and_links_to_streams_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let [socket, link, fifo] = ["socket", "link", "fifo"].map(|name| folder.path().join(name));
    let _listener = std::os::unix::net::UnixListener::bind(&socket).unwrap();
    assert_eq!(fault(TEXT.bytes(&socket)), FileFault::NotRegular { kind: "a socket" });
    pipe(&fifo);
    std::os::unix::fs::symlink(&fifo, &link).unwrap();
    assert_eq!(fault(TEXT.bytes(&link)), FileFault::NotRegular { kind: "a pipe" });
    // If a pipe replaces a file after it was checked, opening it does not wait either.
    let opened = cranny_file::system::open_without_waiting(&fifo).unwrap();
    assert!(!opened.metadata().unwrap().is_file());
}

#[test]
fn the_head_of_a_file_is_read_alone() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a");
    fs::write(&file, "0123456789").unwrap();
    assert_eq!(head(&file, 4).unwrap(), b"0123");
    assert_eq!(head(&file, 40).unwrap(), b"0123456789");
    assert_eq!(fault(head(folder.path(), 4)), FileFault::Folder);
}

#[test]
fn a_file_beyond_its_limit_is_refused_unread_with_the_flag_that_lifts_it() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("big.yaml");
    // The file is sparse: it takes no space on the disk.
    fs::File::create(&file).unwrap().set_len(5 << 30).unwrap();
    let said = fault(TEXT.text(&file)).to_string();
    assert!(
        said.contains("5120.0 MiB") && said.contains("64.0 MiB") && said.contains("--large-files"),
        "{said}"
    );
}
