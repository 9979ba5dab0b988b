//! The target as a physical object: mass, friction and frame.

use std::fs;
use std::io::{Write as _, stderr};
use std::path::{Path, PathBuf};

use cranny_scenario::{
    Credits, DEFAULT_FRICTION, Friction, ObjectError, ObjectSettings, ObjectType, OpenOptions,
    PAPER_FRICTION, Recipe, Scenario, ScenarioError, TargetObject, TargetPhysics, builtin_object, catalogue,
    check, pack,
};
use cranny_shape::{Surface, TriangleSoup, UnionMoments, VolumeMoments};
use cranny_spatial::{Pose, PoseDifference, Vector};

const AS_SAID: TargetPhysics = TargetPhysics { mass_kg: None, friction: None, rolling_m: None };

fn open(what: &str) -> Scenario {
    Scenario::open(what, &OpenOptions::default()).unwrap()
}

fn open_folder(folder: &Path) -> Scenario {
    open(folder.to_str().unwrap())
}

fn target(scenario: &Scenario) -> TargetObject {
    scenario.target_object(&AS_SAID).unwrap().expect("a target")
}

/// Creates a scenario with these lines below name and pose of its target, and below the name of its obstacle.
fn folder_with(target: &str, obstacle: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let corner = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/corner");
    for file in ["grasps.csv", "wedge.obj"] {
        fs::copy(corner.join(file), folder.path().join(file)).unwrap();
    }
    let text = format!(
        "robot: panda_mobile\n\
         frame: {{position: [1, 0, 0.05], rotation_rpy_deg: [0, 0, 90]}}\n\
         start: [0, 0, -0.0178, -0.7601, 0.0198, -2.3421, 0.0298, 1.5412, 0.7534]\n\
         floor: 0\n\
         obstacles:\n  - name: board\n    shapes:\n      - box: {{size: [0.1, 0.1, 0.1]}}\n{obstacle}\
         target:\n  name: thing\n  pose: {{position: [1, 1, 0.5], rotation_rpy_deg: [20, 0, 50]}}\n{target}"
    );
    fs::write(folder.path().join("scenario.yaml"), text).unwrap();
    folder
}

fn fault(target: &str, obstacle: &str) -> String {
    let folder = folder_with(target, obstacle);
    let what = folder.path().to_str().unwrap();
    let fault = Scenario::open(what, &OpenOptions::default()).unwrap_err().to_string();
    // A check for all faults reports this one first.
    let all: Vec<String> = check(what).unwrap().iter().map(ToString::to_string).collect();
    assert_eq!(all[0], fault);
    fault
}

const BOX: &str = "  shapes:\n    - box: {size: [0.04, 0.06, 0.1]}\n";

const TWO_BOXES: &str = "  shapes:\n    - box: {size: [0.04, 0.04, 0.1]}\n    - box: {size: [0.1, 0.02, 0.02]}\n      \
                         pose: {position: [0.08, 0, 0]}\n";

fn near(a: f64, b: f64, tolerance: f64) -> bool {
    (a - b).abs() <= tolerance * b.abs()
}

/// Asserts that the placed object coincides with the target's mesh: they have the same corners, and enclose the same volume.
fn stands_where_the_target_does(scenario: &Scenario, found: &TargetObject) {
    let expected = scenario.target_mesh().unwrap().expect("a target");
    let mut placed = TriangleSoup::default();
    placed.append(&found.object.mesh, &found.world_from_object);
    let is_among = |these: &TriangleSoup, those: &TriangleSoup| {
        these.vertices.iter().all(|v| those.vertices.iter().any(|w| (v - w).norm() < 2e-6))
    };
    assert!(is_among(&placed, &expected) && is_among(&expected, &placed), "{}", scenario.id);
    let volume_m3 = |soup: &TriangleSoup| VolumeMoments::of_mesh(soup).unwrap().volume_m3;
    assert!(near(volume_m3(&placed), volume_m3(&expected), 1e-6), "{}", scenario.id);
    // The volume of overlapping shapes counts once.
    let union_m3 = UnionMoments::of_mesh(&expected).unwrap().moments.volume_m3;
    assert!(near(found.object.volume_m3, union_m3, 1e-3), "{}", scenario.id);
}

