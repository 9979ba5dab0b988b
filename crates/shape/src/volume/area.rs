use cranny_spatial::{Point, Vector};

use crate::Surface;
use crate::distance::ray::triangle_normal;

/// A point of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// Position, in the frame of the surface.
    pub point: Point,
    /// Unit normal of the triangle, outwards by the right-hand rule.
    pub normal: Vector,
    /// Index of the triangle.
    pub triangle: u32,
}

/// Uniform distribution over the area of a surface, sampled with three uniform numbers.
#[derive(Clone, Debug)]
pub struct AreaDistribution<'a> {
    surface: &'a Surface,
    /// Cumulative area of the triangles, in square metres.
    area_up_to_m2: Vec<f64>,
}

impl<'a> AreaDistribution<'a> {
    /// The distribution over all triangles of `surface`; `None` if they have no area.
    pub fn new(surface: &'a Surface) -> Option<Self> {
        let mut sum = 0.0;
        let area_up_to_m2: Vec<f64> = surface
            .corners
            .iter()
            .map(|[a, b, c]| {
                sum += 0.5 * (b - a).cross(&(c - a)).norm();
                sum
            })
            .collect();
        (sum > 0.0 && sum.is_finite()).then_some(Self { surface, area_up_to_m2 })
    }

    /// The area of the whole surface, in square metres.
    pub fn area_m2(&self) -> f64 {
        self.area_up_to_m2.last().copied().unwrap_or(0.0)
    }

    /// Point for three numbers in [0, 1): selects a triangle by its share of the area, then a point of it (Osada et al.
    /// 2002, §4.2). Uniform numbers give uniform points.
    pub fn point(&self, numbers: [f64; 3]) -> SurfacePoint {
        let [which, u, v] = numbers;
        let chosen_m2 = which * self.area_m2();
        let triangle = self.area_up_to_m2.partition_point(|up_to| *up_to <= chosen_m2);
        let triangle = triangle.min(self.area_up_to_m2.len() - 1);
        let corners = &self.surface.corners[triangle];
        let [a, b, c] = corners;
        let root = u.sqrt();
        let point = a + (b - a) * (root * (1.0 - v)) + (c - a) * (root * v);
        SurfacePoint {
            point,
            normal: triangle_normal(corners),
            triangle: u32::try_from(triangle).unwrap_or(u32::MAX),
        }
    }
}
