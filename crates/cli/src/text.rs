use std::io::Write;

use cranny_file::visible;
use serde::Serialize;

use crate::failure::Failure;

/// Prints one JSON document on standard output.
pub fn print_json(document: &impl Serialize) -> Result<(), Failure> {
    let mut text = serde_json::to_string_pretty(document).map_err(std::io::Error::other)?;
    text.push('\n');
    write(&text)
}

/// Prints text on standard output, what a terminal would obey made visible: names come from files.
pub fn print(text: &str) -> Result<(), Failure> {
    write(&visible(text))
}

/// Says something beside the answer, on standard error.
pub fn note(text: &str) -> Result<(), Failure> {
    Ok(writeln!(std::io::stderr(), "note: {}", visible(text))?)
}

/// A reader that has gone away is no failure.
fn write(text: &str) -> Result<(), Failure> {
    match std::io::stdout().lock().write_all(text.as_bytes()) {
        Err(fault) if fault.kind() == std::io::ErrorKind::BrokenPipe => Ok(()),
        other => Ok(other?),
    }
}

/// Metres as millimetres for a person.
pub fn millimetres(metres: f64) -> String {
    format!("{:.2} mm", metres * 1000.0)
}

/// Radians as degrees for a person.
pub fn degrees(radians: f64) -> String {
    format!("{:.2}°", radians.to_degrees())
}

/// A score for a person; "—" where there is none.
pub fn score(score: Option<f64>) -> String {
    score.map_or_else(|| "—".to_owned(), |s| format!("{s:.2}"))
}
