//! Check of a certificate: its scenes, each with its paths.

use super::enclosure::enclosure;
use super::interval::{Interval, ZERO, dot, minus, point, sum};
use super::lines::{Checked, Lines, unless};
use super::proof::{Ledger, Piece};
use super::scene::{Pair, Pose, Scene};

/// Tolerances: start of a path in each joint, position of the tip at its end, and trace of a rotation by one degree,
/// 1 + 2 cos 1°, rounded up.
pub const START_TOLERANCE: f64 = 1e-5;
pub const GOAL_TOLERANCE_M: f64 = 1e-3;
const GOAL_TRACE: f64 = 2.999695390312783;

/// Maximum number of control points of a piece.
const MOST_POINTS: usize = 100;

/// Checks a certificate: returns in lines what it has shown of each scene.
///
/// # Errors
/// First line, from 1, that is malformed or does not hold, with the reason.
pub fn check(text: &str) -> Result<Vec<String>, (usize, String)> {
    let mut lines = Lines::new(text);
    statement(&mut lines).map_err(|reason| (lines.starts.len(), reason))
}

/// Returns for each scene its name and hash, the numbers of its paths, of their pieces and of the pairs that are compared, then
/// pairs that are not compared or have a distance of their own, bounds of links, goals, and objects that differ from the
/// scene before.
fn statement(lines: &mut Lines<'_>) -> Checked<Vec<String>> {
    lines.advance()?;
    lines.read("cranny-certificate/1", |_| Ok(()))?;
    let (mut found, mut ledger) = (Vec::new(), Ledger::default());
    let mut before: Option<(Scene<'_>, Vec<f64>)> = None;
    while before.is_none() || lines.is("scene") {
        let mut scene = Scene::read(lines)?;
        let depth = scene.objects.iter().map(|object| object.depth).max().unwrap_or_default();
        ledger.work(scene.objects.len().pow(2).saturating_mul(50 + depth))?;
        scene.pairs = scene.list_pairs();
        let changes = before.as_ref().map_or(Ok(Vec::new()), |before| scene.changes_since(before))?;
        found.push(format!("scene {} {}", scene.name, scene.hash));
        if before.is_none() && lines.is("none") {
            let [open, inside, blocked] = enclosure(lines, &scene, &mut ledger)?;
            found.push(format!("no motion leads to a goal: {inside} of {open} boxes are left to the start"));
            found.push(format!("goals {}, of which {blocked} are blocked", scene.goals.len()));
            found.push(pairs_of(&scene));
            found.extend(scene.rules);
            break;
        }
        let (mut paths, mut pieces, mut end) = (0, 0, Vec::new());
        while paths == 0 || lines.is("path") {
            let (count, last) = path(lines, &scene, &mut ledger)?;
            (paths, pieces, end) = (paths + 1, pieces + count, last);
        }
        found.push(format!("paths {paths}, of {pieces} pieces"));
        found.push(pairs_of(&scene));
        found.extend(scene.rules.iter().cloned().chain(changes));
        before = Some((scene, end));
    }
    lines.read("end", |_| Ok(()))?;
    unless(lines.is_at_end(), "a line after the end")?;
    Ok(found)
}

fn pairs_of(scene: &Scene<'_>) -> String {
    format!("pairs {}, at least {} m apart but for `keep`", scene.pairs.len(), scene.margin)
}

/// Checks a path: returns the number of its pieces, and its end.
fn path(lines: &mut Lines<'_>, scene: &Scene<'_>, ledger: &mut Ledger) -> Checked<(usize, Vec<f64>)> {
    lines.read("path", Lines::word)?;
    ledger.outside.clear();
    let (mut pieces, mut end) = (0, None::<Vec<f64>>);
    while pieces == 0 || lines.is("piece") {
        lines.read("piece", |_| Ok(()))?;
        let mut points: Vec<Vec<f64>> = Vec::new();
        while points.len() < 2 || lines.is("q") {
            let q = lines.read("q", |line| line.values(scene.joints.len()))?;
            let is_within = |((_, [lower, upper]), x): (&(_, [f64; 2]), &f64)| lower <= x && x <= upper;
            unless(scene.joints.iter().zip(&q).all(is_within), "a joint is outside its limits (5)")?;
            points.push(q);
            unless(points.len() <= MOST_POINTS, "more control points than a piece may have")?;
        }
        // A piece begins where the one before it ends, and the first one at the start (10).
        let (from, tolerance) = end.as_ref().map_or((&scene.start, START_TOLERANCE), |end| (end, 0.0));
        let is_there = |(a, b): (&f64, &f64)| (point(*a) - point(*b)).magnitude().hi <= tolerance;
        unless(points[0].iter().zip(from).all(is_there), "the piece does not begin where the path is")?;
        let mut piece = Piece::new(scene, &points, ledger);
        for pair in &scene.pairs {
            let [a, b] = pair.objects.map(|index| scene.objects[index].name);
            let proof = lines.read("p", |line| piece.check_pair(pair, line));
            proof.map_err(|reason| format!("{a}, {b}: {reason}"))?;
        }
        for bound in &scene.bounds {
            lines.read("b", |line| piece.check_bound(bound, line))?;
        }
        (end, pieces) = (points.pop(), pieces + 1);
    }
    let end = end.unwrap_or_default();
    let tip = Piece::new(scene, &[end.clone(), end.clone()], ledger).pose_in_middle(scene.tip)?;
    unless(scene.goals.iter().any(|goal| is_near(&tip, goal)), "the path ends at no goal")?;
    // Each solid is on the other side of some plane than all of the solid or mesh that it is compared with (9).
    let solids =
        |pair: &Pair| pair.objects.iter().map(|index| scene.objects[*index].solids.len()).product::<usize>();
    let is_complete = ledger.outside.len() == scene.pairs.iter().map(solids).sum::<usize>();
    unless(is_complete, "no plane shows that two objects are not inside each other")?;
    Ok((pieces, end))
}

/// Returns true if the tip is at the goal (11).
fn is_near(tip: &Pose, goal: &Pose) -> bool {
    let off = sum(tip.translation, minus(goal.translation));
    let add_row = |trace: Interval, i: usize| trace + dot(tip.rotation[i], goal.rotation[i]);
    dot(off, off).hi <= GOAL_TOLERANCE_M * GOAL_TOLERANCE_M && (0..3).fold(ZERO, add_row).lo >= GOAL_TRACE
}
