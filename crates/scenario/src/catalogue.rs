use crate::layout::own::{self, Texts};
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
    /// What is to be done.
    pub task: BuiltInTask,
    scenario: &'static str,
    grasps: &'static str,
}

/// What is to be done in a built-in scenario.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BuiltInTask {
    /// The object is to be grasped, and may be put down outside ([`Family::OUTSIDE`]).
    Pick,
    /// The object lies outside at first, and is to be put where the paper has it ([`Family::INSIDE`]).
    Insert,
    /// Columns stand in the way, which are to be taken away before the object is.
    Clear,
}

/// All built-in scenarios, by id: the twenty of the paper.
pub fn catalogue() -> &'static [CatalogueEntry] {
    &CATALOGUE
}

/// The built-in scenarios in which the object lies outside, and is to be brought in: of levels 1, 3 and 5 of each
/// environment, by id: `1`, environment, level.
pub fn insertions() -> &'static [CatalogueEntry] {
    &INSERTIONS
}

/// The built-in scenarios of several steps: what stands in the way is put aside, then the object; by id: `2`, environment,
/// level.
pub fn sequences() -> &'static [CatalogueEntry] {
    &SEQUENCES
}

/// All that is built in.
pub fn built_in() -> impl Iterator<Item = &'static CatalogueEntry> {
    CATALOGUE.iter().chain(&INSERTIONS).chain(&SEQUENCES)
}

/// Entries with the files that `Recipe`s of the catalogue are written to, which a test holds equal. Per family its
/// environment, what is said of the parameter before and after it, and the scenarios: id, parameter, and the parameter
/// as it is said.
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

/// The built-in ids, for a message about an unknown one.
pub(crate) fn known_ids() -> String {
    built_in().map(|entry| entry.id).collect::<Vec<_>>().join(", ")
}

/// The built-in ids that `what` may stand for: the same number, or the same but for one letter or digit.
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

/// The built-in scenario of that id, if there is one.
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
    /// The seed of the grasps of all built-in scenarios; any other would do as well.
    pub const GRASP_SEED: u64 = 0;

    /// The recipe from which the files of this entry are made, by a maker of its family.
    ///
    /// # Errors
    /// None on a sound build.
    pub fn recipe(&self, maker: &FamilyMaker) -> Result<Recipe, ScenarioError> {
        let title = format!("{}, {}: {}", self.id, self.environment, self.description);
        let recipe = match self.task {
            BuiltInTask::Pick => maker.at(self.parameter_m),
            BuiltInTask::Insert => maker.insertion(self.parameter_m),
            BuiltInTask::Clear => maker.clearing(self.parameter_m),
        };
        Ok(Recipe { title, ..recipe? })
    }

    /// The text of its `scenario.yaml` and of its `grasps.csv`.
    pub fn files(&self) -> (&'static str, &'static str) {
        (self.scenario, self.grasps)
    }
}
