use std::io::Write;

use cranny_collision::Margins;
use cranny_file::{counted, visible};
use cranny_path::{AppliedMargin, ClearanceLimit};
use cranny_task::{AllowedContact, FoundGrasp, NotChecked, NotCheckedReason};
use serde::Serialize;

use crate::arguments::Output;
use crate::failure::Failure;

/// Prints an answer in the format of the flags: as one JSON document, or as text unless `quiet` is set.
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

/// Formats a JSON document for output.
pub fn json(document: &impl Serialize) -> Result<String, Failure> {
    Ok(serde_json::to_string_pretty(document).map_err(std::io::Error::other)? + "\n")
}

/// Prints text on standard output with control characters made visible, because names come from files.
pub fn print(text: &str) -> Result<(), Failure> {
    write(visible(text).as_bytes())
}

/// Prints machine-readable content unchanged.
pub fn print_as_it_is(content: &[u8]) -> Result<(), Failure> {
    write(content)
}

/// Prints a note on standard error.
pub fn note(text: &str) -> Result<(), Failure> {
    Ok(writeln!(std::io::stderr(), "note: {}", visible(text))?)
}

/// Writes to standard output; a closed pipe is no error.
fn write(content: &[u8]) -> Result<(), Failure> {
    match std::io::stdout().lock().write_all(content) {
        Err(fault) if fault.kind() == std::io::ErrorKind::BrokenPipe => Ok(()),
        other => Ok(other?),
    }
}

/// Formats metres as millimetres.
pub fn millimetres(metres: f64) -> String {
    format!("{:.2} mm", metres * 1000.0)
}

/// Formats a lower bound in metres as millimetres, rounded down.
pub fn at_least_mm(bound_m: f64) -> String {
    format!("{} mm", cranny_file::at_least(bound_m, 1e3, 2))
}

/// Formats an upper bound in metres as millimetres, rounded up.
pub fn at_most_mm(bound_m: f64) -> String {
    format!("{} mm", cranny_file::at_most(bound_m, 1e3, 2))
}

/// Formats an upper bound in radians as degrees, rounded up.
pub fn at_most_degrees(bound_rad: f64) -> String {
    format!("{}°", cranny_file::at_most(bound_rad, 1_f64.to_degrees(), 2))
}

/// Formats a duration in seconds, rounded up.
pub fn at_most_seconds(seconds: f64) -> String {
    format!("{} s", cranny_file::at_most(seconds, 1.0, 3))
}

/// Formats a lower bound in radians as degrees, rounded down.
pub fn at_least_degrees(bound_rad: f64) -> String {
    let degrees = bound_rad.to_degrees();
    // A small bound is not shown as none.
    let digits = if degrees > 0.0 && degrees < 0.01 { 4 } else { 2 };
    format!("{}°", cranny_file::at_least(bound_rad, 1_f64.to_degrees(), digits))
}

/// Formats a duration in seconds, or in milliseconds below 1 s.
pub fn seconds(seconds: f64) -> String {
    if seconds < 1.0 { format!("{:.2} ms", seconds * 1e3) } else { format!("{seconds:.2} s") }
}

/// Formats radians as degrees.
pub fn degrees(radians: f64) -> String {
    format!("{:.2}°", radians.to_degrees())
}

/// Formats a score; "—" if there is none.
pub fn score(score: Option<f64>) -> String {
    score.map_or_else(|| "—".to_owned(), |s| format!("{s:.2}"))
}

/// Formats a grasp that the planner generated.
pub fn own_grasp(grasp: &FoundGrasp) -> String {
    let FoundGrasp { opening_m, score, uneven_m, .. } = grasp;
    let score = cranny_file::at_least(*score, 1.0, 2);
    let (opening, uneven) = (millimetres(*opening_m), uneven(*uneven_m));
    format!("of its own (score {score}), hand closed to {opening}{uneven}")
}