/// Asserts that mass, friction, pose and inertia are the same.
fn same(one: &TargetObject, other: &TargetObject) {
    let apart = PoseDifference::between(&one.world_from_object, &other.world_from_object);
    assert!(apart.translation_m < 1e-9 && apart.rotation_rad < 1e-9, "{apart:?}");
    let numbers = |found: &TargetObject| [found.object.mass_kg, found.object.friction.low].map(f64::to_bits);
    assert_eq!(numbers(one), numbers(other));
    let largest = one.object.inertia_kg_m2.amax();
    assert!((one.object.inertia_kg_m2 - other.object.inertia_kg_m2).amax() < 1e-6 * largest);
    assert!((one.object.center_of_mass - other.object.center_of_mass).norm() < 1e-6);
    assert_eq!(one.object.parts.parts.len(), other.object.parts.parts.len());
}

#[test]
fn built_in_targets_weigh_what_is_published_and_stand_where_the_scenario_has_them() {
    let objects =
        [("011", "flat_screwdriver", 0.0984), ("021", "tennis_ball", 0.058), ("031", "sugar_box", 0.514)];
    for (id, name, mass_kg) in objects.into_iter().chain([("041", "banana", 0.066)]) {
        let scenario = open(id);
        let found = target(&scenario);
        assert!(near(found.object.mass_kg, mass_kg, 1e-12), "{id}: {}", found.object.mass_kg);
        assert!(near(found.object.friction.low, DEFAULT_FRICTION, 1e-12), "{id}");
        stands_where_the_target_does(&scenario, &found);
        assert!(!found.object.stable_poses.is_empty(), "{id}");
        // A target that is checked as a sphere or a box still has the mass and inertia of the object that it represents, in the
        // same frame: a sphere of triangles is a percent too small.
        let published = builtin_object(name).unwrap();
        let off = (found.object.inertia_kg_m2 - published.inertia_kg_m2).amax();
        assert!(off < 0.03 * published.inertia_kg_m2.amax(), "{id}: {off}");
        assert_eq!(found.object.parts.parts.len(), published.parts.parts.len(), "{id}");
    }
    for entry in catalogue() {
        let physics = open(entry.id).target_physics();
        assert!(
            physics.mass_kg.is_some() && physics.friction == Some(DEFAULT_FRICTION.into()),
            "{}",
            entry.id
        );
    }
}

#[test]
fn a_box_turns_as_the_textbook_says() {
    let folder = folder_with(&format!("{BOX}  mass_kg: 0.6\n"), "");
    let scenario = open_folder(folder.path());
    let found = target(&scenario);
    let moment = |b: f64, c: f64| 0.6 / 12.0 * (b * b + c * c);
    let expected = Vector::new(moment(0.06, 0.1), moment(0.04, 0.1), moment(0.04, 0.06));
    assert!((found.object.inertia_kg_m2.diagonal() - expected).amax() < 1e-9);
    assert!(found.object.center_of_mass.coords.norm() < 1e-12, "its frame is that of its only shape");
    assert!(near(found.object.friction.low, DEFAULT_FRICTION, 1e-12), "nobody says another");
    assert_eq!(scenario.target_physics(), TargetPhysics { mass_kg: Some(0.6), ..AS_SAID });
    stands_where_the_target_does(&scenario, &found);
}

#[test]
fn a_target_of_several_shapes_has_each_in_convex_parts_of_its_own() {
    let folder = folder_with(&format!("{TWO_BOXES}  mass_kg: 0.2\n"), "");
    let scenario = open_folder(folder.path());
    let found = target(&scenario);
    assert_eq!(found.object.parts.parts.len(), 2);
    let error = found.object.parts.error;
    assert!(error.excess < 0.01 && error.missing < 0.01, "{error:?}");
    // Its frame is the one that the file states for it, which the first box has as well.
    let first = scenario.world.bodies()[scenario.target.unwrap()].parts[0].world_from_solid;
    assert!((found.world_from_object.to_matrix() - first.to_matrix()).amax() < 1e-12);
    // It moves with the object.
    let moved = scenario.with_target_moved(&Pose::translation(0.1, 0.0, 0.2)).unwrap();
    let shift = target(&moved).world_from_object.translation.vector - first.translation.vector;
    assert!((shift - Vector::new(0.1, 0.0, 0.2)).norm() < 1e-12, "{shift}");
    stands_where_the_target_does(&scenario, &found);
    // The masses of the boxes are proportional to their volumes, 4 to 1; their centres are 0.08 m apart.
    let bodies = scenario.world.bodies();
    let middles: Vec<Vector> = bodies[scenario.target.unwrap()]
        .parts
        .iter()
        .map(|p| p.world_from_solid.translation.vector)
        .collect();
    let expected = (middles[0] * 4.0 + middles[1]) / 5.0;
    let center = found.world_from_object * found.object.center_of_mass;
    assert!((center.coords - expected).norm() < 1e-9, "{center}");
}

