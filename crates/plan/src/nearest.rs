use fearless_simd::prelude::*;
use fearless_simd::{Level, Simd, dispatch, f32x16};

/// Points of a leaf; a multiple of every SIMD width in use.
const LEAF: usize = 32;

/// The nearest of a growing set of configurations by plain L2 distance, exactly.
///
/// A k-d tree of leaves of 32 points (Bentley 1975) with the true bounding box of every subtree: in nine
/// dimensions the boxes prune far better than the splitting planes. Distances are `f32` sums in a fixed
/// order; of equal ones the point added first wins, so the answer depends on nothing but the points.
#[derive(Clone, Debug)]
pub struct NearestNeighbours {
    dimensions: usize,
    nodes: Vec<Node>,
    /// Low and high corner of each node's box, one after the other.
    boxes: Vec<f32>,
    /// Coordinates of the leaves' points: for each leaf, for each dimension, `LEAF` lanes.
    lanes: Vec<f32>,
    ids: Vec<[u32; LEAF]>,
    len: u32,
    stack: Vec<(u32, f32)>,
}

#[derive(Clone, Copy, Debug)]
enum Node {
    Leaf { leaf: u32, len: u32 },
    Inner { dimension: u32, split: f32, low: u32, high: u32 },
}

impl NearestNeighbours {
    /// An empty set of points with so many coordinates.
    pub fn new(dimensions: usize) -> Self {
        let mut set = Self {
            dimensions,
            nodes: Vec::new(),
            boxes: Vec::new(),
            lanes: Vec::new(),
            ids: Vec::new(),
            len: 0,
            stack: Vec::new(),
        };
        let leaf = set.new_leaf();
        set.new_node(Node::Leaf { leaf, len: 0 });
        set
    }

    /// How many points there are.
    pub fn len(&self) -> usize {
        self.len as usize
    }

    /// Whether there is no point.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Adds a point and returns its index: 0, 1, 2, …
    ///
    /// # Panics
    /// If the point has the wrong number of coordinates.
    pub fn add(&mut self, point: &[f64]) -> usize {
        assert_eq!(point.len(), self.dimensions, "one coordinate per dimension");
        let id = self.len;
        self.len += 1;
        let mut node = 0;
        loop {
            self.grow_box(node, point);
            match self.nodes[node] {
                Node::Inner { dimension, split, low, high } => {
                    let side = if as_lane(point[dimension as usize]) < split { low } else { high };
                    node = side as usize;
                }
                Node::Leaf { leaf, len } if (len as usize) < LEAF => {
                    self.write(leaf, len as usize, id, point.iter().map(|x| as_lane(*x)));
                    self.nodes[node] = Node::Leaf { leaf, len: len + 1 };
                    return id as usize;
                }
                Node::Leaf { leaf, .. } => self.split(node, leaf),
            }
        }
    }

    /// The index of the point nearest to `query`; `None` if there is no point.
    ///
    /// # Panics
    /// If the query has the wrong number of coordinates.
    pub fn nearest(&mut self, query: &[f64]) -> Option<usize> {
        assert_eq!(query.len(), self.dimensions, "one coordinate per dimension");
        if self.is_empty() {
            return None;
        }
        /// More joints than this are refused by nobody, only searched more slowly.
        const STACK_DIMENSIONS: usize = 16;
        let mut on_stack = [0.0; STACK_DIMENSIONS];
        let on_heap: Vec<f32>;
        let query: &[f32] = if self.dimensions <= STACK_DIMENSIONS {
            on_stack.iter_mut().zip(query).for_each(|(lane, x)| *lane = as_lane(*x));
            &on_stack[..self.dimensions]
        } else {
            on_heap = query.iter().map(|x| as_lane(*x)).collect();
            &on_heap
        };
        let mut best = (f32::INFINITY, u32::MAX);
        let mut stack = std::mem::take(&mut self.stack);
        dispatch!(Level::new(), simd => self.search(simd, query, &mut stack, &mut best));
        self.stack = stack;
        Some(best.1 as usize)
    }

