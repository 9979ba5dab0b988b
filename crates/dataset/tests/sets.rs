//! Sets: the same bytes in shards, after a stop, and every false row found.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use cranny_dataset::{
    CheckReport, CheckedRows, DatasetCameras, DatasetError, DatasetFolder, DatasetRecipe, DatasetShard,
    DatasetStatistics, Demonstration, DemonstrationTask, FamilyRange, GRASP_RESULTS, GenerateProgress,
    GenerateReport, GraspReasons, PLAN_FILE, check, export_lerobot, extract, generate, merge,
};
use cranny_path::AuditSettings;
use cranny_record::{PlanFile, PlanSource};
use cranny_scenario::{OpenOptions, RecipeRobot, Scenario};
use cranny_task::{IkAnnotationSettings, IkStatus, annotate_ik};

/// A recipe of 260 rows in 130 scenes, three chunks, of the two families that are fast.
fn recipe() -> DatasetRecipe {
    let family = |name: &str| FamilyRange { family: name.to_owned(), parameter_m: None };
    DatasetRecipe {
        count: 259,
        seed: 7,
        queries_per_scene: 2,
        families: ["gap", "table"].map(family).to_vec(),
        tasks: BTreeMap::from([
            (DemonstrationTask::Reach, 14.0),
            (DemonstrationTask::Carry, 1.0),
            (DemonstrationTask::Place, 1.0),
        ]),
        ..DatasetRecipe::default()
    }
}

fn made(recipe: &DatasetRecipe, shard: Option<DatasetShard>, folder: &Path) -> GenerateReport {
    let stop = AtomicBool::new(false);
    let progress = GenerateProgress { done: &|_, _| {}, stop: &stop, threads: 2 };
    generate(recipe, shard, folder, &progress).unwrap()
}

fn checked(folder: &DatasetFolder) -> CheckReport {
    check(folder, CheckedRows::All, &|_| {}, &AtomicBool::new(false)).unwrap()
}

/// Content of all files of a folder, by their names in it.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut files = BTreeMap::new();
    let mut left = vec![folder.to_owned()];
    while let Some(next) = left.pop() {
        for entry in fs::read_dir(next).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                left.push(path);
            } else {
                files.insert(
                    path.strip_prefix(folder).unwrap().display().to_string(),
                    fs::read(&path).unwrap(),
                );
            }
        }
    }
    files
}

/// A sample of all rows never ended, since the same chunk was counted twice.
#[test]
fn another_spelling_of_a_chunk_is_no_chunk() {
    let place = tempfile::tempdir().unwrap();
    let recipe = DatasetRecipe { count: 4, ..recipe() };
    made(&recipe, None, place.path());
    for part in ["scenes", "demonstrations"] {
        let chunk = |name: &str| place.path().join(part).join(name);
        fs::copy(chunk("000000.parquet"), chunk("0000000.parquet")).unwrap();
    }
    let folder = DatasetFolder::open(place.path()).unwrap();
    let report = check(&folder, CheckedRows::Sample(8, 1), &|_| {}, &AtomicBool::new(false)).unwrap();
    assert_eq!((report.checked, report.faults), (4, Vec::new()));
}

