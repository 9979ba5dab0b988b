//! Scenarios as one file, schema of scenarios, template of a scenario.

use std::fs;
use std::io::{Cursor, Read, Write};
use std::path::{Path, PathBuf};

use cranny_scenario::{
    Credits, OpenOptions, Recipe, Scenario, SchemaFile, check, pack, unpack, write_template,
};
use cranny_task::Criterion;
use strum::VariantArray as _;
use zip::write::SimpleFileOptions;

fn corner() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/corner")
}

fn open(what: &Path) -> Result<Scenario, String> {
    Scenario::open(what.to_str().unwrap(), &OpenOptions::default()).map_err(|fault| fault.to_string())
}

fn packed() -> (tempfile::TempDir, PathBuf) {
    let root = tempfile::tempdir().unwrap();
    let archive = root.path().join("corner.zip");
    let credits = Credits { author: Some("A. Nother".into()), ..Credits::default() };
    let names = pack(&corner(), &archive, &credits).unwrap();
    assert_eq!(names, ["grasps.csv", "scenario.yaml", "wedge.obj"]);
    (root, archive)
}

#[test]
fn a_packed_scenario_opens_as_its_folder_does_and_unpacks_to_the_same_bytes() {
    let (root, archive) = packed();
    let (folder, zip) = (open(&corner()).unwrap(), open(&archive).unwrap());
    assert_eq!((zip.id.as_str(), zip.criterion), ("corner", Criterion::Paper));
    assert_eq!((zip.grasps, zip.start), (folder.grasps, folder.start));
    assert_eq!(zip.world.bodies().len(), folder.world.bodies().len());
    let unpacked = root.path().join("again");
    unpack(&archive, &unpacked).unwrap();
    for file in fs::read_dir(corner()).unwrap() {
        let name = file.unwrap().file_name();
        assert_eq!(fs::read(unpacked.join(&name)).unwrap(), fs::read(corner().join(&name)).unwrap());
    }
    let fault = unpack(&archive, &unpacked).unwrap_err().to_string();
    assert!(fault.contains("exists already"), "{fault}");
    let again = root.path().join("again.zip");
    pack(&corner(), &again, &Credits { author: Some("A. Nother".into()), ..Credits::default() }).unwrap();
    assert_eq!(fs::read(&again).unwrap(), fs::read(&archive).unwrap(), "the same folder, the same bytes");
}

#[test]
fn an_archive_in_the_folder_that_it_packs_is_no_part_of_it() {
    let (root, archive) = packed();
    let folder = root.path().join("mine");
    unpack(&archive, &folder).unwrap();
    let inside = folder.join("mine.zip");
    let pack_again = || {
        pack(&folder, &inside, &Credits::default()).unwrap();
        fs::read(&inside).unwrap()
    };
    assert_eq!(pack_again(), pack_again());
}

#[test]
fn an_archive_cut_short_at_any_byte_is_one_clear_error() {
    let (root, archive) = packed();
    let bytes = fs::read(&archive).unwrap();
    let cut = root.path().join("cut.zip");
    for length in (0..bytes.len()).step_by(7) {
        fs::write(&cut, &bytes[..length]).unwrap();
        let fault = open(&cut).unwrap_err();
        assert!(fault.contains("cut.zip: ") && !fault.contains('\n'), "{length}: {fault}");
        let folder = root.path().join("never");
        assert!(unpack(&cut, &folder).is_err() && !folder.exists());
    }
    assert!(open(&cut).unwrap_err().contains("is not a complete zip archive"));
}

/// Returns an archive with each file changed by `change`, which may rename it.
fn rewritten(archive: &Path, change: impl Fn(&mut String, &mut Vec<u8>)) -> Vec<u8> {
    let mut from = zip::ZipArchive::new(Cursor::new(fs::read(archive).unwrap())).unwrap();
    let mut to = zip::ZipWriter::new(Cursor::new(Vec::new()));
    for index in 0..from.len() {
        let mut entry = from.by_index(index).unwrap();
        let (mut name, mut content) = (entry.name().unwrap().into_owned(), Vec::new());
        entry.read_to_end(&mut content).unwrap();
        change(&mut name, &mut content);
        to.start_file(name, SimpleFileOptions::default()).unwrap();
        to.write_all(&content).unwrap();
    }
    to.finish().unwrap().into_inner()
}

