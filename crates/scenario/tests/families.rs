//! Families with a difficulty parameter, and large sets.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use cranny_collision::{Collider, Margins};
use cranny_grasp::GraspSet;
use cranny_scenario::{
    Family, OpenOptions, RecipeRobot, Scenario, SetMaker, SetProgress, SetReport, SetSettings, check,
    write_set, write_sweep,
};
use cranny_shape::overlap;
use cranny_spatial::Pose;
use strum::VariantArray as _;

fn watched(write: impl FnOnce(&SetProgress) -> SetReport) -> SetReport {
    write(&SetProgress { done: &|| (), stop: &AtomicBool::new(false) })
}

/// Returns a maker for the paper's robot.
fn maker(family: Family, change: impl FnOnce(SetSettings) -> SetSettings) -> SetMaker {
    let robot = RecipeRobot::of_the_paper().unwrap();
    let settings = change(SetSettings::new(family, &robot, 0));
    SetMaker::new(family, robot, settings, |_| unreachable!("nothing is demanded of the paper's arm"))
        .unwrap()
}

fn set(family: Family, seed: u64, count: u64, folder: &Path) -> SetReport {
    let maker = maker(family, |settings| SetSettings { seed, ..settings });
    watched(|progress| write_set(&maker, folder, count, progress).unwrap())
}

/// All files below a folder.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut all = BTreeMap::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            all.extend(files(&path));
        } else {
            all.insert(path.display().to_string(), fs::read(&path).unwrap());
        }
    }
    all
}

/// Returns true if the target penetrates no other body by more than the millimetre that is permitted for its support.
fn rests_beside_everything(scenario: &Scenario) -> bool {
    let target = scenario.target.unwrap();
    let bodies = scenario.world.bodies();
    let others = bodies.iter().enumerate().filter(|(index, _)| *index != target);
    others.flat_map(|(_, body)| &body.parts).all(|part| {
        bodies[target].parts.iter().all(|own| {
            overlap(&own.solid, &own.world_from_solid, &part.solid, &part.world_from_solid)
                .is_none_or(|overlap| overlap.depth_m < 1e-3)
        })
    })
}

#[test]
fn every_scenario_of_a_set_opens_with_a_free_start_and_a_free_grasp() {
    let root = tempfile::tempdir().unwrap();
    for &family in Family::VARIANTS {
        let folder = root.path().join(family.name());
        let report = set(family, 7, 12, &folder);
        assert_eq!((report.written.len(), report.missing), (12, 0), "{family:?}");
        for id in &report.written {
            let path = folder.join(id).display().to_string();
            assert!(check(&path).unwrap().is_empty());
            let scenario = Scenario::open(&path, &OpenOptions::default()).unwrap();
            assert!(rests_beside_everything(&scenario), "{path}");
            let problem = scenario.problem(Margins::default()).unwrap();
            assert!(problem.start_is_free(), "{path}");
            let cell = problem.cell().expect("exact is the default");
            let mut scratch = cell.scratch();
            // The link that carries the hand may collide. It is checked after the hand.
            let hand = scenario.robot.hand_links();
            assert!(scenario.grasps.grasps().iter().all(|grasp| {
                [grasp.world_from_gripper, grasp.twin().world_from_gripper].iter().any(|pose| {
                    let contact = cell.hand_contact(pose, &mut scratch);
                    contact.is_none_or(
                        |contact| !matches!(contact.first, Collider::Link(link) if hand.contains(&link)),
                    )
                })
            }));
        }
    }
}

#[test]
fn the_same_seed_gives_the_same_bytes_on_any_number_of_threads() {
    let root = tempfile::tempdir().unwrap();
    let folder = root.path().join("set");
    let mut seen = Vec::new();
    for threads in [1, 2, 5] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| set(Family::Gap, 3, 10, &folder));
        seen.push(files(&folder));
        fs::remove_dir_all(&folder).unwrap();
    }
    assert!(seen[0].len() > 20 && seen[0] == seen[1] && seen[0] == seen[2]);
    set(Family::Gap, 4, 10, &folder);
    assert_ne!(files(&folder), seen[0]);
}

/// Makes a set and stops after some members.
fn stopped_set(maker: &SetMaker, folder: &Path, count: u64, after: usize) -> SetReport {
    let (stop, finished) = (AtomicBool::new(false), AtomicUsize::new(0));
    let done = || stop.store(finished.fetch_add(1, Ordering::Relaxed) + 1 >= after, Ordering::Relaxed);
    write_set(maker, folder, count, &SetProgress { done: &done, stop: &stop }).unwrap()
}

