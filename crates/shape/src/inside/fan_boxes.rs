//! Boxes of triangles in coordinates in which narrow triangles about an axis do not overlap.

use cranny_spatial::nalgebra::Matrix3;
use cranny_spatial::{Point, Vector};

/// Tree of boxes over triangles, with three kinds of sides: the coordinates of the mesh, those along its principal axes, and the
/// directions from each of some axes. The triangles of a cone, a prism or a disc overlap with their neighbours alone in the
/// directions from their axis, however the mesh is turned.
pub(crate) struct FanBoxes {
    boxes: Vec<FanBox>,
    /// Triangles of the undivided nodes, node by node.
    order: Vec<usize>,
    /// Nodes in depth-first order: each is followed by those inside it.
    nodes: Vec<FanNode>,
}

struct FanNode {
    around: FanBox,
    /// Index of the first node outside it.
    behind: usize,
    /// Range of its triangles.
    range: (usize, usize),
    is_halved: bool,
}

/// Number of axes: the principal ones, those of the three vertices with the most triangles, and the line through the first two
/// of these.
const AXES: usize = 7;

/// Number of sides: six coordinates, and for each axis the cosine and sine of the angle about it.
const SIDES: usize = 6 + 2 * AXES;

/// Lower and upper end of each side.
#[derive(Clone, Copy)]
struct FanBox {
    low: [f64; SIDES],
    high: [f64; SIDES],
}

/// Distance from an axis below which a corner is on it, as a share of the size of the mesh. Mesh files in single precision are
/// rounded by 6e-8.
pub(crate) const NOISE: f64 = 1e-6;

/// Addition to each side, as a share of its unit: above the rounding of a direction at the distance [`NOISE`].
const ROUNDING: f64 = 1e-9;

/// Chord of the greatest angle for which an arc is formed, on the unit circle: 144°.
const LONGEST_CHORD: f64 = 1.9;

/// Maximum number of triangles of an undivided node.
const MOST_IN_A_NODE: usize = 4;

impl FanBoxes {
    pub(crate) fn new(triangles: &[[u32; 3]], corners: &[[Point; 3]]) -> Self {
        let frame = Frame::of(triangles, corners);
        let boxes: Vec<FanBox> = corners.iter().map(|triangle| frame.box_of(triangle)).collect();
        let mut tree = Self { order: (0..boxes.len()).collect(), boxes, nodes: Vec::new() };
        tree.add((0, tree.order.len()));
        tree
    }

    fn add(&mut self, range: (usize, usize)) {
        let members = &mut self.order[range.0..range.1];
        let mut around = FanBox::empty();
        let mut widths = [0.0; SIDES];
        for one in members.iter().map(|&member| &self.boxes[member]) {
            around.include(one);
            (0..SIDES).for_each(|side| widths[side] += one.high[side] - one.low[side]);
        }
        let (at, is_halved) = (self.nodes.len(), members.len() > MOST_IN_A_NODE);
        self.nodes.push(FanNode { around, behind: 0, range, is_halved });
        if is_halved {
            // The side along which the boxes are short compared with their spread separates them best.
            let share = |side: usize| widths[side] / (around.high[side] - around.low[side]);
            let best = (0..SIDES).min_by(|a, b| share(*a).total_cmp(&share(*b))).unwrap_or(0);
            let boxes = &self.boxes;
            let middle = |member: &usize| boxes[*member].low[best] + boxes[*member].high[best];
            let half = members.len() / 2;
            members.select_nth_unstable_by(half, |a, b| middle(a).total_cmp(&middle(b)).then(a.cmp(b)));
            self.add((range.0, range.0 + half));
            self.add((range.0 + half, range.1));
        }
        self.nodes[at].behind = self.nodes.len();
    }

    /// Puts the triangles whose boxes overlap with that of `first` into `near`, in a fixed order; returns `budget` less the
    /// number of nodes and boxes compared, or `None` if it does not suffice.
    pub(crate) fn near(&self, first: usize, mut budget: usize, near: &mut Vec<usize>) -> Option<usize> {
        near.clear();
        let own = &self.boxes[first];
        let mut at = 0;
        while let Some(node) = self.nodes.get(at) {
            budget = budget.checked_sub(1)?;
            if !node.around.overlaps(own) {
                at = node.behind;
                continue;
            }
            if !node.is_halved {
                let members = &self.order[node.range.0..node.range.1];
                budget = budget.checked_sub(members.len())?;
                near.extend(members.iter().copied().filter(|&member| self.boxes[member].overlaps(own)));
            }
            at += 1;
        }
        Some(budget)
    }
}

