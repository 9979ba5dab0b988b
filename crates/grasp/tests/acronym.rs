//! ACRONYM files as h5py wrote them: `fixtures/acronym.py`.

use std::path::{Path, PathBuf};

use cranny_grasp::{ClosingAxis, FRANKA_PADS_M, GraspFormat, ImportSettings, Imported, import_grasps};

use crate::imports::{Files, assert_axes};

fn fixture(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures").join(name)
}

fn read(name: &str, settings: &ImportSettings) -> Result<Imported, String> {
    import_grasps(&fixture(name), settings).map_err(|fault| fault.to_string())
}

fn fault(name: &str) -> String {
    read(name, &ImportSettings::default()).expect_err("it is refused")
}

#[test]
fn acronym_is_read_as_h5py_wrote_it() {
    let path = fixture("acronym.h5");
    let read = read("acronym.h5", &ImportSettings::default()).expect("grasps");
    assert!(!read.notes.iter().any(|note| note.starts_with("not read")), "{:?}", read.notes);
    assert_eq!((read.format, read.in_file, read.object_scale), (GraspFormat::Acronym, 3, Some(0.0125)));
    let grasps = read.grasps.grasps();
    assert_eq!([0, 1, 2].map(|grasp| grasps[grasp].score), [Some(1.0), Some(0.0), Some(1.0)]);
    for (shift, grasp) in grasps.iter().enumerate() {
        let pads = [1.0 + shift as f64, 2.0 - FRANKA_PADS_M, 3.0];
        assert_axes(&grasp.world_from_gripper, pads, [1.0, 0.0, 0.0], [0.0, -1.0, 0.0]);
    }
    // A file that ends early, or whose content contradicts its header, gives an error without a panic.
    let (files, whole) = (Files::new(), std::fs::read(&path).expect("a file"));
    for place in (0..whole.len()).step_by(211) {
        let mut damaged = whole.clone();
        damaged[place] ^= 0xff;
        let _ = files.read(&damaged, &ImportSettings::default());
        let _ = files.read(&whole[..place], &ImportSettings::default());
    }
}

/// Guards against taking every gripper for the Franka hand.
#[test]
fn another_gripper_needs_its_frame() {
    let other = fault("acronym_other_gripper.h5");
    for words in ["gripper/type is 'robotiq_2f_140'", "the Franka hand", "which axis it closes", "the offset"]
    {
        assert!(other.contains(words), "no {words} in: {other}");
    }
    let half = ImportSettings { offset_m: Some(0.2), ..ImportSettings::default() };
    assert!(read("acronym_other_gripper.h5", &half).is_err());
    let whole = ImportSettings { closing: Some(ClosingAxis::X), ..half };
    let given = read("acronym_other_gripper.h5", &whole).expect("grasps");
    assert_axes(
        &given.grasps.grasps()[0].world_from_gripper,
        [1.0, 1.8, 3.0],
        [1.0, 0.0, 0.0],
        [0.0, -1.0, 0.0],
    );
    assert!(given.notes.iter().any(|note| note.contains("'robotiq_2f_140'")), "{:?}", given.notes);
}

#[test]
fn a_mask_is_applied_and_what_is_unknown_is_noted() {
    let masked = read("acronym_masked.h5", &ImportSettings::default()).expect("grasps");
    assert_eq!((masked.in_file, masked.masked, masked.grasps.len()), (3, 1, 2));
    // h5py writes booleans as an enumeration.
    let grasps = masked.grasps.grasps();
    assert_eq!([grasps[0].score, grasps[1].score], [Some(1.0), Some(1.0)]);
    assert_axes(
        &grasps[1].world_from_gripper,
        [3.0, 2.0 - FRANKA_PADS_M, 3.0],
        [1.0, 0.0, 0.0],
        [0.0, -1.0, 0.0],
    );
    let unread = "not read: gripper/offset, grasps/poses, attribute units of grasps/transforms";
    assert!(masked.notes.iter().any(|note| note == unread), "{:?}", masked.notes);
    assert!(masked.notes.iter().any(|note| note.contains("grasps/mask is true")), "{:?}", masked.notes);
}

#[test]
fn an_object_has_one_scale() {
    let one = read("acronym_one_scale.h5", &ImportSettings::default()).expect("grasps");
    assert_eq!(one.object_scale, Some(2.0));
    let three = fault("acronym_three_scales.h5");
    assert!(
        three.contains("object/scale is [1.0, 2.0, 3.0], but grasps fit an object of one scale"),
        "{three}"
    );
}

#[test]
fn a_dataset_that_cannot_be_read_is_refused_for_what_it_is() {
    let half = fault("acronym_half.h5");
    assert!(half.contains("flex/object_in_gripper holds floating-point numbers of 16 bits"), "{half}");
    let lzf = fault("acronym_lzf.h5");
    assert!(lzf.contains("object_in_gripper is compressed by LZF (filter 32000)"), "{lzf}");
    assert!(lzf.contains("save it with gzip"), "{lzf}");
}
