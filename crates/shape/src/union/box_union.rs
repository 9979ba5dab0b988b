use std::sync::Arc;

use cranny_spatial::{FARTHEST_M, LANES, LaneVector, Point, Vector, simd_level};
use fearless_simd::prelude::*;
use fearless_simd::{Simd, dispatch, f32x16};
use parry3d_f64::math::Vector as ParryVector;

use crate::distance::convex::{Convex, Core, HullPoints};
use crate::error::positive;
use crate::union::box_chunk::{BoxChunk, NarrowBox, enclosing};
use crate::union::box_order::compact_order;
use crate::union::free_grid::{Closeness, FreeGrid};
use crate::{Aabb, Ball, ShapeError};

/// Union of boxes along the axes of its frame, all rounded by the same radius: the cells of a map of space or, without extent, the
/// points of a cloud.
///
/// The boxes are the leaves of a tree of sixteen children per node, whose boxes are compared by one vector instruction. Unlike
/// the tree of Ramsey et al. (2024, "Collision-Affording Point Trees", §IV) it has no greatest radius of a query.
#[derive(Debug)]
pub struct BoxUnion {
    /// Chunks of boxes, level by level: those of the union, then the boxes around the chunks of the level before, until a single
    /// chunk remains.
    levels: Vec<Vec<BoxChunk>>,
    free: FreeGrid,
    count: usize,
    radius_m: f64,
    around: Aabb,
}

/// Maximum number of levels: enough for 16⁸ boxes.
const MOST_LEVELS: usize = 8;

impl BoxUnion {
    /// Creates the union of balls of this radius (m) around points (m).
    ///
    /// # Errors
    /// [`ShapeError::NoPoints`] without points, [`ShapeError::NotFinite`] for a coordinate that is not within range, and
    /// [`ShapeError::Size`] unless the radius is positive and finite.
    pub fn of_points(points: &[[f32; 3]], radius_m: f64) -> Result<Self, ShapeError> {
        let radius_m = positive("the radius of the points of a cloud", radius_m)?;
        Self::new(&points.iter().map(|point| [*point, [0.0; 3]]).collect::<Vec<_>>(), radius_m)
    }

    /// Creates the union of boxes; each is rounded outwards to single precision.
    ///
    /// # Errors
    /// [`ShapeError::NoPoints`] without boxes, and [`ShapeError::NotFinite`] for a box that is not within range.
    pub fn of_boxes(boxes: impl Iterator<Item = Aabb>) -> Result<Self, ShapeError> {
        let narrow = |aabb: Aabb| {
            let (low, high) = (aabb.low(), aabb.high());
            let axes = [0, 1, 2].map(|axis| enclosing(low[axis], high[axis]));
            [axes.map(|[center, _]| center), axes.map(|[_, half]| half)]
        };
        Self::new(&boxes.map(narrow).collect::<Vec<_>>(), 0.0)
    }

    fn new(boxes: &[NarrowBox], radius_m: f64) -> Result<Self, ShapeError> {
        for (vertex, [center, half_extents]) in boxes.iter().enumerate() {
            let is_usable = |axis: usize| f64::from(center[axis].abs() + half_extents[axis]) <= FARTHEST_M;
            if !(0..3).all(is_usable) {
                let [x, y, z] = center.map(f64::from);
                return Err(ShapeError::NotFinite { vertex, x, y, z });
            }
        }
        let order = compact_order(boxes);
        let ordered = |places: &[u32]| BoxChunk::of(places.iter().map(|place| boxes[*place as usize]));
        let mut levels: Vec<Vec<BoxChunk>> = vec![order.chunks(LANES).map(ordered).collect()];
        let mut count = boxes.len();
        let around = loop {
            let Some(level) = levels.last() else { return Err(ShapeError::NoPoints) };
            let full = count.div_ceil(LANES);
            let parents: Vec<NarrowBox> =
                (0..full).map(|chunk| level[chunk].around((count - chunk * LANES).min(LANES))).collect();
            match &parents[..] {
                [] => return Err(ShapeError::NoPoints),
                [around] => break *around,
                _ => levels
                    .push(parents.chunks(LANES).map(|chunk| BoxChunk::of(chunk.iter().copied())).collect()),
            }
            count = full;
        };
        let around = BoxChunk::of(std::iter::once(around)).get(0);
        let ordered =
            levels[0].iter().flat_map(|chunk| (0..LANES).map(|lane| chunk.get(lane))).take(boxes.len());
        let are_points = boxes.iter().all(|[_, half_extents]| half_extents.iter().all(|half| *half <= 0.0));
        let free = FreeGrid::new(&around, (boxes.len(), are_points), ordered);
        Ok(Self { levels, free, count: boxes.len(), radius_m, around })
    }