impl FanBox {
    fn empty() -> Self {
        Self { low: [f64::INFINITY; SIDES], high: [f64::NEG_INFINITY; SIDES] }
    }

    fn include(&mut self, other: &Self) {
        for side in 0..SIDES {
            self.low[side] = self.low[side].min(other.low[side]);
            self.high[side] = self.high[side].max(other.high[side]);
        }
    }

    fn overlaps(&self, other: &Self) -> bool {
        (0..SIDES).all(|side| self.low[side] <= other.high[side] && other.low[side] <= self.high[side])
    }
}

/// Coordinates of the boxes.
struct Frame {
    center: Point,
    size_m: f64,
    /// Principal axes, as rows.
    principal: Matrix3<f64>,
    axes: Vec<Axis>,
}

impl Frame {
    fn of(triangles: &[[u32; 3]], corners: &[[Point; 3]]) -> Self {
        let all = || corners.iter().flatten();
        let mean = all().map(|corner| corner.coords).sum::<Vector>() / (3 * corners.len()).max(1) as f64;
        let center = Point::from(mean);
        let spread: Matrix3<f64> = all().map(|corner| corner - center).map(|r| r * r.transpose()).sum();
        let principal = spread.symmetric_eigen().eigenvectors.transpose();
        let size_m = all().map(|corner| (corner - center).amax()).fold(f64::MIN_POSITIVE, f64::max);
        let mut axes: Vec<Axis> =
            (0..3).filter_map(|row| Axis::of(center, principal.row(row).transpose())).collect();
        let hubs = Hub::greatest(triangles, corners);
        axes.extend(hubs.iter().filter_map(|hub| Axis::of(hub.place, hub.normal)));
        if let [one, other, ..] = &hubs[..] {
            axes.extend(Axis::of(one.place, other.place - one.place));
        }
        Self { center, size_m, principal, axes }
    }

    fn box_of(&self, triangle: &[Point; 3]) -> FanBox {
        let mut around = FanBox::empty();
        for corner in triangle {
            let from_center = (corner - self.center) / self.size_m;
            let along = self.principal * from_center;
            for axis in 0..3 {
                for (side, place) in [(axis, from_center[axis]), (3 + axis, along[axis])] {
                    around.low[side] = around.low[side].min(place);
                    around.high[side] = around.high[side].max(place);
                }
            }
        }
        for number in 0..AXES {
            let arc = self.axes.get(number).and_then(|axis| axis.arc(triangle, NOISE * self.size_m));
            for (side, (low, high)) in (6 + 2 * number..).zip(arc.unwrap_or([(-1.0, 1.0); 2])) {
                (around.low[side], around.high[side]) = (low, high);
            }
        }
        for side in 0..SIDES {
            around.low[side] -= ROUNDING;
            around.high[side] += ROUNDING;
        }
        around
    }
}

struct Axis {
    place: Point,
    /// Two directions that are perpendicular to the axis and to each other.
    across: [Vector; 2],
}

impl Axis {
    /// Axis through a point; `None` without a direction.
    fn of(place: Point, direction: Vector) -> Option<Self> {
        let direction = direction.try_normalize(0.0)?;
        let least = direction.iamin();
        let first = direction.cross(&Vector::ith(least, 1.0)).try_normalize(0.0)?;
        Some(Self { place, across: [first, direction.cross(&first)] })
    }

