use cranny_spatial::Point;

use crate::inside::self_crossing::SHALLOW_SHARE;
use crate::inside::shell::Shell;
use crate::{Aabb, TriangleSoup};

/// Point that a closed surface without inner walls winds around backwards, because it crosses itself by more than the noise of
/// a scan. The volume enclosed there could cancel elsewhere.
///
/// Along evenly spaced lines through the box around the surface, in the direction of each axis, the surface must be entered
/// before it is left.
pub(crate) fn wound_backwards(soup: &TriangleSoup, shell: &Shell, around: &Aabb) -> Option<Point> {
    (0..3).find_map(|axis| Lines { axis, around }.first_backwards(soup, shell))
}

/// Lines along one axis, in rows and columns.
struct Lines<'a> {
    axis: usize,
    around: &'a Aabb,
}

/// Number of lines in a row, and of rows: finds regions wider than a sixteenth of the box.
const COUNT: usize = 16;

/// Position of a line in its cell, as a share; no mesh has edges there by design.
const OFFSET: f64 = 0.433_012_7;

/// Intersection of a line with the surface: coordinate on the line (m), and 1 to enter or −1 to leave.
type Hit = (f64, i32);

impl Lines<'_> {
    fn first_backwards(&self, soup: &TriangleSoup, shell: &Shell) -> Option<Point> {
        let mut hits: Vec<Vec<Hit>> = vec![Vec::new(); COUNT * COUNT];
        for facet in &shell.facets {
            self.meet(&soup.corners(facet.triangle as usize), facet.is_inward, &mut hits);
        }
        let least_m = 2.0 * SHALLOW_SHARE * self.around.half_extents.max();
        hits.iter_mut().enumerate().find_map(|(line, hits)| {
            hits.sort_by(|a, b| a.0.total_cmp(&b.0));
            // A line through an edge may miss both its faces; such a line is ignored.
            if hits.iter().map(|(_, step)| step).sum::<i32>() != 0 {
                return None;
            }
            let mut depth = 0;
            let at = hits.windows(2).find_map(|two| {
                depth += two[0].1;
                (depth < 0 && two[1].0 - two[0].0 > least_m).then_some(0.5 * (two[0].0 + two[1].0))
            })?;
            Some(self.point(line, at))
        })
    }

    /// Adds the intersections of the lines with a triangle.
    fn meet(&self, corners: &[Point; 3], is_inward: bool, hits: &mut [Vec<Hit>]) {
        let flat = corners.map(|corner| [0, 1].map(|side| corner[(self.axis + 1 + side) % 3]));
        let cross = |a: [f64; 2], b: [f64; 2], c: [f64; 2]| {
            (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
        };
        let area = cross(flat[0], flat[1], flat[2]);
        let [rows, columns] = [0, 1].map(|side| {
            let reach = flat.map(|p| p[side]);
            let first = reach.iter().copied().fold(f64::INFINITY, f64::min);
            let last = reach.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            (0..COUNT).filter(move |line| (first..=last).contains(&self.place(side, *line)))
        });
        let columns: Vec<usize> = columns.collect();
        for row in rows {
            for &column in &columns {
                let p = [self.place(0, row), self.place(1, column)];
                let shares = [0, 1, 2].map(|i| cross(flat[(i + 1) % 3], flat[(i + 2) % 3], p) / area);
                if shares.iter().all(|share| *share > 0.0) {
                    let at = (0..3).map(|i| shares[i] * corners[i][self.axis]).sum::<f64>();
                    // The line leaves the enclosed volume if the normal points along it.
                    let step = if (area > 0.0) == is_inward { 1 } else { -1 };
                    hits[row * COUNT + column].push((at, step));
                }
            }
        }
    }

    /// Coordinate of a line along the first or second axis after that of the lines, in metres.
    fn place(&self, side: usize, line: usize) -> f64 {
        let along = (self.axis + 1 + side) % 3;
        let share = (line as f64 + OFFSET) / COUNT as f64;
        self.around.low()[along] + 2.0 * share * self.around.half_extents[along]
    }

    fn point(&self, line: usize, at: f64) -> Point {
        let mut point = Point::origin();
        point[self.axis] = at;
        point[(self.axis + 1) % 3] = self.place(0, line / COUNT);
        point[(self.axis + 2) % 3] = self.place(1, line % COUNT);
        point
    }
}
