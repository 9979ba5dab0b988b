use cranny_collision::{Cell, Scratch};
use cranny_robot::{JointKind, Robot};
use cranny_spatial::ROUNDING_M;

use crate::timing::path_curve::{PathCurve, Piece, moved};

/// How far any point of a robot can move, against the world or against another link, while its joints move
/// by a given amount, at any configuration: `Σ |δ_m| · reach_m` over the joints m that move links, mimic
/// joints too.
///
/// The reach of a joint is the greatest distance of a point of any link beyond it from its axis: the lengths
/// between the frames of the joints on the way there, with sliding joints drawn out as far as they go, and
/// the farthest point of the link from the last of them. Of two links, only the joints move one against the
/// other that do not move both, and each of these moves one of them.
pub(crate) struct LinkReach {
    /// Joint, and metres for a unit of it.
    movers: Vec<(usize, f64)>,
}

impl LinkReach {
    pub fn new(robot: &Robot) -> Self {
        let frames = robot.frames();
        let origin = |link: usize| frames.link(link).translation.vector;
        // For each link that a joint ends in, the joint and its reach.
        let mut movers: Vec<Option<(usize, f64)>> = vec![None; robot.links().len()];
        for (index, link) in robot.links().iter().enumerate() {
            let Some(last) = robot.ancestors(index).last() else { continue };
            let points = link.collisions.iter().map(|shape| {
                let ball = shape.solid.ball();
                let center = frames.link(index) * (shape.link_from_shape * ball.center);
                (center.coords - origin(last.child_link)).norm() + ball.radius_m
            });
            let mut distance_m = points.fold(0.0, f64::max);
            let mut beyond = last.child_link;
            for mover in robot.ancestors(index).iter().rev() {
                distance_m += (origin(mover.child_link) - origin(beyond)).norm();
                beyond = mover.child_link;
                let scale = mover.multiplier.abs();
                let limits = &robot.limits()[mover.joint];
                let (reach_m, drawn_out_m) = match mover.kind {
                    JointKind::Revolute => (distance_m * scale, 0.0),
                    JointKind::Prismatic => (scale, scale * limits.lower.abs().max(limits.upper.abs())),
                };
                let known = movers[mover.child_link].map_or(0.0, |(_, reach_m)| reach_m);
                movers[mover.child_link] = Some((mover.joint, reach_m.max(known)));
                distance_m += drawn_out_m;
            }
        }
        Self { movers: movers.into_iter().flatten().collect() }
    }

    /// The bound for the joints moving by `delta`, in metres.
    pub fn motion_m(&self, delta: impl Fn(usize) -> f64) -> f64 {
        self.movers.iter().map(|(joint, reach_m)| delta(*joint).abs() * reach_m).sum()
    }
}

/// Steps of the bisection for the greatest blend: to within 1/128 of the greatest that the edges allow.
const BISECTIONS: usize = 7;

/// Greatest distance of a chord of a cut corner from the curve, as the motion of any point of the robot, in metres.
const CHORD_TOLERANCE_M: f64 = 1e-5;

/// Clearance that a blend keeps in reserve, in metres, so that its chords can be proven to keep what is demanded
/// and their distance from the curve besides: twice that distance, and the resolution of a proof.
const RESERVE_M: f64 = 3.0 * CHORD_TOLERANCE_M;

/// A corner of a path that a trajectory cuts, as the chords of its parabola.
#[derive(Clone, Debug)]
pub struct CutCorner {
    /// The edges of the path between which it lies.
    pub edges: [usize; 2],
    /// Points of the parabola, from its beginning on the first edge to its end on the second, one value per joint each
    /// (m, rad).
    pub chords: Vec<Vec<f64>>,
    /// Bound on the distance of any point of the robot, as the curve has it, from where the chord at the same share of the
    /// way has it, and on the change of any distance between two links, in metres.
    pub deviation_m: f64,
}

impl CutCorner {
    /// Those that a curve cuts.
    pub(crate) fn all_of(curve: &PathCurve, reach: &LinkReach) -> Vec<Self> {
        let of_piece = |(index, piece): (usize, &Piece)| {
            let at = |waypoint: &(usize, f64)| waypoint.0 == index;
            // Way points that are one are passed at once.
            let first = curve.waypoints.iter().position(at)?.checked_sub(1)?;
            let second = curve.waypoints.iter().rposition(at)?;
            Self::of(piece, [first, second], reach)
        };
        curve.pieces.iter().enumerate().filter_map(of_piece).collect()
    }

