//! Results file as a database, with the checks that precede any use of its content.

use std::collections::BTreeMap;
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::time::Duration;

use cranny_file::system::open_plain_file;
use cranny_scenario::{StagingFolder, Temporary};
use rusqlite::config::DbConfig;
use rusqlite::limits::Limit;
use rusqlite::{Connection, ErrorCode, OpenFlags, TransactionBehavior};

use crate::BenchError;

/// Mark of results files among other databases: "CRNY".
pub const APPLICATION: i64 = 0x4352_4e59;

/// Version of the tables that campaigns write.
const VERSION: i64 = 2;

/// Version of older results without [`ADDITIONS`], which are read unchanged.
const OLDER: i64 = 1;

/// Columns that version 2 adds to [`TABLES`]; results of version 1 get them when a campaign continues with them.
const ADDITIONS: &str = "
ALTER TABLE runs ADD COLUMN memory_limit_bytes INTEGER;
ALTER TABLE runs ADD COLUMN sandbox TEXT;
ALTER TABLE trials ADD COLUMN memory_bytes INTEGER;";

/// Tables of version 1.
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

/// Maximum wait for another program to finish writing.
const PATIENCE: Duration = Duration::from_secs(10);

/// Maximum length of a text or path of a trial, in bytes: four times the maximum output of a program.
const MOST_VALUE_BYTES: i32 = 256 << 20;

/// Creates the file if it is missing, completely or not at all, also on a full disk. An empty file is filled.
pub fn begin(path: &Path) -> Result<(), BenchError> {
    let write = |place: &Path| {
        let written = Connection::open(place).and_then(|mut connection| write_tables(&mut connection));
        written.map_err(|reason| fault(path, reason))
    };
    if let Ok(found) = fs::metadata(path) {
        return if found.is_file() && found.len() == 0 { write(path) } else { Ok(()) };
    }
    let beside = folder_beside(path)?;
    let partial = beside.path().join("results.db");
    write(&partial)?;
    match settle(&partial, path) {
        // Another program created the file first, and its file is equivalent.
        Err(BenchError::Unwritable { reason, .. }) if reason.kind() == ErrorKind::AlreadyExists => Ok(()),
        settled => settled,
    }
}

/// Results file in use by a campaign.
#[derive(Debug)]
pub struct Claim {
    /// The file, locked if its file system has locks; the system releases the lock at any end of the campaign.
    pub file: fs::File,
    /// Greatest length until now, in bytes: `SQLite` never shortens a file whose rows are not deleted.
    pub bytes: u64,
}

/// Creates a temporary folder beside a file, for building its replacement.
pub fn folder_beside(path: &Path) -> Result<StagingFolder, BenchError> {
    StagingFolder::beside(path).map_err(|reason| BenchError::Unwritable { path: path.to_owned(), reason })
}

/// Moves a complete file to its destination, unless that exists by now.
pub fn settle(partial: &Path, path: &Path) -> Result<(), BenchError> {
    let settled = match fs::hard_link(partial, path) {
        // Without hard links, two programs at the same instant may still conflict.
        Err(reason) if reason.kind() != ErrorKind::AlreadyExists => fs::rename(partial, path),
        settled => settled,
    };
    settled.map_err(|reason| BenchError::Unwritable { path: path.to_owned(), reason })
}

/// Opens a results file. Its tables are checked before every query, because a view instead of a table can be endless, and
/// because pages may be damaged.
pub fn open(path: &Path) -> Result<Connection, BenchError> {
    let connection = open_unseen(path)?;
    check_pages(path, &connection)?;
    Ok(connection)
}

/// Opens a results file without checking its pages.
pub fn open_unseen(path: &Path) -> Result<Connection, BenchError> {
    let fault = |reason| fault(path, reason);
    check_kinds(path)?;
    // Read and write, because a log that a killed run left behind is written back first.
    let connection = Connection::open_with_flags(path, OpenFlags::SQLITE_OPEN_READ_WRITE).map_err(fault)?;
    harden(&connection).map_err(fault)?;
    let number = |name| connection.pragma_query_value(None, name, |row| row.get(0)).map_err(fault);
    if number("application_id")? != APPLICATION {
        return Err(BenchError::NotResults { path: path.to_owned() });
    }
    let actual = number("user_version")?;
    if ![OLDER, VERSION].contains(&actual) {
        return Err(BenchError::ResultsVersion { path: path.to_owned(), expected: VERSION, actual });
    }
    check_tables(path, &connection, actual)?;
    // A commit survives the end of the program; a failure of the machine may lose the last ones.
    connection.pragma_update(None, "journal_mode", "WAL").map_err(fault)?;
    connection.pragma_update(None, "synchronous", "NORMAL").map_err(fault)?;
    Ok(connection)
}

/// Checks that the results are a file, and that so is what `SQLite` would open beside it: it would wait for the other end of a
/// pipe.
fn check_kinds(path: &Path) -> Result<(), BenchError> {
    if !path.is_file() {
        return Err(BenchError::NotResults { path: path.to_owned() });
    }
    for ending in ["-wal", "-shm", "-journal"] {
        let path = beside(path, ending);
        // Opening and closing it here would release the locks that `SQLite` has on it.
        if let Ok(found) = fs::metadata(&path)
            && !found.is_file()
        {
            let reason = std::io::Error::other("it is no regular file");
            return Err(BenchError::Unreadable { path, reason });
        }
    }
    Ok(())
}