    /// Ranges of cosine and sine of the angles about the axis at which a triangle lies; `None` if it may surround the axis.
    ///
    /// Corners on the axis have no angle, and add none: the triangle lies between the angles of the others.
    fn arc(&self, triangle: &[Point; 3], least_m: f64) -> Option<[(f64, f64); 2]> {
        let across = triangle.map(|corner| self.across.map(|axis| axis.dot(&(corner - self.place))));
        let lengths = across.map(|[x, y]| libm::hypot(x, y));
        let directions: Vec<[f64; 2]> = (0..3)
            .filter(|&corner| lengths[corner] > least_m)
            .map(|corner| across[corner].map(|length| length / lengths[corner]))
            .collect();
        let pairs = [[0, 1], [1, 2], [2, 0]].into_iter();
        let pairs = pairs.filter_map(|[a, b]| Some((*directions.get(a)?, *directions.get(b)?)));
        let chord = |(a, b): &([f64; 2], [f64; 2])| libm::hypot(a[0] - b[0], a[1] - b[1]);
        let Some(ends) = pairs.max_by(|a, b| chord(a).total_cmp(&chord(b))) else {
            // One direction, or a triangle along the axis.
            return directions.first().map(|direction| direction.map(|share| (share, share)));
        };
        let length = chord(&ends);
        // A third direction that is no nearer to both ends than they are to each other lies on the other side of the circle.
        let middle = [0, 1].map(|side| ends.0[side] + ends.1[side]);
        let towards = |direction: &[f64; 2]| middle[0] * direction[0] + middle[1] * direction[1];
        let is_between = |direction: &[f64; 2]| towards(direction) >= towards(&ends.0) - ROUNDING;
        if length > LONGEST_CHORD || !directions.iter().all(is_between) {
            return None;
        }
        // Height of the arc above its chord, on the unit circle.
        let height = 1.0 - (1.0 - 0.25 * length * length).max(0.0).sqrt();
        Some([0, 1].map(|side| {
            let (a, b) = (ends.0[side], ends.1[side]);
            (a.min(b) - height, a.max(b) + height)
        }))
    }
}

/// Vertex of many triangles.
struct Hub {
    place: Point,
    /// Sum of the normals of its triangles.
    normal: Vector,
}

impl Hub {
    /// Those of the three vertices with the most triangles, the greatest first.
    fn greatest(triangles: &[[u32; 3]], corners: &[[Point; 3]]) -> Vec<Self> {
        let mut by_vertex: Vec<(u32, usize, usize)> = (0..)
            .zip(triangles)
            .flat_map(|(index, triangle)| (0..3).map(move |corner| (triangle[corner], index, corner)))
            .collect();
        by_vertex.sort_unstable();
        let mut stars: Vec<&[(u32, usize, usize)]> = by_vertex.chunk_by(|a, b| a.0 == b.0).collect();
        // A stable order keeps vertices of equal rank in that of the file.
        stars.sort_by_key(|star| std::cmp::Reverse(star.len()));
        let hub = |star: &&[(u32, usize, usize)]| {
            let normal = |&(_, index, _): &(u32, usize, usize)| {
                let [a, b, c] = corners[index];
                (b - a).cross(&(c - a))
            };
            let (_, index, corner) = star[0];
            Self { place: corners[index][corner], normal: star.iter().map(normal).sum() }
        };
        stars.iter().take(3).map(hub).collect()
    }
}

#[cfg(test)]
mod tests {
    use cranny_spatial::{Rotation, Stream};

    use super::*;
    use crate::surface::triangles_meet;

    /// Compares with the test of all pairs, for triangles of any shape about hubs and axes.
    #[test]
    fn triangles_that_meet_have_boxes_that_overlap() {
        let mut random = Stream::new(17, 0);
        let mut found = [0; 2];
        for round in 0..40 {
            let mut draw = |size: f64| size * (random.uniform() - 0.5);
            let turn = Rotation::from_euler_angles(draw(6.0), draw(6.0), draw(6.0));
            let vertices: Vec<Point> = (0..40)
                .map(|vertex| match vertex {
                    0 => turn * Point::new(0.0, 0.0, 1.0),
                    1 => turn * Point::new(0.0, 0.0, -1.0),
                    _ => {
                        turn * Point::new(draw(2.0), draw(2.0), if round % 2 == 0 { 0.0 } else { draw(1.0) })
                    }
                })
                .collect();
            let triangles: Vec<[u32; 3]> =
                (0..60).map(|index: u32| [index % 3, 2 + index % 37, 3 + index * 7 % 36]).collect();
            let corners: Vec<[Point; 3]> =
                triangles.iter().map(|triangle| triangle.map(|vertex| vertices[vertex as usize])).collect();
            let boxes = FanBoxes::new(&triangles, &corners);
            let mut near = Vec::new();
            for first in 0..corners.len() {
                boxes.near(first, usize::MAX, &mut near).unwrap();
                for second in 0..corners.len() {
                    let is_near = near.contains(&second);
                    // Those that share a vertex may meet on an axis alone, where they have no direction from it.
                    let is_shared = triangles[first].iter().any(|vertex| triangles[second].contains(vertex));
                    if !is_shared && triangles_meet(&corners[first], &corners[second]) {
                        assert!(is_near, "{:?} {:?}", corners[first], corners[second]);
                    }
                    found[usize::from(is_near)] += 1;
                }
            }
        }
        assert!(found.iter().all(|count| *count > 10_000), "{found:?}");
    }
}
