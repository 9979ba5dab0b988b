use cranny_shape::{Outline, Solid};
use cranny_spatial::nalgebra::Matrix3;
use cranny_spatial::{LaneVector, Pose, Vector};
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, mask32x16};

use crate::world::Part;

/// A solid of the world as the lanes see it.
#[derive(Clone, Debug)]
pub(crate) struct LanePart {
    /// Rows of the rotation from the planning frame to the part's.
    rows: [[f32; 3]; 3],
    /// Its origin in the planning frame, in metres.
    origin: [f32; 3],
    kind: LaneKind,
    /// A box around it; of a half-space, its origin alone.
    around: LaneAabb,
    /// Whether the distance is that to the solid; else it is that to a box around it.
    pub is_exact: bool,
    /// A bound on the rounding of distances to it, in metres.
    pub slack_m: f64,
}

/// A box along the axes of the planning frame, in metres.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LaneAabb {
    center: [f32; 3],
    half_extents: [f32; 3],
}

impl LaneAabb {
    pub fn new(center: &Vector, half_extents: &Vector) -> Self {
        Self { center: lanes(center), half_extents: lanes(half_extents) }
    }

    /// Bits of the lanes in which another such box is not certainly `reach` (m) or farther away along an axis.
    #[inline(always)]
    pub fn within_reach<S: Simd>(
        &self,
        simd: S,
        center: LaneVector<S>,
        half_extents: LaneVector<S>,
        reach: f32x16<S>,
    ) -> u32 {
        let offset = center.minus(LaneVector::splat(simd, self.center)).abs();
        let gap = offset.minus(half_extents).minus(LaneVector::splat(simd, self.half_extents));
        bits(!gap.x.max(gap.y).max(gap.z).simd_ge(reach))
    }
}

#[derive(Clone, Copy, Debug)]
enum LaneKind {
    /// Along the axes of the planning frame.
    AlignedCuboid {
        half_extents: [f32; 3],
    },
    Cuboid {
        half_extents: [f32; 3],
    },
    /// A ball, or a capsule along z; the radius comes off the distance.
    Segment {
        half_length: f32,
        radius: f32,
    },
    Cylinder {
        half_length: f32,
        radius: f32,
    },
    HalfSpace,
}

impl LanePart {
    // Lanes are `f32` by design; the slack of every comparison covers it.
    #[allow(clippy::cast_possible_truncation)]
    pub fn of(Part { world_from_solid, solid }: &Part) -> Self {
        let rotation = world_from_solid.rotation.to_rotation_matrix().into_inner();
        let cuboid = |half_extents: &Vector| match aligned(&rotation, half_extents) {
            Some(half_extents) => LaneKind::AlignedCuboid { half_extents: lanes(&half_extents) },
            None => LaneKind::Cuboid { half_extents: lanes(half_extents) },
        };
        let (kind, is_exact) = match solid.outline() {
            Outline::Cuboid { half_extents } => (cuboid(&half_extents), true),
            Outline::Segment { half_length_m, radius_m } => {
                (LaneKind::Segment { half_length: half_length_m as f32, radius: radius_m as f32 }, true)
            }
            Outline::Cylinder { half_length_m, radius_m } => {
                (LaneKind::Cylinder { half_length: half_length_m as f32, radius: radius_m as f32 }, true)
            }
            Outline::HalfSpace => (LaneKind::HalfSpace, true),
            Outline::Other => (cuboid(&solid.aabb().half_extents), false),
        };
        // What the planning frame sees of a half-space has no box.
        let (origin, around) = if solid.is_half_space() {
            (world_from_solid.translation.vector, Vector::zeros())
        } else {
            ((world_from_solid * solid.aabb().center).coords, rotation.abs() * solid.aabb().half_extents)
        };
        let rows = std::array::from_fn(|row| lanes(&rotation.column(row).into_owned()));
        let slack_m = rounding_m(world_from_solid, solid);
        let around = LaneAabb::new(&origin, &around);
        Self { rows, origin: lanes(&origin), kind, around, is_exact, slack_m }
    }

    /// Bits of the lanes in which a point of the planning frame is not certainly `reach` (m) or farther from
    /// the part. Below the plane of a half-space the distance counts as negative, elsewhere as 0 within.
    #[inline(always)]
    pub fn within_reach<S: Simd>(&self, simd: S, point: LaneVector<S>, reach: f32x16<S>) -> u32 {
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
        }
    }

    /// Bits of the lanes in which a box along the axes of the planning frame is not certainly `reach` (m) or
    /// farther from the box around the part along one of these axes.
    #[inline(always)]
    pub fn box_within_reach<S: Simd>(
        &self,
        simd: S,
        center: LaneVector<S>,
        half_extents: LaneVector<S>,
        reach: f32x16<S>,
    ) -> u32 {
        if let LaneKind::HalfSpace = self.kind {
            let offset = center.minus(LaneVector::splat(simd, self.origin));
            let [x, y, z] = self.rows[2].map(f32::abs);
            return bits(!(offset.dot(self.rows[2]) - half_extents.dot([x, y, z])).simd_ge(reach));
        }
        self.around.within_reach(simd, center, half_extents, reach)
    }
}

/// Bits of the lanes in which a length, given by its square, is less than a bound, or not a number.
#[inline(always)]
pub(crate) fn shorter<S: Simd>(squared: f32x16<S>, bound: f32x16<S>) -> u32 {
    let bound = bound.max(f32x16::splat(bound.token(), 0.0));
    bits(!squared.simd_ge(bound * bound))
}

/// The lanes of a mask, lane 0 in the lowest bit.
#[inline(always)]
#[allow(clippy::cast_possible_truncation)]
pub(crate) fn bits<S: Simd>(mask: mask32x16<S>) -> u32 {
    mask.to_bitmask() as u32
}

/// The rotation's columns as half extents along the planning frame's axes, if its axes are these.
fn aligned(rotation: &Matrix3<f64>, half_extents: &Vector) -> Option<Vector> {
    /// Turned by less than this the box moves by less than the slack of any comparison.
    const STRAIGHT: f64 = 1e-9;
    let turned = rotation.abs();
    let is_straight = turned.iter().all(|entry| *entry < STRAIGHT || *entry > 1.0 - STRAIGHT);
    is_straight.then(|| turned.map(f64::round) * half_extents)
}

/// A bound on the rounding of distances to a part, in metres: of its own place and size, and of the sums of
/// the kernels, relative to how far away it is.
fn rounding_m(world_from_solid: &Pose, solid: &Solid) -> f64 {
    /// Some twenty roundings of 6·10⁻⁸.
    const RELATIVE: f64 = 2e-6;
    let size = if solid.is_half_space() { 0.0 } else { solid.ball().radius_m };
    RELATIVE * (world_from_solid.translation.vector.norm() + size + 1.0)
}

/// A vector as the lanes hold it.
#[allow(clippy::cast_possible_truncation)]
pub(crate) fn lanes(vector: &Vector) -> [f32; 3] {
    std::array::from_fn(|axis| vector[axis] as f32)
}
