use crate::layout::own::{self, Texts};
use crate::{Family, FamilyMaker, OpenOptions, Recipe, Scenario, ScenarioError};

/// Built-in scenario; it needs no file.
#[derive(Clone, Debug, PartialEq)]
pub struct CatalogueEntry {
    /// Identifier: `0`, environment, level.
    pub id: &'static str,
    /// Short description of the environment.
    pub environment: &'static str,
    /// Distinguishing feature of this scenario, in one line.
    pub description: &'static str,
    /// Family of the scenario.
    pub family: Family,
    /// Value of the family's difficulty parameter, in metres.
    pub parameter_m: f64,
    /// Task of the scenario.
    pub task: BuiltInTask,
    scenario: &'static str,
    grasps: &'static str,
}

/// Task of a built-in scenario.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BuiltInTask {
    /// Pick the object; it may be placed outside ([`Family::OUTSIDE`]).
    Pick,
    /// Place the object, which starts outside, at its pose in the paper ([`Family::INSIDE`]).
    Insert,
    /// Move the columns that block the access aside, then the object.
    Clear,
}

/// Returns the twenty built-in scenarios of the paper, ordered by id.
pub fn catalogue() -> &'static [CatalogueEntry] {
    &CATALOGUE
}

/// Returns the built-in scenarios in which the object starts outside and must be placed inside: levels 1, 3 and 5 of each
/// environment, ordered by id (`1`, environment, level).
pub fn insertions() -> &'static [CatalogueEntry] {
    &INSERTIONS
}

/// Returns the built-in scenarios with several picks: obstacles, then the object. Ordered by id (`2`, environment, level).
pub fn sequences() -> &'static [CatalogueEntry] {
    &SEQUENCES
}

/// Returns all built-in scenarios.
pub fn built_in() -> impl Iterator<Item = &'static CatalogueEntry> {
    CATALOGUE.iter().chain(&INSERTIONS).chain(&SEQUENCES)
}

/// Entries with the files that `Recipe`s of the catalogue are written to; a test checks that both are equal. Per family: the
/// environment, the text before and after the parameter, and the scenarios with id, parameter, and the parameter as text.
macro_rules! entries {
    ($task:ident, $($family:ident, $environment:literal, $before:literal, $after:literal {
        $($id:literal: $parameter_m:literal = $said:literal,)*
    })*) => {
        [$($(CatalogueEntry {
            id: $id,
            environment: $environment,
            description: concat!($before, $said, $after),
            family: Family::$family,
            parameter_m: $parameter_m,
            task: BuiltInTask::$task,
            scenario: include_str!(concat!("../scenarios/", $id, "/scenario.yaml")),
            grasps: include_str!(concat!("../scenarios/", $id, "/grasps.csv")),
        },)*)*]
    };
}

const CATALOGUE: [CatalogueEntry; 20] = entries! {
    Pick,
    Shelf, "screwdriver in a shelf", "the screwdriver lies ", " m behind the front edge" {
        "011": 0.113 = "0.11",
        "012": 0.213 = "0.21",
        "013": 0.313 = "0.31",
        "014": 0.413 = "0.41",
        "015": 0.513 = "0.51",
    }
    Table, "ball under a table", "the ball lies ", " m behind the front edge" {
        "021": 0.2 = "0.2",
        "022": 0.3 = "0.3",
        "023": 0.4 = "0.4",
        "024": 0.5 = "0.5",
        "025": 0.6 = "0.6",
    }
    Gap, "box behind a gap", "the gap between the walls is ", " m wide" {
        "031": 0.64 = "0.64",
        "032": 0.56 = "0.56",
        "033": 0.48 = "0.48",
        "034": 0.40 = "0.40",
        "035": 0.32 = "0.32",
    }
    Gate, "banana behind a gate", "the gate's opening is ", " m wide and high" {
        "041": 0.86 = "0.86",
        "042": 0.78 = "0.78",
        "043": 0.70 = "0.70",
        "044": 0.62 = "0.62",
        "045": 0.54 = "0.54",
    }
};

