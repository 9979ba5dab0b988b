use std::ops::Range;

use cranny_shape::Aabb;
use cranny_spatial::Point;

use crate::body::world::Part;

/// Parts of a world in a tree of boxes along the axes of the planning frame, to skip distant parts in groups (broad phase).
///
/// Nodes are stored in the order of traversal, parents before children. A skipped node is followed by the first node beyond its
/// subtree, so that the traversal needs no stack.
#[derive(Clone, Debug)]
pub(crate) struct PartTree {
    nodes: Vec<PartNode>,
    parts: Vec<usize>,
}

#[derive(Clone, Debug)]
pub(crate) struct PartNode {
    /// Box around all its parts; `None` if some are unbounded, or if the box would not help.
    pub aabb: Option<Aabb>,
    /// Range of the parts of a leaf in [`PartTree::parts`]; empty for any other node.
    pub places: Range<usize>,
    /// Next node if this one is skipped.
    pub next: usize,
}

/// Maximum number of parts that are checked one by one: the released scenarios have 6 to 12, for which a tree would be slower.
pub(crate) const FEW: usize = 16;

/// Maximum number of parts of a leaf. Checks among 100 and 1000 boxes are no faster with 2, and slower with 8.
const LEAF: usize = 4;

impl PartTree {
    pub fn new<'a>(parts: impl Iterator<Item = &'a Part>) -> Self {
        let boxes: Vec<Option<Aabb>> = parts.map(box_around).collect();
        let mut tree = Self { nodes: Vec::new(), parts: Vec::with_capacity(boxes.len()) };
        let all = 0..boxes.len();
        if boxes.len() <= FEW {
            tree.add_leaf(None, all.collect());
            return tree;
        }
        let (bounded, endless): (Vec<usize>, Vec<usize>) = all.partition(|part| boxes[*part].is_some());
        tree.add_leaf(None, endless);
        let bounded = bounded.into_iter().filter_map(|part| Some((part, boxes[part]?))).collect();
        tree.add(bounded);
        tree
    }

    /// Returns all parts, by index, in the order of the leaves.
    pub fn parts(&self) -> &[usize] {
        &self.parts
    }

    /// Returns all nodes; traversal starts at the first.
    pub fn nodes(&self) -> &[PartNode] {
        &self.nodes
    }

    /// Returns the positions in [`Self::parts`] of all parts that may be closer than `reach_m` (m) to a point, in order.
    pub fn near(&self, center: Point, reach_m: f64) -> impl Iterator<Item = usize> {
        let mut next = 0;
        std::iter::from_fn(move || {
            loop {
                let node = self.nodes.get(next)?;
                let is_far = node.aabb.as_ref().is_some_and(|aabb| aabb.distance_to(&center) > reach_m);
                next = if is_far { node.next } else { next + 1 };
                if !is_far && !node.places.is_empty() {
                    return Some(node.places.clone());
                }
            }
        })
        .flatten()
    }

    fn add_leaf(&mut self, aabb: Option<Aabb>, mut parts: Vec<usize>) {
        parts.sort_unstable();
        let begin = self.parts.len();
        self.parts.extend(parts);
        self.nodes.push(PartNode { aabb, places: begin..self.parts.len(), next: self.nodes.len() + 1 });
    }

    /// Adds the subtree of these parts, split in half along the axis with the largest spread of their centres.
    fn add(&mut self, mut parts: Vec<(usize, Aabb)>) {
        let corners: Vec<Point> = parts.iter().flat_map(|(_, aabb)| [aabb.low(), aabb.high()]).collect();
        let aabb = Aabb::around(&corners, 0.0);
        if parts.len() <= LEAF {
            self.add_leaf(Some(aabb), parts.into_iter().map(|(part, _)| part).collect());
            return;
        }
        let spread = Aabb::around(parts.iter().map(|(_, aabb)| &aabb.center), 0.0).half_extents;
        let axis = spread.imax();
        parts.sort_by(|(a, box_a), (b, box_b)| {
            box_a.center[axis].total_cmp(&box_b.center[axis]).then(a.cmp(b))
        });
        let node = self.nodes.len();
        self.nodes.push(PartNode { aabb: Some(aabb), places: 0..0, next: 0 });
        let upper = parts.split_off(parts.len() / 2);
        self.add(parts);
        self.add(upper);
        self.nodes[node].next = self.nodes.len();
    }
}

fn box_around(part: &Part) -> Option<Aabb> {
    let Part { world_from_solid, solid } = part;
    (!solid.is_half_space()).then(|| solid.aabb().transformed(world_from_solid))
}

#[cfg(test)]
mod tests {
    use cranny_shape::Solid;
    use cranny_spatial::{Pose, Stream, Vector};
    use proptest::prelude::*;

    use super::*;

    fn random_parts(random: &mut Stream, count: usize) -> Vec<Part> {
        (0..count)
            .map(|index| {
                let place = Vector::zeros().map(|_: f64| random.uniform_between(-2.0, 2.0));
                let size = Vector::zeros().map(|_: f64| random.uniform_between(0.001, 0.3));
                let solid = if index % 50 == 7 { Ok(Solid::half_space()) } else { Solid::cuboid(size) };
                let world_from_solid = Pose::from_parts(place.into(), random.rotation());
                Part { world_from_solid, solid: solid.expect("a positive size") }
            })
            .collect()
    }

    proptest! {
        #[test]
        fn no_near_part_is_passed_over(seed in any::<u64>(), count in 0_usize..200, reach_m in 0.0..1.0) {
            let mut random = Stream::new(seed, 0);
            let parts = random_parts(&mut random, count);
            let tree = PartTree::new(parts.iter());
            let mut all = tree.parts().to_vec();
            all.sort_unstable();
            prop_assert_eq!(all, (0..count).collect::<Vec<_>>());
            for _ in 0..20 {
                let point = Point::from(Vector::zeros().map(|_: f64| random.uniform_between(-3.0, 3.0)));
                let found: Vec<usize> = tree.near(point, reach_m).map(|place| tree.parts()[place]).collect();
                for (index, part) in parts.iter().enumerate() {
                    let is_near = box_around(part).is_none_or(|aabb| aabb.distance_to(&point) <= reach_m);
                    prop_assert!(!is_near || found.contains(&index), "{index} of {count} at {point}");
                }
            }
        }
    }
}
