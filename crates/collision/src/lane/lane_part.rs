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

/// A solid of the world in lane form.
#[derive(Clone, Debug)]
pub(crate) struct LanePart {
    /// The solid, or a box around it.
    pub solid: LaneSolid,
    /// Its hull; `None` if it is not convex or is unbounded.
    pub hull: Option<LaneHull>,
    /// Coarse hull in the frame of the solid, shared by all its placements.
    coarse: Option<Arc<CoarseHull>>,
    /// Bounding volume for the broad phase.
    pub around: LaneAround,
    /// True if distances are measured to the solid; otherwise they are measured to a box around it.
    pub is_exact: bool,
    /// Bound on the rounding of distances to it, in metres.
    pub slack_m: f64,
}

/// Bounding box of a part of the world, or a half-space.
#[derive(Clone, Copy, Debug)]
pub(crate) enum LaneAround {
    Box(LaneAabb),
    HalfSpace {
        /// A point of its plane, in metres.
        origin: [f32; 3],
        /// Its outward normal, of length 1.
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

    /// Returns the bits of the lanes in which a box along the axes of the planning frame is not certainly `reach` (m) or
    /// farther from this bounding volume along one of these axes.
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

/// Typical distance between a hull or mesh of the world and its box, in metres.
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

    /// Returns this box repeated in every lane.
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

    /// Returns this part with its solid at another pose.
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

    /// Returns the centre and half extents of the part's box along the axes of the planning frame, in metres; `None` for a
    /// half-space.
    pub fn box_around(&self) -> Option<[[f32; 3]; 2]> {
        match self.around {
            LaneAround::Box(LaneAabb { center, half_extents }) => Some([center, half_extents]),
            LaneAround::HalfSpace { .. } => None,
        }
    }

    /// Returns the outward normal of the plane and its height along it (m), if the part is a half-space.
    pub fn plane(&self) -> Option<([f32; 3], f32)> {
        match self.around {
            LaneAround::Box(_) => None,
            LaneAround::HalfSpace { origin, normal } => Some((normal, dot(origin, normal))),
        }
    }

    /// Returns true if any point of a ball may come closer than `free_m` (m).
    pub fn is_near(&self, ball: &Ball, free_m: f32) -> bool {
        /// Upper bound, with ample reserve, on the rounding of any distance, in metres.
        const ROUNDING_M: f32 = 1e-3;
        self.solid.is_closer(lanes(&ball.center.coords), free_m + narrow(ball.radius_m) + ROUNDING_M)
    }

    /// Returns the maximum underestimate of a link's distance, in metres, for a link with or without hulls.
    pub fn blur_m(&self, link_has_hulls: bool) -> f64 {
        match &self.hull {
            Some(hull) if link_has_hulls => hull.bulge_m(),
            _ if self.is_exact => 0.0,
            _ => BOX_BLUR_M,
        }
    }
}
