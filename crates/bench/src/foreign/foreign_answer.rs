//! Answers of external programs.

use std::path::Path;

use cranny_path::{AuditLimits, PathError};
use cranny_plan::Statistics;
use cranny_task::{Segment, Stage, check_segments, joined, number_stages};
use serde::Deserialize;
use strum::IntoStaticStr;

use crate::TrialOutcome;

/// Answer of a program, not yet judged.
#[derive(Clone, Debug, PartialEq)]
pub struct ForeignAnswer {
    /// Outcome if there is no path.
    pub outcome: TrialOutcome,
    /// Outcome in the words of the program, if it states one and there is no path.
    pub stated: Option<&'static str>,
    /// Segments of its path; empty if it found none.
    pub segments: Vec<Segment>,
    /// Statistics reported by the program.
    pub statistics: Statistics,
}

/// JSON form of an answer.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Document {
    /// Version of the protocol; 1 by default.
    #[serde(default)]
    protocol: Option<u64>,
    #[serde(default)]
    waypoints: Vec<Vec<f64>>,
    #[serde(default)]
    segments: Option<Vec<Segment>>,
    #[serde(default)]
    outcome: Option<StatedOutcome>,
    #[serde(default)]
    statistics: ForeignStatistics,
}

/// Outcome that a program may state.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, IntoStaticStr)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "kebab-case")]
enum StatedOutcome {
    Solved,
    BudgetExhausted,
    GaveUp,
    ClaimedNotProven,
    StartInvalid,
    GoalsInvalid,
    NoReachableGrasp,
    RegionOutOfReach,
}

