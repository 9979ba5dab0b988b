//! Rows of the results, one for each trial.

use std::path::Path;

use cranny_plan::Statistics;
use cranny_task::Criterion;
use rusqlite::{Connection, Row, Rows, params};

use crate::asked::trial::short_detail;
use crate::{BenchError, StoredTrial, Trial, TrialOutcome, TrialRecord};

/// Columns of a row without its number, its run, its path, which is large, and the column that older results lack.
const CONTENT: &str = "scenario, scenario_hash, planner, settings, criterion, seed, time_limit_s, \
    iteration_limit, goal, outcome, detail, iterations, nodes, collision_checks, ik_attempts, goals_tried, \
    planning_time_s, ik_time_s, collision_time_s, proof_time_s, nearest_time_s, path_length, clearance_m, grasp, \
    grasp_score, also_solved";

/// Returns the query for rows as [`read`] parses them, before any `WHERE`.
pub fn selection(is_older: bool) -> String {
    format!("SELECT id, run, {CONTENT}, {} FROM trials", memory(is_older))
}

/// Returns the column that older results lack.
fn memory(is_older: bool) -> &'static str {
    if is_older { "NULL AS memory_bytes" } else { "memory_bytes" }
}

/// Treatment of an existing row of the same trial.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Present {
    Stays,
    IsReplaced,
}

/// Adds a row with the path of its trial (way points; m, rad; one value per joint); returns the number of added rows.
pub fn insert(
    connection: &Connection,
    present: Present,
    run: u64,
    record: &TrialRecord,
    path: &[Vec<f64>],
) -> rusqlite::Result<usize> {
    let otherwise = match present {
        Present::Stays => "IGNORE",
        Present::IsReplaced => "REPLACE",
    };
    let sql = format!(
        "INSERT OR {otherwise} INTO trials (run, {CONTENT}, path, memory_bytes) VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11, ?12, \
         ?13, ?14, ?15, ?16, ?17, ?18, ?19, ?20, ?21, ?22, ?23, ?24, ?25, ?26, ?27, ?28, ?29)"
    );
    let (trial, statistics) = (&record.trial, &record.statistics);
    connection.prepare_cached(&sql)?.execute(params![
        run,
        trial.scenario,
        trial.scenario_hash,
        trial.planner,
        trial.settings,
        trial.criterion.name(),
        trial.seed,
        trial.time_limit_s,
        trial.iteration_limit,
        trial.goal,
        record.outcome.name(),
        record.detail,
        statistics.iterations,
        statistics.nodes,
        statistics.collision_checks,
        statistics.ik_attempts,
        statistics.goals_tried,
        statistics.planning_time_s,
        statistics.ik_time_s,
        statistics.collision_time_s,
        statistics.proof_time_s,
        statistics.nearest_time_s,
        record.path_length,
        record.clearance_m,
        record.grasp,
        record.grasp_score,
        record.also_solved,
        (!path.is_empty()).then(|| bytes_of_path(path)),
        record.memory_bytes,
    ])
}

/// Returns the SQL that copies the trials of the attached database `others`; their runs must be copied already, with the one
/// of this identity for trials whose run is missing.
pub fn take_up_trials(is_older: bool, unknown: &str) -> String {
    let memory = memory(is_older);
    format!(
        "INSERT OR IGNORE INTO trials (run, {CONTENT}, path, memory_bytes) \
         SELECT mine.id, {CONTENT}, path, {memory} \
         FROM others.trials AS trial LEFT JOIN others.runs AS theirs ON theirs.id = trial.run \
         JOIN main.runs AS mine ON mine.identity = COALESCE(theirs.identity, '{unknown}') ORDER BY trial.id"
    )
}