#[test]
fn shards_and_resumed_runs_give_the_bytes_of_one_process() {
    let place = tempfile::tempdir().unwrap();
    let recipe = recipe();
    let at = |name: &str| place.path().join(name);
    let report = made(&recipe, None, &at("whole"));
    assert!(
        report.is_complete && report.rows == 259 && report.known == 0 && report.solved > 240,
        "{report:?}"
    );
    let whole = files(&at("whole"));
    assert_eq!(whole.len(), 2 + 2 * 3);

    // Two shards, merged.
    let shards: Vec<_> = (1..=2).map(|index| DatasetShard { index, of: 2 }).collect();
    for shard in &shards {
        made(&recipe, Some(*shard), &at(&format!("part {}", shard.index)));
    }
    let parts = [at("part 2"), at("part 1")];
    merge(&parts, &at("merged"), &mut || {}).unwrap();
    assert_eq!(files(&at("merged")), whole);
    let fault = |parts: &[std::path::PathBuf]| merge(parts, &at("no"), &mut || {}).unwrap_err().to_string();
    assert!(fault(&parts[..1]).contains("shard 1/2 is missing"));
    assert!(fault(&[parts[0].clone(), parts[0].clone()]).contains("which is given twice"));
    assert!(fault(&[parts[0].clone(), at("whole")]).contains("of another data set"));

    // A run that is stopped, with what a kill may leave, and continued.
    let stopped = at("stopped");
    let (stop, rows) = (AtomicBool::new(false), AtomicU64::new(0));
    let done = |more: u64, _: u64| {
        if rows.fetch_add(more, Ordering::Relaxed) > 150 {
            stop.store(true, Ordering::Relaxed);
        }
    };
    let progress = GenerateProgress { done: &done, stop: &stop, threads: 1 };
    let report = generate(&recipe, None, &stopped, &progress).unwrap();
    assert!(!report.is_complete && report.rows == 128, "{report:?}");
    fs::write(stopped.join("demonstrations/000002.parquet"), b"half of a file").unwrap();
    let report = made(&recipe, None, &stopped);
    assert_eq!((report.known, report.rows, report.is_complete), (128, 131, true));
    assert_eq!(files(&stopped), whole);

    // Another recipe does not write into the folder.
    let other = DatasetRecipe { seed: 8, ..recipe };
    let progress = GenerateProgress { done: &|_, _| {}, stop: &AtomicBool::new(false), threads: 1 };
    let fault = generate(&other, None, &stopped, &progress).unwrap_err();
    assert!(matches!(fault, DatasetError::OtherDataset { .. }), "{fault}");
}

