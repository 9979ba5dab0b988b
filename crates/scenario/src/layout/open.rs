use std::path::Path;

use cranny_file::nearest_files;
use cranny_grasp::read_csv;

use crate::given_grasps::GivenGrasps;
use crate::layout::archive::Unpacked;
use crate::layout::own;
use crate::layout::released;
use crate::scenario::{OpenOptions, Scenario};
use crate::{ScenarioError, built_in, catalogue};

/// Returns true if [`Scenario::open`] recognizes `what`, unread, as a scenario: a built-in id, an archive, or a folder with a
/// scenario file.
pub fn is_scenario(what: &str) -> bool {
    let folder = Path::new(what);
    built_in().any(|entry| entry.id == what)
        || folder.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("zip"))
        || [own::FILE, released::FILE].iter().any(|file| folder.join(file).is_file())
}

impl Scenario {
    /// Opens the scenario that `what` names: a built-in id (see [`catalogue`](crate::catalogue())), a folder in Cranny's layout
    /// (`scenario.yaml`), such a folder packed as one `.zip`, or a folder in the paper's layout (`scene.yaml`). An id takes
    /// precedence over a folder of the same name; `./021` is the folder.
    ///
    /// # Errors
    /// [`ScenarioError`], with file and line where there is one.
    pub fn open(what: &str, options: &OpenOptions) -> Result<Self, ScenarioError> {
        let scenario = Self::open_own(what, options)?;
        match &options.grasps {
            GivenGrasps::Own => Ok(scenario),
            GivenGrasps::File(file) => Ok(scenario.with_grasps(read_csv(file)?)),
            GivenGrasps::None => Ok(scenario.without_grasps()),
        }
    }

    /// Opens the scenario with its own grasps.
    fn open_own(what: &str, options: &OpenOptions) -> Result<Self, ScenarioError> {
        let folder = Path::new(what);
        if let Some(scenario) = catalogue::open(what, options) {
            scenario
        } else if folder.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("zip")) {
            let unpacked = Unpacked::open(folder)?;
            own::open(&unpacked.folder(), options)
        } else if own::is_there(&folder.join(own::FILE))? {
            own::open(folder, options)
        } else if own::is_there(&folder.join(released::FILE))? {
            released::open(folder, options)
        } else if folder.is_dir() {
            Err(ScenarioError::NoScenarioFile { folder: folder.to_owned() })
        } else if own::is_there(folder)? {
            Err(ScenarioError::FileForFolder { path: folder.to_owned() })
        } else {
            // Suggestions: ids, and scenarios near the given path.
            let ids = catalogue::near_ids(what).into_iter().map(str::to_owned);
            let near =
                ids.chain(nearest_files(folder).into_iter().filter(|near| is_scenario(near))).collect();
            Err(ScenarioError::Unknown { what: what.to_owned(), known: catalogue::known_ids(), near })
        }
    }
}
