use cranny_collision::{Cell, Closest, Collider};
use cranny_spatial::{Point, Vector};
use rayon::prelude::*;
use serde::Serialize;

use crate::{ShownPath, number_row};

/// How far the robot is from everything along a path, and which pair is the closest.
#[derive(Clone, Debug, PartialEq)]
pub struct ClearanceProfile {
    /// The instants, in seconds.
    pub times_s: Vec<f64>,
    /// The closest pair at each of them, its distance negative for how deep it overlaps.
    pub closest: Vec<Closest>,
    /// The names of the pairs that occur, each once.
    names: Vec<(String, String)>,
    /// Per instant which of them.
    name_indices: Vec<u32>,
}

impl ClearanceProfile {
    /// At `most` instants of the path at most, evenly over its samples, the first and the last among them; by the
    /// exact check of single configurations, so that nothing is said of what lies between. `None` where there is
    /// nothing to touch.
    pub fn along(path: &ShownPath, cell: &Cell, most: usize) -> Option<Self> {
        let last = path.times_s.len().checked_sub(1)?;
        let count = path.times_s.len().min(most.max(2));
        // The same place twice only where there is but one.
        let mut places: Vec<usize> = (0..count).map(|k| k * last / (count - 1).max(1)).collect();
        places.dedup();
        let closest: Option<Vec<Closest>> = places
            .par_iter()
            .map_init(|| cell.scratch(), |scratch, &place| cell.closest(&path.configurations[place], scratch))
            .collect();
        let closest = closest?;
        let name = |collider: Collider| cell.name(collider).to_owned();
        let mut names: Vec<(String, String)> = Vec::new();
        let mut name_indices = Vec::new();
        for pair in &closest {
            let pair = (name(pair.first), name(pair.second));
            let known = names.iter().position(|other| *other == pair).unwrap_or_else(|| {
                names.push(pair);
                names.len() - 1
            });
            name_indices.push(number_row::index(known));
        }
        let times_s = places.iter().map(|&place| path.times_s[place]).collect();
        Some(Self { times_s, closest, names, name_indices })
    }

    pub(crate) fn rows(&self) -> ClearanceRows {
        let pair =
            |(first, second): &(String, String)| PairNames { first: first.clone(), second: second.clone() };
        // Without a place where they touch, no line is drawn.
        let nowhere = [Point::from(Vector::repeat(f64::NAN)); 2];
        let points = self.closest.iter().flat_map(|closest| closest.points.unwrap_or(nowhere));
        let points = points.flat_map(|p| [p.x, p.y, p.z].map(number_row::single));
        ClearanceRows {
            times_s: number_row::floats64(self.times_s.iter().copied()),
            distances_m: number_row::floats64(self.closest.iter().map(|closest| closest.distance_m)),
            closest: number_row::unsigned32(self.name_indices.iter().copied()),
            pairs: self.names.iter().map(pair).collect(),
            points: number_row::floats32(points),
        }
    }
}

/// The same as a page reads it.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct ClearanceRows {
    times_s: String,
    distances_m: String,
    closest: String,
    pairs: Vec<PairNames>,
    points: String,
}

/// Two things that touch or are close.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub(crate) struct PairNames {
    pub first: String,
    pub second: String,
}