    /// The chords of a parabola `q(σ) = origin + slope·σ + ½·curvature·σ²`, σ in [0, length].
    ///
    /// On an interval of length h a parabola is at most `h²/8·|curvature|` from its chord.
    fn of(parabola: &Piece, edges: [usize; 2], reach: &LinkReach) -> Option<Self> {
        let curvature = parabola.curvature.as_ref()?;
        let whole_m = 0.125 * parabola.length * parabola.length * reach.motion_m(|joint| curvature[joint]);
        let pieces = (whole_m / CHORD_TOLERANCE_M).sqrt().ceil().max(1.0);
        let deviation_m = whole_m / (pieces * pieces) + ROUNDING_M;
        let at = |piece: u32| parabola.begin + parabola.length * (f64::from(piece) / pieces);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a small count")]
        let chords = (0..=pieces as u32).map(|piece| parabola.position(at(piece))).collect();
        Some(Self { edges, chords, deviation_m })
    }
}

/// The greatest found `r` up to `greatest` for which the parabola from `corner − r·before` to
/// `corner + r·after` is proven to keep every distance that `cell` demands, each pair its own; 0 if none is.
///
/// Half of the parabola, `q(τ)` with τ in [0, ½], is compared with the line from its beginning to the corner,
/// at the same share of the way: `q(τ) − line(2τ) = τ²·r·(after − before)`. So no point of the parabola is
/// farther from the two lines than `w = ¼·r·(after − before)`, and no pair of bodies closer than on the
/// lines by more than their motion under `w`. If the lines are proven to keep that much more than is demanded, the
/// parabola is proven. It lies in the triangle of its three points, so within the limits of the joints.
pub(crate) fn proven_blend(
    cell: &Cell,
    reach: &LinkReach,
    corner: &[f64],
    (before, after): (&[f64], &[f64]),
    greatest: f64,
    scratch: &mut Scratch,
) -> f64 {
    let per_r_m = 0.25 * reach.motion_m(|joint| after[joint] - before[joint]);
    let mut is_proven = |r: f64| {
        let beyond_m = r * per_r_m + RESERVE_M;
        let mut keeps = |a: &[f64], b: &[f64]| cell.motion_beyond(beyond_m, a, b, scratch).is_proven();
        keeps(&moved(corner, before, -r), corner) && keeps(corner, &moved(corner, after, r))
    };
    if is_proven(greatest) {
        return greatest;
    }
    // A shorter blend lies on shorter lines and nearer to them.
    let (mut proven, mut unproven) = (0.0, greatest);
    for _ in 0..BISECTIONS {
        let r = 0.5 * (proven + unproven);
        if is_proven(r) { proven = r } else { unproven = r }
    }
    proven
}

#[cfg(test)]
mod tests {
    use std::path::Path;
    use std::sync::Arc;

    use cranny_collision::{Body, Margins, World};
    use cranny_robot::{RobotOptions, TextSource};
    use cranny_shape::Solid;
    use cranny_spatial::{Point, Pose, Stream};

    use super::*;

    fn panda() -> Robot {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenario/robots/panda_mobile");
        #[allow(clippy::disallowed_methods, reason = "a test reads the robot")]
        let text = std::fs::read_to_string(folder.join("panda_mobile.urdf")).expect("the URDF");
        let options = RobotOptions {
            srdf: Some(TextSource::Path(folder.join("panda_mobile.srdf"))),
            ..RobotOptions::default()
        };
        Robot::from_urdf_text(&text, "panda_mobile.urdf", Some(&folder), &options).expect("the robot")
    }

    /// Corners of the shapes of each link, in its frame.
    fn corners(robot: &Robot) -> Vec<(usize, Point)> {
        let mut corners = Vec::new();
        for (index, link) in robot.links().iter().enumerate() {
            for shape in &link.collisions {
                let points = shape.solid.bounding_points().map_or(Vec::new(), |(points, _)| points);
                corners.extend(points.iter().map(|point| (index, shape.link_from_shape * point)));
            }
        }
        corners
    }

