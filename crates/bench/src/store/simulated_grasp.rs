use rusqlite::{Connection, OptionalExtension as _, params};

use crate::{BenchError, Results};

/// Result of simulating a grasp at which trials ended, by another crate: a row of the table `simulated_grasps`.
#[derive(Clone, Debug, PartialEq)]
pub struct SimulatedGrasp {
    /// Id of the scenario.
    pub scenario: String,
    /// Hash of its content, as [`Trial::scenario_hash`](crate::Trial::scenario_hash).
    pub scenario_hash: String,
    /// Index of the grasp, from 0.
    pub grasp: usize,
    /// Outcome, in one word.
    pub outcome: String,
    /// Distance of the object from its expected position at the end, in metres.
    pub translation_error_m: f64,
    /// Rotation of the object from its expected orientation at the end, in radians.
    pub rotation_error_rad: f64,
    /// Time for which the object stayed at its expected pose, in seconds.
    pub held_s: f64,
    /// Contact force of a finger, in newtons.
    pub contact_force_n: f64,
    /// Number of further trials in which the grasp held the object, and number of further trials; `None` if there were none.
    pub robust: Option<(usize, usize)>,
}

const NAME: &str = "simulated_grasps";

const TABLE: &str = "CREATE TABLE simulated_grasps (
    scenario TEXT NOT NULL,
    scenario_hash TEXT NOT NULL,
    grasp INTEGER NOT NULL,
    settings TEXT NOT NULL,
    outcome TEXT NOT NULL,
    translation_error_m REAL NOT NULL,
    rotation_error_rad REAL NOT NULL,
    held_s REAL NOT NULL,
    contact_force_n REAL NOT NULL,
    robust_held INTEGER,
    robust_trials INTEGER,
    PRIMARY KEY (scenario, scenario_hash, grasp, settings)
)";

impl Results {
    /// Stores the results of grasps under these settings instead of earlier ones, all or none; trials and runs are unchanged.
    ///
    /// # Errors
    /// [`BenchError::OtherTable`] if the file has another table of that name, [`BenchError::Database`].
    pub fn keep_simulated_grasps(
        &mut self,
        settings: &str,
        grasps: &[SimulatedGrasp],
    ) -> Result<(), BenchError> {
        let other = || BenchError::OtherTable { path: self.path.clone(), name: NAME.to_owned() };
        let found = self.done(definition(&self.connection))?;
        if found.as_ref().is_some_and(|found| found != TABLE) {
            return Err(other());
        }
        let kept = keep(&mut self.connection, found.is_none(), settings, grasps);
        self.done(kept)
    }
}

/// Returns the SQL definition of the database object with this name.
fn definition(connection: &Connection) -> rusqlite::Result<Option<String>> {
    let sql = "SELECT COALESCE(sql, '') FROM sqlite_schema WHERE name = ?1";
    connection.query_row(sql, [NAME], |row| row.get(0)).optional()
}

fn keep(
    connection: &mut Connection,
    is_new: bool,
    settings: &str,
    grasps: &[SimulatedGrasp],
) -> rusqlite::Result<()> {
    let transaction = connection.transaction()?;
    if is_new {
        transaction.execute_batch(TABLE)?;
    }
    transaction.execute("DELETE FROM simulated_grasps WHERE settings = ?1", [settings])?;
    let sql = "INSERT INTO simulated_grasps VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11)";
    for grasp in grasps {
        let (held, trials) = grasp.robust.unzip();
        transaction.prepare_cached(sql)?.execute(params![
            grasp.scenario,
            grasp.scenario_hash,
            grasp.grasp,
            settings,
            grasp.outcome,
            grasp.translation_error_m,
            grasp.rotation_error_rad,
            grasp.held_s,
            grasp.contact_force_n,
            held,
            trials,
        ])?;
    }
    transaction.commit()
}
