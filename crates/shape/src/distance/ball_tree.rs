use cranny_spatial::{Point, Pose};

use crate::distance::convex::Core;
use crate::hulls::coarse_hull::chosen;
use crate::hulls::convex_hull::Plane;
use crate::hulls::cut::{Cut, longest_side};
use crate::mesh::each_once;
use crate::solid::Kind;
use crate::{Ball, CoarseHull, Solid, TriangleSoup};

/// Balls whose union contains a solid, as a binary tree.
///
/// The balls of the leaves together contain the solid. The ball of an inner node contains the piece of the solid that the
/// leaves below it cover, so an object clear of the ball is clear of this piece.
#[derive(Clone, Debug)]
pub struct BallTree {
    nodes: Vec<BallNode>,
}

/// A node of a [`BallTree`].
#[derive(Clone, Copy, Debug)]
pub struct BallNode {
    /// Ball that contains the node's piece of the solid, in the frame of the tree.
    pub ball: Ball,
    /// Indices of the two halves of the piece, both after this node; `None` for a leaf.
    pub children: Option<[usize; 2]>,
}

/// Maximum number of times that a piece of the solid is halved.
const DEEPEST: usize = 14;

/// Slack added to every radius, in metres: a hundred times the rounding of a cut ([`crate::hulls::cut`]), for at most
/// [`DEEPEST`] cuts.
const SLACK_M: f64 = 1e-7;

/// Maximum number of corners of a hull, because the time of a cut is quadratic in them. A larger hull is reduced to this many,
/// and the balls grow by the protrusion of the others from their hull: some tenths of a millimetre.
const MOST_CORNERS: usize = 64;

impl BallTree {
    /// The tree around a solid, in the solid's frame. Halves a piece until its ball protrudes from the faces of the solid
    /// by at most `bulge_m` (metres). A mesh counts as its convex hull. `None` for a half-space.
    ///
    /// Containment does not depend on a hull algorithm, whose faces may be wrong where a solid is thin:
    ///
    /// 1. Takes the corners of the solid's core, or some of them and a bound on the protrusion of the others.
    /// 2. Cuts their convex hull in half across the longest side of its box, repeatedly. The cuts are exact and use corners
    ///    alone.
    /// 3. Puts a small ball around the corners of each piece, grown by the radius that rounds the core. The faces of the hull
    ///    only determine which ball protrudes least.
    pub fn around(solid: &Solid, bulge_m: f64) -> Option<Self> {
        if let Some(coarse) = CoarseHull::of(solid, MOST_CORNERS) {
            return Some(Self::around_coarse(solid, &coarse, bulge_m));
        }
        // A mesh, or a hull whose corners cannot be distinguished.
        let (points, radius_m) = solid.bounding_points()?;
        let points = each_once(points);
        let whole = || Self { nodes: vec![BallNode { ball: enclosing(&points, radius_m), children: None }] };
        let tree = chosen(&points, MOST_CORNERS).and_then(|(corners, standing_out_m)| {
            Self::around_corners(&corners, radius_m + standing_out_m, bulge_m)
        });
        Some(tree.unwrap_or_else(whole))
    }

    /// [`Self::around`] for a convex solid whose coarse hull is known.
    pub fn around_coarse(solid: &Solid, coarse: &CoarseHull, bulge_m: f64) -> Self {
        let around = |corners: &[Point], rounding_m: f64| {
            Self::around_corners(corners, rounding_m, bulge_m).unwrap_or_else(|| {
                let ball = enclosing(corners, rounding_m);
                Self { nodes: vec![BallNode { ball, children: None }] }
            })
        };
        match solid.kind() {
            Kind::Convex(convex) => match convex.core {
                Core::Segment { half_length } => Self::along_segment(half_length, convex.radius_m, bulge_m),
                // The prism around the cylinder has fewer corners than the one inside.
                Core::Cylinder { .. } => around(&convex.bounding_points(), convex.radius_m),
                _ => around(&coarse.corners, coarse.radius_m + coarse.bulge_m),
            },
            Kind::Mesh(_) | Kind::Union(_) | Kind::HalfSpace => {
                around(&coarse.corners, coarse.radius_m + coarse.bulge_m)
            }
        }
    }

    /// Tree around the rounded hull of some points; `None` if all lie in one plane, or are one.
    fn around_corners(corners: &[Point], rounding_m: f64, bulge_m: f64) -> Option<Self> {
        let planes = TriangleSoup::convex_hull(corners).ok()?.planes();
        let mut tree = Self { nodes: Vec::new() };
        tree.cover(corners, &planes, rounding_m, bulge_m, 0);
        Some(tree)
    }