impl StatedOutcome {
    /// Returns the outcome of a trial without a path.
    fn without_path(self) -> TrialOutcome {
        match self {
            Self::Solved | Self::BudgetExhausted => TrialOutcome::BudgetExhausted,
            // Nobody has seen the path that a program claims.
            Self::GaveUp | Self::ClaimedNotProven => TrialOutcome::GaveUp,
            Self::StartInvalid => TrialOutcome::StartInvalid,
            Self::GoalsInvalid => TrialOutcome::GoalsInvalid,
            // No trial has a region as its goal.
            Self::NoReachableGrasp | Self::RegionOutOfReach => TrialOutcome::NoReachableGrasp,
        }
    }
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct ForeignStatistics {
    iterations: u64,
    nodes: u64,
    collision_checks: u64,
    ik_attempts: u64,
    goals_tried: u64,
}

/// Maximum of each count: the largest value that a results file can store.
const MOST_COUNT: u64 = i64::MAX.cast_unsigned();

/// Maximum number of way points of a path, those of all its segments together.
const MOST_WAY_POINTS: usize = AuditLimits::UNTRUSTED.way_points;

/// Parses the output of a program: a JSON document, or way points as comma-separated lines; empty if it found no path.
///
/// A path through several stages consists of segments. Segments without stage numbers are numbered by their modes.
///
/// # Errors
/// Description of the problem, with the line. A path may have at most 10 000 way points ([`AuditLimits::UNTRUSTED`]).
pub fn read_output(output: &[u8], joints: usize, stages: &[Stage]) -> Result<ForeignAnswer, String> {
    let text = std::str::from_utf8(output).map_err(|_| "the output is not UTF-8".to_owned())?;
    if !text.trim_start().starts_with('{') {
        let segments = reach_along(read_lines(text, joints)?);
        check_stages(stages, &segments)?;
        return Ok(ForeignAnswer {
            outcome: TrialOutcome::BudgetExhausted,
            stated: None,
            segments,
            statistics: Statistics::default(),
        });
    }
    check_marks(output, joints)?;
    let document: Document =
        cranny_file::json(text.as_bytes()).map_err(|reason| format!("line {}: {reason}", reason.line))?;
    let segments = match (document.protocol.unwrap_or(1), document.segments) {
        (1 | 2, None) => {
            check_count(document.waypoints.len())?;
            reach_along(document.waypoints)
        }
        (2, Some(mut segments)) if document.waypoints.is_empty() => {
            check_count(segments.iter().map(|segment| segment.waypoints.len()).sum())?;
            if segments.iter().all(|segment| segment.stage == 0) {
                number_stages(stages, &mut segments);
            }
            let reach = [Stage::pick()];
            check_segments(if stages.is_empty() { &reach } else { stages }, &segments)?;
            // The path to a goal may consist of several segments.
            let is_reach = segments.iter().all(|segment| segment.stage == 0 && !segment.mode.holds);
            if is_reach { reach_along(joined(&segments)) } else { segments }
        }
        (1 | 2, Some(_)) => {
            return Err(
                "`segments` are valid only in answers with protocol 2 and without `waypoints`".to_owned()
            );
        }
        (other, _) => return Err(format!("unknown protocol {other} (known: 1, 2)")),
    };
    check_stages(stages, &segments)?;
    let mut way_points = segments.iter().flat_map(|segment| &segment.waypoints).enumerate();
    if let Some((index, q)) = way_points.find(|(_, q)| q.len() != joints) {
        return Err(format!("way point {index} has {} values instead of {joints}", q.len()));
    }
    let ForeignStatistics { iterations, nodes, collision_checks, ik_attempts, goals_tried } =
        document.statistics;
    if let Some(count) = [iterations, nodes, collision_checks, ik_attempts, goals_tried]
        .into_iter()
        .find(|&count| count > MOST_COUNT)
    {
        return Err(format!("the statistics contain the count {count}, which is too large"));
    }
    let stated = document.outcome.map(<&str>::from);
    match document.outcome {
        Some(StatedOutcome::Solved) if segments.is_empty() => {
            return Err("the outcome is 'solved', but there are no way points".to_owned());
        }
        Some(outcome) if outcome != StatedOutcome::Solved && !segments.is_empty() => {
            return Err(format!("the outcome is '{}', but there are way points", <&str>::from(outcome)));
        }
        _ => {}
    }
    Ok(ForeignAnswer {
        outcome: document.outcome.map_or(TrialOutcome::BudgetExhausted, StatedOutcome::without_path),
        stated: stated.filter(|_| segments.is_empty()),
        segments,
        statistics: Statistics {
            iterations,
            nodes,
            collision_checks,
            ik_attempts,
            goals_tried,
            ..Statistics::default()
        },
    })
}

/// Refuses a path with more way points than are judged.
fn check_count(actual: usize) -> Result<(), String> {
    let most = MOST_WAY_POINTS;
    if actual > most { Err(PathError::TooManyWayPoints { actual, most }.to_string()) } else { Ok(()) }
}

/// Refuses JSON with more values than any path that is judged, before it is parsed: the shortest lists of numbers take ten
/// times the memory of their text.
fn check_marks(output: &[u8], joints: usize) -> Result<(), String> {
    /// More marks per value than a way point has that is a segment of its own, with all keys and a rounded corner.
    const MARKS: usize = 24;
    let marks = output.iter().filter(|byte| matches!(byte, b',' | b'[')).count();
    if marks > MARKS * (joints + 1) * MOST_WAY_POINTS {
        return Err(format!(
            "the output has {marks} commas and brackets, more than any path of {MOST_WAY_POINTS} way points, the most \
             that are judged"
        ));
    }
    Ok(())
}

/// Converts the path of an answer that has way points alone.
fn reach_along(path: Vec<Vec<f64>>) -> Vec<Segment> {
    if path.is_empty() { Vec::new() } else { vec![Segment::reach(path, Vec::new())] }
}

/// Checks that the segments of a path match the stages of its task; without stages the path ends at the grasp.
fn check_stages(stages: &[Stage], segments: &[Segment]) -> Result<(), String> {
    let reach = [Stage::pick()];
    check_segments(if stages.is_empty() { &reach } else { stages }, segments)?;
    if stages.len() > 1 && segments.iter().all(|segment| segment.stage == 0) && !segments.is_empty() {
        let modes: Vec<String> = segments.iter().map(|segment| format!("`{}`", segment.mode.name)).collect();
        return Err(format!(
            "the path has {} only, but the task continues with the target in the hand: answer with protocol 2 and \
             segments `reach`, `lift-off`, `carry` and so on",
            modes.join(", ")
        ));
    }
    Ok(())
}

/// Summary that the released program writes in addition to its way points.
// Other keys contain settings and times of the program itself.
#[derive(Default, Deserialize)]
struct ReleasedSummary {
    #[serde(default)]
    sr: Option<f64>,
    #[serde(default)]
    iters: Option<f64>,
    #[serde(default)]
    treesize: Option<f64>,
}

/// Reads the output of the released program: `prefix.txt` (a summary as JSON) and `prefix.try` (way points).
///
/// # Errors
/// Description of the problem, with the line.
pub fn read_released(prefix: &Path, joints: usize) -> Result<ForeignAnswer, String> {
    let text = |ending: &str| cranny_file::TABLE.text(&prefix.with_extension(ending));
    let summary = text("txt").map_err(|reason| format!("the program left no .txt file: {reason}"))?;
    let summary: ReleasedSummary = cranny_file::json(summary.as_bytes())
        .map_err(|reason| format!(".txt, line {}: {reason}", reason.line))?;
    let is_solved = summary.sr.is_some_and(|rate| rate > 0.0);
    // After a failure, the way points are not a path.
    let path = match text("try") {
        Ok(way_points) if is_solved => {
            read_lines(&way_points, joints).map_err(|fault| format!(".try, {fault}"))?
        }
        Err(reason) if is_solved => return Err(format!("the program left no .try file: {reason}")),
        _ => Vec::new(),
    };
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "counts, written as numbers of any kind"
    )]
    let count = |number: Option<f64>| number.map_or(0, |number| (number.max(0.0) as u64).min(MOST_COUNT));
    let statistics = Statistics {
        iterations: count(summary.iters),
        nodes: count(summary.treesize),
        ..Statistics::default()
    };
    let segments = reach_along(path);
    Ok(ForeignAnswer { outcome: TrialOutcome::BudgetExhausted, stated: None, segments, statistics })
}

