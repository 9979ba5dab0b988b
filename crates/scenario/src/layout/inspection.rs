//! Complete fault reports of scenarios in Cranny's layout.

use std::collections::HashSet;
use std::path::Path;

use cranny_grasp::check_csv;
use cranny_robot::{LimitViolation, Robot};
use cranny_shape::Solid;
use cranny_spatial::Pose;

use crate::files::mesh_solids::MeshSolids;
use crate::files::number_table;
use crate::files::yaml;
use crate::layout::archive::Unpacked;
use crate::layout::own::{FILE, GRASPS_FILE, IK_FILE, Layout, is_there};
use crate::layout::own_file::ScenarioFile;
use crate::{OpenOptions, Scenario, ScenarioError};

/// Returns all faults of the scenario that `what` names, as accepted by [`Scenario::open`](crate::Scenario::open). For folders
/// in Cranny's layout, packed or not, the report is complete (see [`check_folder`]); for others it has the first fault only.
///
/// # Errors
/// If `what` names no scenario, or one that is not readable.
pub fn check(what: &str) -> Result<Vec<ScenarioError>, ScenarioError> {
    let folder = Path::new(what);
    let checked = if folder.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("zip")) {
        Unpacked::open(folder).and_then(|unpacked| check_folder(&unpacked.folder()))
    } else if folder.join(FILE).is_file() {
        check_folder(folder)
    } else {
        Scenario::open(what, &OpenOptions::default()).map(|_| Vec::new())
    };
    match checked {
        Err(
            fault @ (ScenarioError::Unknown { .. }
            | ScenarioError::FileForFolder { .. }
            | ScenarioError::NoScenarioFile { .. }
            | ScenarioError::Unreadable { .. }),
        ) => Err(fault),
        Err(fault) => Ok(vec![fault]),
        faults => faults,
    }
}

/// Returns all faults of a scenario folder, in the order of its files and their lines; none if it opens.
///
/// An unreadable element of `scenario.yaml` hides only itself: an entry of a list, or else a top-level key.
///
/// # Errors
/// [`ScenarioError::NoScenarioFile`] or [`ScenarioError::Unreadable`] if there is nothing to read.
pub fn check_folder(folder: &Path) -> Result<Vec<ScenarioError>, ScenarioError> {
    let path = folder.join(FILE);
    if !path.is_file() {
        return Err(ScenarioError::NoScenarioFile { folder: folder.to_owned() });
    }
    let mut faults = Vec::new();
    let text = yaml::text(cranny_file::TEXT, &path)?;
    let legible = Legible::of(&path, &text, &mut faults);
    let has_goal = |file: &ScenarioFile| file.target.is_some() || !file.regions.is_empty();
    // An unreadable goal is a goal.
    let has_goal = legible.as_ref().is_some_and(|legible| has_goal(&legible.file))
        || text.lines().any(|line| GOALS.iter().any(|key| is_key_of(line, key)));
    let robot = legible.map(|legible| {
        legible.check(&Layout { folder, path: &path, meshes: MeshSolids::default() }, &mut faults)
    });
    // The grasps file is optional if there is a target, of which the planner can compute grasps, or a region.
    let grasps = folder.join(GRASPS_FILE);
    if !has_goal || is_there(&grasps)? {
        check_grasps(&grasps, &mut faults);
    }
    let dof = robot.flatten().map(|robot| robot.dof());
    check_ik(&folder.join(IK_FILE), dof, &mut faults);
    if faults.is_empty() {
        // Opening finds faults that the elements do not show, such as poses too far away.
        faults.extend(Scenario::open(&folder.to_string_lossy(), &OpenOptions::default()).err());
    }
    Ok(faults)
}

/// Readable content of a `scenario.yaml`.
struct Legible {
    file: ScenarioFile,
    /// Keys that were inserted instead of missing or unreadable ones.
    replaced: Vec<&'static str>,
}

/// Maximum number of lines that are read repeatedly, in some seconds: a long file with many faults is reported incompletely.
const MOST_LINES_READ: usize = 1_000_000;

/// Keys of goals without a file of grasps.
const GOALS: [&str; 2] = ["target", NAMED];

/// Key whose value maps names to elements.
const NAMED: &str = "regions";

