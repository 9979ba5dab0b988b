//! Changed certificates are refused, or state something that holds: no change makes a checker state what is false.

use std::collections::BTreeMap;
use std::path::Path;

use cranny_spatial::Stream;

use crate::certificates::checker::{check, sha256};
use crate::certificates::{certificate, cranny};

/// Greatest difference of a value of a joint within which two paths are one, in m or rad.
const SAME: f64 = 1e-9;

/// Kinds of change, each with its share of the same size.
const KINDS: [&str; 18] = [
    "moved plane",
    "random plane",
    "shortened interval",
    "omitted pair",
    "repeated pair",
    "proof of another pair",
    "permuted edges",
    "moved way point",
    "moved way point of both edges",
    "NaN or huge number",
    "huge count",
    "altered hash",
    "other scene",
    "other scene with its hash",
    "added allowed contact",
    "added pair that is not compared",
    "omitted line with its hash",
    "cut file",
];

/// Claim of a certificate: the scenes by their hashes, and the control points of its paths.
#[derive(PartialEq)]
struct Claim {
    hashes: Vec<String>,
    points: Vec<Vec<f64>>,
}

impl Claim {
    fn of(text: &str) -> Self {
        let words = |kind: &'static str| text.lines().filter_map(move |line| line.strip_prefix(kind));
        let point = |line: &str| line.split(' ').map(|x| x.parse().expect("a number")).collect();
        Self {
            hashes: words("hash ").map(ToOwned::to_owned).collect(),
            points: words("q ").map(point).collect(),
        }
    }

    fn has_path_of(&self, other: &Self) -> bool {
        let is_near = |(a, b): (&Vec<f64>, &Vec<f64>)| {
            a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).abs() <= SAME)
        };
        self.points.len() == other.points.len() && self.points.iter().zip(&other.points).all(is_near)
    }
}

/// Outcomes of the changes of one kind.
#[derive(Default)]
struct Counts {
    refused: usize,
    same: usize,
    other_scene: usize,
    other_path: usize,
}

/// A changed certificate that is accepted states one of three things: the same as before, as another plane was good enough; or
/// another scene, with another hash and with every pair that is not compared or may touch; or another path in the same scene,
/// which `cranny verify` proves too.
#[test]
fn changed_certificates_are_refused_or_state_what_holds() {
    let folder = tempfile::tempdir().expect("a folder");
    let rounds = if std::env::var_os("CRANNY_LONG").is_some() { 100_008 } else { 540 };
    // Those with an object of many faces take ten times as long.
    let scenarios = ["022", "033", "023", "034", "024", "035", "025", "011", "021", "044"];
    let texts = scenarios.map(|id| certificate(folder.path(), id, &["--stop-at-corners"]));
    let mut counts: BTreeMap<&str, Counts> = BTreeMap::new();
    let mut random = Stream::new(56, 0);
    for round in 0..rounds {
        let (kind, which) = (round % KINDS.len(), round / KINDS.len() % texts.len());
        let text = &texts[which];
        let changed = change(text, kind, &mut random);
        let of_kind = counts.entry(KINDS[kind]).or_default();
        let Ok(stated) = check(&changed) else {
            of_kind.refused += 1;
            continue;
        };
        let (before, after) = (Claim::of(text), Claim::of(&changed));
        if before.hashes != after.hashes {
            states_its_scene(&changed, &stated);
            of_kind.other_scene += 1;
        } else if before.has_path_of(&after) {
            of_kind.same += 1;
        } else {
            assert!(is_proven(folder.path(), scenarios[which], &after), "{}: {changed}", KINDS[kind]);
            of_kind.other_path += 1;
        }
    }
    for (kind, Counts { refused, same, other_scene, other_path }) in &counts {
        println!(
            "{kind}: {refused} refused, {same} the same, {other_scene} of another scene, {other_path} paths"
        );
    }
    let all = |count: fn(&Counts) -> usize| counts.values().map(count).sum::<usize>();
    assert!(all(|counts| counts.refused) > rounds / 2);
    for kind in ["omitted pair", "repeated pair", "altered hash", "other scene", "huge count", "cut file"] {
        assert_eq!(counts[kind].refused, rounds / KINDS.len(), "{kind}");
    }
}

/// Checks that what is stated of a changed scene is what its lines are: hash, margin, and each exception.
fn states_its_scene(text: &str, stated: &[String]) {
    let (_, scene) = text.split_once('\n').expect("a format");
    let (scene, _) = scene.split_once("hash ").expect("a hash");
    assert!(stated[0].ends_with(&sha256(scene.as_bytes())), "{stated:?}");
    let rules = ["keep ", "skip ", "goal "];
    let rules = scene.lines().filter(|line| rules.iter().any(|rule| line.starts_with(rule)));
    assert_eq!(stated.len(), 3 + rules.count(), "{stated:?}");
    let margin = scene.lines().find_map(|line| line.strip_prefix("margin ")).expect("a margin");
    let margin: f64 = margin.parse().expect("a number");
    assert!(stated[2].ends_with(&format!("at least {margin} m apart but for `keep`")), "{stated:?}");
}

/// Returns true if `cranny verify` proves the path of a certificate with straight edges.
fn is_proven(folder: &Path, scenario: &str, claim: &Claim) -> bool {
    let mut points = claim.points.clone();
    points.dedup();
    let line = |q: &Vec<f64>| q.iter().map(ToString::to_string).collect::<Vec<_>>().join(",");
    let rows: Vec<String> = points.iter().map(line).collect();
    std::fs::write(folder.join("changed.csv"), rows.join("\n") + "\n").expect("written");
    cranny(folder, &["verify", scenario, "changed.csv"]).0 == Some(0)
}