#[test]
fn what_the_scenario_says_goes_before_the_object_and_what_is_asked_before_both() {
    let folder = folder_with("  shapes:\n    - object: banana\n  mass_kg: 0.2\n  friction: 0.6\n", "");
    let scenario = open_folder(folder.path());
    let found = target(&scenario);
    assert_eq!((found.object.mass_kg, found.object.friction.low), (0.2, 0.6));
    let published = builtin_object("banana").unwrap();
    let scaled = published.inertia_kg_m2 * (0.2 / published.mass_kg);
    assert!((found.object.inertia_kg_m2 - scaled).amax() < 1e-15);
    assert_eq!(found.object.name, "banana");
    stands_where_the_target_does(&scenario, &found);

    let heavy = TargetPhysics { mass_kg: Some(1.5), ..AS_SAID };
    let found = scenario.target_object(&heavy).unwrap().expect("a target");
    assert_eq!((found.object.mass_kg, found.object.friction.low), (1.5, 0.6));
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        for scenario in [&scenario, &open("021")] {
            let mass = TargetPhysics { mass_kg: Some(bad), ..AS_SAID };
            let friction = TargetPhysics { friction: Some(bad.into()), ..AS_SAID };
            let fault = scenario.target_object(&mass).unwrap_err();
            assert!(
                matches!(fault, ScenarioError::Object(ObjectError::Number { what: "mass", .. })),
                "{fault}"
            );
            let fault = scenario.target_object(&friction).unwrap_err();
            assert!(
                matches!(fault, ScenarioError::Object(ObjectError::Number { what: "friction", .. })),
                "{fault}"
            );
        }
    }
}

/// A body that a task picks has the mass and friction of its object too, whether it is the target or an obstacle.
#[test]
fn an_obstacle_has_the_mass_of_its_object_unless_its_entry_states_one() {
    let banana = builtin_object("banana").unwrap();
    for (line, mass_kg) in [("", banana.mass_kg), ("    mass_kg: 0.3\n", 0.3)] {
        let fruit = format!(
            "  - name: fruit\n    pose: {{position: [0, 0, 0.3]}}\n    shapes: [{{object: banana}}]\n{line}"
        );
        let folder = folder_with(BOX, &fruit);
        let scenario = open_folder(folder.path());
        let fruit = scenario.world.body_index("fruit").unwrap();
        let stated = scenario.physics_of(fruit);
        assert_eq!((stated.mass_kg, stated.friction), (Some(mass_kg), Some(DEFAULT_FRICTION.into())));
        let picked = scenario.with_target("fruit").unwrap();
        assert_eq!(picked.target_physics(), stated);
        let object = target(&picked).object;
        assert!((object.mass_kg - mass_kg).abs() < 1e-15);
        // Its frame and its mass survive the files of another folder.
        let copy = tempfile::tempdir().unwrap();
        Recipe::of_scenario(&scenario).unwrap().write_folder(copy.path()).unwrap();
        let again = open_folder(copy.path());
        assert_eq!(again.physics_of(again.world.body_index("fruit").unwrap()).mass_kg, Some(mass_kg));
    }
}

#[test]
fn a_target_without_a_mass_and_a_scenario_without_a_target() {
    let scenario = open_folder(folder_with(BOX, "").path());
    let fault = scenario.target_object(&AS_SAID).unwrap_err();
    assert!(matches!(fault, ScenarioError::Object(ObjectError::NoMass { .. })));
    let text = fault.to_string();
    assert!(text.contains("the mass of 'thing'") && text.contains("add mass_kg to its entry"), "{text}");
    let light = TargetPhysics { mass_kg: Some(0.1), ..AS_SAID };
    assert!(scenario.target_object(&light).unwrap().is_some());
    for id in ["011", "021"] {
        let scenario = open(id);
        let name = scenario.world.bodies()[scenario.target.unwrap()].name.clone();
        let without = scenario.without_body(&name).unwrap();
        assert!(without.target_object(&AS_SAID).unwrap().is_none());
        assert_eq!(without.target_physics(), AS_SAID);
    }
}

