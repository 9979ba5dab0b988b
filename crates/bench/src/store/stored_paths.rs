//! Check of the paths of all rows, which are too large to be read with them.

use crate::{BenchError, Results, TrialOutcome};

/// Checks that each solved trial has a path, and that each path consists of whole way points.
///
/// # Errors
/// [`BenchError::Row`] with the first trial that does not, [`BenchError::Database`].
pub fn check_paths(results: &Results) -> Result<(), BenchError> {
    let sql = "SELECT id, outcome, CAST(substr(path, 1, 4) AS BLOB), length(CAST(path AS BLOB)) FROM trials
               WHERE path IS NOT NULL OR outcome = ?1 ORDER BY id";
    let mut statement = results.done(results.connection.prepare(sql))?;
    let mut rows = results.done(statement.query([TrialOutcome::Solved.name()]))?;
    while let Some(row) = results.done(rows.next())? {
        let head: Option<Vec<u8>> = results.done(row.get(2))?;
        let length: Option<u64> = results.done(row.get(3))?;
        let way_points = length.zip(head).map_or(Some(0), |(length, head)| way_points_in(length, &head));
        let is_solved = results.done(row.get::<_, String>(1))? == TrialOutcome::Solved.name();
        let (what, text) = match way_points {
            None => ("path", format!("{} bytes", length.unwrap_or(0))),
            Some(0) if is_solved => ("result", "solved without a path".to_owned()),
            Some(_) => continue,
        };
        let id = results.done(row.get(0))?;
        return Err(BenchError::Row { path: results.path().to_owned(), id, what, text });
    }
    Ok(())
}

/// Returns the number of way points of a stored path of this length in bytes that begins with `head`; `None` if it is cut.
fn way_points_in(length: u64, head: &[u8]) -> Option<u64> {
    let joints = u64::from(u32::from_le_bytes(head.try_into().ok()?));
    let (values, of_way_point) = (length - head.len() as u64, 8 * joints);
    if joints == 0 {
        return (values == 0).then_some(0);
    }
    values.is_multiple_of(of_way_point).then(|| values / of_way_point)
}
