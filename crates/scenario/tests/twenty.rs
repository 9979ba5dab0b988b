//! The files of the twenty built-in scenarios, and of the derived ones, agree with their recipes.

use std::fs;
use std::path::Path;

use cranny_grasp::csv_text;
use cranny_scenario::{
    CatalogueEntry, Family, FamilyMaker, RecipeRobot, SceneScale, catalogue, insertions, sequences,
};
use strum::VariantArray as _;

/// The files are rewritten if `CRANNY_WRITE` is set; the program must then be built again.
#[test]
fn the_files_of_the_twenty_are_what_their_recipes_make() {
    let scenarios = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios");
    for &family in Family::VARIANTS {
        let maker = {
            let robot = RecipeRobot::of_the_paper().unwrap();
            FamilyMaker::new(family, robot, SceneScale::PAPER, CatalogueEntry::GRASP_SEED).unwrap()
        };
        for entry in
            catalogue().iter().chain(insertions()).chain(sequences()).filter(|entry| entry.family == family)
        {
            let recipe = entry.recipe(&maker).unwrap();
            if std::env::var_os("CRANNY_WRITE").is_some() {
                recipe.write_folder(&scenarios.join(entry.id)).unwrap();
                continue;
            }
            let read = |name: &str| fs::read_to_string(scenarios.join(entry.id).join(name)).unwrap();
            let (yaml, grasps) = (recipe.yaml(), csv_text(&recipe.grasps));
            assert!(yaml == read("scenario.yaml") && grasps == read("grasps.csv"), "{}", entry.id);
            assert_eq!(entry.files(), (yaml.as_str(), grasps.as_str()), "{}", entry.id);
        }
    }
}