fn with_hash(lines: &[String]) -> String {
    let end = lines.iter().position(|line| line.starts_with("hash ")).expect("a hash");
    let scene = lines[1..end].join("\n") + "\n";
    let mut lines = lines.to_vec();
    lines[end] = format!("hash {}", sha256(scene.as_bytes()));
    lines.join("\n") + "\n"
}

/// Changes a certificate in one way, by the index of [`KINDS`].
#[expect(clippy::too_many_lines, reason = "one arm for each kind of change")]
fn change(text: &str, kind: usize, random: &mut Stream) -> String {
    let mut lines: Vec<String> = text.lines().map(ToOwned::to_owned).collect();
    let hash = lines.iter().position(|line| line.starts_with("hash ")).expect("a hash");
    let margin = lines.iter().position(|line| line.starts_with("margin ")).expect("a margin");
    let links = lines.iter().filter(|line| line.starts_with("link ")).count();
    let objects = links + lines.iter().filter(|line| line.starts_with("body ")).count();
    let mut pick = |from: usize, below: usize| from + random.index(below - from);
    let with =
        |first: &str| (hash..lines.len()).filter(|at| lines[*at].starts_with(first)).collect::<Vec<_>>();
    let (pairs, points) = (with("p "), with("q "));
    let (at, other) = (pairs[pick(0, pairs.len())], pairs[pick(0, pairs.len())]);
    let point = points[pick(0, points.len())];
    let words = |line: &str| line.split(' ').map(ToOwned::to_owned).collect::<Vec<String>>();
    let mut marks = words(&lines[at]);
    match kind {
        0 => {
            let planes: Vec<usize> = (1..marks.len()).filter(|word| marks[*word].contains(',')).collect();
            if !planes.is_empty() {
                let word = planes[pick(0, planes.len())];
                let mut n: Vec<i32> = marks[word].split(',').map(|x| x.parse().expect("a number")).collect();
                n[pick(0, 3)] += [-9, -2, -1, 1, 2, 9][pick(0, 6)];
                marks[word] = format!("{},{},{}", n[0], n[1], n[2]);
            }
            lines[at] = marks.join(" ");
        }
        1 => {
            let mut whole = || i32::try_from(pick(0, 400)).expect("a number") - 200;
            let plane = format!("{},{},{}", whole(), whole(), whole());
            let word = pick(1, marks.len());
            marks[word] = plane;
            lines[at] = marks.join(" ");
        }
        2 => {
            marks.remove(pick(1, marks.len()));
            lines[at] = marks.join(" ");
        }
        3 => drop(lines.remove(at)),
        4 => lines.insert(at, lines[at].clone()),
        5 => {
            let from = lines[other].clone();
            lines[at] = from;
        }
        6 => lines.swap(point, points[pick(0, points.len())]),
        7 | 8 => {
            let mut q = words(&lines[point]);
            let joint = pick(1, q.len());
            let value: f64 = q[joint].parse().expect("a number");
            q[joint] = match pick(0, 3) {
                0 => (value + 0.2).to_string(),
                1 => (value - 0.01).to_string(),
                _ => value.next_up().to_string(),
            };
            let (old, new) = (lines[point].clone(), q.join(" "));
            let both = kind == 8;
            lines
                .iter_mut()
                .skip(hash)
                .filter(|line| both && **line == old)
                .for_each(|line| line.clone_from(&new));
            lines[point] = new;
        }
        9 => {
            let by = ["NaN", "1e999", "-inf", "-", "1e7"][pick(0, 5)];
            let line = pick(1, lines.len());
            let mut changed = words(&lines[line]);
            let word = pick(0, changed.len());
            by.clone_into(&mut changed[word]);
            lines[line] = changed.join(" ");
        }
        10 => {
            let by = ["99999999999999999999", "999999999", "-1"][pick(0, 3)];
            let tip = lines.iter().position(|line| line.starts_with("tip ")).expect("a tip");
            lines[tip] = format!("tip {by}");
        }
        11 => {
            let digit = pick(5, 69);
            let old = lines[hash].as_bytes()[digit];
            let new = if old == b'0' { "1" } else { "0" };
            lines[hash].replace_range(digit..=digit, new);
        }
        12 | 13 => {
            let line = pick(1, hash);
            let mut changed = words(&lines[line]);
            let numbers: Vec<usize> =
                (1..changed.len()).filter(|word| changed[*word].parse::<f64>().is_ok()).collect();
            if let Some(word) = numbers.get(pick(0, numbers.len().max(1))) {
                let value: f64 = changed[*word].parse().expect("a number");
                changed[*word] = [value + 1.0, value * 1.01 + 1e-6, value - 0.01][pick(0, 3)].to_string();
            } else {
                changed.push("0".to_owned());
            }
            lines[line] = changed.join(" ");
            if kind == 13 {
                return with_hash(&lines);
            }
        }
        14 | 15 => {
            let (a, b) = (pick(0, links - 1), pick(links, objects));
            let line =
                if kind == 14 { format!("keep {a} {b} -0.01") } else { format!("skip {a} {b} declared") };
            lines.insert(margin + 1, line);
            // Without the hash of its scene, with it, and without the proof of the pair.
            let how = pick(0, 3);
            let proof = format!("p {a} {b} ");
            lines.retain(|line| how < 2 || !line.starts_with(&proof));
            if how > 0 {
                return with_hash(&lines);
            }
        }
        16 => {
            lines.remove(pick(1, hash));
            return with_hash(&lines);
        }
        _ => return text[..pick(0, text.len() - 1)].to_owned(),
    }
    lines.join("\n") + "\n"
}