#[test]
fn all_rows_are_true_and_a_changed_one_is_found() {
    let place = tempfile::tempdir().unwrap();
    let folder = place.path().join("set");
    let recipe = DatasetRecipe { count: 40, queries_per_scene: 4, ..recipe() };
    let tasks = DemonstrationTask::Reach;
    let recipe = DatasetRecipe {
        tasks: BTreeMap::from([
            (tasks, 2.0),
            (DemonstrationTask::Carry, 1.0),
            (DemonstrationTask::Place, 1.0),
        ]),
        hold: Some(1.5),
        ..recipe
    };
    made(&recipe, None, &folder);
    let set = DatasetFolder::open(&folder).unwrap();
    let report = checked(&set);
    assert_eq!((report.checked, &report.faults[..]), (40, &[][..]));
    let statistics = DatasetStatistics::of(&set, &mut || {}).unwrap();
    assert_eq!((statistics.rows, statistics.solved), (40, report.proven));
    assert!(report.proven > 30 && statistics.bytes / 40 < 3000, "{statistics:?}");

    // Files with one value changed: a way point, a clearance, a grasp, the pose of an object.
    let [demonstrations, scenes] = set.files(0);
    let (sound, sound_scenes) = (fs::read(&demonstrations).unwrap(), fs::read(&scenes).unwrap());
    let chunk = set.read(0).unwrap();
    let row = chunk.demonstrations.iter().find(|row| row.is_solved() && row.waypoints.len() >= 27).unwrap();
    for (value, in_scenes) in [
        (row.waypoints[10], false),
        (row.clearance_m, false),
        (row.path_length, false),
        (row.grasp_pose[3], false),
        (chunk.scenes[0].placement[0], true),
        (chunk.scenes[0].target_pose[1], true),
    ] {
        let (file, sound) = if in_scenes { (&scenes, &sound_scenes) } else { (&demonstrations, &sound) };
        let bytes = value.to_le_bytes();
        let at = sound.windows(8).position(|window| window == bytes).unwrap();
        let mut other = sound.clone();
        other[at..at + 8].copy_from_slice(&(value + 1e-7).to_le_bytes());
        fs::write(file, &other).unwrap();
        assert!(!checked(&set).faults.is_empty(), "{value}");
        fs::write(file, sound).unwrap();
    }
    assert_eq!(checked(&set).faults, []);

    // Each task can be extracted, and is verified as any other plan.
    for task in ["reach", "carry", "place"] {
        let row = chunk.demonstrations.iter().find(|row| row.is_solved() && row.task == task).unwrap();
        let into = place.path().join(task);
        extract(&set, row.row, &into).unwrap();
        let scenario = Scenario::open(&into.display().to_string(), &OpenOptions::default()).unwrap();
        let problem = scenario.problem(recipe.margins()).unwrap();
        let plan = PlanFile::read(&into.join(PLAN_FILE)).unwrap();
        let source = PlanSource { scenario: task.to_owned(), ..PlanSource::default() };
        let judgement = plan.judge(&source, &problem, AuditSettings::default()).unwrap().unwrap();
        // Text rounds the pose of the object, and with it how unevenly the fingers close on it.
        let differs = judgement.differs.iter().filter(|statement| !statement.key.ends_with("uneven_m"));
        let differs: Vec<_> = differs.collect();
        assert!(judgement.audit.valid && differs.is_empty(), "{task}: {differs:?}");
        assert_eq!(plan.waypoints.concat(), row.waypoints);
    }
    let fault = extract(&set, 40, &place.path().join("none")).unwrap_err().to_string();
    assert!(fault.contains("row 40 is not there: the data set has the rows from 0 to 39"), "{fault}");

    // The export has a frame for each sample of each trajectory.
    let into = place.path().join("lerobot");
    let export = export_lerobot(&set, 10.0, &into, &mut || {}).unwrap();
    let solved = chunk.demonstrations.iter().filter(|row| row.is_solved());
    let frames: f64 = solved.map(|row| (row.duration_s * 10.0).ceil() + 1.0).sum();
    assert_eq!((export.episodes, export.frames.to_string()), (report.proven, frames.to_string()));
    assert!(into.join("meta/info.json").exists() && into.join("data/chunk-000/file-000.parquet").exists());

    // A damaged file is an error with its name.
    fs::write(&demonstrations, &sound[..sound.len() - 9]).unwrap();
    let fault = set.read(0).unwrap_err().to_string();
    assert!(fault.contains("000000.parquet: the file is damaged"), "{fault}");
}

/// A description with numbers that no recipe may state; none of them is believed.
#[test]
fn a_false_description_is_refused() {
    let place = tempfile::tempdir().unwrap();
    let folder = place.path().join("set");
    made(&DatasetRecipe { count: 3, ..recipe() }, None, &folder);
    let description = folder.join("dataset.json");
    let sound_text = fs::read_to_string(&description).unwrap();
    let number = |key: &str, value: &str| {
        let at = sound_text.find(&format!("\"{key}\": ")).expect("the key") + key.len() + 4;
        let end = at + sound_text[at..].find([',', '\n']).expect("its end");
        format!("{}{value}{}", &sound_text[..at], &sound_text[end..])
    };
    let shard = |shard: &str| sound_text.replacen('{', &format!("{{\"shard\": {shard},"), 1);
    for (text, expected) in [
        (number("count", "0"), "`count`"),
        (number("count", "1000000000000000000"), "`count`"),
        (number("queries_per_scene", "0"), "`queries_per_scene`"),
        (number("scenes_per_chunk", "0"), "`scenes_per_chunk`"),
        (number("rate_hz", "-1"), "`rate_hz`"),
        (number("margin_m", "1e300"), "`margin_m`"),
        (shard("{\"index\": 0, \"of\": 0}"), "no shard 0/0"),
        (shard("{\"index\": 1, \"of\": 1000000000000000000}"), "no shard"),
    ] {
        fs::write(&description, text).unwrap();
        let fault = DatasetFolder::open(&folder).unwrap_err().to_string();
        assert!(fault.contains("dataset.json") && fault.contains(expected), "{fault}");
    }
    // A count that the files do not reach costs no time.
    fs::write(&description, number("count", "1000000000000")).unwrap();
    let claimed = DatasetFolder::open(&folder).unwrap();
    assert!(check(&claimed, CheckedRows::Sample(3, 0), &|_| {}, &AtomicBool::new(false)).is_err());
}