/// Required keys, each with a readable stand-in.
const NEEDED: [(&str, &str); 3] = [("robot", "panda_mobile"), ("start", "[]"), ("floor", "null")];

impl Legible {
    /// Reads the text; on failure, removes the smallest element around the fault and retries.
    fn of(path: &Path, text: &str, faults: &mut Vec<ScenarioError>) -> Option<Self> {
        let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
        let mut replaced = Vec::new();
        // Each turn removes an element or inserts a key, and reads the whole text again.
        let turns =
            (MOST_LINES_READ / lines.len().max(1)).clamp(NEEDED.len() + 1, lines.len() + NEEDED.len() + 1);
        for _ in 0..turns {
            let fault = match yaml::parse::<ScenarioFile>(path, &(lines.join("\n") + "\n")) {
                Ok(file) => return Some(Self { file, replaced }),
                Err(fault) => fault,
            };
            let said = fault.to_string();
            let missing = NEEDED.iter().find(|(key, _)| said.contains(&format!("missing field `{key}`")));
            if let Some((key, stand_in)) = missing {
                if replaced.contains(key) {
                    faults.push(fault);
                    return None;
                }
                if !faults.iter().any(|earlier| hides(earlier, key, text)) {
                    faults.push(fault);
                }
                replaced.push(key);
                lines.push(format!("{key}: {stand_in}"));
                continue;
            }
            let ScenarioError::Yaml { at, .. } = &fault else {
                faults.push(fault);
                return None;
            };
            let line = (at.line as usize).clamp(1, lines.len().max(1)) - 1;
            faults.push(fault);
            if !leave_out(&mut lines, line) {
                return None;
            }
        }
        None
    }

    /// Checks all readable content; returns the robot if it can be built.
    fn check(&self, layout: &Layout, faults: &mut Vec<ScenarioError>) -> Option<std::sync::Arc<Robot>> {
        let file = &self.file;
        let was_there = |key: &str| !self.replaced.contains(&key);
        let robot = layout.robot(file, &OpenOptions::default());
        let robot = robot.map_err(|fault| faults.push(fault)).ok().map(|(robot, _)| robot);
        let frame = layout.pose(file.frame.as_ref());
        faults.extend(frame.err());
        if let Some(robot) = robot.as_ref().filter(|_| was_there("start") && was_there("robot")) {
            match layout.start(file, robot, &OpenOptions::default()) {
                Ok(start) if start.len() != robot.dof() => faults.push(ScenarioError::StartCount {
                    file: layout.at(file.start_place()).to_string(),
                    expected: robot.dof(),
                    actual: start.len(),
                    joints: robot.joint_names().join(", "),
                }),
                Ok(start) => faults.extend(robot.limit_violations(&start).map(|beyond| {
                    let LimitViolation { joint, value, lower, upper } = beyond;
                    let joint = robot.joint_names()[joint].clone();
                    ScenarioError::StartBeyond {
                        at: layout.at(file.start_place()),
                        joint,
                        value,
                        lower,
                        upper,
                    }
                })),
                Err(fault) => faults.push(fault),
            }
        }
        if let Some(height) = &file.floor {
            faults.extend(layout.floor(height, &Pose::identity()).err());
        }
        let mut names = HashSet::new();
        for entry in file.obstacles.iter().chain(&file.target) {
            faults.extend(layout.check_name(entry, &mut names).err());
            let is_target = file.target.as_ref().is_some_and(|target| std::ptr::eq(target, entry));
            let mesh = if is_target { Solid::mesh } else { Solid::mesh_with_small_holes };
            faults.extend(layout.body_faults(entry, mesh));
            faults.extend(layout.physics_of(entry).err());
        }
        let (mut names, obstacles) = (HashSet::new(), file.obstacle_names());
        for entry in &file.places {
            faults.extend(layout.place(entry, (file, &obstacles), &Pose::identity(), &mut names).err());
        }
        faults.extend(layout.tasks(file, &Pose::identity()).err());
        faults.extend(layout.speeds(file).err());
        if let Some(robot) = robot.as_ref().filter(|_| was_there("robot")) {
            faults.extend(layout.with_bounded_joints(robot.clone(), file).err());
            let mut names = HashSet::new();
            let bounds = file.tool_bounds.iter();
            faults.extend(bounds.filter_map(|entry| layout.tool_bound(entry, robot, &mut names).err()));
        }
        faults.extend(layout.physics_of_obstacles(file).err().filter(|_| !file.steps.is_empty()));
        robot.filter(|_| was_there("robot"))
    }
}

