use std::sync::Arc;

use cranny_spatial::{Point, Vector, simd_level};
use fearless_simd::prelude::*;
use fearless_simd::{Simd, dispatch, f64x8};
use parry3d_f64::math::Vector as ParryVector;
use parry3d_f64::shape::SupportMap;

/// A convex solid: a core given by its support function, and a radius by which the core is rounded.
///
/// Spheres and capsules are a point and a segment with a radius, so their distances are exact.
#[derive(Clone, Debug)]
pub(crate) struct Convex {
    pub core: Core,
    pub radius_m: f64,
}

/// Core of a convex solid, before rounding. Segments and cylinders lie along z. All are centred at their origin.
#[derive(Clone, Debug)]
pub(crate) enum Core {
    Point,
    Segment { half_length: f64 },
    Cuboid { half_extents: Vector },
    Cylinder { half_length: f64, radius: f64 },
    Hull(Arc<HullPoints>),
    Triangle([ParryVector; 3]),
}

impl Convex {
    pub fn sharp(core: Core) -> Self {
        Self { core, radius_m: 0.0 }
    }

    /// Points whose convex hull, rounded by the radius, contains the solid: exactly, except for the cylinder, which gets the
    /// eight-sided prism around it.
    pub fn bounding_points(&self) -> Vec<Point> {
        let signs = [-1.0, 1.0];
        match &self.core {
            Core::Point => vec![Point::origin()],
            Core::Segment { half_length } => signs.map(|s| Point::new(0.0, 0.0, s * half_length)).to_vec(),
            Core::Cuboid { half_extents: h } => {
                let mut corners = Vec::with_capacity(8);
                for x in signs {
                    for y in signs {
                        corners.extend(signs.map(|z| Point::new(x * h.x, y * h.y, z * h.z)));
                    }
                }
                corners
            }
            Core::Cylinder { half_length, radius } => {
                let outer = radius / libm::cos(std::f64::consts::PI / 8.0);
                let corner = |k: u32| cranny_spatial::sin_cos(std::f64::consts::FRAC_PI_4 * f64::from(k));
                (0..8)
                    .flat_map(|k| {
                        let (sin, cos) = corner(k);
                        signs.map(|s| Point::new(outer * cos, outer * sin, s * half_length))
                    })
                    .collect()
            }
            Core::Hull(points) => points.iter().collect(),
            Core::Triangle(corners) => corners.iter().map(|p| Point::new(p.x, p.y, p.z)).collect(),
        }
    }
}

impl SupportMap for Core {
    fn local_support_point(&self, direction: ParryVector) -> ParryVector {
        match self {
            Self::Point => ParryVector::ZERO,
            Self::Segment { half_length } => ParryVector::new(0.0, 0.0, half_length.copysign(direction.z)),
            Self::Cuboid { half_extents: h } => ParryVector::new(
                h.x.copysign(direction.x),
                h.y.copysign(direction.y),
                h.z.copysign(direction.z),
            ),
            Self::Cylinder { half_length, radius } => {
                let across = (direction.x * direction.x + direction.y * direction.y).sqrt();
                let scale = if across > 0.0 { radius / across } else { 0.0 };
                ParryVector::new(direction.x * scale, direction.y * scale, half_length.copysign(direction.z))
            }
            Self::Hull(points) => points.farthest(direction),
            Self::Triangle([a, b, c]) => {
                let reach = [a, b, c].map(|corner| corner.dot(direction));
                if reach[0] >= reach[1] && reach[0] >= reach[2] {
                    *a
                } else if reach[1] >= reach[2] {
                    *b
                } else {
                    *c
                }
            }
        }
    }
}

/// Number of hull points that are compared at once.
const LANES: usize = 8;

/// Corners of a convex hull, stored coordinate by coordinate for vector instructions. The first corner fills up the last chunk.
#[derive(Clone, Debug)]
pub(crate) struct HullPoints {
    chunks: Vec<[[f64; LANES]; 3]>,
    len: usize,
}

impl HullPoints {
    pub fn new(corners: &[ParryVector]) -> Self {
        let chunk = |chunk: &[ParryVector]| {
            let corner = |lane: usize| chunk.get(lane).copied().unwrap_or(corners[0]);
            let coordinate = |axis: usize| std::array::from_fn(|lane| corner(lane).to_array()[axis]);
            [coordinate(0), coordinate(1), coordinate(2)]
        };
        Self { chunks: corners.chunks(LANES).map(chunk).collect(), len: corners.len() }
    }

    pub fn iter(&self) -> impl Iterator<Item = Point> {
        let point = |index: usize| self.corner(index / LANES, index % LANES);
        (0..self.len).map(point).map(|p| Point::new(p.x, p.y, p.z))
    }

    fn corner(&self, chunk: usize, lane: usize) -> ParryVector {
        let [x, y, z] = &self.chunks[chunk];
        ParryVector::new(x[lane], y[lane], z[lane])
    }

    /// Farthest corner along `direction`. Every instruction set adds in the same order, so all find the same corner.
    fn farthest(&self, direction: ParryVector) -> ParryVector {
        let (chunk, lane) = dispatch!(simd_level(), simd => farthest_corner(simd, &self.chunks, direction));
        self.corner(chunk, lane)
    }
}

/// Chunk and lane of the farthest corner; the first lane of equal ones.
#[inline(always)]
fn farthest_corner<S: Simd>(simd: S, chunks: &[[[f64; LANES]; 3]], direction: ParryVector) -> (usize, usize) {
    let [dx, dy, dz] = direction.to_array().map(|d| f64x8::splat(simd, d));
    let mut best = f64x8::splat(simd, f64::NEG_INFINITY);
    // The chunk number is an f64, so that it has the width of the values that select it.
    let mut best_chunk = f64x8::splat(simd, 0.0);
    let mut number = 0.0;
    for [x, y, z] in chunks {
        let [x, y, z] = [x, y, z].map(|lanes| f64x8::from_slice(simd, lanes));
        let reach = x * dx + y * dy + z * dz;
        let is_farther = reach.simd_gt(best);
        best = is_farther.select(reach, best);
        best_chunk = is_farther.select(f64x8::splat(simd, number), best_chunk);
        number += 1.0;
    }
    let (mut reaches, mut numbers) = ([0.0; LANES], [0.0; LANES]);
    best.store_slice(&mut reaches);
    best_chunk.store_slice(&mut numbers);
    let mut lane = 0;
    for other in 1..LANES {
        if reaches[other] > reaches[lane] {
            lane = other;
        }
    }
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "chunk numbers are small whole numbers"
    )]
    (numbers[lane] as usize, lane)
}