/// Difference of the travel of two fingers above which it is reported, in metres; smaller ones are invisible.
const UNEVEN_M: f64 = 1e-3;

/// Formats the fact that one finger meets the object before the other; empty if the difference is negligible.
pub fn uneven(uneven_m: Option<f64>) -> String {
    uneven_m.filter(|uneven_m| *uneven_m > UNEVEN_M).map_or_else(String::new, |uneven_m| {
        format!(" (one meets it {} before the other: it will be pushed, or the hand)", at_most_mm(uneven_m))
    })
}

/// Returns the message for an index beyond the last of `count` items, counted from 0.
pub fn only_so_many(count: usize, noun: &str) -> String {
    let verb = if count == 1 { "is" } else { "are" };
    format!("there {verb} {}, counted from 0", counted(count, noun))
}

/// Formats the pair of bodies that limits a clearance, and notes that the smaller grasp margin applies to it.
pub fn limited_by(limit: Option<&ClearanceLimit>, margins: Margins) -> String {
    let Margins { margin_m, grasp_margin_m, .. } = margins;
    match limit {
        Some(ClearanceLimit { first, second, margin: AppliedMargin::GraspMargin, .. })
            if grasp_margin_m < margin_m =>
        {
            let [margin, grasp_margin] = [margin_m, grasp_margin_m].map(at_least_mm);
            format!(
                "; limited by {first} and {second}, to which the grasp margin of {grasp_margin} applies, not the margin \
                 of {margin}"
            )
        }
        _ => String::new(),
    }
}

/// Returns text after "proven" or "valid" on pairs that were not compared or may touch; empty if there are none.
pub fn but_for(not_checked: &[NotChecked]) -> String {
    NotChecked::summary(not_checked).map_or_else(String::new, |summary| format!(", but for {summary}"))
}

/// Maximum number of adjacent pairs named in a line.
const MOST_NAMED: usize = 3;

/// Formats the pairs that are not compared, with reason and remedy, and the allowed contacts: a line each with its heading;
/// adjacent links share one line per kind.
pub fn not_checked(pairs: &[NotChecked]) -> Vec<(&'static str, String)> {
    use NotCheckedReason::{
        AdjacentAtJoint, AdjacentFree, AdjacentTouching, AdjacentUnproven, AlwaysTouching,
    };
    let alone = pairs.iter().filter_map(|NotChecked { first, second, depth_m, reason, contact }| {
        // A depth below rounding is none.
        let depth = at_most_mm(if *depth_m < 1e-9 { 0.0 } else { *depth_m });
        if let Some(AllowedContact { segment, allowance_m }) = contact {
            let (segment, allowance) = (<&str>::from(segment), at_most_mm(*allowance_m));
            let text = format!(
                "{first} may touch the face of {second} that carries it in {segment}: {depth} deep, at most {allowance}"
            );
            return Some(("contact", text));
        }
        let text = match reason {
            AlwaysTouching => format!(
                "{first} and {second} touch in every configuration, at least {} deep (--strict-pairs checks \
                 them; an SRDF or unchecked_pairs may exempt them)",
                at_least_mm(*depth_m)
            ),
            NotCheckedReason::NeverMoves => format!("{first} never moves, and is {depth} deep in {second}"),
            _ => return None,
        };
        Some((NOT_CHECKED, text))
    });
    let mut lines: Vec<_> = alone.collect();
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
        let of_kind = pairs.iter().filter(|pair| pair.reason == reason);
        let count = of_kind.clone().count();
        let names = of_kind.take(MOST_NAMED).map(|pair| format!("{} and {}", pair.first, pair.second));
        let mut names = names.collect::<Vec<_>>().join(", ");
        if count > MOST_NAMED {
            names.push_str(", …");
        }
        if count > 0 {
            lines.push((NOT_CHECKED, format!("{} ({names}): {what}", counted(count, "pair"))));
        }
    }
    lines
}

/// Heading of the lines on pairs that are not compared.
const NOT_CHECKED: &str = "not checked";