    /// Returns the number of boxes.
    #[allow(clippy::len_without_is_empty, reason = "it is never empty")]
    pub fn len(&self) -> usize {
        self.count
    }

    /// Returns the radius by which the boxes are rounded, in metres.
    pub fn radius_m(&self) -> f64 {
        self.radius_m
    }

    /// Returns the boxes without their rounding, near ones next to each other.
    pub fn boxes(&self) -> impl Iterator<Item = Aabb> {
        (0..self.count).map(|index| self.get(0, index))
    }

    /// Returns the box around the whole, with its rounding.
    pub(crate) fn around(&self) -> Aabb {
        self.around.grown(self.radius_m)
    }

    fn get(&self, level: usize, index: usize) -> Aabb {
        self.levels[level][index / LANES].get(index % LANES)
    }

    /// Returns true unless a point of its frame (m) is `reach_m` (m) or farther from all boxes, in single precision: a distance is
    /// off by no more than the comparison of a single box would be.
    #[inline(always)]
    pub fn is_closer<S: Simd>(&self, simd: S, point: [f32; 3], reach_m: f32) -> bool {
        match self.free.closeness(point, self.whole_reach(reach_m)) {
            Closeness::Closer => true,
            Closeness::Farther => false,
            Closeness::AtBox(index) if self.is_box_closer(index, point, reach_m) => true,
            Closeness::AtBox(_) | Closeness::Open => self.any_closer(simd, point, reach_m, |_, _| true),
        }
    }

    /// Returns false if a point is certainly not closer to a box, as [`Self::is_closer`], and mostly true only if it is.
    #[inline(always)]
    pub fn may_be_closer(&self, point: [f32; 3], reach_m: f32) -> bool {
        self.free.may_be_closer(point, self.whole_reach(reach_m))
    }

    /// Returns true if a point is certainly closer to a box, as [`Self::is_closer`], and mostly false only if it is not.
    #[inline(always)]
    pub fn is_surely_closer(&self, point: [f32; 3], reach_m: f32) -> bool {
        match self.free.closeness(point, self.whole_reach(reach_m)) {
            Closeness::Closer => true,
            Closeness::AtBox(index) => self.is_box_closer(index, point, reach_m),
            Closeness::Farther | Closeness::Open => false,
        }
    }

    /// Returns true if a point is closer to a box than `reach_m` (m), in single precision.
    #[inline(always)]
    fn is_box_closer(&self, index: u32, point: [f32; 3], reach_m: f32) -> bool {
        let [center, half_extents] = self.narrow_box(index);
        let reach_m = self.whole_reach(reach_m);
        let beyond = |axis: usize| ((point[axis] - center[axis]).abs() - half_extents[axis]).max(0.0);
        let [x, y, z] = [beyond(0), beyond(1), beyond(2)];
        x * x + y * y + z * z < reach_m * reach_m
    }

    /// Calls `visit` with the indices of boxes closer to a point, as [`Self::is_closer`], until it returns false. Returns false then.
    #[inline(always)]
    pub fn all_closer<S: Simd>(
        &self,
        simd: S,
        point: [f32; 3],
        reach_m: f32,
        mut visit: impl FnMut(u32) -> bool,
    ) -> bool {
        !self.may_be_closer(point, reach_m)
            || !self.any_closer(simd, point, reach_m, |chunk, mut near| {
                while near != 0 {
                    #[allow(clippy::cast_possible_truncation, reason = "a tree has at most 16⁸ boxes")]
                    let index = (chunk * LANES) as u32 + near.trailing_zeros();
                    near &= near - 1;
                    if !visit(index) {
                        return true;
                    }
                }
                false
            })
    }

    /// Returns a reach with the rounding of the boxes added, at least 0, in metres.
    #[inline(always)]
    #[allow(clippy::cast_possible_truncation, reason = "single precision is what is meant")]
    fn whole_reach(&self, reach_m: f32) -> f32 {
        (reach_m + self.radius_m as f32).max(0.0)
    }

    /// Returns centre and half extents of a box without its rounding, in single precision (m).
    pub fn narrow_box(&self, index: u32) -> [[f32; 3]; 2] {
        let index = index as usize;
        self.levels[0][index / LANES].narrow(index % LANES)
    }