/// Parses way points, one a line; blank lines are skipped.
fn read_lines(text: &str, joints: usize) -> Result<Vec<Vec<f64>>, String> {
    check_count(text.lines().filter(|line| !line.trim().is_empty()).count())?;
    let mut path = Vec::new();
    for (index, line) in text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty()) {
        let number = |field: &str| {
            let finite = field.trim().parse().ok().filter(|number: &f64| number.is_finite());
            finite.ok_or_else(|| format!("line {}: '{}' is not a finite number", index + 1, shown(field)))
        };
        // The released files end every line with a comma.
        let fields = || line.trim().trim_end_matches(',').split(',');
        // A line of words is reported with its words.
        number(fields().next().unwrap_or_default())?;
        // The fields are counted before they are collected, because a line may have any number of them.
        let actual = fields().count();
        if actual != joints {
            return Err(format!("line {}: {actual} numbers instead of {joints}", index + 1));
        }
        path.push(fields().map(number).collect::<Result<_, String>>()?);
    }
    Ok(path)
}

/// Returns the escaped beginning of a text that may be long and unprintable.
fn shown(text: &str) -> String {
    const MOST: usize = 40;
    text.trim().chars().take(MOST).flat_map(char::escape_default).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn way_points_come_as_json_or_as_lines() {
        let expected = vec![vec![0.1 + 0.2, -1e-300], vec![1.0, 2.0]];
        let text = format!("{},{}\n\n1,2,\n", expected[0][0], expected[0][1]);
        assert_eq!(joined(&read_output(text.as_bytes(), 2, &[]).unwrap().segments), expected);
        let text =
            serde_json::json!({"waypoints": expected, "outcome": "solved", "statistics": {"iterations": 7}});
        let answer = read_output(text.to_string().as_bytes(), 2, &[]).unwrap();
        assert_eq!((joined(&answer.segments), answer.statistics.iterations), (expected, 7));
    }

    fn segments(first: &serde_json::Value, second: &serde_json::Value) -> serde_json::Value {
        let mut segments = serde_json::json!([
            {"kind": "polyline", "mode": "reach", "attached": null, "opening_m": null, "waypoints": [[0, 0], [0.5, 1]]},
            {"kind": "polyline", "mode": "reach", "waypoints": [[0.5, 1], [1, 2]]},
        ]);
        for (segment, change) in [first, second].into_iter().enumerate() {
            for (key, value) in change.as_object().unwrap() {
                segments[segment][key] = value.clone();
            }
        }
        segments
    }

    #[test]
    fn a_path_of_protocol_2_may_come_as_segments() {
        use serde_json::json;
        let read = |answer: serde_json::Value| read_output(answer.to_string().as_bytes(), 2, &[]);
        let same = json!({});
        let answer = read(json!({"protocol": 2, "segments": segments(&same, &same), "outcome": "solved"}));
        assert_eq!(joined(&answer.unwrap().segments), [[0.0, 0.0], [0.5, 1.0], [1.0, 2.0]]);
        for protocol in [1, 2] {
            let answer = read(json!({"protocol": protocol, "waypoints": [[0, 0], [1, 2]]}));
            assert_eq!(joined(&answer.unwrap().segments), [[0.0, 0.0], [1.0, 2.0]]);
        }
        assert_eq!(read(json!({"protocol": 2, "segments": []})).unwrap().segments.len(), 0);
        for (first, second, says) in [
            (json!({"kind": "spline"}), same.clone(), "a segment is of kind 'spline'"),
            (json!({"mode": ""}), same.clone(), "a segment is of mode ''"),
            (
                same.clone(),
                json!({"mode": "carry"}),
                "segment 1, 'carry', holds an object that was not picked",
            ),
            (same.clone(), json!({"attached": "ball"}), "segment 1, 'reach', states what is in the hand"),
            (json!({"opening_m": 0.04}), same.clone(), "segment 0, 'reach', states what is in the hand"),
            (json!({"waypoints": []}), same.clone(), "segment 0, 'reach', has no way points"),
            (
                same.clone(),
                json!({"waypoints": [[0.5, 1.5], [1, 2]]}),
                "does not begin where the segment before",
            ),
            (same.clone(), json!({"waypoints": [[0.5, 1], [1]]}), "way point 2 has 1 values"),
        ] {
            let fault = read(json!({"protocol": 2, "segments": segments(&first, &second)})).unwrap_err();
            assert!(fault.contains(says), "{fault}");
        }
        let whole = segments(&same, &same);
        let fault = read(json!({"protocol": 3, "segments": whole})).unwrap_err();
        assert!(fault.contains("unknown protocol 3 (known: 1, 2)"), "{fault}");
        let fault = read(json!({"segments": whole})).unwrap_err();
        assert!(fault.contains("with protocol 2"), "{fault}");
        let fault = read(json!({"protocol": 2, "segments": whole, "waypoints": [[0, 0]]})).unwrap_err();
        assert!(fault.contains("without `waypoints`"), "{fault}");
    }

    #[test]
    fn no_path_is_an_answer() {
        for text in ["", "\n \n", "{}", "{\"outcome\": \"budget-exhausted\"}"] {
            let answer = read_output(text.as_bytes(), 2, &[]).unwrap();
            assert_eq!((answer.outcome, answer.segments.len()), (TrialOutcome::BudgetExhausted, 0));
        }
        for (stated, recorded) in [
            ("no-reachable-grasp", TrialOutcome::NoReachableGrasp),
            ("region-out-of-reach", TrialOutcome::NoReachableGrasp),
            ("claimed-not-proven", TrialOutcome::GaveUp),
            ("gave-up", TrialOutcome::GaveUp),
            ("start-invalid", TrialOutcome::StartInvalid),
            ("goals-invalid", TrialOutcome::GoalsInvalid),
        ] {
            let text = serde_json::json!({"outcome": stated}).to_string();
            let answer = read_output(text.as_bytes(), 2, &[]).unwrap();
            assert_eq!((answer.outcome, answer.stated), (recorded, Some(stated)));
            let text = serde_json::json!({"outcome": stated, "waypoints": [[1, 2]]}).to_string();
            let fault = read_output(text.as_bytes(), 2, &[]).unwrap_err();
            assert_eq!(fault, format!("the outcome is '{stated}', but there are way points"));
        }
    }

    #[test]
    fn an_unknown_outcome_is_refused_with_those_that_a_program_may_state() {
        for unknown in ["cancelled", "rejected", "solvd"] {
            let text = serde_json::json!({"outcome": unknown}).to_string();
            let fault = read_output(text.as_bytes(), 2, &[]).unwrap_err();
            let (_, known) = fault.split_once("expected one of ").unwrap();
            let known = known.split([',', ' ']).map(|word| word.trim_matches(['`', '\'']));
            let known: Vec<&str> = known.filter(|word| !word.is_empty()).collect();
            let accepted = [
                "solved",
                "budget-exhausted",
                "gave-up",
                "claimed-not-proven",
                "start-invalid",
                "goals-invalid",
                "no-reachable-grasp",
                "region-out-of-reach",
            ];
            assert_eq!(known, accepted, "{fault}");
            assert!(fault.contains(unknown), "{fault}");
        }
    }

    #[test]
    fn what_is_no_answer_is_named_with_its_line() {
        let fault = |text: &[u8]| read_output(text, 2, &[]).unwrap_err();
        assert!(fault(b"1,2\nloading robot ...\n").contains("line 2: 'loading robot ...'"));
        assert!(fault(b"1,2\n1,2,3\n").contains("line 2: 3 numbers instead of 2"));
        assert!(fault(b"1,nan\n").contains("'nan'"));
        assert!(fault(b"{\"waypoints\": [[1, 2],\n[1]]}").contains("way point 1 has 1 values"));
        assert!(fault(b"{\"waypoints\":\n [[1, ").contains("line 2"));
        assert!(fault(b"{\"outcome\": \"solved\"}").contains("no way points"));
        assert!(fault(b"{\"way_points\": []}").contains("way_points"));
        assert!(fault(b"{\"statistics\": {\"iterations\": 18446744073709551615}}").contains("too large"));
        assert!(fault(&[0xff, 0xfe, 0x00]).contains("UTF-8"));
    }

    #[test]
    fn a_path_of_too_many_way_points_is_refused_in_every_form() {
        let fault = |text: &str, stages: &[Stage]| read_output(text.as_bytes(), 2, stages).unwrap_err();
        let refusal = "the path has 150000 way points, but at most 10000 are judged";
        assert_eq!(fault(&"0,0\n".repeat(150_000), &[]), refusal);
        let list = |count: usize| vec!["[0,0]"; count].join(",");
        let json = |count| format!("{{\"waypoints\": [{}]}}", list(count));
        assert_eq!(fault(&json(150_000), &[]), refusal);
        assert_eq!(joined(&read_output(json(10_000).as_bytes(), 2, &[]).unwrap().segments).len(), 10_000);
        let segment = format!("{{\"mode\": \"reach\", \"waypoints\": [{}]}}", list(2));
        let segments =
            |count| format!("{{\"protocol\": 2, \"segments\": [{}]}}", vec![&*segment; count].join(","));
        assert_eq!(fault(&segments(75_000), &[Stage::pick()]), refusal);
        assert!(read_output(segments(5000).as_bytes(), 2, &[]).is_ok());
        for many in [list(1_000_000), "0,".repeat(1_000_000) + "0"] {
            let fault = fault(&format!("{{\"waypoints\": [[{many}]]}}"), &[]);
            assert!(fault.contains("more than any path of 10000 way points"), "{fault}");
        }
    }

    #[test]
    fn the_files_of_the_released_program_are_read() {
        let folder = tempfile::tempdir().unwrap();
        let prefix = folder.path().join("trial");
        assert!(read_released(&prefix, 2).unwrap_err().contains("no .txt"));
        let summary = |sr: u8| {
            format!("{{\"sr\": {sr}, \"dtg\": 41.5, \"time\": 1.5, \"iters\": 812, \"treesize\": 700}}")
        };
        std::fs::write(prefix.with_extension("txt"), summary(1)).unwrap();
        assert!(read_released(&prefix, 2).unwrap_err().contains("no .try"));
        std::fs::write(prefix.with_extension("try"), "0,0\n0.5,1\n").unwrap();
        let answer = read_released(&prefix, 2).unwrap();
        assert_eq!(joined(&answer.segments), [[0.0, 0.0], [0.5, 1.0]]);
        assert_eq!((answer.statistics.iterations, answer.statistics.nodes), (812, 700));
        std::fs::write(prefix.with_extension("txt"), summary(0)).unwrap();
        assert_eq!(read_released(&prefix, 2).unwrap().segments.len(), 0);
    }
}
