use crate::own_layout::{self, Texts};
use crate::{Family, FamilyMaker, OpenOptions, Recipe, Scenario, ScenarioError};

/// A scenario that needs no file.
#[derive(Clone, Debug, PartialEq)]
pub struct CatalogueEntry {
    /// What to open it by: `0`, environment, level.
    pub id: &'static str,
    /// The environment, in a few words.
    pub environment: &'static str,
    /// What is special about this one, in a line.
    pub description: &'static str,
    /// The family that it belongs to.
    pub family: Family,
    /// The value of the family's dial, in metres.
    pub parameter_m: f64,
    scenario: &'static str,
    grasps: &'static str,
}

/// All built-in scenarios, by id: the twenty of the paper.
pub fn catalogue() -> &'static [CatalogueEntry] {
    &CATALOGUE
}

/// An entry with the files that `Recipe`s of the catalogue are written to, which a test holds equal.
macro_rules! entry {
    ($id:literal, $family:ident, $environment:literal, $parameter_m:literal, $description:literal) => {
        CatalogueEntry {
            id: $id,
            environment: $environment,
            description: $description,
            family: Family::$family,
            parameter_m: $parameter_m,
            scenario: include_str!(concat!("../../../scenarios/", $id, "/scenario.yaml")),
            grasps: include_str!(concat!("../../../scenarios/", $id, "/grasps.csv")),
        }
    };
}

const CATALOGUE: [CatalogueEntry; 20] = [
    entry!(
        "011",
        Shelf,
        "screwdriver in a shelf",
        0.113,
        "the screwdriver lies 0.11 m behind the front edge"
    ),
    entry!(
        "012",
        Shelf,
        "screwdriver in a shelf",
        0.213,
        "the screwdriver lies 0.21 m behind the front edge"
    ),
    entry!(
        "013",
        Shelf,
        "screwdriver in a shelf",
        0.313,
        "the screwdriver lies 0.31 m behind the front edge"
    ),
    entry!(
        "014",
        Shelf,
        "screwdriver in a shelf",
        0.413,
        "the screwdriver lies 0.41 m behind the front edge"
    ),
    entry!(
        "015",
        Shelf,
        "screwdriver in a shelf",
        0.513,
        "the screwdriver lies 0.51 m behind the front edge"
    ),
    entry!("021", Table, "ball under a table", 0.2, "the ball lies 0.2 m behind the front edge"),
    entry!("022", Table, "ball under a table", 0.3, "the ball lies 0.3 m behind the front edge"),
    entry!("023", Table, "ball under a table", 0.4, "the ball lies 0.4 m behind the front edge"),
    entry!("024", Table, "ball under a table", 0.5, "the ball lies 0.5 m behind the front edge"),
    entry!("025", Table, "ball under a table", 0.6, "the ball lies 0.6 m behind the front edge"),
    entry!("031", Gap, "box behind a gap", 0.64, "the gap between the walls is 0.64 m wide"),
    entry!("032", Gap, "box behind a gap", 0.56, "the gap between the walls is 0.56 m wide"),
    entry!("033", Gap, "box behind a gap", 0.48, "the gap between the walls is 0.48 m wide"),
    entry!("034", Gap, "box behind a gap", 0.40, "the gap between the walls is 0.40 m wide"),
    entry!("035", Gap, "box behind a gap", 0.32, "the gap between the walls is 0.32 m wide"),
    entry!("041", Gate, "banana behind a gate", 0.86, "the gate's opening is 0.86 m wide and high"),
    entry!("042", Gate, "banana behind a gate", 0.78, "the gate's opening is 0.78 m wide and high"),
    entry!("043", Gate, "banana behind a gate", 0.70, "the gate's opening is 0.70 m wide and high"),
    entry!("044", Gate, "banana behind a gate", 0.62, "the gate's opening is 0.62 m wide and high"),
    entry!("045", Gate, "banana behind a gate", 0.54, "the gate's opening is 0.54 m wide and high"),
];

/// The built-in ids, for a message about an unknown one.
pub(crate) fn known_ids() -> String {
    CATALOGUE.each_ref().map(|entry| entry.id).join(", ")
}

/// The built-in ids that `what` may stand for: the same number, or the same but for one letter or digit.
pub(crate) fn near_ids(what: &str) -> Vec<&'static str> {
    let ids = CATALOGUE.each_ref().map(|entry| entry.id);
    let number = |text: &str| text.parse::<u32>().ok();
    let same: Vec<_> =
        ids.into_iter().filter(|id| number(what).is_some() && number(id) == number(what)).collect();
    if !same.is_empty() {
        return same;
    }
    let differ = |id: &str| id.chars().zip(what.chars()).filter(|(a, b)| a != b).count();
    ids.into_iter().filter(|id| id.len() == what.len() && differ(id) == 1).take(3).collect()
}

/// The built-in scenario of that id, if there is one.
pub(crate) fn open(id: &str, options: &OpenOptions) -> Option<Result<Scenario, ScenarioError>> {
    let entry = CATALOGUE.iter().find(|entry| entry.id == id)?;
    let texts = Texts {
        folder: format!("scenarios/{id}").into(),
        scenario: entry.scenario.to_owned(),
        grasps: entry.grasps.to_owned(),
        ik: None,
    };
    Some(own_layout::open_texts(id.to_owned(), &texts, options))
}

impl CatalogueEntry {
    /// The seed of the grasps of all built-in scenarios; any other would do as well.
    pub const GRASP_SEED: u64 = 0;

    /// The recipe from which the files of this entry are made, by a maker of its family.
    ///
    /// # Errors
    /// None on a sound build.
    pub fn recipe(&self, maker: &FamilyMaker) -> Result<Recipe, ScenarioError> {
        let title = format!("{}, {}: {}", self.id, self.environment, self.description);
        Ok(Recipe { title, ..maker.at(self.parameter_m)? })
    }

    /// The text of its `scenario.yaml` and of its `grasps.csv`.
    pub fn files(&self) -> (&'static str, &'static str) {
        (self.scenario, self.grasps)
    }
}
