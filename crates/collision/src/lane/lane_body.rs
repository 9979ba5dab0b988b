use cranny_robot::LaneKinematics;
use cranny_shape::{Ball, BallTree, CoarseHull, Outline, Solid, inner_balls};
use cranny_spatial::Pose;

use crate::body::link_body::LinkBody;
use crate::lane::ball_pack::BallPack;
use crate::lane::lane_ball::LaneBall;
use crate::lane::lane_hull::LaneHull;
use crate::lane::lane_vector::{RELATIVE_ROUNDING, lanes};

/// Maximum distance by which the outer balls of a link protrude from it, in metres: a tenth of the thickness of an arm. Smaller
/// balls would leave fewer configurations to the exact check, but take longer themselves.
const BULGE_M: f64 = 0.008;

/// Number of balls inside a link, shared among its solids, that prove contact without the exact check.
const INNER_BALLS: usize = 32;

/// A link in lane form: balls around it and inside it, in a frame of the lane kinematics.
#[derive(Clone, Debug)]
pub(crate) struct LaneBody {
    /// Index of the frame to which it is fixed.
    pub frame: usize,
    /// Centre and half extents of its box along the axes of the frame, in metres.
    pub middle: [f32; 3],
    pub half_extents: [f32; 3],
    /// Tree of balls whose leaves cover the link; the root comes first.
    pub outer: Vec<LaneNode>,
    /// Hulls of its solids; empty if a solid is not convex, or if the link consists of balls.
    pub hulls: Vec<LaneHull>,
    /// Balls inside the link, the largest first.
    pub inner: Vec<LaneBall>,
    /// The balls of `inner`, packed in lanes.
    pub packed_inner: Vec<BallPack>,
    /// True if the link consists exactly of the balls of `inner`.
    pub is_balls: bool,
    /// Maximum distance by which its hulls (without hulls, its outer balls) protrude from it, in metres; 0 for a link of balls.
    pub blur_m: f64,
    /// Contribution of its position and size to the rounding error of distances to it, in metres.
    pub slack_m: f64,
}

/// A node of the tree of outer balls.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LaneNode {
    pub ball: LaneBall,
    /// Indices of its two children; both 0 for a leaf.
    pub children: [u32; 2],
}

impl LaneBody {
    pub fn new(kinematics: &LaneKinematics, body: &LinkBody) -> Self {
        let placement = kinematics.placement(body.link);
        let place = |link_from_shape: &Pose| placement.frame_from_link * link_from_shape;
        let coarse: Vec<Option<CoarseHull>> =
            body.shapes.iter().map(|(_, solid)| LaneHull::coarse(solid)).collect();
        let trees = body.shapes.iter().zip(&coarse).filter_map(|((link_from_shape, solid), coarse)| {
            let tree = match coarse {
                Some(coarse) => BallTree::around_coarse(solid, coarse, BULGE_M),
                None => BallTree::around(solid, BULGE_M)?,
            };
            Some((place(link_from_shape), tree))
        });
        let tree = BallTree::joined(trees.collect());
        let outer: Vec<LaneNode> = tree
            .nodes()
            .iter()
            .map(|node| LaneNode {
                ball: LaneBall::new(&node.ball),
                // Trees have far fewer nodes than `u32` can index.
                children: node.children.map_or([0; 2], |children| {
                    children.map(|child| u32::try_from(child).unwrap_or_default())
                }),
            })
            .collect();
        let ball = |(link_from_shape, solid): &(Pose, Solid)| match solid.outline() {
            Outline::Segment { half_length_m: 0.0, radius_m } => {
                let center = place(link_from_shape) * solid.aabb().center;
                Some(LaneBall::new(&Ball { center, radius_m }))
            }
            _ => None,
        };
        let balls: Option<Vec<LaneBall>> = body.shapes.iter().map(ball).collect();
        let is_balls = balls.is_some();
        let mut inner = balls.unwrap_or_else(|| inner_of(body, place));
        inner.sort_by(|a, b| b.radius.total_cmp(&a.radius));
        let hull = |((link_from_shape, solid), coarse): (&(Pose, Solid), &Option<CoarseHull>)| {
            Some(LaneHull::of(&place(link_from_shape), solid, coarse.as_ref()?))
        };
        let hulls: Vec<LaneHull> = match body.shapes.iter().zip(&coarse).map(hull).collect() {
            Some(hulls) if !is_balls => hulls,
            _ => Vec::new(),
        };
        let blur_m = match &hulls[..] {
            [] if is_balls => 0.0,
            [] => BULGE_M,
            hulls => hulls.iter().map(LaneHull::bulge_m).fold(0.0, f64::max),
        };
        let aabb = body.bounds.aabb.transformed(&placement.frame_from_link);
        let root = &tree.nodes()[0].ball;
        let from_frame_m = root.center.coords.norm() + root.radius_m;
        let slack_m = kinematics.position_error_m(placement.frame, from_frame_m)
            + RELATIVE_ROUNDING * (kinematics.farthest_m(placement.frame) + from_frame_m);
        let [middle, half_extents] = [aabb.center.coords, aabb.half_extents].map(|v| lanes(&v));
        Self {
            frame: placement.frame,
            middle,
            half_extents,
            outer,
            hulls,
            packed_inner: BallPack::all(&inner),
            inner,
            is_balls,
            blur_m,
            slack_m,
        }
    }
}

/// Returns balls inside the solids of a link, in the frame to which `place` transforms.
fn inner_of(body: &LinkBody, place: impl Fn(&Pose) -> Pose) -> Vec<LaneBall> {
    let per_solid = (INNER_BALLS / body.shapes.len()).max(1);
    let of_shape = |(link_from_shape, solid): &(Pose, Solid)| {
        let frame_from_shape = place(link_from_shape);
        let placed =
            move |ball: Ball| LaneBall::new(&Ball { center: frame_from_shape * ball.center, ..ball });
        inner_balls(solid, per_solid).into_iter().map(placed)
    };
    body.shapes.iter().flat_map(of_shape).collect()
}
