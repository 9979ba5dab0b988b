use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use cranny_scenario::Temporary;
use rusqlite::{Connection, OptionalExtension as _, params};

use crate::store::results_file::Claim;
use crate::store::results_row::{self, Present};
use crate::store::run_information::UNKNOWN;
use crate::store::stored_trial::StoredTrial;
use crate::{BenchError, RunInformation, Tally, TrialRecord, store::results_file};

/// Results of campaigns: one `SQLite` file, one row a trial.
///
/// Every trial is written as it ends, in a transaction of its own, to a write-ahead log: if the program is killed, at most
/// the trial in progress is lost. A [`Trial`](crate::Trial) occurs at most once.
#[derive(Debug)]
pub struct Results {
    pub(crate) connection: Connection,
    pub(crate) path: PathBuf,
    /// Lock owned while a campaign writes.
    pub(crate) claim: Option<Claim>,
    /// Copy that is read instead, if the results are on a read-only medium.
    copy: Option<Temporary>,
}

/// Run of a campaign in the results: restarting the campaign makes another run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Run {
    /// Number of the run in these results, from 1.
    pub id: u64,
    /// Machine, program and settings of the run.
    pub information: RunInformation,
    /// Start time: UTC, ISO 8601.
    pub began: String,
    /// End time: UTC, ISO 8601; `None` if the run was killed.
    pub ended: Option<String>,
}

/// Source of a scenario, in addition to its id and hash.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ScenarioSource {
    /// Id of the scenario.
    pub scenario: String,
    /// Hash of its content, as [`Trial::scenario_hash`](crate::Trial::scenario_hash).
    pub scenario_hash: String,
    /// Source that it was opened from: an id, or a path on the machine of the run.
    pub source: String,
    /// Number of its goal configurations (`|G_IK|`), if determined.
    pub goals: Option<usize>,
}

/// Summary of merging results.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Merged {
    /// Number of new trials.
    pub added: u64,
    /// Number of trials that existed before and were kept.
    pub known: u64,
}

impl Results {
    /// Opens the results at `path` for writing; creates new ones if the file is missing or empty.
    ///
    /// # Errors
    /// [`BenchError::NotResults`], [`BenchError::ResultsVersion`], [`BenchError::OtherTable`], [`BenchError::Damaged`],
    /// [`BenchError::Database`]; an existing file is unchanged then.
    pub fn create(path: &Path) -> Result<Self, BenchError> {
        results_file::begin(path)?;
        let mut results = Self::new(results_file::open(path)?, path);
        results_file::bring_up_to_date(path, &mut results.connection)?;
        Ok(results)
    }

    fn new(connection: Connection, path: &Path) -> Self {
        Self { connection, path: path.to_owned(), claim: None, copy: None }
    }

    /// Opens the results at `path` for reading.
    ///
    /// # Errors
    /// As [`Self::create`], and [`BenchError::NoResults`] if there are none.
    pub fn open(path: &Path) -> Result<Self, BenchError> {
        if !path.exists() {
            return Err(BenchError::NoResults { path: path.to_owned() });
        }
        let mut results = if results_file::is_writable(path) {
            Self::new(results_file::open(path)?, path)
        } else {
            // Reading may also write back a log.
            let (copy, file) = results_file::copied(path)?;
            Self { copy: Some(copy), ..Self::new(results_file::open(&file)?, path) }
        };
        path.clone_into(&mut results.path);
        results.done(results.connection.pragma_update(None, "query_only", true))?;
        Ok(results)
    }

    /// Returns the numbers of ended and of solved trials of each planner in the results at `path`, without checking the
    /// integrity of the file, which takes longer.
    ///
    /// # Errors
    /// As [`Self::open`], but [`BenchError::Damaged`].
    pub fn glance(path: &Path) -> Result<BTreeMap<String, Tally>, BenchError> {
        if !path.exists() {
            return Err(BenchError::NoResults { path: path.to_owned() });
        }
        let results = Self::new(results_file::open_unseen(path)?, path);
        let sql = "SELECT planner, count(*), sum(outcome = 'solved') FROM trials GROUP BY planner";
        let mut statement = results.done(results.connection.prepare(sql))?;
        let tallies = statement
            .query_map([], |row| Ok((row.get(0)?, Tally { ended: row.get(1)?, solved: row.get(2)? })))
            .and_then(Iterator::collect);
        results.done(tallies)
    }

