use std::cmp::Ordering;
use std::collections::BTreeSet;
use std::ops::Bound::{Excluded, Unbounded};

use robust::{Coord, orient2d};

/// Returns true if two sides of a closed polygon cross at a point that is inside both (Shamos & Hoey 1976, "Geometric
/// intersection problems", whole; the segment test of Cormen, Leiserson, Rivest & Stein 2009, "Introduction to
/// algorithms", §33.2).
///
/// 1. Sweeps a line over the corners by x, by y where x is equal.
/// 2. Keeps the sides that the line meets in their order on it. The order stays valid until two sides cross, which are
///    neighbours just before.
/// 3. Compares sides that become neighbours, exactly. Where sides end and begin at one corner, those that end are removed
///    first, so that sides that cross there become neighbours.
///
/// Sides that touch or coincide do not cross: they keep their order. The time is O(n log n) for n corners.
pub(crate) fn crosses_itself(corners: &[Coord<f64>]) -> bool {
    // 1.
    let mut events: Vec<(Coord<f64>, IsBegin, Side)> = Vec::with_capacity(2 * corners.len());
    for (index, &one) in corners.iter().enumerate() {
        let other = corners[(index + 1) % corners.len()];
        let (begin, end) = match by_place(&one, &other) {
            Ordering::Less => (one, other),
            Ordering::Greater => (other, one),
            Ordering::Equal => continue,
        };
        let side = Side { begin, end, index };
        events.extend([(begin, true, side), (end, false, side)]);
    }
    events.sort_by(|a, b| by_place(&a.0, &b.0).then(a.1.cmp(&b.1)).then(a.2.index.cmp(&b.2.index)));
    let mut met: BTreeSet<Side> = BTreeSet::new();
    for (_, is_begin, side) in events {
        // 2.
        if !is_begin {
            met.remove(&side);
        }
        let below = met.range(..side).next_back();
        let above = met.range((Excluded(side), Unbounded)).next();
        // 3.
        let is_crossed = if is_begin {
            below.into_iter().chain(above).any(|other| side.crosses(other))
        } else {
            below.zip(above).is_some_and(|(below, above)| below.crosses(above))
        };
        if is_crossed {
            return true;
        }
        if is_begin {
            met.insert(side);
        }
    }
    false
}

/// True if a side begins at the event; false if it ends there.
type IsBegin = bool;

fn by_place(a: &Coord<f64>, b: &Coord<f64>) -> Ordering {
    // Adding zero turns −0 into 0, so that the two compare equal.
    let order = |a: f64, b: f64| (a + 0.0).total_cmp(&(b + 0.0));
    order(a.x, b.x).then(order(a.y, b.y))
}

/// Side from its lesser corner to its greater one. Sides are ordered by height where the sweep meets both, collinear ones
/// by index.
#[derive(Clone, Copy)]
struct Side {
    begin: Coord<f64>,
    end: Coord<f64>,
    index: usize,
}

impl Side {
    /// Positive for a point to the left of the side, which is above it.
    fn turn(&self, place: Coord<f64>) -> f64 {
        orient2d(self.begin, self.end, place)
    }

    fn crosses(&self, other: &Self) -> bool {
        let apart = |s: f64, t: f64| (s > 0.0 && t < 0.0) || (s < 0.0 && t > 0.0);
        apart(self.turn(other.begin), self.turn(other.end))
            && apart(other.turn(self.begin), other.turn(self.end))
    }

    /// Order relative to a side that begins no earlier.
    fn with_later(&self, later: &Self) -> Ordering {
        let above = |turn: f64| turn.partial_cmp(&0.0).unwrap_or(Ordering::Equal);
        above(self.turn(later.begin)).then_with(|| above(self.turn(later.end))).reverse()
    }
}

impl Ord for Side {
    fn cmp(&self, other: &Self) -> Ordering {
        let order = if by_place(&self.begin, &other.begin) == Ordering::Greater {
            other.with_later(self).reverse()
        } else {
            self.with_later(other)
        };
        order.then(self.index.cmp(&other.index))
    }
}

impl PartialOrd for Side {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Side {
    fn eq(&self, other: &Self) -> bool {
        self.index == other.index
    }
}

impl Eq for Side {}

#[cfg(test)]
mod tests {
    use cranny_spatial::Stream;

    use super::*;

    /// Reference that compares all pairs.
    fn some_pair_crosses(corners: &[Coord<f64>]) -> bool {
        let side = |index: usize| {
            let end = corners[(index + 1) % corners.len()];
            Side { begin: corners[index], end, index }
        };
        (0..corners.len()).any(|one| (0..one).any(|other| side(one).crosses(&side(other))))
    }

    /// On a coarse grid sides touch, coincide and have no length in most polygons.
    #[test]
    fn the_sweep_finds_what_a_comparison_of_all_pairs_finds() {
        let mut random = Stream::new(8, 0);
        let mut crossed = [0; 2];
        for corners in 3..14 {
            for places in [2.0, 3.0, 5.0, 9.0, 1e6] {
                for _ in 0..400 {
                    let mut place = || (random.uniform() * places).floor() - 1.0;
                    let polygon: Vec<_> = (0..corners).map(|_| Coord { x: place(), y: place() }).collect();
                    let expected = some_pair_crosses(&polygon);
                    crossed[usize::from(expected)] += 1;
                    assert_eq!(crosses_itself(&polygon), expected, "{polygon:?}");
                }
            }
        }
        assert!(crossed.iter().all(|count| *count > 2000), "{crossed:?}");
    }

    /// Tests simple polygons, some with one corner moved.
    #[test]
    fn the_sweep_finds_one_crossing_in_a_star() {
        let mut random = Stream::new(9, 0);
        let mut crossed = [0; 2];
        for corners in 5..120_u32 {
            for _ in 0..20 {
                let mut star: Vec<_> = (0..corners)
                    .map(|corner| {
                        let angle = f64::from(corner) / f64::from(corners) * std::f64::consts::TAU;
                        let (sine, cosine) = cranny_spatial::sin_cos(angle);
                        let radius = (1.0 + 8.0 * random.uniform()).floor();
                        Coord { x: radius * cosine, y: radius * sine }
                    })
                    .collect();
                assert!(!crosses_itself(&star));
                star[1] = Coord { x: 16.0 * random.uniform() - 8.0, y: 16.0 * random.uniform() - 8.0 };
                let expected = some_pair_crosses(&star);
                crossed[usize::from(expected)] += 1;
                assert_eq!(crosses_itself(&star), expected, "{star:?}");
            }
        }
        assert!(crossed.iter().all(|count| *count > 100), "{crossed:?}");
    }
}
