use std::f64::consts::{PI, TAU};

use cranny_shape::{Outline, Solid};
use cranny_spatial::{Point, Pose, Stream, Vector, sin_cos};

use crate::cloud::point_cloud::narrow;
use crate::{PointCloud, SenseError};

/// Returns `count` points drawn uniformly by area from the surfaces of solids with their poses in the frame of the cloud, in the
/// order in which they are drawn. Each whole surface counts, also where solids overlap. Balls, capsules and cylinders are sampled
/// by their equations, all others by their triangles.
///
/// # Errors
/// [`SenseError::NoArea`] without a surface of finite area; a half-space has none.
pub fn sample_surfaces<'a>(
    solids: impl IntoIterator<Item = (Pose, &'a Solid)>,
    count: usize,
    seed: u64,
) -> Result<PointCloud, SenseError> {
    let mut sources = Vec::new();
    for (pose, solid) in solids {
        for (piece_pose, piece) in solid.pieces() {
            if !piece.is_half_space() {
                sources.push((pose * piece_pose, Source::of(&piece)?));
            }
        }
    }
    let area_up_to_m2 = up_to(sources.iter().map(|(_, source)| source.area_m2()));
    if !area_up_to_m2.last().is_some_and(|sum_m2| *sum_m2 > 0.0 && sum_m2.is_finite()) {
        return Err(SenseError::NoArea);
    }
    let mut random = Stream::new(seed, 0);
    let mut points = Vec::with_capacity(count);
    for _ in 0..count {
        let (pose, source) = &sources[drawn(&area_up_to_m2, &mut random)];
        points.push(narrow(&(pose * source.point(&mut random))));
    }
    Ok(PointCloud::of(points))
}

/// Returns sums of areas up to each one.
fn up_to(areas_m2: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut sum_m2 = 0.0;
    let add = |area_m2| {
        sum_m2 += area_m2;
        sum_m2
    };
    areas_m2.map(add).collect()
}

/// Draws an index with a probability in proportion to its area.
fn drawn(area_up_to_m2: &[f64], random: &mut Stream) -> usize {
    let chosen_m2 = random.uniform() * area_up_to_m2.last().copied().unwrap_or(0.0);
    area_up_to_m2.partition_point(|up_to| *up_to <= chosen_m2).min(area_up_to_m2.len() - 1)
}

/// Surface that is sampled.
enum Source {
    /// A cylinder between two caps: half-balls for a capsule, discs for a cylinder.
    Round {
        half_length_m: f64,
        radius_m: f64,
        has_balls: bool,
    },
    Triangles {
        corners: Vec<[Point; 3]>,
        area_up_to_m2: Vec<f64>,
    },
}

impl Source {
    fn of(solid: &Solid) -> Result<Self, SenseError> {
        Ok(match solid.outline() {
            Outline::Segment { half_length_m, radius_m } => {
                Self::Round { half_length_m, radius_m, has_balls: true }
            }
            Outline::Cylinder { half_length_m, radius_m } => {
                Self::Round { half_length_m, radius_m, has_balls: false }
            }
            _ => {
                let soup = solid.tessellation().ok_or(SenseError::NoArea)?;
                let corners: Vec<_> =
                    (0..soup.triangles.len()).map(|triangle| soup.corners(triangle)).collect();
                let area_up_to_m2 =
                    up_to(corners.iter().map(|[a, b, c]| 0.5 * (b - a).cross(&(c - a)).norm()));
                Self::Triangles { corners, area_up_to_m2 }
            }
        })
    }

    fn area_m2(&self) -> f64 {
        match self {
            Self::Round { half_length_m, radius_m, has_balls } => {
                let of_caps = if *has_balls { 4.0 } else { 2.0 } * PI * radius_m * radius_m;
                of_caps + 2.0 * TAU * radius_m * half_length_m
            }
            Self::Triangles { area_up_to_m2, .. } => area_up_to_m2.last().copied().unwrap_or(0.0),
        }
    }

    fn point(&self, random: &mut Stream) -> Point {
        match self {
            Self::Round { half_length_m, radius_m, has_balls } => {
                let side_m2 = 2.0 * TAU * radius_m * half_length_m;
                let is_side = random.uniform() * self.area_m2() < side_m2;
                let (sin, cos) = sin_cos(TAU * random.uniform());
                let height = random.uniform_between(-1.0, 1.0);
                if is_side {
                    return Point::new(radius_m * cos, radius_m * sin, height * half_length_m);
                }
                let (across, beyond_m) = if *has_balls {
                    // The height of a uniform point of a ball is uniform (Archimedes).
                    ((1.0 - height * height).max(0.0).sqrt(), height * radius_m)
                } else {
                    (height.abs().sqrt(), 0.0)
                };
                let z = half_length_m.copysign(height) + beyond_m;
                Point::from(Vector::new(radius_m * across * cos, radius_m * across * sin, z))
            }
            Self::Triangles { corners, area_up_to_m2 } => {
                let [a, b, c] = &corners[drawn(area_up_to_m2, random)];
                // Osada et al. 2002, "Shape distributions", §4.2.
                let (root, share) = (random.uniform().sqrt(), random.uniform());
                a + (b - a) * (root * (1.0 - share)) + (c - a) * (root * share)
            }
        }
    }
}
