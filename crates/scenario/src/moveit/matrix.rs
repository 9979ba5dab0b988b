//! Allowed collision matrix of a scene.

use std::collections::HashSet;

use cranny_robot::Robot;

use crate::moveit::file::{MatrixEntry, RowEntry};
use crate::moveit::message_file::MessageFile;
use crate::{MoveItDeviation, MoveItError, ScenarioError};

/// Pairs of a matrix by name, each with true if it may touch.
pub(crate) struct Matrix<'a> {
    pairs: Vec<(&'a str, &'a str, bool)>,
    /// Names of links and objects that may touch anything.
    free: Vec<&'a str>,
    /// Names of links and objects that may touch nothing but what an entry names.
    strict: Vec<&'a str>,
}

impl<'a> Matrix<'a> {
    /// # Errors
    /// [`MoveItError::Matrix`] for a matrix that is not square and symmetric, or without one default for each name.
    pub fn new(file: &MessageFile, entry: &'a MatrixEntry) -> Result<Self, ScenarioError> {
        let names = entry.entry_names.as_ref();
        let at = names.map_or_else(|| file.line(1), |names| file.at(names.referenced));
        let names = names.map_or(&[][..], |names| &names.value[..]);
        let rows: Vec<&[bool]> = entry.entry_values.iter().map(RowEntry::values).collect();
        let is_square = rows.len() == names.len() && rows.iter().all(|row| row.len() == names.len());
        let has_defaults = entry.default_entry_names.len() == entry.default_entry_values.len();
        let mut pairs = Vec::new();
        let mut is_symmetric = true;
        for first in 0..if is_square { names.len() } else { 0 } {
            for second in 0..first {
                is_symmetric &= rows[first][second] == rows[second][first];
                pairs.push((names[first].as_str(), names[second].as_str(), rows[first][second]));
            }
        }
        if !(is_square && has_defaults && is_symmetric) {
            return Err(MoveItError::Matrix { at, names: names.len() }.into());
        }
        let named = |wanted: bool| {
            let defaults = entry.default_entry_names.iter().zip(&entry.default_entry_values);
            defaults.filter(move |(_, may)| **may == wanted).map(|(name, _)| name.as_str()).collect()
        };
        Ok(Self { pairs, free: named(true), strict: named(false) })
    }

    /// Returns the pairs of links that may not touch in the scene but that the robot never checks: by an entry, or, without one,
    /// by a default.
    pub fn forbidden(&self, robot: &Robot) -> Vec<[String; 2]> {
        let name = |link: usize| robot.links()[link].name.as_str();
        let is_strict = |name: &str| self.strict.contains(&name);
        let is_named = |a: &str, b: &str| {
            self.pairs
                .iter()
                .any(|&(first, second, _)| (first, second) == (a, b) || (first, second) == (b, a))
        };
        let exempt = robot.disabled_pairs().iter().chain(robot.adjacent_pairs());
        let by_default = exempt
            .map(|&(first, second)| (name(first), name(second)))
            .filter(|(first, second)| (is_strict(first) || is_strict(second)) && !is_named(first, second));
        let forbidden = self.pairs.iter().filter(|(first, second, may)| {
            let links = (robot.link_index(first), robot.link_index(second));
            matches!(links, (Some(first), Some(second)) if !may && is_exempt(robot, first, second))
        });
        let by_entry = forbidden.map(|&(first, second, _)| (first, second));
        by_entry.chain(by_default).map(|(first, second)| [first.to_owned(), second.to_owned()]).collect()
    }

    /// Returns the pairs and names that may touch in the scene but are checked; a link comes first in a pair.
    pub fn checked(&self, robot: &Robot, bodies: &HashSet<&str>) -> Vec<MoveItDeviation> {
        let mut deviations = Vec::new();
        for &(first, second, _) in self.pairs.iter().filter(|(_, _, may)| *may) {
            let is_checked = match (robot.link_index(first), robot.link_index(second)) {
                (Some(a), Some(b)) => !is_exempt(robot, a, b),
                (Some(_), None) => bodies.contains(second),
                (None, Some(_)) => bodies.contains(first),
                (None, None) => false,
            };
            if is_checked {
                let (first, second) =
                    if robot.link_index(first).is_some() { (first, second) } else { (second, first) };
                let (first, second) = (first.to_owned(), second.to_owned());
                deviations.push(MoveItDeviation::AllowedPairChecked { first, second });
            }
        }
        let is_there = |name: &&&str| robot.link_index(name).is_some() || bodies.contains(**name);
        let free = self.free.iter().filter(is_there);
        deviations.extend(free.map(|name| MoveItDeviation::AllowedLinkChecked { name: (*name).to_owned() }));
        deviations
    }
}

/// Returns true if the robot never checks that pair of links.
fn is_exempt(robot: &Robot, first: usize, second: usize) -> bool {
    let pair = (first.min(second), first.max(second));
    // Both lists are sorted.
    robot.disabled_pairs().binary_search(&pair).is_ok() || robot.adjacent_pairs().binary_search(&pair).is_ok()
}