    #[inline(always)]
    fn search<S: Simd>(&self, simd: S, query: &[f32], stack: &mut Vec<(u32, f32)>, best: &mut (f32, u32)) {
        stack.push((0, 0.0));
        while let Some((node, bound)) = stack.pop() {
            if bound > best.0 {
                continue;
            }
            match self.nodes[node as usize] {
                Node::Leaf { leaf, len } => self.scan(simd, leaf, len as usize, query, best),
                Node::Inner { low, high, .. } => {
                    let mut children =
                        [(low, self.box_distance(low, query)), (high, self.box_distance(high, query))];
                    if children[0].1 < children[1].1 {
                        children.swap(0, 1);
                    }
                    // The nearer child comes off the stack first.
                    stack.extend(children.into_iter().filter(|(_, bound)| *bound <= best.0));
                }
            }
        }
    }

    #[inline(always)]
    fn scan<S: Simd>(&self, simd: S, leaf: u32, len: usize, query: &[f32], best: &mut (f32, u32)) {
        let begin = leaf as usize * self.dimensions * LEAF;
        let mut halves = [f32x16::splat(simd, 0.0); 2];
        for (lanes, x) in self.lanes[begin..].chunks_exact(LEAF).zip(query) {
            let x = f32x16::splat(simd, *x);
            for (sum, lanes) in halves.iter_mut().zip(lanes.chunks_exact(LEAF / 2)) {
                let difference = f32x16::from_slice(simd, lanes) - x;
                *sum += difference * difference;
            }
        }
        // Most leaves hold nothing nearer, which the least of all sums shows at once.
        if halves[0].min(halves[1]).reduce_min() > best.0 {
            return;
        }
        let mut sums = [0.0; LEAF];
        halves[0].store_slice(&mut sums[..LEAF / 2]);
        halves[1].store_slice(&mut sums[LEAF / 2..]);
        for (&sum, &id) in sums.iter().zip(&self.ids[leaf as usize]).take(len) {
            if sum < best.0 || (sum <= best.0 && id < best.1) {
                *best = (sum, id);
            }
        }
    }

    #[inline(always)]
    fn box_distance(&self, node: u32, query: &[f32]) -> f32 {
        let begin = node as usize * 2 * self.dimensions;
        let (low, high) = self.boxes[begin..begin + 2 * self.dimensions].split_at(self.dimensions);
        let mut sum = 0.0;
        for ((low, high), x) in low.iter().zip(high).zip(query) {
            let outside = (low - x).max(x - high).max(0.0);
            sum += outside * outside;
        }
        sum
    }

    fn grow_box(&mut self, node: usize, point: &[f64]) {
        let begin = node * 2 * self.dimensions;
        for (dimension, x) in point.iter().enumerate() {
            let x = as_lane(*x);
            let (low, high) = (begin + dimension, begin + self.dimensions + dimension);
            self.boxes[low] = self.boxes[low].min(x);
            self.boxes[high] = self.boxes[high].max(x);
        }
    }

