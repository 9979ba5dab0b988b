use cranny_spatial::{Point, Vector};

use crate::{ShapeError, TriangleSoup};

/// Closed surface through a row of closed rings with equal numbers of points. Neighbouring rings are joined. Fans about their
/// centres close the first and the last ring.
///
/// Rings run counterclockwise as seen from the end of the row, so that normals point outwards.
#[derive(Clone, Debug, PartialEq)]
pub struct Loft {
    rings: Vec<Vec<Point>>,
}

impl Loft {
    /// A loft through `rings`.
    ///
    /// # Errors
    /// [`ShapeError::Rings`] for fewer than two rings, rings of fewer than three points, or of different numbers of them.
    pub fn new(rings: Vec<Vec<Point>>) -> Result<Self, ShapeError> {
        let points = rings.first().map_or(0, Vec::len);
        if rings.len() < 2 || points < 3 || rings.iter().any(|ring| ring.len() != points) {
            return Err(ShapeError::Rings { rings: rings.len(), points });
        }
        Ok(Self { rings })
    }

    /// Surface of the loft: closed, normals outwards.
    ///
    /// # Errors
    /// [`ShapeError::NotFinite`].
    pub fn mesh(&self) -> Result<TriangleSoup, ShapeError> {
        let mut corners = Vec::new();
        let count = self.rings[0].len();
        for pair in self.rings.windows(2) {
            for here in 0..count {
                let next = (here + 1) % count;
                let (a, b, c, d) = (pair[0][here], pair[0][next], pair[1][next], pair[1][here]);
                corners.extend([a, b, c, a, c, d]);
            }
        }
        let (first, last) = (&self.rings[0], &self.rings[self.rings.len() - 1]);
        for here in 0..count {
            let next = (here + 1) % count;
            corners.extend([middle(first), first[next], first[here]]);
            corners.extend([middle(last), last[here], last[next]]);
        }
        TriangleSoup::from_corners(corners)
    }

    /// Convex hulls of the pieces of the loft between the rings `cuts`. A ring at a cut belongs to the pieces on both sides.
    ///
    /// # Errors
    /// [`ShapeError::FlatHull`] for a piece without volume.
    pub fn convex_pieces(&self, cuts: &[usize]) -> Result<Vec<TriangleSoup>, ShapeError> {
        let last = self.rings.len() - 1;
        let mut bounds: Vec<usize> = cuts.iter().copied().filter(|&cut| cut > 0 && cut < last).collect();
        bounds.insert(0, 0);
        bounds.push(last);
        let piece = |ends: &[usize]| TriangleSoup::convex_hull(&self.rings[ends[0]..=ends[1]].concat());
        bounds.windows(2).map(piece).collect()
    }
}

fn middle(ring: &[Point]) -> Point {
    let sum: Vector = ring.iter().map(|point| point.coords).sum();
    (sum / ring.len() as f64).into()
}
