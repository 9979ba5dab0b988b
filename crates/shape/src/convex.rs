use std::sync::Arc;

use cranny_spatial::{Point, Vector};
use parry3d_f64::math::Vector as ParryVector;
use parry3d_f64::shape::SupportMap;

/// A convex body: a core given by its support function, and a radius by which the core is rounded.
///
/// Spheres and capsules are a point and a segment with a radius, so their distances are exact.
#[derive(Clone, Debug)]
pub(crate) struct Convex {
    pub core: Core,
    pub radius_m: f64,
}

/// What is rounded. Segments and cylinders lie along z, all are centred at the origin of their frame.
#[derive(Clone, Debug)]
pub(crate) enum Core {
    Point,
    Segment { half_length: f64 },
    Cuboid { half_extents: Vector },
    Cylinder { half_length: f64, radius: f64 },
    Hull(Arc<[ParryVector]>),
    Triangle([ParryVector; 3]),
}

impl Convex {
    pub fn sharp(core: Core) -> Self {
        Self { core, radius_m: 0.0 }
    }

    /// Points whose convex hull, rounded by the radius, contains the body: exactly it, save for the
    /// cylinder, which gets a prism of eight sides around it.
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
            Core::Hull(points) => points.iter().map(|p| Point::new(p.x, p.y, p.z)).collect(),
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
            Self::Hull(points) => farthest(points, direction),
            Self::Triangle(corners) => farthest(corners, direction),
        }
    }
}

fn farthest(points: &[ParryVector], direction: ParryVector) -> ParryVector {
    let mut best = points[0];
    let mut best_reach = best.dot(direction);
    for &point in &points[1..] {
        let reach = point.dot(direction);
        if reach > best_reach {
            (best, best_reach) = (point, reach);
        }
    }
    best
}
