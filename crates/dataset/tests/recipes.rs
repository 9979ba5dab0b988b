//! Recipes from files.

use std::fs;

use cranny_dataset::{DatasetRecipe, DemonstrationTask};
use cranny_plan::Registry;

fn read(text: &str) -> Result<DatasetRecipe, String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("recipe.yaml");
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
    ] {
        let found = read(text).unwrap_err();
        assert!(found.starts_with(fault), "{text}: {found}");
    }
}
