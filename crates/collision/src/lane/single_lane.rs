use std::cmp::Ordering;

use cranny_shape::BoxUnion;
use fearless_simd::Simd;

use crate::lane::ball_pack::BallPack;
use crate::lane::lane_body::{LaneBody, LaneNode};
use crate::lane::lane_hull::LaneHull;
use crate::lane::lane_part::LanePart;
use crate::lane::lane_solid::LaneSolid;
use crate::lane::lane_vector::{dot, is_shorter, minus, narrow};
use crate::lane::single_frame::{Bars, SingleFrame, Verdict};

/// Maximum number of boxes of a union that are compared with the hulls of a link; more are left to the exact check.
const MOST_BOXES: usize = 48;

/// Maximum number of nodes of a link's tree of balls whose visit is due.
const MOST_OPEN: usize = 64;

impl LaneBody {
    /// Checks the link against a part of the world that is near the ball around it.
    ///
    /// 1. Two boxes along the same axes are compared directly.
    /// 2. The balls of a link that consists of balls are checked, otherwise its inner balls; then the box around it.
    /// 3. Its hulls are checked against the hull of the part, or its lowest corner against a half-space, or the boxes of a union near
    ///    its outer balls.
    /// 4. Without hulls, the outer balls are checked: if no leaf is near, the link is free; then the inner balls.
    #[inline(never)]
    pub fn against_part<S: Simd>(
        &self,
        simd: S,
        frame: &SingleFrame,
        part: &LanePart,
        bars: Bars,
    ) -> Verdict {
        // 1.
        if let [LaneHull { cuboid: Some(cuboid), .. }] = &self.hulls[..]
            && part.is_exact
            && let Some(gap_m) = frame.solid(cuboid).aligned_gap_m(&part.solid)
        {
            return bars.verdict([gap_m; 2]);
        }
        // 2.
        let closer = |packs, reach_m, must_be_sure| {
            BallPack::any_closer(simd, packs, frame, &part.solid, reach_m, must_be_sure)
        };
        let in_contact = |packs| closer(packs, bars.contact_m, true);
        if self.is_balls && !closer(&self.packed_inner, bars.free_m, false) {
            return Verdict::Free;
        }
        let (large, small) = self.packed_inner.split_at(self.packed_inner.len().min(1));
        if part.is_exact && in_contact(large) {
            return Verdict::Contact;
        }
        if part.box_around().is_some_and(|around| !self.is_box_closer(frame, around, bars.free_m)) {
            return Verdict::Free;
        }
        // 3.
        if !self.hulls.is_empty()
            && let Some((normal, height)) = part.plane()
        {
            let verdict = |hull: &LaneHull| {
                let [low, high] = simd.vectorize(
                    #[inline(always)]
                    || hull.least_along(simd, frame, normal),
                );
                bars.verdict([low - height, high - height])
            };
            return Verdict::of_all(self.hulls.iter().map(verdict));
        }
        if !self.hulls.is_empty()
            && let Some(other) = &part.hull
        {
            let apart = part.solid.apart(frame.point(self.outer[0].ball.center));
            return Verdict::of_all(
                self.hulls
                    .iter()
                    .map(|hull| hull.against(simd, frame, other, &SingleFrame::ROOT, apart, bars)),
            );
        }
        if !self.hulls.is_empty()
            && let Some(union) = part.solid.as_union()
        {
            let union_frame = SingleFrame { axes: part.solid.rows, origin: part.solid.origin };
            let verdict = self.against_union(simd, frame, union, &union_frame, bars);
            let is_deep = verdict == Verdict::Doubt && in_contact(small);
            return if is_deep { Verdict::Contact } else { verdict };
        }
        // 4.
        if !self.any_leaf_closer(0, frame, &part.solid, bars.free_m) {
            return Verdict::Free;
        }
        if part.is_exact && in_contact(small) { Verdict::Contact } else { Verdict::Doubt }
    }

    /// Checks the link against another one, in the same manner.
    #[inline(never)]
    pub fn against_body<S: Simd>(
        &self,
        simd: S,
        frame: &SingleFrame,
        other: &Self,
        other_frame: &SingleFrame,
        bars: Bars,
    ) -> Verdict {
        let trees = BallTrees {
            nodes: [&self.outer, &other.outer],
            frames: [frame, other_frame],
            free_m: bars.free_m,
        };
        let roots = [trees.node(0, 0), trees.node(1, 0)];
        if !trees.are_closer(roots[0], roots[1]) {
            return Verdict::Free;
        }
        if !self.hulls.is_empty() && !other.hulls.is_empty() {
            let apart = roots[0].apart(&roots[1]);
            let pairs = self.hulls.iter().flat_map(|a| other.hulls.iter().map(move |b| (a, b)));
            return Verdict::of_all(pairs.map(|(a, b)| a.against(simd, frame, b, other_frame, apart, bars)));
        }
        let packs = [&self.packed_inner[..], &other.packed_inner];
        let meet = |reach_m| BallPack::any_meet(simd, packs, [frame, other_frame], reach_m);
        let is_near = if self.is_balls && other.is_balls {
            meet(bars.free_m)
        } else {
            trees.any_leaves_closer(roots[0], roots[1])
        };
        match is_near {
            false => Verdict::Free,
            true if meet(bars.contact_m) => Verdict::Contact,
            true => Verdict::Doubt,
        }
    }