#[test]
fn pictures_and_reasons_change_no_row_and_a_false_picture_is_found() {
    let place = tempfile::tempdir().unwrap();
    let at = |name: &str| place.path().join(name);
    let plain = DatasetRecipe { count: 12, queries_per_scene: 3, ..recipe() };
    let full = DatasetRecipe {
        cameras: Some(DatasetCameras::Default(2)),
        reasons: GraspReasons::All,
        ..plain.clone()
    };
    made(&plain, None, &at("plain"));
    made(&full, None, &at("full"));
    let [plain, set] = ["plain", "full"].map(|name| DatasetFolder::open(&at(name)).unwrap());
    let (before, chunk) = (plain.read(0).unwrap(), set.read(0).unwrap());
    // Rows without a path hold NaN.
    let text = |chunk: &cranny_dataset::Chunk| format!("{:?}", chunk.demonstrations);
    assert!(text(&before) == text(&chunk), "pictures change a row");
    assert_eq!(plain.read_pictures(0).unwrap(), []);

    // Every grasp has a result, and those that came up before keep theirs.
    let not_tried = GRASP_RESULTS.iter().position(|name| *name == "not-tried").unwrap();
    for (scene, before) in chunk.scenes.iter().zip(&before.scenes) {
        assert_eq!(scene.goals, before.goals);
        for (result, before) in scene.grasp_results.iter().zip(&before.grasp_results) {
            let was_tried = usize::from(*before) != not_tried;
            assert!(usize::from(*result) != not_tried && (!was_tried || result == before));
        }
    }

    // The results are those of another search for each grasp, as far as both are certain.
    let solved = chunk.demonstrations.iter().find(|row| row.is_solved()).unwrap();
    extract(&set, solved.row, &at("row")).unwrap();
    let scenario = Scenario::open(&at("row").display().to_string(), &OpenOptions::default()).unwrap();
    let problem = scenario.problem(cranny_collision::Margins::default()).unwrap();
    let settings = IkAnnotationSettings { attempts: 400, seed: 5, ..IkAnnotationSettings::default() };
    let annotations = annotate_ik(&problem, &settings, &|| (), &AtomicBool::new(false)).unwrap();
    let scene = chunk.scenes.iter().find(|scene| scene.scene == solved.scene).unwrap();
    assert_eq!(annotations.len(), scene.grasp_results.len());
    let mut agreed = 0;
    for (annotation, result) in annotations.iter().zip(&scene.grasp_results) {
        let name = GRASP_RESULTS[usize::from(*result)];
        match annotation.status {
            IkStatus::HandCollides { .. } => assert_eq!(name, "hand-collides"),
            IkStatus::OutOfReach { .. } => assert_eq!(name, "out-of-reach"),
            IkStatus::Solved => agreed += usize::from(name == "reachable"),
            _ => assert_ne!(name, "hand-collides"),
        }
    }
    assert!(agreed > 10, "{agreed}");

    // Each scene has its pictures, with the target and the robot in them, and they are checked.
    let pictures = set.read_pictures(0).unwrap();
    assert_eq!(pictures.len(), 2 * chunk.scenes.len());
    for picture in &pictures {
        assert!(picture.depth_png.starts_with(b"\x89PNG") && picture.segments_png.starts_with(b"\x89PNG"));
        assert_eq!((picture.width, picture.height, picture.pose.len()), (320, 240, 7));
        assert_eq!(picture.segments.last().map(String::as_str), Some("robot"));
    }
    assert_eq!(checked(&set).faults, []);
    let file = set.pictures_file(0).unwrap();
    let sound = fs::read(&file).unwrap();
    let wanted = &pictures[3].depth_png;
    let begin = sound.windows(wanted.len()).position(|window| window == wanted).unwrap();
    let mut other = sound.clone();
    other[begin + wanted.len() / 2] ^= 1;
    fs::write(&file, &other).unwrap();
    let faults = checked(&set).faults;
    assert!(
        !faults.is_empty() && faults.iter().all(|fault| fault.problem.contains("pictures of its scene 1"))
    );

    // Shards with pictures are merged.
    let shards: Vec<_> = (1..=2).map(|index| DatasetShard { index, of: 2 }).collect();
    for shard in &shards {
        made(&full, Some(*shard), &at(&format!("part {}", shard.index)));
    }
    merge(&[at("part 1"), at("part 2")], &at("merged"), &mut || {}).unwrap();
    fs::write(&file, sound).unwrap();
    assert_eq!(files(&at("merged")), files(&at("full")));
}