#[test]
fn numbers_that_are_none_are_refused_with_their_line() {
    let line = |key: &str| format!("{BOX}  {key}\n");
    for (key, expected) in [
        ("mass_kg: -1", "scenario.yaml:14: the mass of an object must be a positive number, but is -1"),
        ("mass_kg: 0", "scenario.yaml:14: the mass of an object must be a positive number, but is 0"),
        ("mass_kg: .nan", "scenario.yaml:14: 'NaN' is not a finite number"),
        ("mass_kg: .inf", "scenario.yaml:14: 'inf' is not a finite number"),
        ("friction: -0.2", "scenario.yaml:14: the friction of an object must be a positive number"),
        ("friction: .nan", "scenario.yaml:14: '.nan' is not a finite number"),
        (
            "friction: [0.6, 0.35]",
            "scenario.yaml:14: a range of friction goes from its lower end to its upper one",
        ),
        ("friction: [0, 0.35]", "scenario.yaml:14: the friction of an object must be a positive number"),
        ("friction: [0.3, .nan]", "scenario.yaml:14: 'NaN' is not a finite number"),
        ("friction: [0.3]", "scenario.yaml:14: "),
        ("friction: [0.3, 0.4, 0.5]", "scenario.yaml:14: "),
        ("friction: slippery", "scenario.yaml:14: "),
        ("mass: 1", "scenario.yaml:14: unknown field `mass`"),
        ("mass_kg: heavy", "scenario.yaml:14: "),
    ] {
        let said = fault(&line(key), "");
        assert!(said.contains(expected) && !said.contains('\n'), "{key}\n  said: {said}\n  not:  {expected}");
    }
}

/// Loads take the lower end of a range, and what is written states both.
#[test]
fn a_friction_may_be_a_range() {
    let folder = folder_with(&format!("{BOX}  mass_kg: 0.2\n  friction: [0.35, 0.6]\n"), "");
    let scenario = open_folder(folder.path());
    let range = Friction { low: 0.35, high: 0.6 };
    assert_eq!(scenario.target_physics().friction, Some(range));
    assert_eq!(scenario.target_physics().least_friction(), Some(0.35));
    let object = scenario.target_object(&AS_SAID).unwrap().unwrap().object;
    assert_eq!(object.friction, range);
    let written = tempfile::tempdir().unwrap();
    object.write_folder(written.path()).unwrap();
    assert_eq!(ObjectType::read_folder(written.path()).unwrap().friction, range);
    assert_eq!("0.35..0.6".parse(), Ok(range));
    assert!("0.6..0.35".parse::<Friction>().is_err() && "x".parse::<Friction>().is_err());
}

#[test]
fn an_obstacle_may_have_a_mass() {
    let folder = folder_with(BOX, "    mass_kg: 0.2\n    friction: 0.3\n");
    let scenario = open_folder(folder.path());
    let physics = scenario.with_target("board").unwrap().target_physics();
    assert_eq!(physics, TargetPhysics { mass_kg: Some(0.2), friction: Some(0.3.into()), rolling_m: None });
    for (key, line) in [("mass", "mass_kg: -1"), ("friction", "friction: 0")] {
        let said = fault(BOX, &format!("    {line}\n"));
        assert!(said.contains("scenario.yaml:9: ") && said.contains(key), "{said}");
    }
}

#[test]
fn a_written_folder_has_the_same_target() {
    let root = tempfile::tempdir().unwrap();
    let several = folder_with(&format!("{TWO_BOXES}  mass_kg: 0.1\n  friction: 0.7\n"), "");
    let banana = folder_with("  shapes:\n    - object: banana\n  friction: 0.7\n", "");
    let scenarios = ["011", "021", "031", "041"].map(open).into_iter();
    for (index, scenario) in
        scenarios.chain([several, banana].map(|folder| open_folder(folder.path()))).enumerate()
    {
        let folder = root.path().join(index.to_string());
        scenario.write_folder(&folder).unwrap();
        let read = open_folder(&folder);
        assert_eq!(read.given_physics, scenario.given_physics);
        same(&target(&scenario), &target(&read));
    }
    // A built-in object is referenced by name again, not written out.
    assert!(
        fs::read_to_string(root.path().join("0/scenario.yaml")).unwrap().contains("object: flat_screwdriver")
    );
    // A recipe without files has the same values.
    let scenario = open("021");
    let recipe = Recipe::of_scenario(&scenario).unwrap();
    assert_eq!(recipe.target_physics(), scenario.target_physics());
    same(&target(&scenario), &target(&recipe.scenario("021", &OpenOptions::default()).unwrap()));
}

