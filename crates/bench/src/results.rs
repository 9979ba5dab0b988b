use std::path::{Path, PathBuf};
use std::time::Duration;

use rusqlite::{Connection, OpenFlags, OptionalExtension as _, params};

use crate::results_row::{self, COLUMNS};
use crate::{BenchError, RunInformation, Trial, TrialRecord};

/// The results of campaigns: one `SQLite` file, one row a trial.
///
/// Every trial is written as it ends, in a transaction of its own, to a write-ahead log: whatever ends the
/// program, at most the trial under way is lost. A [`Trial`] can be there but once.
#[derive(Debug)]
pub struct Results {
    connection: Connection,
    path: PathBuf,
}

/// A run of a campaign, as the results keep it: the same campaign begun again is another run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Run {
    /// Its number in these results, from 1.
    pub id: u64,
    /// On what, by what and how.
    pub information: RunInformation,
    /// When it began: UTC, ISO 8601.
    pub began: String,
    /// When it ended; `None` where it was killed.
    pub ended: Option<String>,
}

/// A trial as the results keep it.
#[derive(Clone, Debug, PartialEq)]
pub struct StoredTrial {
    /// Its number in these results, from 1: what `cranny bench replay` is given.
    pub id: u64,
    /// The [`Run`] that it was part of, by number.
    pub run: u64,
    /// The trial and how it went.
    pub record: TrialRecord,
    /// Whether the path also meets the other of the two criteria, where that was asked.
    pub also_solved: Option<bool>,
}

/// Where a scenario was found: what its id and hash alone do not tell.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ScenarioSource {
    /// Its id.
    pub scenario: String,
    /// Its content, as [`Trial::scenario_hash`].
    pub scenario_hash: String,
    /// What it was opened by: an id, or a path on the machine of the run.
    pub source: String,
    /// How many goal configurations are known for it (`|G_IK|`), where somebody asked.
    pub goals: Option<usize>,
}

/// What joining results did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Merged {
    /// Trials that were new.
    pub added: u64,
    /// Trials that were there already, and stayed as they were.
    pub known: u64,
}

/// "CRNY": what tells the results from other databases.
const APPLICATION: i64 = 0x4352_4e59;

/// The version of the tables.
const VERSION: i64 = 1;

const TABLES: &str = "
CREATE TABLE runs (
    id INTEGER PRIMARY KEY,
    identity TEXT NOT NULL UNIQUE DEFAULT (lower(hex(randomblob(16)))),
    machine TEXT NOT NULL,
    processor TEXT NOT NULL,
    cpu_features TEXT NOT NULL,
    cores INTEGER NOT NULL,
    version TEXT NOT NULL,
    commit_hash TEXT,
    command TEXT NOT NULL,
    workers INTEGER NOT NULL,
    began TEXT NOT NULL DEFAULT (strftime('%Y-%m-%dT%H:%M:%SZ', 'now')),
    ended TEXT
);
CREATE TABLE scenarios (
    scenario TEXT NOT NULL,
    scenario_hash TEXT NOT NULL,
    source TEXT NOT NULL,
    goals INTEGER,
    PRIMARY KEY (scenario, scenario_hash)
);
CREATE TABLE planners (
    planner TEXT NOT NULL,
    settings TEXT NOT NULL,
    source TEXT NOT NULL,
    PRIMARY KEY (planner, settings)
);
CREATE TABLE trials (
    id INTEGER PRIMARY KEY,
    run INTEGER NOT NULL REFERENCES runs (id),
    scenario TEXT NOT NULL,
    scenario_hash TEXT NOT NULL,
    planner TEXT NOT NULL,
    settings TEXT NOT NULL,
    criterion TEXT NOT NULL,
    seed INTEGER NOT NULL,
    time_limit_s REAL NOT NULL,
    iteration_limit INTEGER,
    goal INTEGER,
    outcome TEXT NOT NULL,
    detail TEXT,
    iterations INTEGER NOT NULL,
    nodes INTEGER NOT NULL,
    collision_checks INTEGER NOT NULL,
    ik_attempts INTEGER NOT NULL,
    goals_tried INTEGER NOT NULL,
    planning_time_s REAL NOT NULL,
    ik_time_s REAL NOT NULL,
    collision_time_s REAL NOT NULL,
    proof_time_s REAL NOT NULL,
    nearest_time_s REAL NOT NULL,
    path_length REAL,
    clearance_m REAL,
    grasp INTEGER,
    grasp_score REAL,
    also_solved INTEGER,
    path BLOB
);
CREATE UNIQUE INDEX trial_identity ON trials (
    scenario, scenario_hash, planner, settings, criterion, seed, time_limit_s,
    COALESCE(iteration_limit, -1), COALESCE(goal, -1)
);";