#[test]
fn a_robot_that_is_not_built_in_moves_into_the_set() {
    let place = tempfile::tempdir().unwrap();
    let at = |name: &str| place.path().join(name);
    RecipeRobot::load(Path::new("panda_mobile")).unwrap().write(&at("own")).unwrap();
    let recipe = DatasetRecipe {
        count: 6,
        queries_per_scene: 2,
        robots: vec![at("own").display().to_string()],
        tasks: BTreeMap::from([(DemonstrationTask::Reach, 1.0)]),
        ..recipe()
    };
    made(&recipe, None, &at("set"));
    let report = made(&recipe, None, &at("set"));
    assert_eq!((report.known, report.rows), (6, 0));

    // The set does not need the files outside of it.
    fs::rename(at("set"), at("moved")).unwrap();
    fs::rename(at("own"), at("elsewhere")).unwrap();
    let set = DatasetFolder::open(&at("moved")).unwrap();
    let report = checked(&set);
    assert!(report.faults.is_empty() && report.proven > 3, "{report:?}");
    let row = set.read(0).unwrap().demonstrations.into_iter().find(Demonstration::is_solved).unwrap();
    extract(&set, row.row, &at("row")).unwrap();
    let scenario = Scenario::open(&at("row").display().to_string(), &OpenOptions::default()).unwrap();
    let problem = scenario.problem(cranny_collision::Margins::default()).unwrap();
    let plan = PlanFile::read(&at("row").join(PLAN_FILE)).unwrap();
    let source = PlanSource { scenario: "row".to_owned(), ..PlanSource::default() };
    assert!(plan.judge(&source, &problem, AuditSettings::default()).unwrap().unwrap().audit.valid);
    export_lerobot(&set, 10.0, &at("lerobot"), &mut || {}).unwrap();

    // Another robot at the same path is not that of the set.
    fs::rename(at("moved"), at("set")).unwrap();
    fs::rename(at("elsewhere"), at("own")).unwrap();
    let urdf = fs::read_dir(at("own")).unwrap().map(|entry| entry.unwrap().path());
    let urdf = urdf.into_iter().find(|path| path.extension().is_some_and(|end| end == "urdf")).unwrap();
    let text = fs::read_to_string(&urdf).unwrap();
    fs::write(&urdf, format!("{text}<!-- changed -->\n")).unwrap();
    let progress = GenerateProgress { done: &|_, _| {}, stop: &AtomicBool::new(false), threads: 1 };
    let fault = generate(&recipe, None, &at("set"), &progress).unwrap_err();
    assert!(matches!(fault, DatasetError::OtherDataset { .. }), "{fault}");
}