/// Returns the SQL that counts the trials with different results here and in the attached database `others`, and names one.
/// The join repeats the columns of the index, so that the index is used.
pub fn overlap() -> String {
    let differs =
        CONTENT.split(", ").chain(["path"]).map(|column| format!("mine.{column} IS NOT theirs.{column}"));
    let differs = differs.collect::<Vec<_>>().join(" OR ");
    format!(
        "SELECT count(*), min(theirs.scenario || ', ' || theirs.planner || ', seed ' || theirs.seed)
         FROM others.trials AS theirs JOIN main.trials AS mine ON mine.scenario = theirs.scenario
             AND mine.scenario_hash = theirs.scenario_hash AND mine.planner = theirs.planner
             AND mine.settings = theirs.settings AND mine.criterion = theirs.criterion AND mine.seed = theirs.seed
             AND mine.time_limit_s = theirs.time_limit_s
             AND COALESCE(mine.iteration_limit, -1) = COALESCE(theirs.iteration_limit, -1)
             AND COALESCE(mine.goal, -1) = COALESCE(theirs.goal, -1)
         WHERE {differs}"
    )
}

/// Parses all rows of a [`selection`] one by one.
pub fn for_each(
    mut rows: Rows,
    path: &Path,
    mut visit: impl FnMut(StoredTrial) -> Result<(), BenchError>,
) -> Result<(), BenchError> {
    let fault = |reason| BenchError::Database { path: path.to_owned(), reason };
    while let Some(row) = rows.next().map_err(fault)? {
        let criterion: String = row.get(6).map_err(fault)?;
        let outcome: String = row.get(11).map_err(fault)?;
        let id = row.get(0).map_err(fault)?;
        let no =
            |what, text: &str| BenchError::Row { path: path.to_owned(), id, what, text: text.to_owned() };
        let criterion = criterion.parse().map_err(|_| no("criterion", &criterion))?;
        let outcome = outcome.parse().map_err(|_| no("outcome", &outcome))?;
        visit(stored(row, criterion, outcome).map_err(fault)?)?;
    }
    Ok(())
}

fn stored(row: &Row, criterion: Criterion, outcome: TrialOutcome) -> rusqlite::Result<StoredTrial> {
    let trial = Trial {
        scenario: row.get(2)?,
        scenario_hash: row.get(3)?,
        planner: row.get(4)?,
        settings: row.get(5)?,
        criterion,
        seed: row.get(7)?,
        time_limit_s: row.get(8)?,
        iteration_limit: row.get(9)?,
        goal: row.get(10)?,
    };
    let statistics = Statistics {
        iterations: row.get(13)?,
        nodes: row.get(14)?,
        collision_checks: row.get(15)?,
        ik_attempts: row.get(16)?,
        goals_tried: row.get(17)?,
        planning_time_s: row.get(18)?,
        ik_time_s: row.get(19)?,
        collision_time_s: row.get(20)?,
        proof_time_s: row.get(21)?,
        nearest_time_s: row.get(22)?,
    };
    let record = TrialRecord {
        trial,
        outcome,
        detail: row.get::<_, Option<String>>(12)?.as_deref().map(short_detail),
        statistics,
        path_length: row.get(23)?,
        clearance_m: row.get(24)?,
        grasp: row.get(25)?,
        grasp_score: row.get(26)?,
        also_solved: row.get(27)?,
        memory_bytes: row.get(28)?,
    };
    Ok(StoredTrial { id: row.get(0)?, run: row.get(1)?, record })
}

/// Encodes a path of way points (m, rad; one value per joint) as bytes: the number of joints (4 bytes), then every value of
/// every way point (8 bytes each), little-endian.
pub fn bytes_of_path(path: &[Vec<f64>]) -> Vec<u8> {
    let joints = path.first().map_or(0, Vec::len);
    let mut bytes = u32::try_from(joints).unwrap_or(u32::MAX).to_le_bytes().to_vec();
    bytes.extend(path.iter().flatten().flat_map(|value| value.to_le_bytes()));
    bytes
}

/// Inverse of [`bytes_of_path`]: way points (m, rad; one value per joint). Bytes after the last whole way point are
/// ignored; the path is empty if the number of joints is missing, or is 0.
pub fn path_of_bytes(bytes: &[u8]) -> Vec<Vec<f64>> {
    let Some((joints, values)) = bytes.split_first_chunk::<4>() else { return Vec::new() };
    let joints = u32::from_le_bytes(*joints) as usize;
    let (values, _) = values.as_chunks::<8>();
    let values: Vec<f64> = values.iter().map(|value| f64::from_le_bytes(*value)).collect();
    if joints == 0 { Vec::new() } else { values.chunks_exact(joints).map(<[f64]>::to_vec).collect() }
}