    /// Calls `visit` with each chunk of boxes of which some are closer to a point, and their bits, until it returns true. Returns true
    /// then.
    #[inline(always)]
    fn any_closer<S: Simd>(
        &self,
        simd: S,
        point: [f32; 3],
        reach_m: f32,
        mut visit: impl FnMut(usize, u32) -> bool,
    ) -> bool {
        let reach = self.whole_reach(reach_m);
        let (point, bound) = (LaneVector::splat(simd, point), f32x16::splat(simd, reach * reach));
        let top = self.levels.len() - 1;
        let mut open = [0_u32; MOST_LEVELS];
        let mut chunks = [0_usize; MOST_LEVELS];
        let mut level = top;
        open[level] = self.levels[level][0].within(simd, point, bound);
        loop {
            if open[level] == 0 {
                if level == top {
                    return false;
                }
                level += 1;
            } else if level == 0 {
                if visit(chunks[0], open[0]) {
                    return true;
                }
                open[0] = 0;
            } else {
                let child = chunks[level] * LANES + open[level].trailing_zeros() as usize;
                open[level] &= open[level] - 1;
                level -= 1;
                chunks[level] = child;
                open[level] = self.levels[level][child].within(simd, point, bound);
            }
        }
    }

    /// Calls `visit` with boxes (without their rounding) that may be within the reach of a body: at first `reach_m` (m), then the
    /// value that the last call returned; mostly the nearest first. The body is given by a ball around it, and by a lower bound of
    /// its distance from a box, in metres.
    pub(crate) fn nearest(
        &self,
        ball: &Ball,
        gap_m: impl Fn(&Aabb) -> f64,
        reach_m: f64,
        mut visit: impl FnMut(&Aabb) -> f64,
    ) {
        let mut reach_m = reach_m;
        let mut open = vec![Node { gap_m: f64::NEG_INFINITY, level: self.levels.len(), index: 0 }];
        let mut children = Vec::with_capacity(LANES);
        while let Some(Node { gap_m: gap, level, index }) = open.pop() {
            if gap >= reach_m {
                continue;
            }
            if level == 0 {
                reach_m = visit(&self.get(0, index));
                continue;
            }
            let chunk = &self.levels[level - 1][index];
            let mut near = near_lanes(chunk, ball, reach_m + self.radius_m);
            while near != 0 {
                let lane = near.trailing_zeros() as usize;
                near &= near - 1;
                let gap_m = gap_m(&chunk.get(lane)) - self.radius_m;
                // NaN does not count as far.
                if gap_m < reach_m || gap_m.is_nan() {
                    children.push(Node { gap_m, level: level - 1, index: index * LANES + lane });
                }
            }
            children.sort_by(|a: &Node, b| b.gap_m.total_cmp(&a.gap_m).then(b.index.cmp(&a.index)));
            open.append(&mut children);
        }
    }

    /// Returns the boxes, rounded and as convex solids in the frame of the union, that meet a region of that frame.
    pub(crate) fn pieces_near(&self, region: &Aabb) -> Vec<Convex> {
        let mut pieces = Vec::new();
        let mut open = vec![(self.levels.len(), 0)];
        while let Some((level, index)) = open.pop() {
            if level == 0 {
                pieces.push(self.piece(&self.get(0, index)));
                continue;
            }
            // Empty places are beyond every region.
            let meets =
                |lane: &usize| self.levels[level - 1][index].get(*lane).grown(self.radius_m).overlaps(region);
            open.extend((0..LANES).filter(meets).map(|lane| (level - 1, index * LANES + lane)));
        }
        pieces
    }

    /// Returns one of its boxes, rounded, as a convex solid in the frame of the union.
    pub(crate) fn piece(&self, aabb: &Aabb) -> Convex {
        let corners = corners(aabb).map(|corner| ParryVector::new(corner.x, corner.y, corner.z));
        let is_point = aabb.half_extents.amax() <= 0.0;
        let corners = if is_point { &corners[..1] } else { &corners[..] };
        Convex { core: Core::Hull(Arc::new(HullPoints::new(corners))), radius_m: self.radius_m }
    }
}

/// A node of the tree of boxes, with the lower bound of its distance.
struct Node {
    gap_m: f64,
    level: usize,
    index: usize,
}