/// A stopped set used to be refused by its own repetition, and a killed one left a hidden folder.
#[test]
fn a_stopped_set_goes_on_where_it_was_and_is_the_same() {
    let root = tempfile::tempdir().unwrap();
    let whole = root.path().join("whole");
    let folder = root.path().join("set");
    let maker = maker(Family::Gap, |settings| settings);
    let expected = watched(|progress| write_set(&maker, &whole, 8, progress).unwrap());
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let report = pool.install(|| stopped_set(&maker, &folder, 8, 3));
    assert_eq!((report.written.len(), report.missing), (3, 5));
    let unfinished = report.unfinished.expect("the folder of the three");
    let content = unfinished.join("set");
    assert!(!folder.exists() && content.join(&report.written[0]).is_dir());
    // Killed while it wrote a member, and a line of the list.
    let list = unfinished.join("unfinished.jsonl");
    let text = fs::read_to_string(&list).unwrap();
    fs::write(&list, text.clone() + "{\"number\": 7, \"li").unwrap();
    fs::create_dir(content.join("gap-00007")).unwrap();
    fs::write(content.join("gap-00007/half"), "written").unwrap();
    // A finished member is not made again.
    let kept = content.join(&report.written[0]).join("kept");
    fs::write(kept, "").unwrap();
    let report = watched(|progress| write_set(&maker, &folder, 8, progress).unwrap());
    assert_eq!(report, expected);
    fs::remove_file(folder.join(&report.written[0]).join("kept")).unwrap();
    let of = |folder: &Path| {
        let strip = |(name, content): (String, Vec<u8>)| {
            (name.strip_prefix(folder.to_str().unwrap()).unwrap().to_owned(), content)
        };
        files(folder).into_iter().map(strip).collect::<BTreeMap<_, _>>()
    };
    assert!(of(&folder) == of(&whole));
    assert_eq!(fs::read_dir(root.path()).unwrap().count(), 2);
}

#[test]
fn only_the_same_set_goes_on_and_only_once_at_a_time() {
    let root = tempfile::tempdir().unwrap();
    let folder = root.path().join("set");
    let maker = maker(Family::Gap, |settings| settings);
    let unfinished = stopped_set(&maker, &folder, 4, 1).unfinished.expect("a folder");
    let other = stopped_set(&maker, &folder, 5, 1).unfinished.expect("a folder");
    assert_ne!(unfinished, other);
    let progress = SetProgress { done: &|| (), stop: &AtomicBool::new(false) };
    let again = || write_set(&maker, &folder, 4, &progress).map_err(|fault| fault.to_string());
    let list = fs::File::open(unfinished.join("unfinished.jsonl")).unwrap();
    list.lock().unwrap();
    assert!(again().unwrap_err().contains("another program is making the same scenarios"));
    drop(list);
    // The folder of another program is neither used nor removed.
    fs::write(unfinished.join("unfinished.jsonl"), "mine\n").unwrap();
    assert!(again().unwrap_err().contains("exists already"));
    assert!(unfinished.join("set/gap-00000").is_dir() && !folder.exists());
    // Killed before the first line, and before the list.
    for has_list in [true, false] {
        fs::remove_dir_all(&unfinished).unwrap();
        fs::create_dir(&unfinished).unwrap();
        if has_list {
            fs::write(unfinished.join("unfinished.jsonl"), "{\"format\": \"cran").unwrap();
        }
        assert_eq!(again().unwrap().written.len(), 4);
        assert!(!unfinished.exists());
        fs::remove_dir_all(&folder).unwrap();
        fs::create_dir(&unfinished).unwrap();
    }
}

/// The name of an unfinished set can be computed by anybody, who may put a link or other content there.
#[test]
fn nothing_is_made_in_the_folder_of_another_or_left_where_there_was_none() {
    let root = tempfile::tempdir().unwrap();
    let folder = root.path().join("a/b/set");
    let maker = maker(Family::Gap, |settings| settings);
    let unfinished = stopped_set(&maker, &folder, 4, 1).unfinished.expect("a folder");
    let progress = SetProgress { done: &|| (), stop: &AtomicBool::new(false) };
    let again = || write_set(&maker, &folder, 4, &progress).map_err(|fault| fault.to_string());
    fs::remove_dir_all(&unfinished).unwrap();
    fs::create_dir(&unfinished).unwrap();
    fs::write(unfinished.join("theirs"), "").unwrap();
    assert!(again().unwrap_err().contains("exists already"));
    assert_eq!(fs::read_dir(&unfinished).unwrap().count(), 1);
    #[cfg(unix)]
    {
        let victim = root.path().join("victim");
        fs::create_dir(&victim).unwrap();
        fs::remove_dir_all(&unfinished).unwrap();
        std::os::unix::fs::symlink(&victim, &unfinished).unwrap();
        assert!(again().unwrap_err().contains("exists already"));
        assert_eq!(fs::read_dir(&victim).unwrap().count(), 0);
        fs::remove_dir(&victim).unwrap();
    }
    // Stopped before the first member.
    fs::remove_dir_all(root.path().join("a")).unwrap();
    let stopped = SetProgress { done: &|| (), stop: &AtomicBool::new(true) };
    assert_eq!(write_set(&maker, &folder, 4, &stopped).unwrap().unfinished, None);
    assert_eq!(fs::read_dir(root.path()).unwrap().count(), 0);
    // Killed after the set was complete, before the list was removed.
    assert_eq!(again().unwrap().written.len(), 4);
    let list = unfinished.join("unfinished.jsonl");
    fs::create_dir(&unfinished).unwrap();
    fs::write(list, "").unwrap();
    assert!(again().unwrap_err().contains("exists already"));
    assert!(!unfinished.exists() && !folder.join("unfinished.jsonl").exists());
}