impl Results {
    /// Opens the results at `path` to add to them; begins new ones where there are none.
    ///
    /// # Errors
    /// [`BenchError::NotResults`], [`BenchError::ResultsVersion`], [`BenchError::Database`]; what stood there
    /// before is untouched.
    pub fn create(path: &Path) -> Result<Self, BenchError> {
        Self::connect(path, OpenFlags::SQLITE_OPEN_READ_WRITE | OpenFlags::SQLITE_OPEN_CREATE)
    }

    /// Opens the results at `path`.
    ///
    /// # Errors
    /// As [`Self::create`], and [`BenchError::NoResults`] where there are none.
    pub fn open(path: &Path) -> Result<Self, BenchError> {
        if !path.is_file() {
            return Err(BenchError::NoResults { path: path.to_owned() });
        }
        // Read and write, because a log that a killed run left behind is written back first.
        Self::connect(path, OpenFlags::SQLITE_OPEN_READ_WRITE)
    }

    fn connect(path: &Path, flags: OpenFlags) -> Result<Self, BenchError> {
        let fault = |reason: rusqlite::Error| match reason.sqlite_error_code() {
            Some(rusqlite::ErrorCode::NotADatabase) => BenchError::NotResults { path: path.to_owned() },
            _ => BenchError::Database { path: path.to_owned(), reason },
        };
        let mut connection = Connection::open_with_flags(path, flags).map_err(fault)?;
        connection.busy_timeout(PATIENCE).map_err(fault)?;
        let pragma = |connection: &Connection, name: &str| {
            connection.pragma_query_value(None, name, |row| row.get::<_, i64>(0)).map_err(fault)
        };
        let tables: i64 = connection
            .query_row("SELECT count(*) FROM sqlite_schema", [], |row| row.get(0))
            .map_err(fault)?;
        if tables > 0 {
            if pragma(&connection, "application_id")? != APPLICATION {
                return Err(BenchError::NotResults { path: path.to_owned() });
            }
            let actual = pragma(&connection, "user_version")?;
            if actual != VERSION {
                return Err(BenchError::ResultsVersion { path: path.to_owned(), expected: VERSION, actual });
            }
        }
        // A commit survives the end of the program; only the end of the machine may take the last ones with it.
        connection.pragma_update(None, "journal_mode", "WAL").map_err(fault)?;
        connection.pragma_update(None, "synchronous", "NORMAL").map_err(fault)?;
        if tables == 0 {
            // In one transaction: results that are half begun are none.
            let transaction = connection.transaction().map_err(fault)?;
            transaction.execute_batch(TABLES).map_err(fault)?;
            transaction.pragma_update(None, "application_id", APPLICATION).map_err(fault)?;
            transaction.pragma_update(None, "user_version", VERSION).map_err(fault)?;
            transaction.commit().map_err(fault)?;
        }
        Ok(Self { connection, path: path.to_owned() })
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Begins a run, and returns its number.
    ///
    /// # Errors
    /// [`BenchError::Database`].
    pub fn begin_run(&mut self, information: &RunInformation) -> Result<u64, BenchError> {
        let RunInformation { machine, processor, cpu_features, cores, version, commit, command, workers } =
            information;
        self.done(self.connection.execute(
            "INSERT INTO runs (machine, processor, cpu_features, cores, version, commit_hash, command, workers)
             VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8)",
            params![machine, processor, cpu_features.join(" "), cores, version, commit, command, workers],
        ))?;
        Ok(self.connection.last_insert_rowid().cast_unsigned())
    }

    /// Notes that a run ended by itself.
    ///
    /// # Errors
    /// [`BenchError::Database`].
    pub fn end_run(&mut self, run: u64) -> Result<(), BenchError> {
        let sql = "UPDATE runs SET ended = strftime('%Y-%m-%dT%H:%M:%SZ', 'now') WHERE id = ?1";
        self.done(self.connection.execute(sql, [run])).map(drop)
    }

    /// Adds a trial with the path that its planner gave, and returns whether it was new: one that is there
    /// already stays as it is.
    ///
    /// # Errors
    /// [`BenchError::Database`].
    pub fn append(
        &mut self,
        run: u64,
        record: &TrialRecord,
        also_solved: Option<bool>,
        path: &[Vec<f64>],
    ) -> Result<bool, BenchError> {
        let added = results_row::insert(&self.connection, run, record, also_solved, path);
        Ok(self.done(added)? == 1)
    }

    /// Notes where a scenario was found.
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

    /// Notes how a planner is called, as JSON: what its name and settings do not tell.
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

    /// All trials, in the order in which they ended.
    ///
    /// # Errors
    /// [`BenchError::Row`], [`BenchError::Database`].
    pub fn trials(&self) -> Result<Vec<StoredTrial>, BenchError> {
        self.select(&format!("SELECT {COLUMNS} FROM trials ORDER BY id"), [])
    }

