use std::io::Write;

use cranny_file::{counted, visible};
use cranny_plan::{NotChecked, NotCheckedReason, OwnGrasp};
use serde::Serialize;

use crate::arguments::Output;
use crate::failure::Failure;

/// Prints an answer as the flags ask for it: as one JSON document, or for a person unless quiet was asked for.
pub fn answer(
    document: &impl Serialize,
    page: impl FnOnce() -> String,
    output: Output,
) -> Result<(), Failure> {
    match output {
        Output { json: true, .. } => print_json(document),
        Output { quiet: true, .. } => Ok(()),
        _ => print(&page()),
    }
}

/// Prints one JSON document on standard output.
pub fn print_json(document: &impl Serialize) -> Result<(), Failure> {
    write(json(document)?.as_bytes())
}

/// A JSON document as it is printed or written to a file.
pub fn json(document: &impl Serialize) -> Result<String, Failure> {
    Ok(serde_json::to_string_pretty(document).map_err(std::io::Error::other)? + "\n")
}

/// Prints text on standard output, what a terminal would obey made visible: names come from files.
pub fn print(text: &str) -> Result<(), Failure> {
    write(visible(text).as_bytes())
}

/// Prints what another program reads, unchanged.
pub fn print_as_it_is(content: &[u8]) -> Result<(), Failure> {
    write(content)
}

/// Says something beside the answer, on standard error.
pub fn note(text: &str) -> Result<(), Failure> {
    Ok(writeln!(std::io::stderr(), "note: {}", visible(text))?)
}

/// A reader that has gone away is no failure.
fn write(content: &[u8]) -> Result<(), Failure> {
    match std::io::stdout().lock().write_all(content) {
        Err(fault) if fault.kind() == std::io::ErrorKind::BrokenPipe => Ok(()),
        other => Ok(other?),
    }
}

/// Metres as millimetres for a person.
pub fn millimetres(metres: f64) -> String {
    format!("{:.2} mm", metres * 1000.0)
}

/// Seconds for a person, short ones as milliseconds.
pub fn seconds(seconds: f64) -> String {
    if seconds < 1.0 { format!("{:.2} ms", seconds * 1e3) } else { format!("{seconds:.2} s") }
}

/// Radians as degrees for a person.
pub fn degrees(radians: f64) -> String {
    format!("{:.2}°", radians.to_degrees())
}

/// A score for a person; "—" where there is none.
pub fn score(score: Option<f64>) -> String {
    score.map_or_else(|| "—".to_owned(), |s| format!("{s:.2}"))
}

/// A grasp that a planner made.
pub fn own_grasp(grasp: &OwnGrasp) -> String {
    let OwnGrasp { opening_m, score: own, .. } = grasp;
    format!("of its own (score {}), fingers {} apart when closed", score(Some(*own)), millimetres(*opening_m))
}

/// What is said of a number beyond the last of `count` things, which are counted from 0.
pub fn only_so_many(count: usize, noun: &str) -> String {
    let verb = if count == 1 { "is" } else { "are" };
    format!("there {verb} {}, counted from 0", counted(count, noun))
}

/// The exception that follows "proven" or "valid" where something was not compared.
pub fn but_for(not_checked: &[NotChecked]) -> String {
    match not_checked.iter().filter(|pair| pair.is_exception()).count() {
        0 => String::new(),
        1 => ", but for 1 pair that is not checked".to_owned(),
        count => format!(", but for {count} pairs that are not checked"),
    }
}

/// As many adjacent pairs are named in a line.
const MOST_NAMED: usize = 3;

/// Pairs that are not compared, why, and what to do about it: a line each, but one for all adjacent links of a kind.
pub fn not_checked(pairs: &[NotChecked]) -> Vec<String> {
    use NotCheckedReason::{
        AdjacentAtJoint, AdjacentFree, AdjacentTouching, AdjacentUnproven, AlwaysTouching,
    };
    let of = |reason| pairs.iter().filter(move |pair| pair.reason == reason);
    let alone = pairs.iter().filter_map(|NotChecked { first, second, depth_m, reason }| {
        let depth = millimetres(*depth_m);
        match reason {
            AlwaysTouching => Some(format!(
                "{first} and {second} touch wherever the joints between them stand, at least {depth} deep \
                 (--strict-pairs checks them; an SRDF or unchecked_pairs may exempt them)"
            )),
            NotCheckedReason::NeverMoves => Some(format!("{first} stands still, {depth} deep in {second}")),
            _ => None,
        }
    });
    let mut lines: Vec<String> = alone.collect();
    for (reason, what) in [
        (AdjacentTouching, "adjacent, touching at every value of their joint"),
        (
            AdjacentAtJoint,
            "adjacent, touching near their joint at some of its values (--strict-pairs checks them)",
        ),
        (AdjacentUnproven, "adjacent, too close to prove them free at any value of their joint"),
        (
            AdjacentFree,
            "adjacent, proven to touch at no value of their joint: their distance alone is not counted",
        ),
    ] {
        let count = of(reason).count();
        let names = of(reason).take(MOST_NAMED).map(|pair| format!("{} and {}", pair.first, pair.second));
        let mut names = names.collect::<Vec<_>>().join(", ");
        if count > MOST_NAMED {
            names.push_str(", …");
        }
        if count > 0 {
            lines.push(format!("{} ({names}): {what}", counted(count, "pair")));
        }
    }
    lines
}