#[test]
fn paths_that_leave_the_folder_and_changed_files_are_refused() {
    let (root, archive) = packed();
    let bad = root.path().join("bad.zip");
    for name in ["../grasps.csv", "/grasps.csv", "a/../../grasps.csv", "..\\grasps.csv", "C:grasps.csv"] {
        let bytes = rewritten(&archive, |entry, _| {
            if entry == "grasps.csv" {
                name.clone_into(entry);
            }
        });
        fs::write(&bad, bytes).unwrap();
        let fault = unpack(&bad, &root.path().join("out")).unwrap_err().to_string();
        assert!(fault.contains("would leave the folder") && !root.path().join("out").exists(), "{fault}");
        assert!(!root.path().join("grasps.csv").exists());
    }
    let tampered = rewritten(&archive, |entry, content| {
        if entry == "wedge.obj" {
            content.extend(b"# changed\n");
        }
    });
    fs::write(&bad, tampered).unwrap();
    assert!(open(&bad).unwrap_err().contains("'wedge.obj' is not what was packed"));
    let renamed = rewritten(&archive, |entry, _| *entry = entry.replace("wedge", "edge"));
    fs::write(&bad, renamed).unwrap();
    assert!(open(&bad).unwrap_err().contains("'wedge.obj' is missing"));
    let bare = rewritten(&archive, |entry, _| *entry = entry.replace("manifest", "other"));
    fs::write(&bad, bare).unwrap();
    assert!(open(&bad).unwrap_err().contains("no manifest.json"));
}

#[test]
fn a_scenario_that_needs_files_from_elsewhere_is_not_packed() {
    let root = tempfile::tempdir().unwrap();
    let folder = root.path().join("inner");
    fs::create_dir(&folder).unwrap();
    for name in ["grasps.csv", "scenario.yaml"] {
        fs::copy(corner().join(name), folder.join(name)).unwrap();
    }
    fs::copy(corner().join("wedge.obj"), root.path().join("wedge.obj")).unwrap();
    let yaml = fs::read_to_string(folder.join("scenario.yaml")).unwrap();
    fs::write(folder.join("scenario.yaml"), yaml.replace("wedge.obj", "../wedge.obj")).unwrap();
    open(&folder).unwrap();
    let archive = root.path().join("inner.zip");
    let fault = pack(&folder, &archive, &Credits::default()).unwrap_err().to_string();
    assert!(fault.contains("does not open by itself") && fault.contains("wedge.obj"), "{fault}");
    assert!(!fault.contains("unpacked"), "{fault}");
    assert!(!archive.exists());
}

#[test]
fn the_committed_schemas_are_those_of_the_types() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/schema");
    for file in SchemaFile::VARIANTS {
        let path = folder.join(format!("{}.schema.json", file.name()));
        if std::env::var_os("CRANNY_WRITE").is_some() {
            fs::write(&path, file.schema()).unwrap();
        }
        assert_eq!(fs::read_to_string(&path).unwrap(), file.schema(), "{}", file.name());
    }
}

#[test]
fn the_template_is_sound_and_is_never_written_over_anything() {
    let root = tempfile::tempdir().unwrap();
    let folder = root.path().join("mine");
    write_template(&folder, None).unwrap();
    assert!(check(folder.to_str().unwrap()).unwrap().is_empty());
    assert_eq!(open(&folder).unwrap().grasps.len(), 3);
    assert!(write_template(&folder, None).unwrap_err().to_string().contains("exists already"));
}

#[test]
fn what_a_recipe_writes_opens_as_the_same_scenario() {
    let root = tempfile::tempdir().unwrap();
    let original = open(&corner()).unwrap();
    let folder = root.path().join("corner");
    Recipe::of_scenario(&original).unwrap().write_folder(&folder).unwrap();
    let again = open(&folder).unwrap();
    assert_eq!((&again.start, again.target), (&original.start, original.target));
    let pairs = again.world.bodies().iter().zip(original.world.bodies());
    for (written, body) in pairs {
        assert_eq!((&written.name, written.parts.len()), (&body.name, body.parts.len()));
        for (a, b) in written.parts.iter().zip(&body.parts) {
            let shift = a.world_from_solid.translation.vector - b.world_from_solid.translation.vector;
            assert!(
                shift.norm() < 1e-9
                    && a.world_from_solid.rotation.angle_to(&b.world_from_solid.rotation) < 1e-9
            );
            if !a.solid.is_half_space() {
                assert!((a.solid.aabb().half_extents - b.solid.aabb().half_extents).norm() < 1e-7);
            }
        }
    }
}

