//! Octomaps of `MoveIt` scenes.

use cranny_collision::{Cell, Collider, Contact, Margins};
use cranny_spatial::Point;

use crate::moveit_folder::Folder;

const EMPTY: &str = "octomap: {header: {}, origin: {}, octomap: {header: {}, binary: false, id: '', resolution: 0, data: []}}";

/// Bytes of a tree of 16 levels, whose only occupied cell is the one beside the origin in the positive octant.
fn one_cell() -> String {
    let mut bytes = vec![0, -64];
    for _ in 0..14 {
        bytes.extend([3, 0]);
    }
    bytes.extend([2, 0]);
    format!("{bytes:?}")
}

fn octomap(pose: &str, keys: &str) -> String {
    format!("octomap: {{header: {{frame_id: shelf}}, origin: {pose}, octomap: {{header: {{}}, {keys}}}}}")
}

#[test]
fn occupied_cells_are_obstacles_at_the_pose_of_the_tree() {
    let folder = Folder::new();
    let keys = format!("binary: true, id: OcTree, resolution: 0.5, data: {}", one_cell());
    let pose = "{position: [0.1, 0.2, 0.3], orientation: [0, 0, 1, 0]}";
    folder.changed("scene.yaml", EMPTY, &octomap(pose, &keys));
    let problem = folder.open().unwrap();
    let bodies = problem.world.bodies();
    let body = bodies.iter().find(|body| body.name == "<octomap>").unwrap();
    // The frame `shelf` is 1 m above the world's; the cell is a cube of 0.5 m, turned by 180° about z.
    let [part] = &body.parts[..] else { panic!("one solid") };
    let pieces = part.solid.pieces();
    let center = part.world_from_solid * pieces[0].0 * Point::origin();
    assert_eq!(pieces.len(), 1);
    assert!((center - Point::new(0.1 - 0.25, 0.2 - 0.25, 0.3 + 0.25 + 1.0)).norm() < 1e-6, "{center}");
    let half_extents = pieces[0].1.aabb().half_extents;
    assert!((half_extents.add_scalar(-0.25)).amax() < 1e-6, "{half_extents}");
}

/// The arm, 5 cm wide, stands in a cell that begins 1 cm beside its axis, and beside one that begins 10 cm from it.
#[test]
fn the_robot_touches_an_octomap_where_it_touches_a_cell() {
    for (x, is_touched) in [(0.01, true), (0.1, false)] {
        let folder = Folder::new();
        let keys = format!("binary: true, id: OcTree, resolution: 0.5, data: {}", one_cell());
        let world = octomap(&format!("{{position: [{x}, -0.25, -1]}}"), &keys);
        folder.write("scene.yaml", &format!("world: {{{world}}}\n{FRAMES}"));
        let problem = folder.open().unwrap();
        let cell = Cell::new(problem.robot.clone(), problem.world.clone(), Margins::default()).unwrap();
        let contacts = cell.contacts(&problem.start, &mut cell.scratch());
        let is_of_cell = |contact: &Contact| contact.second == Collider::Body(0);
        assert_eq!(contacts.iter().any(is_of_cell), is_touched, "{x}: {contacts:?}");
    }
}

const FRAMES: &str = "fixed_frame_transforms:
  - {header: {frame_id: world}, child_frame_id: shelf, transform: {translation: [0, 0, 1], rotation: [0, 0, 0, 1]}}
";

#[test]
fn octomaps_that_are_not_read_are_refused_with_the_reason() {
    let cell = one_cell();
    for (keys, words) in [
        (
            format!("binary: false, id: OcTree, resolution: 0.5, data: {cell}"),
            "an octomap with probabilities is not supported",
        ),
        (format!("id: OcTree, resolution: 0.5, data: {cell}"), "an octomap with probabilities"),
        (format!("binary: true, id: ColorOcTree, resolution: 0.5, data: {cell}"), "its id is 'ColorOcTree'"),
        (format!("binary: true, id: OcTree, resolution: 0, data: {cell}"), "the resolution is 0"),
        (format!("binary: true, id: OcTree, data: {cell}"), "the resolution is 0"),
        ("binary: true, id: OcTree, resolution: 0.5, data: [3]".to_owned(), "ends within the tree"),
        ("binary: true, id: OcTree, resolution: 0.01, data: [2, 0, 1]".to_owned(), "1 bytes follow"),
        (
            "binary: true, id: OcTree, resolution: 0.5, data: [300, 0]".to_owned(),
            "a list of bytes, -128 to 255",
        ),
        (
            "binary: true, id: OcTree, resolution: 0.5, data: 'AgA='".to_owned(),
            "a list of bytes, -128 to 255",
        ),
    ] {
        let folder = Folder::new();
        let fault = folder.changed("scene.yaml", EMPTY, &octomap("{}", &keys)).fault();
        assert!(fault.contains(words) && fault.contains("scene.yaml:"), "no '{words}' in: {fault}");
    }
    // Free cells alone are no obstacle.
    let folder = Folder::new();
    let keys = format!("binary: true, id: OcTree, resolution: 0.5, data: {}", cell.replace("2, 0]", "1, 0]"));
    folder.changed("scene.yaml", EMPTY, &octomap("{}", &keys));
    assert!(folder.open().unwrap().world.bodies().iter().all(|body| body.name != "<octomap>"));
}