const INSERTIONS: [CatalogueEntry; 12] = entries! {
    Insert,
    Shelf, "screwdriver into a shelf", "the screwdriver is to lie ", " m behind the front edge" {
        "111": 0.113 = "0.11",
        "113": 0.313 = "0.31",
        "115": 0.513 = "0.51",
    }
    Table, "ball under a table, from above", "the ball is to lie ", " m behind the front edge" {
        "121": 0.2 = "0.2",
        "123": 0.4 = "0.4",
        "125": 0.6 = "0.6",
    }
    Gap, "box through a gap", "the gap between the walls is ", " m wide" {
        "131": 0.64 = "0.64",
        "133": 0.48 = "0.48",
        "135": 0.32 = "0.32",
    }
    Gate, "banana through a gate", "the gate's opening is ", " m wide and high" {
        "141": 0.86 = "0.86",
        "143": 0.70 = "0.70",
        "145": 0.54 = "0.54",
    }
};

const SEQUENCES: [CatalogueEntry; 3] = entries! {
    Clear,
    Shelf, "screwdriver behind two columns in a shelf", "the screwdriver lies ", " m behind the front edge" {
        "213": 0.313 = "0.31",
    }
    Gap, "box behind two columns in a gap", "the gap between the walls is ", " m wide" {
        "235": 0.32 = "0.32",
    }
    Gate, "banana behind three columns in a gate", "the gate's opening is ", " m wide and high" {
        "245": 0.54 = "0.54",
    }
};

/// Returns the built-in ids, for an error message about an unknown id.
pub(crate) fn known_ids() -> String {
    built_in().map(|entry| entry.id).collect::<Vec<_>>().join(", ")
}

/// Returns the built-in ids close to `what`: with the same number, or with one differing character.
pub(crate) fn near_ids(what: &str) -> Vec<&'static str> {
    let ids = || built_in().map(|entry| entry.id);
    let number = |text: &str| text.parse::<u32>().ok();
    let same: Vec<_> = ids().filter(|id| number(what).is_some() && number(id) == number(what)).collect();
    if !same.is_empty() {
        return same;
    }
    let differ = |id: &str| id.chars().zip(what.chars()).filter(|(a, b)| a != b).count();
    ids().filter(|id| id.len() == what.len() && differ(id) == 1).take(3).collect()
}

/// Opens the built-in scenario `id`; `None` if there is none.
pub(crate) fn open(id: &str, options: &OpenOptions) -> Option<Result<Scenario, ScenarioError>> {
    let entry = built_in().find(|entry| entry.id == id)?;
    let texts = Texts {
        folder: format!("scenarios/{id}").into(),
        scenario: entry.scenario.to_owned(),
        grasps: Some(entry.grasps.to_owned()),
        ik: None,
    };
    Some(own::open_texts(id.to_owned(), &texts, options))
}

impl CatalogueEntry {
    /// Seed of the grasps of all built-in scenarios; the value is arbitrary.
    pub const GRASP_SEED: u64 = 0;

    /// Returns the recipe from which the files of this entry are made, by a maker of its family.
    ///
    /// # Errors
    /// None unless the built-in files are broken.
    pub fn recipe(&self, maker: &FamilyMaker) -> Result<Recipe, ScenarioError> {
        let title = format!("{}, {}: {}", self.id, self.environment, self.description);
        let recipe = match self.task {
            BuiltInTask::Pick => maker.at(self.parameter_m),
            BuiltInTask::Insert => maker.insertion(self.parameter_m),
            BuiltInTask::Clear => maker.clearing(self.parameter_m),
        };
        Ok(Recipe { title, ..recipe? })
    }

    /// Returns the texts of `scenario.yaml` and `grasps.csv`.
    pub fn files(&self) -> (&'static str, &'static str) {
        (self.scenario, self.grasps)
    }
}
