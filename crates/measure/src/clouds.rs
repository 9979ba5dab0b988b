//! Worlds as clouds: points sampled on the surfaces of all bodies.

use std::error::Error;
use std::time::Instant;

use cranny_collision::{Body, Part, World};
use cranny_sense::{PointCloud, sample_surfaces};
use cranny_shape::{Aabb, BoxUnion, Solid};
use cranny_spatial::{Point, Pose, Vector, other_seed};

/// Sampling and filters of a cloud.
#[derive(Clone, Copy, Debug)]
pub struct CloudSettings {
    /// Points on each object.
    pub points_per_object: usize,
    /// Radius of the ball around each point that is left, in metres.
    pub radius_m: f64,
    /// Side of the voxels of which one point each is kept, in metres; `None`: all are kept.
    pub voxel_m: Option<f64>,
    /// Distance from the root along each axis within which points are kept, in metres.
    pub reach_m: f64,
}

impl Default for CloudSettings {
    /// Numbers of VAMP's evaluation (`KavrakiLab/vamp`, `scripts/evaluate_mbm.py`, `src/vamp/constants.py`): 10⁴ points on each object
    /// within 1.19 m, of which its filter leaves one within 2 cm, with a radius of 2.5 mm.
    fn default() -> Self {
        Self { points_per_object: 10_000, radius_m: 0.0025, voxel_m: Some(0.02), reach_m: 1.19 }
    }
}

/// World whose only body is a cloud, with the time that it took.
#[derive(Debug)]
pub struct CloudWorld {
    /// The world.
    pub world: World,
    /// Number of points before the filters.
    pub sampled: usize,
    /// Number of points that are left.
    pub kept: usize,
    /// Time of the filters, in seconds.
    pub filter_s: f64,
    /// Time to build the tree of the points, in seconds.
    pub build_s: f64,
}

impl CloudWorld {
    /// Samples the surfaces of all bodies of a world, filters the points and builds their tree.
    ///
    /// # Errors
    /// A body without a surface, or a setting out of range.
    pub fn of(world: &World, settings: &CloudSettings, seed: u64) -> Result<Self, Box<dyn Error>> {
        let mut points = Vec::new();
        for (index, body) in world.bodies().iter().enumerate() {
            let solids = body.parts.iter().map(|part| (part.world_from_solid, &part.solid));
            let seed = other_seed(seed, index as u64);
            points.extend(sample_surfaces(solids, settings.points_per_object, seed)?.points);
        }
        let cloud = PointCloud::of(points);
        let begin = Instant::now();
        let around = Aabb { center: Point::origin(), half_extents: Vector::repeat(settings.reach_m) };
        let mut left = cloud.cropped(&around, &Pose::identity());
        if let Some(side_m) = settings.voxel_m {
            left = left.thinned(side_m)?;
        }
        let filter_s = begin.elapsed().as_secs_f64();
        let begin = Instant::now();
        let solid = Solid::union(BoxUnion::of_points(&left.points, settings.radius_m)?);
        let build_s = begin.elapsed().as_secs_f64();
        let parts = vec![Part { world_from_solid: Pose::identity(), solid }];
        let body = Body { name: "cloud".to_owned(), parts, tilt_rad: None, center_of_mass: None };
        let (sampled, kept) = (cloud.points.len(), left.points.len());
        Ok(Self { world: world.with_bodies(vec![body])?, sampled, kept, filter_s, build_s })
    }
}