    /// Joins trees into one, each moved by `target_from_tree`.
    ///
    /// # Panics
    /// If there are no trees.
    pub fn joined(trees: Vec<(Pose, Self)>) -> Self {
        let placed: Vec<Self> = trees.into_iter().map(|(pose, tree)| tree.transformed(&pose)).collect();
        let mut joined = Self { nodes: Vec::new() };
        joined.join(placed);
        joined
    }

    /// The nodes, the root first.
    pub fn nodes(&self) -> &[BallNode] {
        &self.nodes
    }

    fn transformed(mut self, target_from_tree: &Pose) -> Self {
        for node in &mut self.nodes {
            node.ball.center = target_from_tree * node.ball.center;
        }
        self
    }

    /// Covers the piece with these corners as in 2. and 3. of [`Self::around`]; returns its node.
    fn cover(
        &mut self,
        corners: &[Point],
        planes: &[Plane],
        rounding_m: f64,
        bulge_m: f64,
        depth: usize,
    ) -> usize {
        let (ball, stands_out_m) = least_bulge(corners, planes, bulge_m);
        let node = self.nodes.len();
        let radius_m = ball.radius_m + rounding_m + SLACK_M;
        self.nodes.push(BallNode { ball: Ball { radius_m, ..ball }, children: None });
        if stands_out_m > bulge_m
            && depth < DEEPEST
            && let Some(Cut { low, high }) = Cut::across(corners)
        {
            let [low, high] =
                [low, high].map(|half| self.cover(&half, planes, rounding_m, bulge_m, depth + 1));
            self.nodes[node].children = Some([low, high]);
        }
        node
    }

    /// Tree around a capsule: balls along its axis whose seams lie on the capsule, and one ball at each end.
    fn along_segment(half_length: f64, radius_m: f64, bulge_m: f64) -> Self {
        let spacing = 2.0 * (2.0 * radius_m * bulge_m + bulge_m * bulge_m).sqrt();
        #[allow(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "A capsule has far fewer pieces than a count can hold"
        )]
        let count = (2.0 * half_length / spacing).ceil().clamp(1.0, 4096.0) as usize;
        let half = half_length / count as f64;
        let ball = |z: f64, radius_m: f64| Self {
            nodes: vec![BallNode {
                ball: Ball { center: Point::new(0.0, 0.0, z), radius_m: radius_m + SLACK_M },
                children: None,
            }],
        };
        let mut balls = vec![ball(-half_length, radius_m)];
        balls.extend((0..count).map(|index| {
            ball(-half_length + (2 * index + 1) as f64 * half, (half * half + radius_m * radius_m).sqrt())
        }));
        balls.push(ball(half_length, radius_m));
        let mut tree = Self { nodes: Vec::new() };
        tree.join(balls);
        tree
    }

    /// Appends a node over `trees` with all nodes below it; returns its index.
    fn join(&mut self, mut trees: Vec<Self>) -> usize {
        let node = self.nodes.len();
        if trees.len() == 1 {
            for inner in &trees[0].nodes {
                let children = inner.children.map(|children| children.map(|child| child + node));
                self.nodes.push(BallNode { children, ..*inner });
            }
            return node;
        }
        let balls: Vec<Ball> = trees.iter().flat_map(Self::leaves).collect();
        let ball = around_balls(&balls);
        self.nodes.push(BallNode { ball, children: None });
        let centers: Vec<Point> = trees.iter().map(|tree| tree.nodes[0].ball.center).collect();
        let axis = longest_side(&centers).0;
        trees.sort_by(|a, b| a.nodes[0].ball.center[axis].total_cmp(&b.nodes[0].ball.center[axis]));
        let high = trees.split_off(trees.len() / 2);
        let children = [self.join(trees), self.join(high)];
        self.nodes[node].children = Some(children);
        node
    }

    fn leaves(&self) -> impl Iterator<Item = Ball> {
        self.nodes.iter().filter(|node| node.children.is_none()).map(|node| node.ball)
    }
}