    /// Turns a full leaf into an inner node with two leaves, cut at the median of the box's longest side.
    fn split(&mut self, node: usize, leaf: u32) {
        let begin = node * 2 * self.dimensions;
        let extent = |d: &usize| self.boxes[begin + self.dimensions + d] - self.boxes[begin + d];
        let dimension = (0..self.dimensions).max_by(|a, b| extent(a).total_cmp(&extent(b))).unwrap_or(0);
        let lane = |d: usize, slot: usize| (leaf as usize * self.dimensions + d) * LEAF + slot;
        let points: Vec<(u32, Vec<f32>)> = (0..LEAF)
            .map(|slot| {
                let coordinates = (0..self.dimensions).map(|d| self.lanes[lane(d, slot)]).collect();
                (self.ids[leaf as usize][slot], coordinates)
            })
            .collect();
        let mut values: Vec<f32> = points.iter().map(|(_, p)| p[dimension]).collect();
        values.sort_by(f32::total_cmp);
        // If most values are equal, any cut that leaves both sides non-empty will do.
        let split = values.iter().copied().skip(LEAF / 2).find(|v| *v > values[0]).unwrap_or(values[0]);

        let begin = leaf as usize * self.dimensions * LEAF;
        self.lanes[begin..begin + self.dimensions * LEAF].fill(f32::INFINITY);
        let leaves = [leaf, self.new_leaf()];
        let children = leaves.map(|leaf| self.new_node(Node::Leaf { leaf, len: 0 }));
        let mut lens = [0u32; 2];
        for (slot, (id, point)) in points.into_iter().enumerate() {
            // Equal points cannot be told apart: they are dealt out in halves.
            let is_high = if split > values[0] { point[dimension] >= split } else { slot >= LEAF / 2 };
            let side = usize::from(is_high);
            let exact: Vec<f64> = point.iter().map(|x| f64::from(*x)).collect();
            self.grow_box(children[side] as usize, &exact);
            self.write(leaves[side], lens[side] as usize, id, point.into_iter());
            lens[side] += 1;
        }
        for side in 0..2 {
            self.nodes[children[side] as usize] = Node::Leaf { leaf: leaves[side], len: lens[side] };
        }
        let dimension = u32::try_from(dimension).unwrap_or(u32::MAX);
        self.nodes[node] = Node::Inner { dimension, split, low: children[0], high: children[1] };
    }

    fn write(&mut self, leaf: u32, slot: usize, id: u32, point: impl Iterator<Item = f32>) {
        self.ids[leaf as usize][slot] = id;
        for (dimension, x) in point.enumerate() {
            self.lanes[(leaf as usize * self.dimensions + dimension) * LEAF + slot] = x;
        }
    }

    fn new_leaf(&mut self) -> u32 {
        // Empty slots are infinitely far from everything.
        self.lanes.resize(self.lanes.len() + self.dimensions * LEAF, f32::INFINITY);
        self.ids.push([u32::MAX; LEAF]);
        u32::try_from(self.ids.len() - 1).unwrap_or(u32::MAX)
    }

    fn new_node(&mut self, node: Node) -> u32 {
        self.boxes.extend(std::iter::repeat_n(f32::INFINITY, self.dimensions));
        self.boxes.extend(std::iter::repeat_n(f32::NEG_INFINITY, self.dimensions));
        self.nodes.push(node);
        u32::try_from(self.nodes.len() - 1).unwrap_or(u32::MAX)
    }
}

/// A coordinate as the tree stores it.
#[allow(clippy::cast_possible_truncation)]
fn as_lane(x: f64) -> f32 {
    x as f32
}

#[cfg(test)]
mod tests {
    use super::*;
    use cranny_spatial::Stream;
    use proptest::prelude::*;

    fn scan(points: &[Vec<f64>], query: &[f64]) -> usize {
        let distance = |p: &Vec<f64>| -> f32 {
            p.iter().zip(query).map(|(a, b)| (as_lane(*a) - as_lane(*b)).powi(2)).sum()
        };
        (0..points.len()).min_by(|a, b| distance(&points[*a]).total_cmp(&distance(&points[*b]))).unwrap()
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(40))]
        #[test]
        fn the_tree_answers_as_a_scan_does(seed in 0u64..1000, count in 1usize..700, grid in 0u32..3) {
            let mut random = Stream::new(seed, 0);
            // A coarse grid makes equal coordinates and equal points.
            let mut draw = || {
                let x = random.uniform_between(-2.0, 2.0);
                if grid == 0 { x } else { (x * f64::from(grid)).round() }
            };
            let mut point = || (0..9).map(|_| draw()).collect::<Vec<f64>>();
            let mut tree = NearestNeighbours::new(9);
            let mut points = Vec::new();
            for _ in 0..count {
                points.push(point());
                tree.add(points.last().unwrap());
                let query = point();
                prop_assert_eq!(tree.nearest(&query), Some(scan(&points, &query)));
            }
        }
    }

    #[test]
    fn many_equal_points_are_no_trouble() {
        let mut tree = NearestNeighbours::new(2);
        for _ in 0..1000 {
            tree.add(&[0.5, 0.5]);
        }
        assert_eq!(tree.nearest(&[0.0, 0.0]), Some(0));
    }
}
