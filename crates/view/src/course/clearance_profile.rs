use std::borrow::Cow;
use std::collections::HashMap;

use cranny_collision::{Cell, Closest, Collider};
use cranny_robot::Hold;
use cranny_spatial::{Point, Vector};
use cranny_task::State;
use rayon::prelude::*;
use serde::Serialize;

use crate::{CarriedObjectMotion, SampledPath, viewer::number_row};

/// Clearance of the robot along a path, with the closest pair at each instant.
#[derive(Clone, Debug, PartialEq)]
pub struct ClearanceProfile {
    /// Instants, in seconds.
    pub times_s: Vec<f64>,
    /// Closest pair at each instant; a negative distance is the depth of the overlap.
    pub closest: Vec<Closest>,
    /// Clearances at each instant, in metres ([`Cell::clearances`]): of the robot with its held object to the world, and
    /// between its links.
    pub apart_m: Vec<[f64; 2]>,
    /// Names of the pairs that occur, each once.
    names: Vec<(String, String)>,
    /// Index into `names`, one per instant.
    name_indices: Vec<u32>,
}

impl ClearanceProfile {
    /// Computes the profile at up to `most` instants, spread evenly over the samples of the path and including the first and
    /// the last; `None` without pairs to check. Each is checked exactly, and nothing is known between them.
    ///
    /// From the start of the closing on, the object belongs to the robot, in the `states` along the segments, with the last of
    /// which the profile ends. The support of an object counts from the end of the lift-off until the set-down.
    pub fn along(path: &SampledPath, cell: &Cell, states: &[State], most: usize) -> Option<Self> {
        let mut modes = path.carries.iter().flat_map(|carry| &carry.modes);
        let unknown = modes.find(|shown| shown.mode.holds && shown.segment >= states.len());
        let shown = unknown.map_or(path.times_s.len(), |unknown| {
            let until_s = modes_before(path, unknown.segment);
            path.times_s.partition_point(|&time_s| time_s <= until_s)
        });
        let last = shown.checked_sub(1)?;
        let count = shown.min(most.max(2));
        // Removes the duplicate that arises if there is only one instant.
        let mut places: Vec<usize> = (0..count).map(|k| k * last / (count - 1).max(1)).collect();
        places.dedup();
        let (mut closest, mut names, mut name_indices) = (Vec::new(), Vec::new(), Vec::new());
        let mut apart_m = Vec::new();
        let mut known: HashMap<(String, String), usize> = HashMap::new();
        for Stretch { cell, places } in stretches(path, cell, states, &places) {
            let nearest = places.par_iter().map_init(
                || cell.scratch(),
                |scratch, &place| {
                    let q = &path.configurations[place];
                    Some((cell.closest(q, scratch)?, cell.clearances(q, scratch)))
                },
            );
            let nearest: Vec<(Closest, [f64; 2])> = nearest.collect::<Option<_>>()?;
            let (nearest, apart): (Vec<Closest>, Vec<[f64; 2]>) = nearest.into_iter().unzip();
            apart_m.extend(apart);
            let name = |collider: Collider| cell.name(collider).to_owned();
            for pair in nearest.iter().map(|pair| (name(pair.first), name(pair.second))) {
                let index = *known.entry(pair).or_insert_with_key(|pair| {
                    names.push(pair.clone());
                    names.len() - 1
                });
                name_indices.push(number_row::index(index));
            }
            closest.extend(nearest);
        }
        let times_s = places.iter().map(|&place| path.times_s[place]).collect();
        Some(Self { times_s, closest, apart_m, names, name_indices })
    }

