use cranny_shape::{Range, Solid, separation_in};
use cranny_spatial::{Point, Pose, Rotation};

use crate::{Segment, SegmentKind, SenseError, SensedScene, SensorModel, View};

/// A body whose place is known: the robot where it stands, or the object to be grasped.
#[derive(Clone, Debug)]
pub struct KnownBody {
    /// Name in messages.
    pub name: String,
    /// Solids with their poses in the planning frame.
    pub solids: Vec<(Pose, Solid)>,
    /// Error of its place, in metres: a depth that fits the body within this error shows the body.
    pub tolerance_m: f64,
    /// Distance from its surface within which space counts as free unless another surface is measured there, in metres.
    pub reach_m: f64,
}

/// Known bodies as one list of solids.
pub(crate) struct KnownSolids {
    solids: Vec<KnownSolid>,
}

struct KnownSolid {
    pose: Pose,
    solid: Solid,
    reach_m: f64,
}

/// Relation of a cube to the space around the known bodies.
pub(crate) enum Nearness {
    Beyond,
    /// Within reach of one of them, with all its points.
    Within,
    /// Undecided, with the solids that may be near.
    Partly(Vec<usize>),
}

impl KnownSolids {
    pub fn new(bodies: &[KnownBody]) -> Self {
        let solids = bodies.iter().flat_map(|body| {
            body.solids.iter().map(|(pose, solid)| KnownSolid {
                pose: *pose,
                solid: solid.clone(),
                reach_m: body.reach_m,
            })
        });
        Self { solids: solids.collect() }
    }

    /// Returns the indices of all solids.
    pub fn all(&self) -> Vec<usize> {
        (0..self.solids.len()).collect()
    }

    /// Returns the relation of a cube, by its centre and half side (m), to these solids.
    pub fn nearness(&self, center: &Point, half_m: f64, among: &[usize]) -> Nearness {
        /// Half diagonal of a cube of half side 1, rounded up.
        const DIAGONAL: f64 = 1.732_051;
        let diagonal_m = DIAGONAL * half_m;
        let mut near = Vec::new();
        for &index in among {
            let KnownSolid { pose, solid, reach_m } = &self.solids[index];
            let far_m = reach_m + diagonal_m;
            let ball = solid.ball();
            if (pose * ball.center - center).norm() - ball.radius_m > far_m
                || solid.aabb().distance_to(&pose.inverse_transform_point(center)) > far_m
            {
                continue;
            }
            let distance_m = distance_m(center, solid, pose, far_m);
            if distance_m + diagonal_m <= *reach_m {
                return Nearness::Within;
            }
            if distance_m <= far_m {
                near.push(index);
            }
        }
        if near.is_empty() { Nearness::Beyond } else { Nearness::Partly(near) }
    }

    /// Returns true if a cube comes within reach of one of these solids.
    pub fn reaches(&self, center: &Point, half_m: f64, among: &[usize]) -> bool {
        let cube = Solid::cuboid(cranny_spatial::Vector::repeat(half_m));
        let at = Pose::from_parts(center.coords.into(), Rotation::identity());
        among.iter().any(|&index| {
            let KnownSolid { pose, solid, reach_m } = &self.solids[index];
            cube.as_ref().is_ok_and(|cube| {
                separation_in(cube, &at, solid, pose, Range::to(reach_m + half_m)).lower_m <= *reach_m
            })
        })
    }
}

/// Lower bound of the distance of a point from a solid, at most `beyond_m` and some more (m).
fn distance_m(point: &Point, solid: &Solid, pose: &Pose, beyond_m: f64) -> f64 {
    /// Radius of the ball that stands for a point, in metres.
    const POINT_M: f64 = 1e-9;
    let at = Pose::from_parts(point.coords.into(), Rotation::identity());
    let ball = Solid::sphere(POINT_M);
    ball.map_or(0.0, |ball| separation_in(&ball, &at, solid, pose, Range::to(2.0 * beyond_m)).lower_m)
}

/// Pixels of a view that show known bodies.
pub(crate) struct Explained {
    /// Least depth of the body in the pixel and around it, less its tolerance (m); NaN for other pixels. Empty if no pixel shows any.
    depths_m: Vec<f32>,
}

impl Explained {
    /// Returns the pixels of `view` whose depths fit a known body there and in the pixels around.
    ///
    /// # Errors
    /// [`SenseError::NoSurface`] for a body that cannot be rendered.
    pub fn of(view: &View, bodies: &[KnownBody]) -> Result<Self, SenseError> {
        let mut scene = SensedScene::default();
        for body in bodies {
            let segment = Segment { name: body.name.clone(), kind: SegmentKind::Body };
            scene.add(segment, body.solids.iter().map(|(pose, solid)| (*pose, solid)))?;
        }
        let render = scene.render(&view.camera);
        if render.segments.iter().all(|segment| *segment == 0) {
            return Ok(Self { depths_m: Vec::new() });
        }
        let (width, height) = (view.camera.width_px, view.camera.height_px);
        let SensorModel { lateral_error_px, .. } = view.sensor;
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "at most 16")]
        let around = lateral_error_px.ceil() as usize;
        let mut depths_m = vec![f32::NAN; width * height];
        for v in around..height.saturating_sub(around) {
            for u in around..width.saturating_sub(around) {
                let segment = render.segments[v * width + u];
                let Some(body) = bodies.get(usize::from(segment).wrapping_sub(1)) else { continue };
                let Some(measured_m) = view.depth.depth_m(u, v).map(f64::from) else { continue };
                let (mut near_m, mut far_m, mut is_whole) = (f64::INFINITY, 0.0_f64, true);
                for row in v - around..=v + around {
                    for place in row * width + u - around..=row * width + u + around {
                        is_whole &= render.segments[place] == segment;
                        let depth_m = f64::from(render.depth.depths_m()[place]);
                        (near_m, far_m) = (near_m.min(depth_m), far_m.max(depth_m));
                    }
                }
                let (near_m, far_m) = (near_m - body.tolerance_m, far_m + body.tolerance_m);
                let fits = view.sensor.greatest_true_depth_m(measured_m) >= near_m
                    && view.sensor.least_true_depth_m(measured_m) <= far_m;
                if is_whole && fits {
                    #[allow(clippy::cast_possible_truncation, reason = "a reserve covers the rounding")]
                    {
                        depths_m[v * width + u] = near_m as f32;
                    }
                }
            }
        }
        Ok(Self { depths_m })
    }

    /// Returns the depth of the body that a pixel shows, less its tolerance, in metres.
    pub fn depth_m(&self, pixel: usize) -> Option<f64> {
        self.depths_m.get(pixel).filter(|depth_m| !depth_m.is_nan()).map(|depth_m| f64::from(*depth_m))
    }
}
