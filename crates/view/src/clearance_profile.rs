use std::borrow::Cow;
use std::sync::Arc;

use cranny_collision::{Cell, Closest, Collider};
use cranny_robot::Hold;
use cranny_solve::TaskCells;
use cranny_spatial::{Point, Vector};
use rayon::prelude::*;
use serde::Serialize;

use crate::{ShownMode, ShownPath, number_row};

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
    ///
    /// From when the hand begins to close on what it carries away, the object counts as part of the robot, in these cells;
    /// without them nothing is said of the rest of the path. What it rests on counts from the end of the lift-off on, and
    /// until it is set down.
    pub fn along(path: &ShownPath, cell: &Cell, cells: Option<&TaskCells>, most: usize) -> Option<Self> {
        let shown = path.carries.first().map_or(path.times_s.len(), |carry| match cells {
            Some(_) => path.times_s.len(),
            None => path.times_s.partition_point(|&time_s| time_s <= carry.closes_s()[0]),
        });
        let last = shown.checked_sub(1)?;
        let count = shown.min(most.max(2));
        // The same place twice only where there is but one.
        let mut places: Vec<usize> = (0..count).map(|k| k * last / (count - 1).max(1)).collect();
        places.dedup();
        let (mut closest, mut names, mut name_indices) = (Vec::new(), Vec::new(), Vec::new());
        for Stretch { cell, places } in stretches(path, cell, cells, &places) {
            let nearest = places.par_iter().map_init(
                || cell.scratch(),
                |scratch, &place| cell.closest(&path.configurations[place], scratch),
            );
            let nearest: Vec<Closest> = nearest.collect::<Option<_>>()?;
            let name = |collider: Collider| cell.name(collider).to_owned();
            for pair in nearest.iter().map(|pair| (name(pair.first), name(pair.second))) {
                let known = names.iter().position(|other| *other == pair).unwrap_or_else(|| {
                    names.push(pair);
                    names.len() - 1
                });
                name_indices.push(number_row::index(known));
            }
            closest.extend(nearest);
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

/// Instants of a path, and what is checked there.
struct Stretch<'a, 'b> {
    cell: Cow<'a, Cell>,
    places: &'b [usize],
}

/// Each mode in its cell; while the hand closes or opens, at each instant another cell.
fn stretches<'a, 'b>(
    path: &ShownPath,
    empty: &'a Cell,
    cells: Option<&'a TaskCells>,
    places: &'b [usize],
) -> Vec<Stretch<'a, 'b>> {
    let Some((carry, cells)) = path.carries.first().zip(cells) else {
        return vec![Stretch { cell: Cow::Borrowed(empty), places }];
    };
    let until = |from: usize, time_s: f64| {
        from + places[from..].partition_point(|&place| path.times_s[place] < time_s)
    };
    let mut stretches = Vec::new();
    let mut begin = 0;
    for (index, ShownMode { mode, .. }) in carry.modes.iter().enumerate() {
        let next = carry.modes.get(index + 1);
        let holds_next = next.is_some_and(|next| next.mode.holds());
        // Where the hand moves, the mode ends with its last instant; else the next begins with it.
        let end = match next {
            Some(next) if holds_next == mode.holds() => until(begin, next.from_s),
            Some(_) => {
                let ends_s = carry.modes[index].until_s;
                begin + places[begin..].partition_point(|&place| path.times_s[place] <= ends_s)
            }
            None => places.len(),
        };
        let cell = cells.cell(*mode).map_or(empty, Arc::as_ref);
        stretches.push(Stretch { cell: Cow::Borrowed(cell), places: &places[begin..end] });
        begin = end;
        let Some(next) = next.filter(|_| holds_next != mode.holds()) else { continue };
        let goes_on = until(begin, next.from_s);
        let held = cells.cell(if holds_next { next.mode } else { *mode }).map_or(empty, Arc::as_ref);
        for place in places[begin..goes_on].chunks(1) {
            let closing = carry.closing_at(path.times_s[place[0]]);
            // A hand that is less closed holds as well what the closed one holds.
            let cell = held.with_hold(Hold { closing, ..cells.grip.hold });
            stretches.push(Stretch { cell: cell.map_or(Cow::Borrowed(held), Cow::Owned), places: place });
        }
        begin = goes_on;
    }
    stretches
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