    /// Checks the hulls of the link against those boxes of a union that are near its outer balls, in doubt if there are too many.
    #[inline(never)]
    fn against_union<S: Simd>(
        &self,
        simd: S,
        frame: &SingleFrame,
        union: &BoxUnion,
        union_frame: &SingleFrame,
        bars: Bars,
    ) -> Verdict {
        simd.vectorize(
            #[inline(always)]
            || {
                let (mut near, mut count) = ([(0, 0); MOST_BOXES], 0);
                let (mut open, mut open_count) = ([0; MOST_OPEN], 1);
                while open_count > 0 {
                    open_count -= 1;
                    let node = open[open_count];
                    let LaneNode { ball, children } = self.outer[node as usize];
                    let center = union_frame.turned_back(minus(frame.point(ball.center), union_frame.origin));
                    let reach_m = bars.free_m + ball.radius;
                    if children != [0; 2] {
                        if union.may_be_closer(center, reach_m) {
                            if open_count + 2 > MOST_OPEN {
                                return Verdict::Doubt;
                            }
                            open[open_count..open_count + 2].copy_from_slice(&children);
                            open_count += 2;
                        }
                        continue;
                    }
                    let is_all = union.all_closer(simd, center, reach_m, |index| {
                        if near[..count].iter().any(|(known, _)| *known == index) {
                            return true;
                        }
                        if count == MOST_BOXES {
                            return false;
                        }
                        near[count] = (index, node);
                        count += 1;
                        true
                    });
                    if !is_all {
                        return Verdict::Doubt;
                    }
                }
                let radius = narrow(union.radius_m());
                let verdict = |(index, node): &(u32, u32)| {
                    let narrow_box = union.narrow_box(*index);
                    let other = LaneHull::of_box(narrow_box, radius);
                    let [center, _] = narrow_box;
                    let ball = self.outer[*node as usize].ball;
                    let apart = minus(frame.point(ball.center), union_frame.point(center));
                    Verdict::of_all(
                        self.hulls
                            .iter()
                            .map(|hull| hull.against(simd, frame, &other, union_frame, apart, bars)),
                    )
                };
                Verdict::of_all(near[..count].iter().map(verdict))
            },
        )
    }

    /// Returns true if the boxes around the link and a part, given by its centre and half extents, are closer than `free_m` (m)
    /// along all axes of the link's frame.
    fn is_box_closer(&self, frame: &SingleFrame, [center, half_extents]: [[f32; 3]; 2], free_m: f32) -> bool {
        let center = frame.turned_back(minus(center, frame.origin));
        (0..3).all(|axis| {
            let others = dot(frame.axes[axis].map(f32::abs), half_extents);
            let gap = (center[axis] - self.middle[axis]).abs() - self.half_extents[axis] - others;
            // NaN does not count as farther.
            !matches!(gap.partial_cmp(&free_m), Some(Ordering::Greater | Ordering::Equal))
        })
    }

    fn is_node_closer(&self, node: u32, frame: &SingleFrame, solid: &LaneSolid, free_m: f32) -> bool {
        let LaneNode { ball, .. } = &self.outer[node as usize];
        solid.is_closer(frame.point(ball.center), free_m + ball.radius)
    }

    fn any_leaf_closer(&self, node: u32, frame: &SingleFrame, solid: &LaneSolid, free_m: f32) -> bool {
        let children = self.outer[node as usize].children;
        self.is_node_closer(node, frame, solid, free_m)
            && (children == [0; 2]
                || children.into_iter().any(|child| self.any_leaf_closer(child, frame, solid, free_m)))
    }
}

/// Trees of outer balls of two links.
struct BallTrees<'a> {
    nodes: [&'a [LaneNode]; 2],
    frames: [&'a SingleFrame; 2],
    free_m: f32,
}

/// A node of a tree, with the centre of its ball in the root frame.
#[derive(Clone, Copy)]
struct Placed<'a> {
    node: &'a LaneNode,
    center: [f32; 3],
}

impl Placed<'_> {
    /// Returns the vector from the centre of another ball to this one.
    fn apart(&self, other: &Self) -> [f32; 3] {
        minus(self.center, other.center)
    }

    fn is_leaf(&self) -> bool {
        self.node.children == [0; 2]
    }
}

impl<'a> BallTrees<'a> {
    /// Returns a node of the first or the second tree.
    fn node(&self, tree: usize, node: u32) -> Placed<'a> {
        let node = &self.nodes[tree][node as usize];
        Placed { node, center: self.frames[tree].point(node.ball.center) }
    }

    fn are_closer(&self, a: Placed, b: Placed) -> bool {
        is_closer(a.center, b.center, self.free_m + a.node.ball.radius + b.node.ball.radius)
    }

    /// Returns true if two leaves below these nodes are closer than `free_m` (m).
    fn any_leaves_closer(&self, a: Placed, b: Placed) -> bool {
        if !self.are_closer(a, b) {
            return false;
        }
        if a.is_leaf() && b.is_leaf() {
            return true;
        }
        // Split the larger ball.
        if !a.is_leaf() && (b.is_leaf() || a.node.ball.radius >= b.node.ball.radius) {
            a.node.children.into_iter().any(|child| self.any_leaves_closer(self.node(0, child), b))
        } else {
            b.node.children.into_iter().any(|child| self.any_leaves_closer(a, self.node(1, child)))
        }
    }
}

/// Returns true if two points are closer than `reach_m` (m), or a coordinate is NaN.
fn is_closer(a: [f32; 3], b: [f32; 3], reach_m: f32) -> bool {
    let way = minus(a, b);
    is_shorter(dot(way, way), reach_m)
}