/// Returns an archive with these names, patched byte by byte, so that it can be invalid.
fn archive_of(names: &[&str], content: &[u8]) -> Vec<u8> {
    let mut to = zip::ZipWriter::new(Cursor::new(Vec::new()));
    for (index, _) in names.iter().enumerate() {
        // Placeholders of the same length are replaced in the bytes: the library writes no name twice.
        to.start_file(format!("{index:0width$}", width = names[index].len()), SimpleFileOptions::default())
            .unwrap();
        to.write_all(content).unwrap();
    }
    let mut bytes = to.finish().unwrap().into_inner();
    for (index, name) in names.iter().enumerate() {
        let placeholder = format!("{index:0width$}", width = name.len()).into_bytes();
        for at in 0..bytes.len() - placeholder.len() {
            let is_name = at >= 30
                && bytes[at..].starts_with(&placeholder)
                && (bytes[at - 30..].starts_with(b"PK\x03\x04")
                    || (at >= 46 && bytes[at - 46..].starts_with(b"PK\x01\x02")));
            if is_name {
                bytes[at..at + name.len()].copy_from_slice(name.as_bytes());
            }
        }
    }
    bytes
}

/// Names that a system would reject, or that would overwrite each other.
#[test]
fn names_that_hurt_where_they_are_unpacked_are_refused() {
    let root = tempfile::tempdir().unwrap();
    let archive = root.path().join("bad.zip");
    let cases: [(&[&str], &str); 8] = [
        (&["grasps.csv", "grasps.csv"], "holds 'grasps.csv' twice"),
        (&["grasps.csv", "Grasps.CSV"], "holds 'Grasps.CSV' twice"),
        (&["CON"], "no name for a file on every system"),
        (&["a/com1.obj"], "no name for a file on every system"),
        (&[".git/hooks/post-checkout"], "is hidden"),
        (&["a?b"], "no name for a file on every system"),
        (&["mesh."], "no name for a file on every system"),
        (&["a\x1b[31mb"], "no name for a file on every system"),
    ];
    for (names, expected) in cases {
        fs::write(&archive, archive_of(names, b"x")).unwrap();
        let folder = root.path().join("out");
        let fault = unpack(&archive, &folder).unwrap_err().to_string();
        assert!(fault.contains(expected) && !folder.exists(), "{names:?}: {fault}");
    }
    fs::write(&archive, archive_of(&["com.obj", "console.obj", "a.b/c.d"], b"x")).unwrap();
    let fault = unpack(&archive, &root.path().join("out")).unwrap_err().to_string();
    assert!(fault.contains("no manifest.json"), "{fault}");
}

/// An archive that unpacks from 0.9 MB to 0.9 GB of zeros must not be unpacked.
#[test]
fn an_archive_that_unpacks_to_far_more_than_it_is_is_refused_at_once() {
    let root = tempfile::tempdir().unwrap();
    let archive = root.path().join("bomb.zip");
    fs::write(&archive, archive_of(&["a.obj", "b.obj"], &vec![0; 20 << 20])).unwrap();
    let fault = unpack(&archive, &root.path().join("out")).unwrap_err().to_string();
    assert!(fault.contains("over 100 times its own size"), "{fault}");
    // A false size in the directory does not circumvent the limit.
    let mut bytes = fs::read(&archive).unwrap();
    for at in 0..bytes.len() - 46 {
        if bytes[at..].starts_with(b"PK\x01\x02") {
            bytes[at + 24..at + 28].copy_from_slice(&1000_u32.to_le_bytes());
        }
    }
    fs::write(&archive, bytes).unwrap();
    assert!(unpack(&archive, &root.path().join("out")).is_err());
    assert!(!root.path().join("out").exists());
}

/// Files that could not be unpacked again are not packed.
#[test]
fn a_folder_with_a_name_that_no_archive_may_hold_is_not_packed() {
    let root = tempfile::tempdir().unwrap();
    for file in ["scenario.yaml", "grasps.csv", "wedge.obj"] {
        fs::copy(corner().join(file), root.path().join(file)).unwrap();
    }
    fs::write(root.path().join("aux.obj"), "").unwrap();
    let archive = root.path().join("a.zip");
    let fault = pack(root.path(), &archive, &Credits::default()).unwrap_err().to_string();
    assert!(fault.contains("no name for a file on every system") && !archive.exists(), "{fault}");
}
