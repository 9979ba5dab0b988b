//! Built-in objects, objects from meshes, and obstacles.

use cranny_scenario::{
    ObjectError, ObjectSettings, ObjectType, Obstacle, ScenarioError, builtin_object, builtin_object_names,
};
use cranny_shape::{RepairedMesh, ShapeError, Surface, TriangleSoup};
use cranny_spatial::{Point, Pose, Vector};

fn bounds(soup: &TriangleSoup) -> (Point, Point) {
    let first = soup.vertices[0];
    soup.vertices.iter().fold((first, first), |(low, high), p| (low.inf(p), high.sup(p)))
}

#[test]
fn built_in_objects_have_their_published_sizes_and_sound_meshes() {
    let sizes = [
        ("flat_screwdriver", [0.215, 0.031, 0.031], 0.0984),
        ("tennis_ball", [0.0647, 0.0647, 0.0647], 0.058),
        ("sugar_box", [0.038, 0.089, 0.175], 0.514),
    ];
    for (name, size, mass_kg) in sizes {
        let object = builtin_object(name).unwrap();
        let (low, high) = bounds(&object.mesh);
        assert!(((high - low) - Vector::from(size)).amax() < 1e-4, "{name}: {}", high - low);
        assert!((low.coords + high.coords).amax() < 1e-12, "{name} is centred");
        assert!((object.mass_kg - mass_kg).abs() < 1e-12);
    }
    let banana = builtin_object("banana").unwrap();
    let (low, high) = bounds(&banana.mesh);
    assert!(((high - low).z - 0.036).abs() < 2e-4, "{}", high - low);
    // The ends of the bend are its farthest points; the straight line between them is shorter than the bend.
    assert!((high - low).y > 0.16 && (high - low).y < 0.19);
    for name in builtin_object_names() {
        let object = builtin_object(name).unwrap();
        object.solid().unwrap();
        let repaired = RepairedMesh::of(&object.mesh).unwrap();
        assert_eq!(
            (repaired.merged_vertices, repaired.dropped_triangles, repaired.flipped_triangles),
            (0, 0, 0),
            "{name}"
        );
        assert_eq!(repaired.shallow_crossings, 0, "{name}");
        let error = object.parts.error;
        assert!(error.excess < 0.05 && error.missing < 0.01, "{name}: {error:?}");
        assert!(object.inertia_kg_m2.symmetric_eigenvalues().min() > 0.0);
        assert!(!object.stable_poses.is_empty());
        assert!(object.stable_poses.windows(2).all(|two| two[0].probability >= two[1].probability));
        for stable in &object.stable_poses {
            let resting = |v: &Point| (stable.ground_from_body * v).z;
            let lowest = object.mesh.vertices.iter().map(resting).fold(f64::INFINITY, f64::min);
            assert!(lowest.abs() < 1e-6, "{name} rests on the ground: {lowest}");
            let center = stable.ground_from_body * object.center_of_mass;
            assert!(center.x.abs() < 1e-12 && center.y.abs() < 1e-12 && center.z > 0.0);
        }
    }
    assert!(matches!(builtin_object("anvil"), Err(ScenarioError::Object(ObjectError::Unknown { .. }))));
}

#[test]
fn an_object_survives_its_folder() {
    let folder = tempfile::tempdir().unwrap();
    for name in builtin_object_names() {
        let object = builtin_object(name).unwrap();
        let path = folder.path().join(name);
        object.write_folder(&path).unwrap();
        let read = ObjectType::read_folder(&path).unwrap();
        assert_eq!(read.name, object.name);
        assert_eq!(read.mesh.triangles.len(), object.mesh.triangles.len());
        assert_eq!(read.parts.parts.len(), object.parts.parts.len());
        assert!((read.mass_kg - object.mass_kg).abs() < 1e-15);
        assert!((read.inertia_kg_m2 - object.inertia_kg_m2).amax() < 1e-15);
        assert!((read.center_of_mass - object.center_of_mass).norm() < 1e-15);
        assert_eq!(read.stable_poses.len(), object.stable_poses.len());
        for (a, b) in read.stable_poses.iter().zip(&object.stable_poses) {
            assert!((a.probability - b.probability).abs() < 1e-15);
            assert!(
                (a.ground_from_body.to_homogeneous() - b.ground_from_body.to_homogeneous()).amax() < 1e-9
            );
        }
    }
    std::fs::write(folder.path().join("banana/object.yaml"), "name: banana\nmass_kg: [").unwrap();
    let fault = ObjectType::read_folder(&folder.path().join("banana")).unwrap_err().to_string();
    assert!(fault.contains("object.yaml:"), "{fault}");
    std::fs::remove_file(folder.path().join("sugar_box/mesh.obj")).unwrap();
    let fault = ObjectType::read_folder(&folder.path().join("sugar_box")).unwrap_err().to_string();
    assert!(fault.contains("mesh.obj"), "{fault}");
}