#[test]
fn an_object_of_ones_own_comes_along_in_folders_and_archives() {
    let folder = folder_with("  shapes:\n    - object: hammer\n      pose: {position: [0, 0, 0.1]}\n", "");
    let settings = ObjectSettings { friction: 0.4.into(), ..ObjectSettings::new("hammer", 0.8) };
    let soup = Surface::cuboid_soup(&Vector::new(0.01, 0.02, 0.1));
    let mut hammer = ObjectType::from_mesh(&soup, &settings).unwrap().0;
    // The head is heavier than the rest, which no mesh shows.
    hammer.center_of_mass.z = 0.06;
    hammer.write_folder(&folder.path().join("hammer")).unwrap();
    let scenario = open_folder(folder.path());
    let found = target(&scenario);
    assert_eq!(
        (found.object.mass_kg, found.object.friction.low, found.object.center_of_mass.z),
        (0.8, 0.4, 0.06)
    );
    stands_where_the_target_does(&scenario, &found);

    let root = tempfile::tempdir().unwrap();
    let written: PathBuf = root.path().join("written");
    scenario.write_folder(&written).unwrap();
    same(&found, &target(&open_folder(&written)));
    let archive = root.path().join("packed.zip");
    pack(&written, &archive, &Credits::default()).unwrap();
    let packed = open_folder(&archive);
    same(&found, &target(&packed));

    let shift = Pose::translation(0.1, 0.0, 0.2);
    let moved = target(&packed.with_target_moved(&shift).unwrap());
    let apart = PoseDifference::between(&moved.world_from_object, &(shift * found.world_from_object));
    assert!(apart.translation_m < 1e-9 && apart.rotation_rad < 1e-9, "{apart:?}");
}

/// Returns the folder of the released data; `None`, with a message, if there is none.
fn data() -> Option<PathBuf> {
    let data = std::env::var_os("CRANNY_DATA").map(PathBuf::from);
    if data.is_none() {
        assert!(std::env::var_os("CRANNY_REQUIRE_ALL").is_none(), "CRANNY_DATA is not set");
        let _ = writeln!(stderr(), "SKIPPED: CRANNY_DATA is not set, so no released target is weighed");
    }
    data.map(|data| data.join("jogramop"))
}

#[test]
fn released_targets_weigh_what_their_library_says() {
    let Some(data) = data() else { return };
    let root = tempfile::tempdir().unwrap();
    for (id, mass_kg) in [("011", 0.2), ("021", 0.2), ("031", 0.4), ("041", 0.2)] {
        let source = data.join("scenarios").join(id);
        let scenario = open_folder(&source);
        assert_eq!(
            scenario.target_physics(),
            TargetPhysics { mass_kg: Some(mass_kg), friction: Some(PAPER_FRICTION.into()), rolling_m: None }
        );
        let found = target(&scenario);
        stands_where_the_target_does(&scenario, &found);
        let error = found.object.parts.error;
        assert!(error.excess < 0.1 && error.missing < 0.05, "{id}: {error:?}");

        let own = root.path().join("own").join(id);
        Recipe::import_released(&source).unwrap().write_folder(&own).unwrap();
        let imported = open_folder(&own);
        same(&found, &target(&imported));
        let released = root.path().join("scenarios").join(id);
        Recipe::of_scenario(&imported).unwrap().write_released(&released).unwrap();
        assert_eq!(open_folder(&released).target_physics(), scenario.target_physics());
    }
}

#[test]
fn a_library_may_leave_the_mass_out_but_say_none_that_is_negative() {
    let root = tempfile::tempdir().unwrap();
    let folder = root.path().join("021");
    Recipe::of_scenario(&open("021")).unwrap().write_released(&folder).unwrap();
    let physics = open_folder(&folder).target_physics();
    assert_eq!(
        physics,
        TargetPhysics { mass_kg: Some(0.058), friction: Some(DEFAULT_FRICTION.into()), rolling_m: None }
    );
    let library = folder.join("object_library/object_library.yaml");
    let text = fs::read_to_string(&library).unwrap();
    assert!(text.contains("  mass: 0.058\n"));
    for silent in ["", "  mass: 0\n", "  mass: null\n"] {
        fs::write(&library, text.replace("  mass: 0.058\n", silent)).unwrap();
        assert_eq!(open_folder(&folder).target_physics().mass_kg, None, "{silent}");
    }
    for bad in ["-1", ".nan"] {
        fs::write(&library, text.replace("mass: 0.058", &format!("mass: {bad}"))).unwrap();
        let what = folder.to_str().unwrap();
        let fault = Scenario::open(what, &OpenOptions::default()).unwrap_err().to_string();
        assert!(fault.contains("object_library.yaml:6: "), "{fault}");
    }
}