    /// Returns the number of trials.
    ///
    /// # Errors
    /// [`BenchError::Database`].
    pub fn count(&self) -> Result<usize, BenchError> {
        self.done(self.connection.query_row("SELECT count(*) FROM trials", [], |row| row.get(0)))
    }

    /// Returns the path of the file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Begins a run, and returns its number.
    ///
    /// # Errors
    /// [`BenchError::Database`].
    pub fn begin_run(&mut self, information: &RunInformation) -> Result<u64, BenchError> {
        let RunInformation {
            machine, processor, cpu_features, cores, version, commit, command, workers, ..
        } = information;
        let (limit, sandbox) = (information.memory_limit_bytes, &information.sandbox);
        let features = cpu_features.join(" ");
        self.done(self.connection.execute(
            "INSERT INTO runs (machine, processor, cpu_features, cores, version, commit_hash, command, workers,
                               memory_limit_bytes, sandbox)
             VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10)",
            params![machine, processor, features, cores, version, commit, command, workers, limit, sandbox],
        ))?;
        Ok(self.connection.last_insert_rowid().cast_unsigned())
    }

    /// Records that a run ended by itself.
    ///
    /// # Errors
    /// [`BenchError::Database`].
    pub fn end_run(&mut self, run: u64) -> Result<(), BenchError> {
        let sql = "UPDATE runs SET ended = strftime('%Y-%m-%dT%H:%M:%SZ', 'now') WHERE id = ?1";
        self.done(self.connection.execute(sql, [run])).map(drop)
    }

    /// Adds a trial with the path of its planner (way points; m, rad; one value per joint), and replaces an existing entry
    /// of that trial.
    ///
    /// # Errors
    /// [`BenchError::Database`].
    pub fn replace(&mut self, run: u64, record: &TrialRecord, path: &[Vec<f64>]) -> Result<(), BenchError> {
        self.done(results_row::insert(&self.connection, Present::IsReplaced, run, record, path)).map(drop)
    }

    /// Adds a trial with the path of its planner (way points; m, rad; one value per joint). Returns true if it is new; an
    /// existing entry remains unchanged.
    ///
    /// # Errors
    /// [`BenchError::Database`].
    pub fn append(&mut self, run: u64, record: &TrialRecord, path: &[Vec<f64>]) -> Result<bool, BenchError> {
        let added = results_row::insert(&self.connection, Present::Stays, run, record, path);
        Ok(self.done(added)? == 1)
    }

    /// Records the source of a scenario.
    ///
    /// # Errors
    /// [`BenchError::Database`].
    pub fn note_scenario(&mut self, source: &ScenarioSource) -> Result<(), BenchError> {
        let ScenarioSource { scenario, scenario_hash, source, goals } = source;
        self.done(self.connection.execute(
            "INSERT INTO scenarios (scenario, scenario_hash, source, goals) VALUES (?1, ?2, ?3, ?4)
             ON CONFLICT DO UPDATE SET source = excluded.source, goals = COALESCE(excluded.goals, goals)",
            params![scenario, scenario_hash, source, goals],
        ))
        .map(drop)
    }

    /// Records the call of a planner as JSON, in addition to its name and settings.
    ///
    /// # Errors
    /// [`BenchError::Database`].
    pub fn note_planner(&mut self, planner: &str, settings: &str, source: &str) -> Result<(), BenchError> {
        self.done(self.connection.execute(
            "INSERT INTO planners (planner, settings, source) VALUES (?1, ?2, ?3)
             ON CONFLICT DO UPDATE SET source = excluded.source",
            params![planner, settings, source],
        ))
        .map(drop)
    }

    /// Returns all trials, in the order in which they ended.
    ///
    /// # Errors
    /// [`BenchError::Row`], [`BenchError::Database`].
    pub fn trials(&self) -> Result<Vec<StoredTrial>, BenchError> {
        self.select("ORDER BY id", [])
    }

    /// Returns all records, in the order in which the trials ended.
    ///
    /// # Errors
    /// As [`Self::trials`].
    pub fn records(&self) -> Result<Vec<TrialRecord>, BenchError> {
        Ok(self.trials()?.into_iter().map(|trial| trial.record).collect())
    }

    /// Returns one trial.
    ///
    /// # Errors
    /// [`BenchError::NoTrial`], and as [`Self::trials`].
    pub fn trial(&self, id: u64) -> Result<StoredTrial, BenchError> {
        let found = self.select("WHERE id = ?1", [id])?;
        if let Some(trial) = found.into_iter().next() {
            return Ok(trial);
        }
        let last = "SELECT COALESCE(max(id), 0) FROM trials";
        let last = self.done(self.connection.query_row(last, [], |row| row.get(0)))?;
        Err(BenchError::NoTrial { path: self.path.clone(), id, last })
    }

    /// Returns the exact path of the planner of a trial (way points; m, rad; one value per joint); empty if there is none.
    ///
    /// # Errors
    /// [`BenchError::NoTrial`], [`BenchError::Database`].
    pub fn path_of(&self, id: u64) -> Result<Vec<Vec<f64>>, BenchError> {
        self.trial(id)?;
        let bytes: Option<Vec<u8>> =
            self.done(
                self.connection.query_row("SELECT path FROM trials WHERE id = ?1", [id], |row| row.get(0)),
            )?;
        Ok(bytes.map(|bytes| results_row::path_of_bytes(&bytes)).unwrap_or_default())
    }

    /// Returns all runs, in their order. A run that is missing, though there are trials of it, is of an unknown machine.
    ///
    /// # Errors
    /// [`BenchError::Database`].
    pub fn runs(&self) -> Result<Vec<Run>, BenchError> {
        let added = added_to_runs(self.is_older()?);
        let sql = format!(
            "SELECT id, machine, processor, cpu_features, cores, version, commit_hash, command, workers,
                   began, ended, {added} FROM runs ORDER BY id"
        );
        let mut statement = self.done(self.connection.prepare(&sql))?;
        let rows = statement.query_map([], |row| {
            let features: String = row.get(3)?;
            let information = RunInformation {
                machine: row.get(1)?,
                processor: row.get(2)?,
                cpu_features: features.split_whitespace().map(str::to_owned).collect(),
                cores: row.get(4)?,
                version: row.get(5)?,
                commit: row.get(6)?,
                command: row.get(7)?,
                workers: row.get(8)?,
                memory_limit_bytes: row.get(11)?,
                sandbox: row.get(12)?,
            };
            Ok(Run { id: row.get(0)?, information, began: row.get(9)?, ended: row.get(10)? })
        });
        let mut runs: Vec<Run> = self.done(rows.and_then(Iterator::collect))?;
        let sql = "SELECT DISTINCT run FROM trials WHERE run NOT IN (SELECT id FROM runs)";
        let mut statement = self.done(self.connection.prepare(sql))?;
        let rows = statement.query_map([], |row| {
            Ok(Run {
                id: row.get(0)?,
                information: RunInformation::unknown(),
                began: UNKNOWN.to_owned(),
                ended: None,
            })
        });
        runs.extend(self.done(rows.and_then(Iterator::collect::<rusqlite::Result<Vec<Run>>>))?);
        runs.sort_by_key(|run| run.id);
        Ok(runs)
    }

    /// Returns the sources of the scenarios.
    ///
    /// # Errors
    /// [`BenchError::Database`].
    pub fn scenarios(&self) -> Result<Vec<ScenarioSource>, BenchError> {
        let sql =
            "SELECT scenario, scenario_hash, source, goals FROM scenarios ORDER BY scenario, scenario_hash";
        let mut statement = self.done(self.connection.prepare(sql))?;
        let rows = statement.query_map([], |row| {
            Ok(ScenarioSource {
                scenario: row.get(0)?,
                scenario_hash: row.get(1)?,
                source: row.get(2)?,
                goals: row.get(3)?,
            })
        });
        self.done(rows.and_then(Iterator::collect))
    }

    /// Returns the call of a planner, if recorded.
    ///
    /// # Errors
    /// [`BenchError::Database`].
    pub fn planner_source(&self, planner: &str, settings: &str) -> Result<Option<String>, BenchError> {
        let sql = "SELECT source FROM planners WHERE planner = ?1 AND settings = ?2";
        self.done(self.connection.query_row(sql, [planner, settings], |row| row.get(0)).optional())
    }

    /// Adds the runs and trials of other results, all or none; existing trials remain unchanged. Trials whose run is missing
    /// in the others become trials of one run on an unknown machine.
    ///
    /// # Errors
    /// As [`Self::open`] and [`Self::trials`] of the others, [`BenchError::Row`], [`BenchError::Database`]; unless `keep_first`,
    /// [`BenchError::Overlap`] if a trial has another result in the others, as is usual for a trial that runs again, and
    /// [`BenchError::OtherRun`] if a run has another machine, program or command there.
    pub fn merge(&mut self, others: &Path, keep_first: bool) -> Result<Merged, BenchError> {
        // Opening it first handles its log and its errors; a copy exists as long as this handle.
        let opened = Self::open(others)?;
        let copy = opened.copy.as_ref().map(|copy| copy.path().join(results_file::COPY));
        let others = copy.unwrap_or_else(|| others.to_owned());
        let others = others.to_string_lossy();
        let is_older = opened.is_older()?;
        let sql = results_row::selection(is_older);
        let mut statement = opened.done(opened.connection.prepare(&sql))?;
        results_row::for_each(opened.done(statement.query([]))?, &opened.path, |trial| {
            trial.check().map_err(|fault| match fault {
                BenchError::Figure { trial: id, figure: what, value } => {
                    BenchError::Row { path: opened.path.clone(), id, what, text: value.to_string() }
                }
                BenchError::Late { trial: id, time_s, limit_s } => {
                    let text = format!("solved after {time_s} of {limit_s} s");
                    BenchError::Row { path: opened.path.clone(), id, what: "result", text }
                }
                other => other,
            })
        })?;
        drop(statement);
        opened.runs()?;
        opened.scenarios()?;
        self.done(self.connection.execute("ATTACH DATABASE ?1 AS others", [&others]))?;
        let overlap = if keep_first { Ok(None) } else { self.overlap_with_others(&opened.path) };
        let merged = match overlap {
            Ok(None) => self.take_up_others(is_older),
            Ok(Some((count, first))) => {
                let (path, into) = (opened.path.clone(), self.path.clone());
                Err(BenchError::Overlap { path, into, count, first })
            }
            Err(fault) => Err(fault),
        };
        let detached = self.done(self.connection.execute_batch("DETACH DATABASE others"));
        let merged = merged?;
        detached.map(|()| merged)
    }

    /// Merges `others` into the results `into`, new or existing, all or none; returns these with the summary of each merge. A
    /// new file appears complete or not at all; an existing one is merged in a copy first.
    ///
    /// # Errors
    /// As [`Self::create`] and [`Self::merge`], and [`BenchError::Unwritable`].
    pub fn merged(
        into: &Path,
        others: &[PathBuf],
        keep_first: bool,
    ) -> Result<(Self, Vec<Merged>), BenchError> {
        let take_up = |results: &mut Self| -> Result<Vec<Merged>, BenchError> {
            others.iter().map(|other| results.merge(other, keep_first)).collect()
        };
        if into.exists() {
            if others.len() > 1 {
                drop(Self::create(into)?);
                let (_copy, file) = results_file::copied(into)?;
                let mut rehearsal = Self::create(&file)?;
                into.clone_into(&mut rehearsal.path);
                take_up(&mut rehearsal)?;
            }
            let mut results = Self::create(into)?;
            let merged = take_up(&mut results)?;
            return Ok((results, merged));
        }
        let beside = results_file::folder_beside(into)?;
        let partial = beside.path().join("results.db");
        results_file::begin(&partial)?;
        let mut results = Self::new(results_file::open(&partial)?, into);
        let merged = take_up(&mut results)?;
        // Closing the last handle writes back the log.
        drop(results);
        results_file::settle(&partial, into)?;
        Ok((Self::create(into)?, merged))
    }

    /// Returns the number of trials with different results here and in the attached others, and one of them.
    fn overlap_with_others(&self, others: &Path) -> Result<Option<(u64, String)>, BenchError> {
        let runs: u64 = self.done(self.connection.query_row(OTHER_RUNS, [], |row| row.get(0)))?;
        if runs > 0 {
            let (path, into) = (others.to_owned(), self.path.clone());
            return Err(BenchError::OtherRun { path, into, runs });
        }
        let row = |row: &rusqlite::Row| Ok((row.get(0)?, row.get::<_, Option<String>>(1)?));
        let (count, first) = self.done(self.connection.query_row(&results_row::overlap(), [], row))?;
        Ok(first.map(|first| (count, first)))
    }

    fn take_up_others(&mut self, is_older: bool) -> Result<Merged, BenchError> {
        let path = self.path.clone();
        let take_up = |connection: &mut Connection| {
            let transaction = connection.transaction()?;
            transaction.execute_batch(&take_up_runs(is_older))?;
            let added = transaction.execute(&results_row::take_up_trials(is_older, UNKNOWN), [])?;
            let all: u64 =
                transaction.query_row("SELECT count(*) FROM others.trials", [], |row| row.get(0))?;
            transaction.commit()?;
            Ok(Merged { added: added as u64, known: all - added as u64 })
        };
        take_up(&mut self.connection).map_err(|reason| BenchError::Database { path, reason })
    }

    /// Reads trials; `which` is the condition and the order in SQL.
    fn select(&self, which: &str, parameters: impl rusqlite::Params) -> Result<Vec<StoredTrial>, BenchError> {
        let sql = format!("{} {which}", results_row::selection(self.is_older()?));
        let mut statement = self.done(self.connection.prepare(&sql))?;
        let mut trials = Vec::new();
        results_row::for_each(self.done(statement.query(parameters))?, &self.path, |trial| {
            trials.push(trial);
            Ok(())
        })?;
        Ok(trials)
    }

    fn is_older(&self) -> Result<bool, BenchError> {
        self.done(results_file::is_older(&self.connection))
    }

    pub(crate) fn done<T>(&self, result: rusqlite::Result<T>) -> Result<T, BenchError> {
        result.map_err(|reason| BenchError::Database { path: self.path.clone(), reason })
    }
}

