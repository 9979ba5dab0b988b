use std::sync::Arc;

use cranny_shape::{Ball, CoarseHull, Outline, Solid};
use cranny_spatial::{LaneVector, Pose, Vector};
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};

use crate::body::world::Part;
use crate::lane::lane_bits::bits;
use crate::lane::lane_hull::LaneHull;
use crate::lane::lane_solid::{LaneSolid, rounding_m};
use crate::lane::lane_vector::{BoxLanes, dot, lanes, narrow};

/// A solid of the world as the lanes see it.
#[derive(Clone, Debug)]
pub(crate) struct LanePart {
    /// The solid, or a box around it.
    pub solid: LaneSolid,
    /// Its hull; none for what is not convex or has no end.
    pub hull: Option<LaneHull>,
    /// What that is made of, wherever the solid is.
    coarse: Option<Arc<CoarseHull>>,
    /// What is known of it at first glance.
    pub around: LaneAround,
    /// Whether the distance is that to the solid; else it is that to a box around it.
    pub is_exact: bool,
    /// A bound on the rounding of distances to it, in metres.
    pub slack_m: f64,
}

/// A box around a part of the world; around a half-space there is none.
#[derive(Clone, Copy, Debug)]
pub(crate) enum LaneAround {
    Box(LaneAabb),
    HalfSpace {
        /// A point of the plane.
        origin: [f32; 3],
        /// Away from the half-space, of length 1.
        normal: [f32; 3],
    },
}

impl LaneAround {
    fn of(world_from_solid: &Pose, solid: &Solid) -> Self {
        let rotation = world_from_solid.rotation.to_rotation_matrix().into_inner();
        if solid.is_half_space() {
            let origin = lanes(&world_from_solid.translation.vector);
            return Self::HalfSpace { origin, normal: lanes(&rotation.column(2).into_owned()) };
        }
        let center = (world_from_solid * solid.aabb().center).coords;
        Self::Box(LaneAabb::new(&center, &(rotation.abs() * solid.aabb().half_extents)))
    }

    /// Bits of the lanes in which a box along the axes of the planning frame is not certainly `reach` (m) or
    /// farther from the box around the part along one of these axes.
    #[inline(always)]
    pub fn within_reach<S: Simd>(&self, simd: S, link: BoxLanes<S>, reach: f32x16<S>) -> u32 {
        match self {
            Self::Box(around) => link.within_reach(around.splat(simd), reach),
            Self::HalfSpace { origin, normal } => {
                let offset = link.middle.minus(LaneVector::splat(simd, *origin));
                bits(!(offset.dot(*normal) - link.half_extents.dot(normal.map(f32::abs))).simd_ge(reach))
            }
        }
    }
}

/// A hull or mesh of the world fills its box to about this, in metres.
const BOX_BLUR_M: f64 = 0.02;

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

    /// The same in every lane.
    #[inline(always)]
    pub fn splat<S: Simd>(&self, simd: S) -> BoxLanes<S> {
        let half_extents = LaneVector::splat(simd, self.half_extents);
        BoxLanes { middle: LaneVector::splat(simd, self.center), half_extents }
    }
}

impl LanePart {
    pub fn of(part: &Part) -> Self {
        Self::with_coarse_hull(part, LaneHull::coarse(&part.solid).map(Arc::new))
    }

    /// The same solid elsewhere.
    pub fn moved(&self, part: &Part) -> Self {
        Self::with_coarse_hull(part, self.coarse.clone())
    }

    fn with_coarse_hull(Part { world_from_solid, solid }: &Part, coarse: Option<Arc<CoarseHull>>) -> Self {
        Self {
            solid: LaneSolid::of(world_from_solid, solid),
            hull: coarse.as_deref().map(|coarse| LaneHull::of(world_from_solid, solid, coarse)),
            coarse,
            around: LaneAround::of(world_from_solid, solid),
            is_exact: solid.outline() != Outline::Other,
            slack_m: rounding_m(world_from_solid, solid),
        }
    }

    /// Centre and half extents of the box around the part along the axes of the planning frame; none around a
    /// half-space.
    pub fn box_around(&self) -> Option<[[f32; 3]; 2]> {
        match self.around {
            LaneAround::Box(LaneAabb { center, half_extents }) => Some([center, half_extents]),
            LaneAround::HalfSpace { .. } => None,
        }
    }

    /// The upward normal of the plane and its height along it, if the part is a half-space.
    pub fn plane(&self) -> Option<([f32; 3], f32)> {
        match self.around {
            LaneAround::Box(_) => None,
            LaneAround::HalfSpace { origin, normal } => Some((normal, dot(origin, normal))),
        }
    }

    /// Whether anything in a ball can come closer than `free_m` (m).
    pub fn is_near(&self, ball: &Ball, free_m: f32) -> bool {
        /// Far more than the rounding of any distance, in metres.
        const ROUNDING_M: f32 = 1e-3;
        self.solid.is_closer(lanes(&ball.center.coords), free_m + narrow(ball.radius_m) + ROUNDING_M)
    }

    /// How much closer it can seem than it is, in metres, to a link with or without hulls.
    pub fn blur_m(&self, link_has_hulls: bool) -> f64 {
        match &self.hull {
            Some(hull) if link_has_hulls => hull.bulge_m(),
            _ if self.is_exact => 0.0,
            _ => BOX_BLUR_M,
        }
    }
}