/// Returns the path of a file that `SQLite` keeps beside the results.
pub fn beside(path: &Path, ending: &str) -> PathBuf {
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(ending);
    path.with_file_name(name)
}

/// Upgrades older results to the current version, completely or not at all.
pub fn bring_up_to_date(path: &Path, connection: &mut Connection) -> Result<(), BenchError> {
    let mut add = || -> rusqlite::Result<()> {
        let transaction = connection.transaction_with_behavior(TransactionBehavior::Immediate)?;
        if is_older(&transaction)? {
            transaction.execute_batch(ADDITIONS)?;
            transaction.pragma_update(None, "user_version", VERSION)?;
        }
        transaction.commit()
    };
    add().map_err(|reason| fault(path, reason))
}

/// Returns true if results lack [`ADDITIONS`].
pub fn is_older(connection: &Connection) -> rusqlite::Result<bool> {
    connection.pragma_query_value(None, "user_version", |row| Ok(row.get::<_, i64>(0)? == OLDER))
}

/// Returns true if the results, and the files that `SQLite` creates beside them, can be written.
pub fn is_writable(path: &Path) -> bool {
    // Opening a pipe would wait for its reader.
    path.is_file()
        && fs::OpenOptions::new().write(true).open(path).is_ok()
        && tempfile::tempfile_in(folder_of(path)).is_ok()
}

/// Returns the folder of a file.
pub fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// File name of a copy of results.
pub const COPY: &str = "results.db";

/// Copies results with their log to a temporary folder.
pub fn copied(path: &Path) -> Result<(Temporary, PathBuf), BenchError> {
    let copy = || -> std::io::Result<_> {
        let folder = Temporary::folder()?;
        let file = folder.path().join(COPY);
        std::io::copy(&mut open_plain_file(path)?, &mut fs::File::create(&file)?)?;
        if let Ok(mut log) = open_plain_file(&beside(path, "-wal")) {
            std::io::copy(&mut log, &mut fs::File::create(beside(&file, "-wal"))?)?;
        }
        Ok((folder, file))
    };
    copy().map_err(|reason| BenchError::Unreadable { path: path.to_owned(), reason })
}

/// Disables the execution of code in the file, and limits the length of values.
fn harden(connection: &Connection) -> rusqlite::Result<()> {
    connection.busy_timeout(PATIENCE)?;
    connection.set_db_config(DbConfig::SQLITE_DBCONFIG_DEFENSIVE, true)?;
    for forbidden in [
        DbConfig::SQLITE_DBCONFIG_TRUSTED_SCHEMA,
        DbConfig::SQLITE_DBCONFIG_ENABLE_TRIGGER,
        DbConfig::SQLITE_DBCONFIG_ENABLE_VIEW,
    ] {
        connection.set_db_config(forbidden, false)?;
    }
    connection.set_limit(Limit::SQLITE_LIMIT_LENGTH, MOST_VALUE_BYTES).map(drop)
}

/// Writes the tables in one transaction, because incomplete results are invalid.
fn write_tables(connection: &mut Connection) -> rusqlite::Result<()> {
    let transaction = connection.transaction()?;
    transaction.execute_batch(TABLES)?;
    transaction.execute_batch(ADDITIONS)?;
    transaction.pragma_update(None, "application_id", APPLICATION)?;
    transaction.pragma_update(None, "user_version", VERSION)?;
    transaction.commit()
}

/// Checks that the tables and their index are exactly as expected. Other content of the file is never queried.
fn check_tables(path: &Path, connection: &Connection, version: i64) -> Result<(), BenchError> {
    let fault = |reason| fault(path, reason);
    let found = definitions(connection).map_err(fault)?;
    let additions = if version == OLDER { "" } else { ADDITIONS };
    let tables = |own: Connection| own.execute_batch(&format!("{TABLES}{additions}")).map(|()| own);
    let own = Connection::open_in_memory().and_then(tables);
    for (name, definition) in own.and_then(|own| definitions(&own)).map_err(fault)? {
        if found.get(&name) != Some(&definition) {
            return Err(BenchError::OtherTable { path: path.to_owned(), name });
        }
    }
    Ok(())
}

/// Checks the integrity of the pages of the expected tables.
fn check_pages(path: &Path, connection: &Connection) -> Result<(), BenchError> {
    let fault = |reason| fault(path, reason);
    for table in ["runs", "scenarios", "planners", "trials"] {
        let verdict = |row: &rusqlite::Row| row.get::<_, String>(0);
        let sql = format!("PRAGMA quick_check('{table}')");
        let problem = connection.query_row(&sql, [], verdict).map_err(fault)?;
        if problem != "ok" {
            return Err(BenchError::Damaged { path: path.to_owned(), problem });
        }
    }
    Ok(())
}

/// Returns the SQL definition of every table, view, index and trigger by its name; automatic indices have none.
fn definitions(connection: &Connection) -> rusqlite::Result<BTreeMap<String, String>> {
    let sql = "SELECT name, sql FROM sqlite_schema WHERE sql IS NOT NULL";
    connection.prepare(sql)?.query_map([], |row| Ok((row.get(0)?, row.get(1)?)))?.collect()
}

fn fault(path: &Path, reason: rusqlite::Error) -> BenchError {
    match reason.sqlite_error_code() {
        Some(ErrorCode::NotADatabase) => BenchError::NotResults { path: path.to_owned() },
        _ => BenchError::Database { path: path.to_owned(), reason },
    }
}