/// Returns the bits of the boxes of a chunk that may be closer than `reach_m` (m) to a ball.
fn near_lanes(chunk: &BoxChunk, ball: &Ball, reach_m: f64) -> u32 {
    /// Upper bound of the rounding of single precision, relative to the numbers compared.
    const ROUNDING: f64 = 1e-5;
    let size_m = ball.center.coords.amax() + ball.radius_m;
    let reach_m = (reach_m + ball.radius_m) * (1.0 + ROUNDING) + size_m * ROUNDING;
    #[allow(clippy::cast_possible_truncation, reason = "rounding is added above")]
    let (point, reach) = ([0, 1, 2].map(|axis| ball.center[axis] as f32), reach_m.max(0.0) as f32);
    dispatch!(simd_level(), simd => chunk.within(simd, LaneVector::splat(simd, point), f32x16::splat(simd, reach * reach)))
}

/// Corners of a box; the first is that of the least coordinates.
pub(crate) fn corners(aabb: &Aabb) -> [Point; 8] {
    let sign = |bit: usize| if bit == 0 { -1.0 } else { 1.0 };
    std::array::from_fn(|corner| {
        let signs = Vector::new(sign(corner & 1), sign(corner & 2), sign(corner & 4));
        aabb.center + aabb.half_extents.component_mul(&signs)
    })
}

#[cfg(test)]
mod tests {
    use cranny_spatial::{Pose, Stream};
    use proptest::prelude::*;

    use super::*;
    use crate::{Range, Separation, Solid, overlap, separation, separation_in};

    /// A cloud, or a union of boxes, with each of its pieces as a solid at its pose.
    fn union(random: &mut Stream, count: usize, is_cloud: bool) -> (Solid, Vec<(Solid, Pose)>) {
        let mut draw = |low: f64, high: f64| random.uniform_between(low, high);
        #[allow(clippy::cast_possible_truncation, reason = "the coordinates of a cloud")]
        let narrow = |x: f64| x as f32;
        let union = if is_cloud {
            let points: Vec<[f32; 3]> = (0..count).map(|_| [0; 3].map(|_| narrow(draw(-0.5, 0.5)))).collect();
            BoxUnion::of_points(&points, draw(0.001, 0.05))
        } else {
            let aabb = |_| Aabb {
                center: Point::new(draw(-0.5, 0.5), draw(-0.5, 0.5), draw(-0.5, 0.5)),
                half_extents: Vector::new(draw(0.001, 0.1), draw(0.001, 0.1), draw(0.001, 0.1)),
            };
            BoxUnion::of_boxes((0..count).map(aabb))
        }
        .expect("good boxes");
        let piece = |aabb: Aabb| {
            let solid =
                if is_cloud { Solid::sphere(union.radius_m()) } else { Solid::cuboid(aabb.half_extents) };
            (
                solid.expect("positive sizes"),
                Pose::from_parts(aabb.center.coords.into(), cranny_spatial::Rotation::identity()),
            )
        };
        let pieces = union.boxes().map(piece).collect();
        (Solid::union(union), pieces)
    }

    /// A solid of every kind that a link can have.
    fn others(random: &mut Stream) -> Vec<Solid> {
        let mut draw = || random.uniform_between(0.02, 0.3);
        let cuboid = Solid::cuboid(Vector::new(draw(), draw(), draw())).expect("positive sizes");
        let mesh = Solid::mesh(&cuboid.tessellation().expect("a bounded solid")).expect("a closed mesh");
        vec![
            cuboid,
            mesh,
            Solid::sphere(draw()).expect("a size"),
            Solid::capsule(draw(), draw()).expect("sizes"),
        ]
    }

