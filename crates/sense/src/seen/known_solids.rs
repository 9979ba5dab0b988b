use std::collections::HashMap;

use cranny_shape::{Range, Solid, Surface, separation_in};
use cranny_spatial::{Point, Pose, Rotation};

use crate::{Render, Segment, SegmentKind, SenseError, SensedScene, SensorModel, View};

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
    /// True if pixels that show it count as free to its back: nothing else can be inside of it.
    pub is_transparent: bool,
    /// True if cells that it touches hold nothing else, whatever is measured there: the robot stands there.
    pub is_alone: bool,
}

/// Known bodies as one list of solids.
pub(crate) struct KnownSolids {
    solids: Vec<KnownSolid>,
}

struct KnownSolid {
    pose: Pose,
    solid: Solid,
    reach_m: f64,
    is_alone: bool,
}

/// Relation of a cube to the space around the known bodies.
pub(crate) enum Nearness {
    Beyond,
    /// Within reach of one of them, with all its points.
    Within,
    /// Undecided, with the solids that may be near.
    Partly(Vec<usize>),
}

/// Half diagonal of a cube of half side 1, rounded up.
const DIAGONAL: f64 = 1.732_051;

impl KnownSolids {
    pub fn new(bodies: &[KnownBody]) -> Self {
        let solids = bodies.iter().flat_map(|body| {
            body.solids.iter().map(|(pose, solid)| KnownSolid {
                pose: *pose,
                solid: solid.clone(),
                reach_m: body.reach_m,
                is_alone: body.is_alone,
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
        let diagonal_m = DIAGONAL * half_m;
        let mut near = Vec::new();
        for &index in among {
            let KnownSolid { pose, solid, reach_m, .. } = &self.solids[index];
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

    /// Returns true if a point lies within a distance (m) of one of these solids.
    pub fn is_within(&self, point: &Point, margin_m: f64, among: &[usize]) -> bool {
        among.iter().any(|&index| {
            let KnownSolid { pose, solid, .. } = &self.solids[index];
            let ball = solid.ball();
            let is_far = (pose * ball.center - point).norm() - ball.radius_m > margin_m;
            !is_far && distance_m(point, solid, pose, margin_m) <= margin_m
        })
    }

    /// Returns true if a cube touches a solid that is alone in the cells that it touches.
    pub fn touches_alone(&self, center: &Point, half_m: f64) -> bool {
        let alone = |index: &usize| self.solids[*index].is_alone;
        let alone: Vec<usize> = (0..self.solids.len()).filter(alone).collect();
        self.is_within(center, DIAGONAL * half_m, &alone)
    }

    /// Returns true if a cube comes within reach of one of these solids.
    pub fn reaches(&self, center: &Point, half_m: f64, among: &[usize]) -> bool {
        let cube = Solid::cuboid(cranny_spatial::Vector::repeat(half_m));
        let at = Pose::from_parts(center.coords.into(), Rotation::identity());
        among.iter().any(|&index| {
            let KnownSolid { pose, solid, reach_m, .. } = &self.solids[index];
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
    /// Row by row; empty if no pixel shows any.
    pixels: Vec<PixelOf>,
}

/// Content of a pixel.
#[derive(Clone, Copy)]
pub(crate) enum PixelOf {
    /// A known body alone; the least depth to which it leaves no space for another, less its tolerance (m).
    Known(f64),
    /// A transparent known body alone; the least depth of its back there, less its tolerance (m).
    Through(f64),
    /// The edge of a known body.
    Edge,
    /// Anything else.
    Other,
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
            return Ok(Self { pixels: Vec::new() });
        }
        let (width, height) = (view.camera.width_px, view.camera.height_px);
        let SensorModel { lateral_error_px, .. } = view.sensor;
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "at most 16")]
        let around = lateral_error_px.ceil() as usize;
        let backs_m = backs_m(view, bodies, &render);
        let mut pixels = vec![PixelOf::Other; width * height];
        let known = KnownSolids::new(bodies);
        let all = known.all();
        for v in 0..height {
            for u in 0..width {
                let Some(measured_m) = view.depth.depth_m(u, v).map(f64::from) else { continue };
                let columns = u.saturating_sub(around)..=(u + around).min(width - 1);
                let rows = v.saturating_sub(around)..=(v + around).min(height - 1);
                let is_border =
                    columns.end() - columns.start() < 2 * around || rows.end() - rows.start() < 2 * around;
                let (mut near_m, mut far_m, mut is_whole) = (f64::INFINITY, 0.0_f64, !is_border);
                let mut back_m = f64::INFINITY;
                let is_through = backs_m.contains_key(&(v * width + u));
                for place in rows.flat_map(|row| columns.clone().map(move |column| row * width + column)) {
                    let segment = usize::from(render.segments[place]);
                    let Some(body) = bodies.get(segment.wrapping_sub(1)) else {
                        is_whole = false;
                        continue;
                    };
                    is_whole &= render.segments[place] == render.segments[v * width + u];
                    let depth_m = f64::from(render.depth.depths_m()[place]);
                    near_m = near_m.min(depth_m - body.tolerance_m);
                    far_m = far_m.max(depth_m + body.tolerance_m);
                    let back = backs_m.get(&place).map_or(depth_m, |back_m| back_m.max(depth_m));
                    back_m = back_m.min(back - body.tolerance_m);
                }
                let is_behind = view.sensor.greatest_true_depth_m(measured_m) >= near_m;
                let fits = is_behind && view.sensor.least_true_depth_m(measured_m) <= far_m;
                // A depth at an edge may lie anywhere between front and back.
                pixels[v * width + u] = match (is_whole, fits, is_behind) {
                    (true, true, _) if is_through => PixelOf::Through(back_m),
                    (true, true, _) => PixelOf::Known(back_m),
                    (_, _, true) if near_m.is_finite() => PixelOf::Edge,
                    // Features of a body may be narrower than a pixel, or beyond the border of the image.
                    (false, _, false) if near_m.is_finite() || is_border => {
                        let camera = &view.camera;
                        let lateral_m = 2.0 * (0.5 + lateral_error_px) * measured_m
                            / camera.focal_x_px.min(camera.focal_y_px);
                        let margin_m = lateral_m + view.sensor.depth_bound_m(measured_m);
                        let point = camera.ray(u as f64, v as f64) * measured_m;
                        let point = camera.world_from_camera * Point::from(point);
                        if known.is_within(&point, margin_m, &all) { PixelOf::Edge } else { PixelOf::Other }
                    }
                    _ => PixelOf::Other,
                };
            }
        }
        Ok(Self { pixels })
    }

    /// Returns true if no pixel shows a known body.
    pub fn is_empty(&self) -> bool {
        self.pixels.is_empty()
    }

    /// Returns true if a pixel shows a transparent body.
    pub fn shows_transparent(&self) -> bool {
        self.pixels.iter().any(|pixel| matches!(pixel, PixelOf::Through(_)))
    }

    /// Returns the content of a pixel.
    pub fn pixel(&self, pixel: usize) -> PixelOf {
        self.pixels.get(pixel).copied().unwrap_or(PixelOf::Other)
    }

    /// Returns true if the depth of a pixel is no sign of another body.
    pub fn is_of_known(&self, pixel: usize) -> bool {
        !matches!(self.pixel(pixel), PixelOf::Other)
    }
}

/// Returns the depth (m) at which the ray of each pixel that shows a transparent body first leaves it.
fn backs_m(view: &View, bodies: &[KnownBody], render: &Render) -> HashMap<usize, f64> {
    let camera = &view.camera;
    let mut backs_m = HashMap::new();
    for (body, number) in bodies.iter().zip(1_u16..) {
        if !body.is_transparent {
            continue;
        }
        let shown = (0..render.segments.len()).filter(|pixel| render.segments[*pixel] == number);
        let pixels: Vec<usize> = shown.collect();
        for (pose, solid) in &body.solids {
            let surface = solid.tessellation().and_then(|soup| Surface::new(&soup).ok());
            let Some(surface) = surface.filter(|_| !pixels.is_empty()) else { continue };
            let solid_from_camera = pose.inv_mul(&camera.world_from_camera);
            let origin = Point::from(solid_from_camera.translation.vector);
            for &pixel in &pixels {
                let ray = camera.ray((pixel % camera.width_px) as f64, (pixel / camera.width_px) as f64);
                let direction = solid_from_camera.rotation * ray.normalize();
                let hits = surface.ray_hits(&origin, &direction, 2.0 * view.sensor.farthest_m);
                // The first way out; of several solids, the first of all.
                let Some(out) = hits.iter().find(|hit| hit.normal.dot(&direction) > 0.0) else { continue };
                let depth_m = out.distance_m / ray.norm();
                let back = backs_m.entry(pixel).or_insert(depth_m);
                *back = back.min(depth_m);
            }
        }
    }
    backs_m
}
