//! Recipes from files.

use std::fs;

use std::path::Path;

use cranny_dataset::{DatasetCameras, DatasetRecipe, DemonstrationTask, GraspReasons, recipe_schema};
use cranny_plan::Registry;
use cranny_scenario::RecipeRobot;

fn read(text: &str) -> Result<DatasetRecipe, String> {
    let folder = tempfile::tempdir().unwrap();
    read_in(folder.path(), text)
}

fn read_in(folder: &Path, text: &str) -> Result<DatasetRecipe, String> {
    let path = folder.join("recipe.yaml");
    fs::write(&path, text).unwrap();
    DatasetRecipe::read(&path, &Registry::default()).map_err(|fault| {
        let fault = fault.to_string();
        fault.rsplit_once("recipe.yaml").map_or(fault.clone(), |(_, rest)| rest.to_owned())
    })
}

#[test]
fn everything_but_the_count_has_a_default() {
    assert_eq!(read("count: 5").unwrap(), DatasetRecipe { count: 5, ..DatasetRecipe::default() });
    let recipe = read("count: 5\nfamilies: [gate]\nranges: {gate: [0.6, 0.7]}\ntasks: {carry: 2}").unwrap();
    assert_eq!(recipe.families[0].parameter_m, Some([0.6, 0.7]));
    assert_eq!(recipe.tasks.get(&DemonstrationTask::Carry), Some(&2.0));
}

#[test]
fn faults_name_their_line_and_what_would_be_valid() {
    for (text, fault) in [
        ("count: 0", ":1: `count` is 0, but must be a whole number from 1 to"),
        ("count: 1\nfamilies: []", ":2: `families` is empty; known: shelf, table, gap, gate"),
        ("count: 1\nfamilies: [shelve]", ":2: unknown name 'shelve' in `families`"),
        ("count: 1\nfamilies: [gap, gap]", ":2: 'gap' is in `families` twice"),
        ("count: 1\nranges:\n  gap: [0.5, 0.4]", ":3: the range of 'gap', from 0.5 to 0.4, is empty"),
        ("count: 1\nranges:\n  gap: [0.5, 40]", ":3: "),
        ("count: 1\nfamilies: [gap]\nranges: {gate: [0.6, 0.7]}", ":3: `ranges` has 'gate', which is not in"),
        ("count: 1\nrobots: [panda]", ":2: unknown name 'panda' in `robots`"),
        ("count: 1\ntasks: {}", ":2: `tasks` has no task with a weight above 0"),
        ("count: 1\ntasks: {fetch: 1}", ":2: unknown task 'fetch' (known: reach, carry, place)"),
        ("count: 1\ntasks: {reach: -1}", ":2: the weight of 'reach' is -1"),
        ("count: 1\nstart_spread: .nan", ":2: `start_spread` is NaN, but must be a number from 0 to 1"),
        ("count: 1\nplanner: reech", ":2: "),
        ("count: 1\nhold: -1", ":2: `hold` is -1"),
        ("count: 1\nreasons: some", ":2: "),
        (
            "count: 1\ncameras: {default: 9}",
            ":2: `cameras` is {\"default\":9}, but must be a file of cameras",
        ),
        ("count: 1\ncameras: 2", ":2: `cameras` is 2, but must be"),
        ("count: 1\ncameras: none.yaml", ":2: "),
        ("count: 1\nrobots: [./robot]", ":2: unknown name './robot' in `robots`"),
    ] {
        let found = read(text).unwrap_err();
        assert!(found.starts_with(fault), "{text}: {found}");
    }
}

#[test]
fn robots_and_cameras_are_files_beside_the_recipe() {
    let folder = tempfile::tempdir().unwrap();
    RecipeRobot::load(Path::new("panda_mobile")).unwrap().write(&folder.path().join("own")).unwrap();
    let cameras = "cameras:\n  - {name: left, width: 32, height: 24, field_of_view_deg: 70, position_m: [0.2, 0.8, 1.1], look_at_m: [1, 0, 0.4]}";
    fs::write(folder.path().join("cameras.yaml"), cameras).unwrap();
    let text = "count: 2\nrobots: [own, panda_mobile]\ncameras: cameras.yaml\nreasons: all";
    let recipe = read_in(folder.path(), text).unwrap();
    assert_eq!(recipe.robots, [folder.path().join("own").display().to_string(), "panda_mobile".to_owned()]);
    assert_eq!(recipe.reasons, GraspReasons::All);
    let Some(DatasetCameras::Placed(cameras)) = &recipe.cameras else { panic!("{:?}", recipe.cameras) };
    assert_eq!((&cameras[0].name[..], cameras[0].size_px), ("left", [32, 24]));
    assert_eq!(read("count: 2\ncameras: {default: 2}").unwrap().cameras, Some(DatasetCameras::Default(2)));
}

#[test]
fn the_committed_schema_is_that_of_the_recipes() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/schema/dataset.schema.json");
    if std::env::var_os("CRANNY_WRITE").is_some() {
        fs::write(&path, recipe_schema()).unwrap();
    }
    assert_eq!(fs::read_to_string(&path).unwrap(), recipe_schema());
}