    fn random_pose(random: &mut Stream) -> Pose {
        Pose::from_parts(
            Vector::zeros().map(|_: f64| random.uniform_between(-0.9, 0.9)).into(),
            random.rotation(),
        )
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(24))]

        /// A union is as far as the nearest of its pieces, and as deep as the deepest.
        #[test]
        fn a_union_is_all_its_pieces(seed in any::<u64>(), count in 1_usize..400, is_cloud in any::<bool>()) {
            let mut random = Stream::new(seed, 0);
            let (union, pieces) = union(&mut random, count, is_cloud);
            prop_assert_eq!(pieces.len(), count);
            let world_from_union = random_pose(&mut random);
            for other in others(&mut random) {
                for _ in 0..4 {
                    let pose = random_pose(&mut random);
                    let parts = || pieces.iter().map(|(solid, place)| (solid, world_from_union * place));
                    let least = parts()
                        .map(|(solid, place)| separation(solid, &place, &other, &pose, f64::MAX))
                        .fold(f64::INFINITY, |least, Separation { lower_m, .. }| least.min(lower_m));
                    let found = separation(&union, &world_from_union, &other, &pose, f64::MAX);
                    prop_assert!((found.lower_m - least).abs() < 1e-6, "{found:?} but {least}");
                    let turned = separation(&other, &pose, &union, &world_from_union, f64::MAX);
                    prop_assert!((turned.lower_m - least).abs() < 1e-6, "{turned:?} but {least}");
                    // A search that may stop early never reports more than is there.
                    for beyond_m in [0.01, 0.1] {
                        let range = Range { beyond_m, exact_below_m: 0.5 * beyond_m };
                        let found = separation_in(&union, &world_from_union, &other, &pose, range);
                        prop_assert!(found.lower_m <= least + 1e-6 && found.upper_m >= least - 1e-6);
                        prop_assert_eq!(found.lower_m >= 0.5 * beyond_m, least >= 0.5 * beyond_m);
                    }
                    let depth = |found: Option<crate::Overlap>| found.map_or(-1.0, |overlap| overlap.depth_m);
                    let deepest = parts()
                        .map(|(solid, place)| depth(overlap(solid, &place, &other, &pose)))
                        .fold(-1.0, f64::max);
                    let found = depth(overlap(&union, &world_from_union, &other, &pose));
                    // The depth of a solid wholly inside a mesh is that of any of its points.
                    let error_m = if other.outline() == crate::Outline::Other { 0.5 } else { 1e-6 };
                    prop_assert!((found - deepest).abs() < error_m, "{found} but {deepest}");
                }
            }
        }

        /// A query of the tree in single precision is one of all its boxes.
        #[test]
        fn no_near_box_is_passed_over(seed in any::<u64>(), count in 1_usize..6000, is_cloud in any::<bool>()) {
            let mut random = Stream::new(seed, 0);
            let (solid, _) = union(&mut random, count, is_cloud);
            let union = solid.as_union().expect("a union");
            for _ in 0..100 {
                let point = Vector::zeros().map(|_: f64| random.uniform_between(-0.8, 0.8));
                let gap_m = |aabb: Aabb| aabb.distance_to(&point.into()) - union.radius_m();
                let least = union.boxes().map(gap_m).fold(f64::INFINITY, f64::min);
                #[allow(clippy::cast_possible_truncation, reason = "single precision is tested")]
                let closer = |reach_m: f64| {
                    let point = [0, 1, 2].map(|axis| point[axis] as f32);
                    dispatch!(simd_level(), simd => union.is_closer(simd, point, reach_m as f32))
                };
                prop_assert!(closer(least + 1e-5));
                prop_assert!(least < 1e-3 || !closer(least - 1e-5), "{least}");
                let mut found = vec![];
                let (reach_m, narrow_reach_m) = (0.05, 0.05_f32);
                #[allow(clippy::cast_possible_truncation, reason = "single precision is tested")]
                let narrow = [0, 1, 2].map(|axis| point[axis] as f32);
                dispatch!(simd_level(), simd => union.all_closer(simd, narrow, narrow_reach_m, |index| {
                    found.push(index);
                    true
                }));
                for (index, aabb) in (0_u32..).zip(union.boxes()) {
                    let gap_m = gap_m(aabb);
                    if (gap_m - reach_m).abs() > 1e-5 {
                        prop_assert_eq!(found.contains(&index), gap_m < reach_m);
                    }
                }
            }
        }
    }

    #[test]
    fn boxes_are_rounded_outwards() {
        let third = Aabb { center: Point::new(1.0 / 3.0, 0.1, 700.1), half_extents: Vector::repeat(0.1) };
        let kept = BoxUnion::of_boxes(std::iter::once(third)).expect("a box").get(0, 0);
        for axis in 0..3 {
            assert!(kept.low()[axis] <= third.low()[axis] && kept.high()[axis] >= third.high()[axis]);
            assert!(kept.high()[axis] - third.high()[axis] < 1e-4);
        }
    }

    #[test]
    fn bad_clouds_are_refused() {
        assert!(matches!(BoxUnion::of_points(&[], 0.01), Err(ShapeError::NoPoints)));
        assert!(matches!(BoxUnion::of_points(&[[0.0; 3]], 0.0), Err(ShapeError::Size { .. })));
        assert!(matches!(BoxUnion::of_points(&[[0.0; 3]], f64::NAN), Err(ShapeError::Size { .. })));
        for odd in [f32::NAN, f32::INFINITY, 1e9] {
            let found = BoxUnion::of_points(&[[0.0; 3], [0.0, odd, 0.0]], 0.01);
            assert!(matches!(found, Err(ShapeError::NotFinite { vertex: 1, .. })));
        }
    }
}
