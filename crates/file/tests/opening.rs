//! Tests of which files are read, and of the errors for the others.

use std::fs;
use std::path::Path;

use cranny_file::{FileFault, MESH, TABLE, TEXT, is_there};

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

/// A pipe named as a mesh would block a command for ever, and `/dev/zero` would take all memory.
#[cfg(unix)]
#[test]
fn pipes_and_devices_are_read_only_where_a_person_names_them() {
    let folder = tempfile::tempdir().unwrap();
    let pipe = folder.path().join("pipe.obj");
    rustix::fs::mkfifoat(rustix::fs::CWD, &pipe, rustix::fs::Mode::RUSR | rustix::fs::Mode::WUSR).unwrap();
    assert_eq!(fault(MESH.bytes(&pipe)), FileFault::NotRegular { kind: "a pipe" });
    assert_eq!(fault(TEXT.bytes(Path::new("/dev/zero"))), FileFault::NotRegular { kind: "a device" });
    let writer = std::thread::spawn({
        let pipe = pipe.clone();
        move || fs::write(pipe, "0,1\n")
    });
    assert_eq!(TABLE.argument().text(&pipe).unwrap(), "0,1\n");
    writer.join().unwrap().unwrap();
    // An endless device is read up to the limit.
    let said = fault(TEXT.argument().bytes(Path::new("/dev/zero")));
    assert!(matches!(said, FileFault::TooLarge { size: None, .. }), "{said:?}");
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