/// A stopped set went on with the members of the robot as it was before.
#[test]
fn a_set_does_not_go_on_with_a_changed_robot() {
    let root = tempfile::tempdir().unwrap();
    let urdf = RecipeRobot::of_the_paper().unwrap().write(&root.path().join("robot")).unwrap();
    let mesh = urdf.with_file_name("triangle.obj");
    let text = fs::read_to_string(&urdf).unwrap();
    let (begin, rest) = text.split_once("</link>").unwrap();
    let visual = "<visual><geometry><mesh filename=\"triangle.obj\"/></geometry></visual>";
    let unfinished = || {
        let robot = RecipeRobot::load(&urdf).unwrap();
        let settings = SetSettings::new(Family::Gap, &robot, 0);
        let maker = SetMaker::new(Family::Gap, robot, settings, |_| Ok(true)).unwrap();
        stopped_set(&maker, &root.path().join("set"), 12, 1).unfinished.expect("a folder")
    };
    fs::write(&urdf, format!("{begin}{visual}</link>{rest}")).unwrap();
    fs::write(&mesh, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    let first = unfinished();
    assert_eq!(unfinished(), first);
    fs::write(&mesh, "v 0 0 0\nv 2 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    let second = unfinished();
    fs::write(&urdf, format!("{begin}{visual}</link>{rest}<!-- changed -->")).unwrap();
    assert!(first != second && unfinished() != first && unfinished() != second);
}

#[test]
fn a_sweep_goes_from_one_value_to_the_other() {
    let root = tempfile::tempdir().unwrap();
    let folder = root.path().join("sweep");
    let maker = maker(Family::Gap, |settings| settings);
    let report = watched(|p| write_sweep(&maker, &folder, [0.64, 0.30], 18, p).unwrap());
    assert_eq!((report.written.len(), report.rejected.total()), (18, 0));
    assert_eq!((report.written[0].as_str(), report.written[17].as_str()), ("gap-0.6400", "gap-0.3000"));
    let index = fs::read_to_string(folder.join("index.csv")).unwrap();
    assert_eq!(index.lines().count(), 19);
    let again = watched(|p| write_sweep(&maker, &root.path().join("one"), [0.4, 0.4], 1, p).unwrap());
    assert_eq!(again.written, ["gap-0.4000"]);
    let stop = AtomicBool::new(false);
    let progress = SetProgress { done: &|| (), stop: &stop };
    let fault = write_sweep(&maker, &folder, [0.64, 0.3], 2, &progress).unwrap_err().to_string();
    assert!(fault.contains("exists already"), "{fault}");
    let elsewhere = root.path().join("never");
    let fault = write_sweep(&maker, &elsewhere, [2.5, 0.3], 2, &progress).unwrap_err().to_string();
    assert!(fault.contains("the gap must be from 0.02 to 1.9 m, but is 2.5"), "{fault}");
    assert!(!elsewhere.exists());
}

#[test]
fn draws_that_are_not_sound_are_counted_by_reason() {
    let maker = maker(Family::Shelf, |settings| SetSettings { most_clutter: 12, seed: 1, ..settings });
    let mut rejected = cranny_scenario::Rejections::default();
    for index in 0..20 {
        let (_, more) = maker.member(index).unwrap();
        rejected = rejected.plus(more);
    }
    assert!(rejected.things_overlap > 0, "{rejected:?}");
    let mut recipe = maker.family().at(0.2).unwrap();
    assert_eq!(maker.rejection(&recipe).unwrap(), None);
    recipe.grasps = GraspSet::default();
    assert_eq!(maker.rejection(&recipe).unwrap().map(|rejection| rejection.no_free_grasp), Some(1));
    recipe.obstacles[0].scene_from_body = Pose::identity();
    assert_eq!(maker.rejection(&recipe).unwrap().map(|rejection| rejection.start_collides), Some(1));
    assert!(Family::of_name("cupboard").unwrap_err().to_string().contains("shelf, table, gap, gate"));
}
