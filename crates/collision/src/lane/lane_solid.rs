use std::cmp::Ordering;
use std::sync::Arc;

use cranny_shape::{BoxUnion, Outline, Solid};
use cranny_spatial::nalgebra::Matrix3;
use cranny_spatial::{LANES, LaneVector, Pose, Vector, simd_level};
use fearless_simd::prelude::*;
use fearless_simd::{Simd, dispatch, f32x16};

use crate::lane::lane_bits::bits;
use crate::lane::lane_vector::{RELATIVE_ROUNDING, dot, is_shorter, lanes, minus, shorter};

/// A solid with a short formula for its distance to a point, in the planning frame or a link's.
#[derive(Clone, Debug)]
pub(crate) struct LaneSolid {
    /// Rows of the rotation from that frame to the frame of the solid.
    pub rows: [[f32; 3]; 3],
    /// Origin of the solid in that frame, in metres.
    pub origin: [f32; 3],
    kind: LaneKind,
    /// Boxes of a union.
    union: Option<Arc<BoxUnion>>,
}

impl LaneSolid {
    /// Creates a solid at this pose, or the box around it if its distance has no short formula.
    #[allow(
        clippy::cast_possible_truncation,
        reason = "lanes are `f32` by design; the slack of every comparison covers it"
    )]
    pub fn of(frame_from_solid: &Pose, solid: &Solid) -> Self {
        let rotation = frame_from_solid.rotation.to_rotation_matrix().into_inner();
        let cuboid = |half_extents: &Vector| match aligned(&rotation, half_extents) {
            Some(half_extents) => LaneKind::AlignedCuboid { half_extents: lanes(&half_extents) },
            None => LaneKind::Cuboid { half_extents: lanes(half_extents) },
        };
        let kind = match solid.outline() {
            Outline::Cuboid { half_extents } => cuboid(&half_extents),
            Outline::Segment { half_length_m, radius_m } => {
                LaneKind::Segment { half_length: half_length_m as f32, radius: radius_m as f32 }
            }
            Outline::Cylinder { half_length_m, radius_m } => {
                LaneKind::Cylinder { half_length: half_length_m as f32, radius: radius_m as f32 }
            }
            Outline::HalfSpace => LaneKind::HalfSpace,
            Outline::Union => LaneKind::Union,
            Outline::Other => cuboid(&solid.aabb().half_extents),
        };
        let origin = if solid.is_half_space() || solid.as_union().is_some() {
            frame_from_solid.translation.vector
        } else {
            (frame_from_solid * solid.aabb().center).coords
        };
        let turned = std::array::from_fn(|row| lanes(&rotation.column(row).into_owned()));
        let is_aligned = matches!(kind, LaneKind::AlignedCuboid { .. });
        let rows = if is_aligned { STRAIGHT_ROWS } else { turned };
        Self { rows, origin: lanes(&origin), kind, union: solid.as_union().cloned() }
    }

    /// Transforms a solid of a link to the planning frame.
    pub fn placed(
        &self,
        direction: impl Fn([f32; 3]) -> [f32; 3],
        point: impl Fn([f32; 3]) -> [f32; 3],
    ) -> Self {
        let kind = match self.kind {
            LaneKind::AlignedCuboid { half_extents } => LaneKind::Cuboid { half_extents },
            kind => kind,
        };
        let union = self.union.clone();
        Self { rows: self.rows.map(direction), origin: point(self.origin), kind, union }
    }

    /// Returns the distance of two boxes that are both along the axes of the frame, in metres, negative for the penetration
    /// depth; `None` for any other solids.
    pub fn aligned_gap_m(&self, other: &Self) -> Option<f32> {
        /// Tolerance below one rounding of a rotation entry.
        const STRAIGHT: f32 = 1e-7;
        let (LaneKind::Cuboid { half_extents }, LaneKind::AlignedCuboid { half_extents: others }) =
            (self.kind, other.kind)
        else {
            return None;
        };
        let is_straight = |entry: &f32| entry.abs() < STRAIGHT || entry.abs() > 1.0 - STRAIGHT;
        if !self.rows.iter().flatten().all(is_straight) {
            return None;
        }
        let gap = |axis: usize| {
            let [x, y, z] = self.rows.map(|row| row[axis].abs());
            let own = x * half_extents[0] + y * half_extents[1] + z * half_extents[2];
            (self.origin[axis] - other.origin[axis]).abs() - own - others[axis]
        };
        let gaps = [gap(0), gap(1), gap(2)];
        let deepest = gaps[0].max(gaps[1]).max(gaps[2]);
        let [x, y, z] = gaps.map(|gap| gap.max(0.0));
        Some(if deepest > 0.0 { (x * x + y * y + z * z).sqrt() } else { deepest })
    }

    /// Returns the boxes of a union, in its own frame; `None` for other solids.
    pub fn as_union(&self) -> Option<&BoxUnion> {
        self.union.as_deref()
    }

    /// Creates a box along the axes of its frame by its centre and half extents (m).
    pub fn straight_box([center, half_extents]: [[f32; 3]; 2]) -> Self {
        let kind = LaneKind::AlignedCuboid { half_extents };
        Self { rows: STRAIGHT_ROWS, origin: center, kind, union: None }
    }

    /// Returns the corner of a box farthest along a direction; `None` for other solids.
    pub fn farthest_corner(&self, direction: [f32; 3]) -> Option<[f32; 3]> {
        let (LaneKind::Cuboid { half_extents } | LaneKind::AlignedCuboid { half_extents }) = self.kind else {
            return None;
        };
        let [x, y, z]: [f32; 3] =
            std::array::from_fn(|side| half_extents[side].copysign(dot(self.rows[side], direction)));
        let [row_x, row_y, row_z] = &self.rows;
        Some(std::array::from_fn(|axis| {
            self.origin[axis] + row_x[axis] * x + row_y[axis] * y + row_z[axis] * z
        }))
    }

    /// Returns those of `lanes`, as bits, in which a point is not certainly `reach` (m) or farther from the solid. Below the
    /// plane of a half-space the distance is negative; inside other solids it is 0.
    #[inline(always)]
    pub fn within_reach<S: Simd>(&self, simd: S, point: LaneVector<S>, reach: f32x16<S>, lanes: u32) -> u32 {
        self.within_reach_by(
            simd,
            point,
            reach,
            lanes,
            #[inline(always)]
            |union, point, reach_m| union.is_closer(simd, point, reach_m),
        )
    }

    /// Returns [`Self::within_reach`], or more lanes where the solid is a union.
    #[inline(always)]
    pub fn maybe_within_reach<S: Simd>(
        &self,
        simd: S,
        point: LaneVector<S>,
        reach: f32x16<S>,
        lanes: u32,
    ) -> u32 {
        self.within_reach_by(simd, point, reach, lanes, BoxUnion::may_be_closer)
    }

    /// Returns [`Self::within_reach`], or fewer lanes where the solid is a union.
    #[inline(always)]
    pub fn surely_within_reach<S: Simd>(
        &self,
        simd: S,
        point: LaneVector<S>,
        reach: f32x16<S>,
        lanes: u32,
    ) -> u32 {
        self.within_reach_by(simd, point, reach, lanes, BoxUnion::is_surely_closer)
    }

    #[inline(always)]
    fn within_reach_by<S: Simd>(
        &self,
        simd: S,
        point: LaneVector<S>,
        reach: f32x16<S>,
        lanes: u32,
        is_closer: impl Fn(&BoxUnion, [f32; 3], f32) -> bool,
    ) -> u32 {
        if let Some(union) = &self.union {
            return self.union_within_reach(simd, union, point, reach, lanes, is_closer);
        }
        self.simple_within_reach(simd, point, reach) & lanes
    }

    /// Checks the boxes of a union lane by lane.
    #[inline(always)]
    fn union_within_reach<S: Simd>(
        &self,
        simd: S,
        union: &BoxUnion,
        point: LaneVector<S>,
        reach: f32x16<S>,
        lanes: u32,
        is_closer: impl Fn(&BoxUnion, [f32; 3], f32) -> bool,
    ) -> u32 {
        let offset = point.minus(LaneVector::splat(simd, self.origin));
        let own = LaneVector {
            x: offset.dot(self.rows[0]),
            y: offset.dot(self.rows[1]),
            z: offset.dot(self.rows[2]),
        };
        let (mut points, mut reaches) = ([[0.0; LANES]; 3], [0.0; LANES]);
        own.store(&mut points);
        reach.store_slice(&mut reaches);
        let mut near = 0;
        let mut rest = lanes;
        while rest != 0 {
            let lane = rest.trailing_zeros() as usize;
            rest &= rest - 1;
            let point = [points[0][lane], points[1][lane], points[2][lane]];
            near |= u32::from(is_closer(union, point, reaches[lane])) << lane;
        }
        near
    }

    #[inline(always)]
    fn simple_within_reach<S: Simd>(&self, simd: S, point: LaneVector<S>, reach: f32x16<S>) -> u32 {
        let zero = f32x16::splat(simd, 0.0);
        let offset = point.minus(LaneVector::splat(simd, self.origin));
        match self.kind {
            LaneKind::AlignedCuboid { half_extents: [half_x, half_y, half_z] } => {
                let x = (offset.x.abs() - half_x).max(zero);
                let y = (offset.y.abs() - half_y).max(zero);
                let z = (offset.z.abs() - half_z).max(zero);
                shorter(x * x + y * y + z * z, reach)
            }
            LaneKind::Cuboid { half_extents: [half_x, half_y, half_z] } => {
                let x = (offset.dot(self.rows[0]).abs() - half_x).max(zero);
                let y = (offset.dot(self.rows[1]).abs() - half_y).max(zero);
                let z = (offset.dot(self.rows[2]).abs() - half_z).max(zero);
                shorter(x * x + y * y + z * z, reach)
            }
            LaneKind::Segment { half_length, radius } => {
                let (x, y) = (offset.dot(self.rows[0]), offset.dot(self.rows[1]));
                let z = (offset.dot(self.rows[2]).abs() - half_length).max(zero);
                shorter(x * x + y * y + z * z, reach + radius)
            }
            LaneKind::Cylinder { half_length, radius } => {
                let (x, y) = (offset.dot(self.rows[0]), offset.dot(self.rows[1]));
                let across = ((x * x + y * y).sqrt() - radius).max(zero);
                let along = (offset.dot(self.rows[2]).abs() - half_length).max(zero);
                shorter(across * across + along * along, reach)
            }
            LaneKind::HalfSpace => bits(!offset.dot(self.rows[2]).simd_ge(reach)),
            LaneKind::Union => u32::MAX,
        }
    }

    /// Returns the vector from the solid to a point, or from its centre if the point lies inside; exact for boxes.
    pub fn apart(&self, point: [f32; 3]) -> [f32; 3] {
        let offset = minus(point, self.origin);
        let (LaneKind::Cuboid { half_extents } | LaneKind::AlignedCuboid { half_extents }) = self.kind else {
            return offset;
        };
        let own = self.rows.map(|row| dot(offset, row));
        let beyond: [f32; 3] =
            std::array::from_fn(|axis| own[axis] - own[axis].clamp(-half_extents[axis], half_extents[axis]));
        if beyond.iter().all(|part| part.abs() <= 0.0) {
            return offset;
        }
        std::array::from_fn(|axis| (0..3).map(|row| self.rows[row][axis] * beyond[row]).sum())
    }

    /// Returns the verdict of [`Self::within_reach`] for a single point.
    pub fn is_closer(&self, point: [f32; 3], reach_m: f32) -> bool {
        let offset = minus(point, self.origin);
        let [x, y, z] = self.rows.map(|row| dot(offset, row));
        match self.kind {
            LaneKind::AlignedCuboid { half_extents } | LaneKind::Cuboid { half_extents } => {
                let beyond = |value: f32, axis: usize| (value.abs() - half_extents[axis]).max(0.0);
                let [x, y, z] = [beyond(x, 0), beyond(y, 1), beyond(z, 2)];
                is_shorter(x * x + y * y + z * z, reach_m)
            }
            LaneKind::Segment { half_length, radius } => {
                let z = (z.abs() - half_length).max(0.0);
                is_shorter(x * x + y * y + z * z, reach_m + radius)
            }
            LaneKind::Cylinder { half_length, radius } => {
                let across = ((x * x + y * y).sqrt() - radius).max(0.0);
                let along = (z.abs() - half_length).max(0.0);
                is_shorter(across * across + along * along, reach_m)
            }
            LaneKind::Union => self.union.as_ref().is_none_or(
                |union| dispatch!(simd_level(), simd => union.is_closer(simd, [x, y, z], reach_m)),
            ),
            // NaN does not count as farther.
            LaneKind::HalfSpace => {
                !matches!(z.partial_cmp(&reach_m), Some(Ordering::Greater | Ordering::Equal))
            }
        }
    }
}