/// Approximate ball around the points with the least protrusion from the planes, and this protrusion (m). The search stops at a
/// ball that protrudes by at most `enough_m` (m).
///
/// The required radius and the height above the highest plane are both convex in the centre, so the search descends their sum
/// by subgradients with ever smaller steps (Shor 1985, "Minimization methods for non-differentiable functions", ch. 2).
fn least_bulge(points: &[Point], planes: &[Plane], enough_m: f64) -> (Ball, f64) {
    const STEPS: usize = 16;
    /// Number of steps after which the search gives up if the ball protrudes more than `HOPELESS` times `enough_m`.
    const HOPEFUL_STEPS: usize = 4;
    const HOPELESS: f64 = 3.0;
    let start = start_ball(points);
    // A plane that is farther below than the search can rise is never the highest.
    let planes: Vec<&Plane> =
        planes.iter().filter(|p| p.height(&start.center) > -4.0 * start.radius_m).collect();
    let mut center = start.center;
    let mut best = (start, f64::INFINITY);
    for step in 0..STEPS {
        let Some((squared, farthest)) = greatest(points.iter(), |point| (*point - center).norm_squared())
        else {
            break;
        };
        let highest = greatest(planes.iter().copied(), |plane| plane.height(&center));
        let radius_m = squared.sqrt();
        // No point of a ball is farther than this from the piece in it, even if the planes of a thin hull are wrong.
        let across_m = 2.0 * radius_m;
        let stands_out_m = highest.map_or(across_m, |(height_m, _)| across_m.min(height_m + radius_m));
        if stands_out_m < best.1 {
            best = (Ball { center, radius_m }, stands_out_m);
            if stands_out_m <= enough_m {
                break;
            }
        }
        // No other centre makes one ball sufficient, so the piece is cut.
        if step == HOPEFUL_STEPS && best.1 > HOPELESS * enough_m {
            break;
        }
        let towards_farthest = (farthest - center).try_normalize(0.0).unwrap_or_default();
        let inwards = highest.map_or_else(cranny_spatial::Vector::zeros, |(_, plane)| -plane.normal());
        center += (towards_farthest + inwards) * (0.5 * start.radius_m / (step + 1) as f64);
    }
    best
}

/// Returns the greatest element by a measure, with its measure; the last of equals.
fn greatest<T: Copy>(all: impl Iterator<Item = T>, measure: impl Fn(T) -> f64) -> Option<(f64, T)> {
    all.map(|one| (measure(one), one)).reduce(|best, next| if next.0 >= best.0 { next } else { best })
}

/// Ball around the points, centred in their box.
fn start_ball(points: &[Point]) -> Ball {
    let aabb = crate::Aabb::around(points, 0.0);
    let radius_m = points.iter().map(|p| (p - aabb.center).norm_squared()).fold(0.0, f64::max).sqrt();
    Ball { center: aabb.center, radius_m }
}

/// A small ball around the points, grown by `rounding_m` (m).
fn enclosing(points: &[Point], rounding_m: f64) -> Ball {
    let balls: Vec<Ball> = points.iter().map(|&center| Ball { center, radius_m: 0.0 }).collect();
    let ball = around_balls(&balls);
    Ball { radius_m: ball.radius_m + rounding_m + SLACK_M, ..ball }
}

/// A small ball around balls: the centre moves towards the farthest ball by ever smaller steps (Bădoiu & Clarkson 2003,
/// "Smaller core-sets for balls", whole, for balls instead of points). The radius follows from the centre.
fn around_balls(balls: &[Ball]) -> Ball {
    /// Number of steps; leaves the radius within 2 % of the least.
    const STEPS: usize = 50;
    let reach = |center: &Point, ball: &Ball| (ball.center - center).norm() + ball.radius_m;
    let farthest = |center: &Point| {
        let found = greatest(balls.iter(), |ball| reach(center, ball));
        found.map_or(Ball { center: *center, radius_m: 0.0 }, |(_, ball)| *ball)
    };
    let mut center = balls.first().map_or(Point::origin(), |ball| ball.center);
    for step in 1..=STEPS {
        let far = farthest(&center);
        let offset = far.center - center;
        if offset.norm() > 0.0 {
            // The target is the far side of the farthest ball.
            let target = far.center + offset.normalize() * far.radius_m;
            center += (target - center) / (step + 1) as f64;
        }
    }
    Ball { center, radius_m: reach(&center, &farthest(&center)) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The corners of all triangles were considered, so that each vertex counted about six times.
    #[test]
    fn each_vertex_of_a_mesh_counts_once() {
        let soup = Solid::sphere(0.1).unwrap().tessellation().unwrap();
        let (corners, _) = Solid::mesh(&soup).unwrap().bounding_points().unwrap();
        assert_eq!(corners.len(), 3 * soup.triangles.len());
        let points = each_once(corners);
        assert_eq!(points.len(), soup.vertices.len());
        assert!(soup.vertices.iter().all(|vertex| points.contains(vertex)));
    }
}