/// Returns the columns of runs that older results lack.
fn added_to_runs(is_older: bool) -> &'static str {
    if is_older { "NULL, NULL" } else { "memory_limit_bytes, sandbox" }
}

/// Counts the runs of the attached others that have another content here; the end of a run may be known later.
const OTHER_RUNS: &str = "SELECT count(*) FROM others.runs AS theirs JOIN main.runs AS mine USING (identity)
     WHERE (mine.machine, mine.processor, mine.cpu_features, mine.cores, mine.version, mine.commit_hash, mine.command,
            mine.workers, mine.began)
     IS NOT (theirs.machine, theirs.processor, theirs.cpu_features, theirs.cores, theirs.version, theirs.commit_hash,
             theirs.command, theirs.workers, theirs.began)";

fn take_up_runs(is_older: bool) -> String {
    let added = added_to_runs(is_older);
    format!(
        "INSERT OR IGNORE INTO runs (identity, machine, processor, cpu_features, cores, version, commit_hash, command,
             workers, began, ended, memory_limit_bytes, sandbox)
         SELECT identity, machine, processor, cpu_features, cores, version, commit_hash, command, workers, began,
             ended, {added}
         FROM others.runs ORDER BY id;
         INSERT OR IGNORE INTO runs (identity, machine, processor, cpu_features, cores, version, command, workers, began)
         SELECT '{UNKNOWN}', '{UNKNOWN}', '{UNKNOWN}', '', 0, '{UNKNOWN}', '{UNKNOWN}', 0, '{UNKNOWN}'
         WHERE EXISTS (SELECT 1 FROM others.trials WHERE run NOT IN (SELECT id FROM others.runs));
         INSERT INTO scenarios SELECT * FROM others.scenarios WHERE true
         ON CONFLICT DO UPDATE SET goals = COALESCE(goals, excluded.goals);
         INSERT OR IGNORE INTO planners SELECT * FROM others.planners;"
    )
}