/// Rotation of a box along the axes of its frame.
const STRAIGHT_ROWS: [[f32; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// Returns the half extents of a box along the axes of the planning frame, if its own axes are parallel to these.
fn aligned(rotation: &Matrix3<f64>, half_extents: &Vector) -> Option<Vector> {
    /// Tolerance of a rotation entry: it moves the box by less than the slack of any comparison.
    const STRAIGHT: f64 = 1e-9;
    let turned = rotation.abs();
    let is_straight = turned.iter().all(|entry| *entry < STRAIGHT || *entry > 1.0 - STRAIGHT);
    is_straight.then(|| turned.map(f64::round) * half_extents)
}

/// Returns the contribution of the position and size of a part to the rounding of distances to it, in metres.
pub(crate) fn rounding_m(world_from_solid: &Pose, solid: &Solid) -> f64 {
    let size = match solid.as_union() {
        _ if solid.is_half_space() => 0.0,
        // Its boxes keep their coordinates, whatever the distance of its frame.
        Some(_) => solid.ball().center.coords.norm() + solid.ball().radius_m,
        None => solid.ball().radius_m,
    };
    RELATIVE_ROUNDING * (world_from_solid.translation.vector.norm() + size)
}

#[derive(Clone, Copy, Debug)]
enum LaneKind {
    /// A box along the axes of the planning frame.
    AlignedCuboid {
        half_extents: [f32; 3],
    },
    Cuboid {
        half_extents: [f32; 3],
    },
    /// A ball, or a capsule along z; its radius is subtracted from the distance.
    Segment {
        half_length: f32,
        radius: f32,
    },
    Cylinder {
        half_length: f32,
        radius: f32,
    },
    HalfSpace,
    Union,
}