#[test]
fn figures_of_an_object_that_its_meshes_do_not_have_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("banana");
    builtin_object("banana").unwrap().write_folder(&path).unwrap();
    let file = path.join("object.yaml");
    let text = std::fs::read_to_string(&file).unwrap();
    let value = |key: &str, from: &str| -> String {
        let rest = &text[text.find(from).unwrap()..];
        let rest = &rest[rest.find(key).unwrap() + key.len()..];
        rest[..rest.find('\n').unwrap()].to_owned()
    };
    for (key, from, stated) in [
        ("mass_kg:", "mass_kg:", " 350"),
        ("volume_m3:", "volume_m3:", " -0.1"),
        ("missing:", "missing:", " 0.5"),
        ("probability:", "stable_poses:", " 7"),
        ("mass_kg:", "mass_kg:", " .nan"),
    ] {
        let old = format!("{key}{}", value(key, from));
        let at = text.find(from).unwrap();
        let changed = format!("{}{}", &text[..at], text[at..].replacen(&old, &format!("{key}{stated}"), 1));
        assert_ne!(changed, text, "{key}");
        std::fs::write(&file, changed).unwrap();
        assert!(ObjectType::read_folder(&path).is_err(), "{key}{stated}");
    }
    // An object with a convex part removed does not have the stated error.
    let first = text.find("- parts/00.obj").unwrap();
    let line = &text[first..first + text[first..].find('\n').unwrap()];
    std::fs::write(&file, text.replacen(line, "", 1)).unwrap();
    let fault = ObjectType::read_folder(&path).unwrap_err().to_string();
    assert!(fault.contains("convex_parts_error"), "{fault}");
}

#[test]
fn a_mesh_in_other_units_gets_a_hint_and_bad_numbers_are_refused() {
    let cuboid = |size: f64| Surface::cuboid_soup(&Vector::new(0.2 * size, 0.3 * size, 0.5 * size));
    let settings = ObjectSettings::new("box", 0.4);
    let millimetres = ObjectType::from_mesh(&cuboid(175.0), &settings).unwrap_err().to_string();
    assert!(millimetres.contains("millimetres") && millimetres.contains("0.001"), "{millimetres}");
    let small = ObjectType::from_mesh(&cuboid(0.000175), &settings).unwrap_err();
    assert!(matches!(small, ScenarioError::Object(ObjectError::Size { .. })), "{small}");
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let mass = ObjectType::from_mesh(&cuboid(0.2), &ObjectSettings::new("box", bad)).unwrap_err();
        assert!(matches!(mass, ScenarioError::Object(ObjectError::Number { what: "mass", .. })), "{mass}");
        let slippery = ObjectSettings { friction: bad.into(), ..settings.clone() };
        let friction = ObjectType::from_mesh(&cuboid(0.2), &slippery).unwrap_err();
        assert!(
            matches!(friction, ScenarioError::Object(ObjectError::Number { what: "friction", .. })),
            "{friction}"
        );
    }
    let mut open = cuboid(0.2);
    open.triangles.pop();
    let fault = ObjectType::from_mesh(&open, &settings).unwrap_err();
    assert!(matches!(fault, ScenarioError::ShapeFile(ShapeError::Open { .. })), "{fault}");
    let empty = ObjectType::from_mesh(&TriangleSoup::default(), &settings).unwrap_err();
    assert!(matches!(empty, ScenarioError::ShapeFile(ShapeError::Empty)), "{empty}");
}

#[test]
fn obstacles_have_the_sizes_of_the_paper() {
    let volume = |obstacle: &Obstacle| -> f64 {
        obstacle.boxes().iter().map(|(_, size)| size.x * size.y * size.z).sum()
    };
    let close = |a: f64, b: f64| (a - b).abs() < 1e-12;
    assert!(close(volume(&Obstacle::TABLE), 2.0 * 0.1 * 0.8 * 0.4 + 2.0 * 0.8 * 0.1));
    assert!(close(volume(&Obstacle::SHELF), 2.0 * 0.03 * 0.5 * 0.4 + 0.46 * 0.5 * 0.03));
    assert!(close(volume(&Obstacle::WALL_SEGMENT), 0.08) && close(volume(&Obstacle::PEDESTAL), 0.08));
    let gate = Obstacle::gate(0.54).boxes();
    assert!(gate.iter().all(|(_, size)| close(size.y, 0.1)));
    assert!(close(gate[0].1.x, 0.73) && close(gate[0].1.z, 0.54) && close(gate[2].1.z, 0.73));
    // No box of a gate protrudes into its opening.
    let free = gate.iter().all(|(middle, size)| {
        (middle.x - 1.0).abs() >= 0.5 * (size.x + 0.54) - 1e-12 || middle.z - 0.5 * size.z >= 0.54 - 1e-12
    });
    assert!(free);
    assert!(Obstacle::gate(0.86).body("gate", &Pose::identity()).unwrap().parts.len() == 3);
    for bad in [Obstacle::gate(0.0), Obstacle::gate(2.5), Obstacle::gate(f64::NAN)] {
        assert!(bad.body("gate", &Pose::identity()).is_err(), "{bad:?}");
    }
}