    /// All records, in the order in which the trials ended.
    ///
    /// # Errors
    /// As [`Self::trials`].
    pub fn records(&self) -> Result<Vec<TrialRecord>, BenchError> {
        Ok(self.trials()?.into_iter().map(|trial| trial.record).collect())
    }

    /// Which trials are there.
    ///
    /// # Errors
    /// As [`Self::trials`].
    pub fn known(&self) -> Result<Vec<Trial>, BenchError> {
        Ok(self.trials()?.into_iter().map(|trial| trial.record.trial).collect())
    }

    /// One trial.
    ///
    /// # Errors
    /// [`BenchError::NoTrial`], and as [`Self::trials`].
    pub fn trial(&self, id: u64) -> Result<StoredTrial, BenchError> {
        let found = self.select(&format!("SELECT {COLUMNS} FROM trials WHERE id = ?1"), [id])?;
        if let Some(trial) = found.into_iter().next() {
            return Ok(trial);
        }
        let last = "SELECT COALESCE(max(id), 0) FROM trials";
        let last = self.done(self.connection.query_row(last, [], |row| row.get(0)))?;
        Err(BenchError::NoTrial { path: self.path.clone(), id, last })
    }

    /// The path that the planner of a trial gave, bit by bit; empty where it gave none.
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

    /// All runs.
    ///
    /// # Errors
    /// [`BenchError::Database`].
    pub fn runs(&self) -> Result<Vec<Run>, BenchError> {
        let sql =
            "SELECT id, machine, processor, cpu_features, cores, version, commit_hash, command, workers,
                   began, ended FROM runs ORDER BY id";
        let mut statement = self.done(self.connection.prepare(sql))?;
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
            };
            Ok(Run { id: row.get(0)?, information, began: row.get(9)?, ended: row.get(10)? })
        });
        self.done(rows.and_then(Iterator::collect))
    }

    /// Where the scenarios were found.
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

    /// How a planner is called, if that was noted.
    ///
    /// # Errors
    /// [`BenchError::Database`].
    pub fn planner_source(&self, planner: &str, settings: &str) -> Result<Option<String>, BenchError> {
        let sql = "SELECT source FROM planners WHERE planner = ?1 AND settings = ?2";
        self.done(self.connection.query_row(sql, [planner, settings], |row| row.get(0)).optional())
    }

    /// Takes up the runs and trials of other results; a trial that is there already stays as it is. All or
    /// nothing.
    ///
    /// # Errors
    /// As [`Self::open`] of the others, [`BenchError::Database`].
    pub fn merge(&mut self, others: &Path) -> Result<Merged, BenchError> {
        // Opened by itself first, for its log and its faults.
        Self::open(others)?;
        let others = others.to_string_lossy();
        self.done(self.connection.execute("ATTACH DATABASE ?1 AS others", [&others]))?;
        let merged = self.take_up_others();
        let detached = self.done(self.connection.execute_batch("DETACH DATABASE others"));
        let merged = merged?;
        detached.map(|()| merged)
    }

    fn take_up_others(&mut self) -> Result<Merged, BenchError> {
        let path = self.path.clone();
        let take_up = |connection: &mut Connection| {
            let transaction = connection.transaction()?;
            transaction.execute_batch(TAKE_UP_RUNS)?;
            let added = transaction.execute(&results_row::take_up_trials(), [])?;
            let all: u64 =
                transaction.query_row("SELECT count(*) FROM others.trials", [], |row| row.get(0))?;
            transaction.commit()?;
            Ok(Merged { added: added as u64, known: all - added as u64 })
        };
        take_up(&mut self.connection).map_err(|reason| BenchError::Database { path, reason })
    }

    fn select(&self, sql: &str, parameters: impl rusqlite::Params) -> Result<Vec<StoredTrial>, BenchError> {
        let mut statement = self.done(self.connection.prepare(sql))?;
        let rows = self.done(statement.query(parameters))?;
        results_row::read(rows, &self.path)
    }

    fn done<T>(&self, result: rusqlite::Result<T>) -> Result<T, BenchError> {
        result.map_err(|reason| BenchError::Database { path: self.path.clone(), reason })
    }
}

/// How long one program waits until another has written.
const PATIENCE: Duration = Duration::from_secs(10);

const TAKE_UP_RUNS: &str = "
INSERT OR IGNORE INTO runs (identity, machine, processor, cpu_features, cores, version, commit_hash, command,
    workers, began, ended)
SELECT identity, machine, processor, cpu_features, cores, version, commit_hash, command, workers, began, ended
FROM others.runs ORDER BY id;
INSERT OR IGNORE INTO scenarios SELECT * FROM others.scenarios;
INSERT OR IGNORE INTO planners SELECT * FROM others.planners;";