    /// Against the world, and in distance from a point of another link, at random configurations, by small and by large
    /// motions of one joint or all.
    #[test]
    fn no_point_moves_farther_than_the_bound() {
        let robot = panda();
        let (reach, corners) = (LinkReach::new(&robot), corners(&robot));
        let mut stream = Stream::new(1, 0);
        let anywhere = |stream: &mut Stream| -> Vec<f64> { robot.random_configuration(stream) };
        let (mut before, mut after) = (robot.frames(), robot.frames());
        let mut tightest = 0.0_f64;
        for round in 0..300 {
            let (a, other) = (anywhere(&mut stream), anywhere(&mut stream));
            let part = [1.0, 0.1, 0.001][round % 3];
            let only = stream.index(2 * robot.dof());
            let b: Vec<f64> = (0..robot.dof())
                .map(|j| if only < robot.dof() && j != only { a[j] } else { a[j] + part * (other[j] - a[j]) })
                .collect();
            let bound_m = reach.motion_m(|joint| b[joint] - a[joint]);
            robot.forward_kinematics(&a, &mut before);
            robot.forward_kinematics(&b, &mut after);
            for (link, corner) in &corners {
                let moved_m = (after.link(*link) * corner - before.link(*link) * corner).norm();
                assert!(moved_m <= bound_m + 1e-12, "{moved_m} beyond {bound_m}");
                tightest = tightest.max(moved_m / bound_m);
                let (other, other_corner) = &corners[stream.index(corners.len())];
                let distance_m = |frames: &cranny_robot::LinkFrames| {
                    (frames.link(*link) * corner - frames.link(*other) * other_corner).norm()
                };
                assert!((distance_m(&after) - distance_m(&before)).abs() <= bound_m + 1e-12);
            }
        }
        // A sliding base moves everything exactly as far as the bound says.
        assert!(tightest > 0.999, "{tightest}");
    }

    /// A ball on two slides.
    const CART: &str = r#"<robot name="cart">
      <link name="rail"/><link name="bridge"/>
      <link name="ball"><collision><geometry><sphere radius="0.05"/></geometry></collision></link>
      <joint name="x" type="prismatic"><parent link="rail"/><child link="bridge"/><axis xyz="1 0 0"/>
        <limit lower="-1" upper="1" velocity="1" effort="1"/></joint>
      <joint name="y" type="prismatic"><parent link="bridge"/><child link="ball"/><axis xyz="0 1 0"/>
        <limit lower="-1" upper="1" velocity="1" effort="1"/></joint>
    </robot>"#;

    /// The ball goes along x to (0.5, 0), then along y; a post of its size stands inside the corner.
    /// Returns how much of the demanded clearance the parabola keeps.
    fn kept_m(post_at: f64, margin_m: f64, factor: f64) -> f64 {
        let robot = Robot::from_urdf_text(CART, "cart.urdf", None, &RobotOptions::default()).expect("a URDF");
        let robot = Arc::new(robot);
        let pose = Pose::translation(0.5 - post_at, post_at, 0.0);
        let post = Body::new("post", pose, Solid::sphere(0.05).expect("a positive radius"));
        let world = World::new(vec![post]).expect("finite poses");
        let margins = Margins { margin_m, ..Margins::default() };
        let cell = Cell::new(robot.clone(), world, margins).expect("a good margin");
        let mut reach = LinkReach::new(&robot);
        reach.movers.iter_mut().for_each(|(_, reach_m)| *reach_m *= factor);
        let slopes = (&[1.0, 0.0][..], &[0.0, 1.0][..]);
        let r = proven_blend(&cell, &reach, &[0.5, 0.0], slopes, 0.45, &mut cell.scratch());
        assert!(r > 0.0);
        let distance_m = |k: u32| {
            let t = f64::from(k) / 1000.0;
            let (x, y) = (0.5 - r * (1.0 - t) * (1.0 - t), r * t * t);
            (x - 0.5 + post_at).hypot(y - post_at) - 0.1
        };
        (0..=1000).map(distance_m).fold(f64::INFINITY, f64::min) - margin_m
    }

    #[test]
    fn a_proven_blend_keeps_its_distance_and_a_wrong_bound_is_caught() {
        for post_at in [0.11, 0.12, 0.15, 0.2] {
            for margin_m in [0.0, 0.005] {
                let kept_m = kept_m(post_at, margin_m, 1.0);
                assert!(kept_m > 0.0, "{kept_m} with the post at {post_at}");
            }
        }
        // The post is five times as far from the corner as from the lines, so the bound must be far too small.
        assert!(kept_m(0.11, 0.0, 0.02) < 0.0);
    }
}
