use std::io::Write;

use cranny_collision::Margins;
use cranny_file::{counted, visible};
use cranny_path::{AppliedMargin, ClearanceLimit};
use cranny_task::{AllowedContact, NotChecked, NotCheckedReason, OwnGrasp};
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

/// Metres of a lower bound as millimetres for a person: never more than the bound.
pub fn at_least_mm(bound_m: f64) -> String {
    format!("{} mm", cranny_file::at_least(bound_m, 1e3, 2))
}

/// Metres of an upper bound as millimetres for a person: never less than the bound.
pub fn at_most_mm(bound_m: f64) -> String {
    format!("{} mm", cranny_file::at_most(bound_m, 1e3, 2))
}

/// Radians of an upper bound as degrees for a person: never less than the bound.
pub fn at_most_degrees(bound_rad: f64) -> String {
    format!("{}°", cranny_file::at_most(bound_rad, 1_f64.to_degrees(), 2))
}

/// Seconds that something takes for a person: never less.
pub fn at_most_seconds(seconds: f64) -> String {
    format!("{} s", cranny_file::at_most(seconds, 1.0, 3))
}

/// Radians of a lower bound as degrees for a person: never more than the bound.
pub fn at_least_degrees(bound_rad: f64) -> String {
    format!("{}°", cranny_file::at_least(bound_rad, 1_f64.to_degrees(), 2))
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
    let OwnGrasp { opening_m, score, uneven_m, .. } = grasp;
    let score = cranny_file::at_least(*score, 1.0, 2);
    let (opening, uneven) = (millimetres(*opening_m), uneven(*uneven_m));
    format!("of its own (score {score}), fingers {opening} apart when closed{uneven}")
}

/// Difference of the travel of two fingers above which it is reported, in metres: less is invisible.
const UNEVEN_M: f64 = 1e-3;

/// Text on fingers of which one meets the object before the other; empty where that is hardly so.
pub fn uneven(uneven_m: Option<f64>) -> String {
    uneven_m.filter(|uneven_m| *uneven_m > UNEVEN_M).map_or_else(String::new, |uneven_m| {
        format!(" (one meets it {} before the other: it will be pushed, or the hand)", at_most_mm(uneven_m))
    })
}

/// What is said of a number beyond the last of `count` things, which are counted from 0.
pub fn only_so_many(count: usize, noun: &str) -> String {
    let verb = if count == 1 { "is" } else { "are" };
    format!("there {verb} {}, counted from 0", counted(count, noun))
}

/// The two things that limit a clearance, where the smaller grasp margin applies to them.
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

/// Text after "proven" or "valid" where something was not compared, or may touch; empty elsewhere.
pub fn but_for(not_checked: &[NotChecked]) -> String {
    NotChecked::summary(not_checked).map_or_else(String::new, |summary| format!(", but for {summary}"))
}

/// As many adjacent pairs are named in a line.
const MOST_NAMED: usize = 3;

/// Pairs that are not compared, why, and what to do about it, and contacts that are allowed, each with the heading of its line:
/// a line each, but one for all adjacent links of a kind.
pub fn not_checked(pairs: &[NotChecked]) -> Vec<(&'static str, String)> {
    use NotCheckedReason::{
        AdjacentAtJoint, AdjacentFree, AdjacentTouching, AdjacentUnproven, AlwaysTouching,
    };
    let alone = pairs.iter().filter_map(|NotChecked { first, second, depth_m, reason, contact }| {
        let depth = at_most_mm(*depth_m);
        if let Some(AllowedContact { segment, allowance_m }) = contact {
            let (segment, allowance) = (<&str>::from(segment), at_most_mm(*allowance_m));
            let text = format!(
                "{first} may touch the face of {second} that carries it in {segment}: {depth} deep, at most {allowance}"
            );
            return Some(("contact", text));
        }
        let text = match reason {
            AlwaysTouching => format!(
                "{first} and {second} touch wherever the joints between them stand, at least {} deep \
                 (--strict-pairs checks them; an SRDF or unchecked_pairs may exempt them)",
                at_least_mm(*depth_m)
            ),
            NotCheckedReason::NeverMoves => format!("{first} stands still, {depth} deep in {second}"),
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

/// The heading of what is not compared.
const NOT_CHECKED: &str = "not checked";