    pub(crate) fn rows(&self) -> ClearanceRows {
        let pair =
            |(first, second): &(String, String)| PairNames { first: first.clone(), second: second.clone() };
        // Not a number where the contact points are unknown: the page then draws no line.
        let nowhere = [Point::from(Vector::repeat(f64::NAN)); 2];
        let points = self.closest.iter().flat_map(|closest| closest.points.unwrap_or(nowhere));
        let points = points.flat_map(|p| [p.x, p.y, p.z].map(number_row::single));
        ClearanceRows {
            times_s: number_row::floats64(self.times_s.iter().copied()),
            distances_m: number_row::floats64(self.closest.iter().map(|closest| closest.distance_m)),
            world_m: number_row::floats64(self.apart_m.iter().map(|[world_m, _]| *world_m)),
            own_m: number_row::floats64(self.apart_m.iter().map(|[_, own_m]| *own_m)),
            closest: number_row::unsigned32(self.name_indices.iter().copied()),
            pairs: self.names.iter().map(pair).collect(),
            points: number_row::floats32(points),
        }
    }
}

/// Instants of a path and the cell that checks them.
struct Stretch<'a, 'b> {
    cell: Cow<'a, Cell>,
    places: &'b [usize],
}

/// Returns the end of the motion before a segment, in seconds.
fn modes_before(path: &SampledPath, segment: usize) -> f64 {
    let modes = path.carries.iter().flat_map(|carry| &carry.modes);
    modes.take_while(|shown| shown.segment < segment).last().map_or(0.0, |before| before.until_s)
}

/// Assigns each instant its cell: one per segment, and one per instant while the hand closes or opens.
fn stretches<'a, 'b>(
    path: &'a SampledPath,
    empty: &'a Cell,
    states: &'a [State],
    places: &'b [usize],
) -> Vec<Stretch<'a, 'b>> {
    let of_carry = |carry: &'a CarriedObjectMotion| carry.modes.iter().map(move |shown| (shown, carry));
    let all = path.carries.iter().flat_map(of_carry);
    let modes: Vec<_> =
        all.filter_map(|(shown, carry)| Some((shown, carry, states.get(shown.segment)?))).collect();
    let until = |from: usize, is_before: &dyn Fn(f64) -> bool| {
        from + places[from..].partition_point(|&place| is_before(path.times_s[place]))
    };
    let mut stretches = Vec::new();
    let mut begin = 0;
    for (index, (now, carry, state)) in modes.iter().enumerate() {
        let next = modes.get(index + 1);
        let moves_hand = next.filter(|(next, ..)| next.mode.holds != now.mode.holds);
        // If the hand moves, the mode ends with its last instant; otherwise the next mode begins with its first.
        let end = match (next, moves_hand) {
            (None, _) => until(begin, &|_| true),
            (Some((next, ..)), None) => until(begin, &|time_s| time_s < next.from_s),
            (Some(_), Some(_)) => until(begin, &|time_s| time_s <= now.until_s),
        };
        stretches.push(Stretch { cell: Cow::Borrowed(state.cell()), places: &places[begin..end] });
        begin = end;
        let Some((next, _, next_state)) = moves_hand else { continue };
        let goes_on = until(begin, &|time_s| time_s < next.from_s);
        let held = if next.mode.holds { next_state } else { state };
        for place in places[begin..goes_on].chunks(1) {
            let closing = carry.closing_at(path.times_s[place[0]]);
            // A partly closed hand holds the same object as the closed one.
            let held_so = held.held().map(|(_, grip)| Hold { closing, ..grip.hold });
            let cell = held_so.and_then(|hold| held.cell().with_hold(hold).ok());
            stretches
                .push(Stretch { cell: cell.map_or(Cow::Borrowed(held.cell()), Cow::Owned), places: place });
        }
        begin = goes_on;
    }
    // This is the whole path if it carries nothing, otherwise the remainder whose hold is unknown.
    stretches.push(Stretch { cell: Cow::Borrowed(empty), places: &places[begin..] });
    stretches
}

/// Clearance profile in the encoding of the page.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct ClearanceRows {
    times_s: String,
    distances_m: String,
    world_m: String,
    own_m: String,
    closest: String,
    pairs: Vec<PairNames>,
    points: String,
}

/// Names of two bodies that touch or are close.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub(crate) struct PairNames {
    pub first: String,
    pub second: String,
}