/// Returns true if the element that was removed because of `earlier` contained `key`.
fn hides(earlier: &ScenarioError, key: &str, text: &str) -> bool {
    let ScenarioError::Yaml { at, .. } = earlier else { return false };
    let lines: Vec<&str> = text.lines().collect();
    let until = (at.line as usize).min(lines.len());
    // The last key of the file before the fault, or at it.
    let last = lines[..until].iter().rev().find(|line| is_key(line));
    last.is_some_and(|line| is_key_of(line, key))
}

/// Returns true if a line begins with this top-level key.
fn is_key_of(line: &str, key: &str) -> bool {
    line.strip_prefix(key).is_some_and(|rest| rest.trim_start().starts_with(':'))
}

fn is_key(line: &str) -> bool {
    line.starts_with(|c: char| c.is_ascii_alphabetic()) && line.contains(':')
}

fn indent(line: &str) -> usize {
    line.len() - line.trim_start().len()
}

/// Empties the list entry or the named element that contains `line`, or else the top-level key, keeping line numbers; returns
/// true if not empty.
fn leave_out(lines: &mut [String], line: usize) -> bool {
    let is_blank = |text: &str| text.trim().is_empty() || text.trim_start().starts_with('#');
    let Some(line) = (0..=line.min(lines.len().saturating_sub(1))).rev().find(|&l| !is_blank(&lines[l]))
    else {
        return false;
    };
    // The top-level key, and the outermost list entry below it.
    let key = (0..=line).rev().find(|&l| indent(&lines[l]) == 0 && !is_blank(&lines[l])).unwrap_or(0);
    let depth = (key + 1..=line)
        .filter(|&l| lines[l].trim_start().starts_with("- "))
        .map(|l| indent(&lines[l]))
        .min();
    let begin = if is_key_of(&lines[key], NAMED) {
        let depth = (key + 1..=line).filter(|&l| !is_blank(&lines[l])).map(|l| indent(&lines[l])).min();
        (key + 1..=line).rev().find(|&l| !is_blank(&lines[l]) && Some(indent(&lines[l])) == depth)
    } else {
        depth.and_then(|depth| {
            let is_entry =
                |l: &usize| indent(&lines[*l]) == depth && lines[*l].trim_start().starts_with("- ");
            (key + 1..=line).rev().find(is_entry)
        })
    };
    let begin = begin.unwrap_or(key);
    let least = indent(&lines[begin]);
    let mut end = begin + 1;
    while end < lines.len() && (is_blank(&lines[end]) || indent(&lines[end]) > least) {
        end += 1;
    }
    for text in &mut lines[begin..end.max(line + 1)] {
        text.clear();
    }
    // A list without entries is invalid, so its key is removed too.
    if begin != key
        && lines[key + 1..].iter().take_while(|l| is_blank(l) || indent(l) > 0).all(|l| is_blank(l))
    {
        lines[key].clear();
    }
    true
}

fn check_grasps(path: &Path, faults: &mut Vec<ScenarioError>) {
    match cranny_file::TABLE.text(path) {
        Ok(text) => {
            let (_, found) = check_csv(path, &text);
            faults.extend(found.into_iter().map(ScenarioError::from));
        }
        Err(reason) => {
            faults.push(cranny_grasp::GraspError::Unreadable { path: path.to_owned(), reason }.into());
        }
    }
}

fn check_ik(path: &Path, dof: Option<usize>, faults: &mut Vec<ScenarioError>) {
    if !path.exists() {
        return;
    }
    match yaml::text(cranny_file::TABLE, path) {
        Ok(text) => {
            let lines = text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty());
            faults.extend(
                lines.filter_map(|(index, line)| number_table::fault_of_line(path, index, line, dof)),
            );
        }
        Err(fault) => faults.push(fault),
    }
}
