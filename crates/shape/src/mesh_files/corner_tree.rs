use robust::{Coord, orient2d};

/// Tree of boxes over the corners of a polygon, which finds those in a triangle without a scan of all.
///
/// Boxes are halved by count across their longer side, so that crowded corners do not deepen the tree. Corners are
/// removed one by one, and empty boxes are skipped.
pub(crate) struct CornerTree {
    /// Boxes in depth-first order: each is followed by those inside it.
    boxes: Vec<CornerBox>,
    /// Corners of the undivided boxes, box by box.
    corners: Vec<usize>,
    /// Box of each corner; `None` for one that is not in the tree.
    boxes_of: Vec<Option<usize>>,
}

struct CornerBox {
    low: Coord<f64>,
    high: Coord<f64>,
    parent: Option<usize>,
    /// Index of the first box outside it.
    behind: usize,
    /// Range of its corners.
    corners: (usize, usize),
    is_halved: bool,
    /// Number of corners left.
    left: usize,
}

/// Maximum number of corners of an undivided box: a scan of them is faster than a division.
const MOST_IN_A_BOX: usize = 8;

impl CornerTree {
    /// Builds the tree of some corners of a polygon.
    pub(crate) fn new(places: &[Coord<f64>], corners: Vec<usize>) -> Self {
        let mut tree = Self { boxes: Vec::new(), corners, boxes_of: vec![None; places.len()] };
        tree.add((0, tree.corners.len()), None, places);
        tree
    }

    fn add(&mut self, range: (usize, usize), parent: Option<usize>, places: &[Coord<f64>]) {
        let corners = &mut self.corners[range.0..range.1];
        let (mut low, mut high) = (Coord { x: f64::MAX, y: f64::MAX }, Coord { x: f64::MIN, y: f64::MIN });
        for place in corners.iter().map(|&corner| places[corner]) {
            low = Coord { x: low.x.min(place.x), y: low.y.min(place.y) };
            high = Coord { x: high.x.max(place.x), y: high.y.max(place.y) };
        }
        let (left, at) = (corners.len(), self.boxes.len());
        let is_halved = left > MOST_IN_A_BOX;
        self.boxes.push(CornerBox { low, high, parent, behind: 0, corners: range, is_halved, left });
        if is_halved {
            let is_wide = high.x - low.x > high.y - low.y;
            let across = |corner: &usize| if is_wide { places[*corner].x } else { places[*corner].y };
            corners.select_nth_unstable_by(left / 2, |a, b| across(a).total_cmp(&across(b)));
            let middle = range.0 + left / 2;
            self.add((range.0, middle), Some(at), places);
            self.add((middle, range.1), Some(at), places);
        } else {
            for &corner in &*corners {
                self.boxes_of[corner] = Some(at);
            }
        }
        self.boxes[at].behind = self.boxes.len();
    }

    /// Returns true if a corner is in the tree.
    pub(crate) fn has(&self, corner: usize) -> bool {
        self.boxes_of[corner].is_some()
    }

    /// Removes a corner if it is in the tree.
    pub(crate) fn remove(&mut self, corner: usize) {
        let mut above = self.boxes_of[corner].take();
        while let Some(at) = above {
            self.boxes[at].left -= 1;
            above = self.boxes[at].parent;
        }
    }

    /// Finds a corner of the tree that satisfies `is_it`; all such corners must lie inside the counterclockwise triangle.
    pub(crate) fn find(
        &self,
        triangle: [Coord<f64>; 3],
        mut is_it: impl FnMut(usize) -> bool,
    ) -> Option<usize> {
        let mut at = 0;
        while let Some(here) = self.boxes.get(at) {
            if here.left == 0 || here.is_beside(triangle) {
                at = here.behind;
                continue;
            }
            if !here.is_halved {
                let corners = &self.corners[here.corners.0..here.corners.1];
                if let Some(found) = corners.iter().find(|&&corner| self.has(corner) && is_it(corner)) {
                    return Some(*found);
                }
            }
            at += 1;
        }
        None
    }
}

impl CornerBox {
    /// Returns true if the whole box lies beyond one side of a triangle. It does if its innermost corner does, and signs
    /// alone determine that corner.
    fn is_beside(&self, triangle: [Coord<f64>; 3]) -> bool {
        (0..3).any(|side| {
            let (from, to) = (triangle[side], triangle[(side + 1) % 3]);
            let inmost = Coord {
                x: if to.y > from.y { self.low.x } else { self.high.x },
                y: if to.x > from.x { self.high.y } else { self.low.y },
            };
            orient2d(from, to, inmost) < 0.0
        })
    }
}

#[cfg(test)]
mod tests {
    use cranny_spatial::Stream;

    use super::*;

    #[test]
    fn the_tree_finds_a_corner_in_a_triangle_where_there_is_one() {
        let mut random = Stream::new(10, 0);
        let mut found = [0; 2];
        for count in [0, 1, 5, 9, 100, 700] {
            let mut place = || Coord { x: (random.uniform() * 40.0).floor(), y: random.uniform().powi(4) };
            let places: Vec<_> = (0..count).map(|_| place()).collect();
            let mut tree = CornerTree::new(&places, (0..count).filter(|corner| corner % 3 > 0).collect());
            for round in 0..count + 40 {
                let mut triangle = [place(), place(), place()];
                if orient2d(triangle[0], triangle[1], triangle[2]) < 0.0 {
                    triangle.swap(1, 2);
                }
                let is_in = |corner: usize| {
                    (0..3).all(|at| orient2d(triangle[at], triangle[(at + 1) % 3], places[corner]) >= 0.0)
                };
                let expected = (0..count).any(|corner| tree.has(corner) && is_in(corner));
                found[usize::from(expected)] += 1;
                assert_eq!(tree.find(triangle, is_in).is_some(), expected);
                assert!(tree.find(triangle, is_in).is_none_or(|corner| tree.has(corner)));
                if round < count {
                    tree.remove((round * 7) % count);
                }
            }
        }
        assert!(found.iter().all(|count| *count > 100), "{found:?}");
    }
}
