use cranny_shape::{Range, Solid, separation_in};
use cranny_spatial::{FARTHEST_M, Point, Pose, Rotation};

use crate::rendering::interval::Side;
use crate::rendering::render::{Meeting, Rays};
use crate::seen::pixel_window::{greater, lesser, window};
use crate::{Segment, SegmentKind, SenseError, SensedScene, View};

/// A body whose place is known: the robot where it stands, or the object to be grasped.
#[derive(Clone, Debug)]
pub struct KnownBody {
    /// Name in messages.
    pub name: String,
    /// Solids with their poses in the planning frame.
    pub solids: Vec<(Pose, Solid)>,
    /// Error of its place, in metres: a depth that fits the body within this error shows the body.
    pub tolerance_m: f64,
    /// Distance from its surface within which unseen space counts as free, in metres. At a transparent body, all does.
    pub reach_m: f64,
    /// Side of the smallest cells at the end of its reach within the fine boxes, which count as free with it, in metres; `None`: they
    /// do not.
    pub border_m: Option<f64>,
    /// True if pixels that show it count as free to its back, those of a half-space without end: nothing else can be inside of it.
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
    border_m: Option<f64>,
    is_transparent: bool,
    is_alone: bool,
}

/// Relation of a cube to the space around the known bodies.
pub(crate) enum Nearness {
    Beyond,
    /// Within reach of one of them, with all its points; true if that one is transparent.
    Within(bool),
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
                border_m: body.border_m,
                is_transparent: body.is_transparent,
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
            let KnownSolid { pose, solid, reach_m, is_transparent, .. } = &self.solids[index];
            let far_m = reach_m + diagonal_m;
            let ball = solid.ball();
            if (pose * ball.center - center).norm() - ball.radius_m > far_m
                || solid.aabb().distance_to(&pose.inverse_transform_point(center)) > far_m
            {
                continue;
            }
            let distance_m = distance_m(center, solid, pose, far_m);
            if distance_m + diagonal_m <= *reach_m {
                return Nearness::Within(*is_transparent);
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
            let is_far = (pose * ball.center - point).norm() - ball.radius_m > margin_m
                || solid.aabb().distance_to(&pose.inverse_transform_point(point)) > margin_m;
            !is_far && distance_m(point, solid, pose, margin_m) <= margin_m
        })
    }

    /// Returns true if a cube touches a solid that is alone in the cells that it touches.
    pub fn touches_alone(&self, center: &Point, half_m: f64) -> bool {
        /// Rounding of boxes, of which a start must be clear, in metres.
        const TOUCH_M: f64 = 1e-4;
        let mut alone = self.solids.iter().filter(|solid| solid.is_alone);
        alone.any(|solid| solid.is_within_of_cube(center, half_m, TOUCH_M))
    }

    /// Returns the least side (m) of cells at the end of the reach of one of these solids, if a cube comes within its reach.
    pub fn border_m(&self, center: &Point, half_m: f64, among: &[usize]) -> Option<f64> {
        let reached = among.iter().map(|index| &self.solids[*index]).filter(|solid| {
            solid.border_m.is_some() && solid.is_within_of_cube(center, half_m, solid.reach_m)
        });
        reached.filter_map(|solid| solid.border_m).reduce(f64::min)
    }
}

impl KnownSolid {
    /// Returns true if a cube, by its centre and half side (m), comes within a distance (m) of the solid.
    fn is_within_of_cube(&self, center: &Point, half_m: f64, distance_m: f64) -> bool {
        let ball = self.solid.ball();
        if (self.pose * ball.center - center).norm() - ball.radius_m > distance_m + DIAGONAL * half_m {
            return false;
        }
        let cube = Solid::cuboid(cranny_spatial::Vector::repeat(half_m));
        let at = Pose::from_parts(center.coords.into(), Rotation::identity());
        cube.as_ref().is_ok_and(|cube| {
            let range = Range::to(distance_m + half_m);
            separation_in(cube, &at, &self.solid, &self.pose, range).lower_m <= distance_m
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

/// Known bodies in a form that is rendered.
pub(crate) struct KnownScene<'a> {
    bodies: &'a [KnownBody],
    scene: SensedScene,
    solids: KnownSolids,
}

impl<'a> KnownScene<'a> {
    /// # Errors
    /// [`SenseError::NoSurface`] for a body that cannot be rendered.
    pub fn new(bodies: &'a [KnownBody]) -> Result<Self, SenseError> {
        let mut scene = SensedScene::default();
        for body in bodies {
            let segment = Segment { name: body.name.clone(), kind: SegmentKind::Body };
            scene.add(segment, body.solids.iter().map(|(pose, solid)| (*pose, solid)))?;
        }
        Ok(Self { bodies, scene, solids: KnownSolids::new(bodies) })
    }

    fn body(&self, segment: u16) -> Option<&KnownBody> {
        self.bodies.get(usize::from(segment).wrapping_sub(1))
    }
}

/// Greatest distance of pixels that are compared with a known body, in pixels.
const MOST_AROUND_PX: f64 = 64.0;

/// Effect of the error of a camera's pose on where it sees a body whose place is known.
struct PoseError {
    position_m: f64,
    /// Displacement of a point per metre of depth, by the error of orientation.
    turn: f64,
    /// Greatest length of a ray of depth 1.
    slant: f64,
    focal_px: f64,
}

impl PoseError {
    fn of(view: &View) -> Self {
        let View { camera, sensor, .. } = view;
        let corners = [[0, 0], [1, 0], [0, 1], [1, 1]].map(|[right, down]| {
            let (u, v) = (right * (camera.width_px - 1), down * (camera.height_px - 1));
            camera.ray(u as f64, v as f64).norm()
        });
        let slant = corners.into_iter().fold(1.0, f64::max);
        Self {
            position_m: sensor.position_error_m,
            turn: 2.0 * libm::sin(0.5 * sensor.turn_error_rad) * slant,
            slant,
            focal_px: camera.focal_x_px.max(camera.focal_y_px),
        }
    }

    /// Returns a bound on the displacement of a point at this depth (m), in metres.
    fn at_m(&self, depth_m: f64) -> f64 {
        self.position_m + self.turn * depth_m.min(FARTHEST_M)
    }

    /// Returns a bound on the displacement in the image of points at least this deep (m), in pixels.
    fn lateral_px(&self, nearest_m: f64) -> f64 {
        if self.position_m + self.turn <= 0.0 {
            return 0.0;
        }
        // Before the displacement, along the axis too, a point may be nearer by as much.
        let true_m = nearest_m - self.at_m(nearest_m);
        if true_m <= 0.0 {
            return f64::INFINITY;
        }
        self.focal_px * (self.position_m / true_m + self.turn * nearest_m / true_m) * (1.0 + self.slant)
    }
}

impl Explained {
    /// Returns the pixels of `view` whose depths fit a known body there and in the pixels around.
    pub fn of(view: &View, known: &KnownScene) -> Self {
        let camera = &view.camera;
        let rays = Rays::centres(camera);
        let fronts = known.scene.meetings(&rays, Side::Front, |_| true);
        if fronts.iter().all(|front| front.segment == 0) {
            return Self { pixels: Vec::new() };
        }
        let is_transparent = |segment: u16| known.body(segment).is_some_and(|body| body.is_transparent);
        let backs = known.scene.meetings(&rays, Side::Back, is_transparent);
        let size_px = [camera.width_px, camera.height_px];
        let [width, height] = size_px;
        let pose_error = PoseError::of(view);
        let nearest_m = fronts.iter().map(|front| front.depth_m).fold(f64::INFINITY, f64::min);
        let around_px = (view.sensor.lateral_error_px + pose_error.lateral_px(nearest_m)).ceil();
        if around_px > MOST_AROUND_PX {
            // It cannot be decided which pixels show them: all that is measured may be something else.
            return Self { pixels: Vec::new() };
        }
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "at most 64")]
        let around = around_px as usize;
        // Depths of front and back in the pixels around each pixel, with their tolerances; the segments there.
        #[allow(clippy::cast_possible_truncation, reason = "rounding is a thousandth of a reserve")]
        let around_each =
            |value: &dyn Fn(&KnownBody, &Meeting, &Meeting) -> f64, none: f32, pick: fn(f32, f32) -> f32| {
                let of = |(front, back): (&Meeting, &Meeting)| {
                    known.body(front.segment).map_or(none, |body| value(body, front, back) as f32)
                };
                let image: Vec<f32> = fronts.iter().zip(&backs).map(of).collect();
                window(&image, size_px, around, pick)
            };
        let error_m = |body: &KnownBody, depth_m: f64| body.tolerance_m + pose_error.at_m(depth_m);
        let near_m = around_each(
            &|body, front, _| front.depth_m - error_m(body, front.depth_m),
            f32::INFINITY,
            lesser,
        );
        let far_m = around_each(&|body, front, _| front.depth_m + error_m(body, front.depth_m), 0.0, greater);
        let end_m = |body: &KnownBody, front: &Meeting, back: &Meeting| {
            let has_back = body.is_transparent && back.segment == front.segment;
            let end_m = if has_back { back.depth_m.max(front.depth_m) } else { front.depth_m };
            end_m - error_m(body, end_m)
        };
        let back_m = around_each(&end_m, f32::INFINITY, lesser);
        let segment = |_: &KnownBody, front: &Meeting, _: &Meeting| f64::from(front.segment);
        let segments = [around_each(&segment, 0.0, lesser), around_each(&segment, 0.0, greater)];
        let all = known.solids.all();
        let mut pixels = vec![PixelOf::Other; width * height];
        for place in 0..pixels.len() {
            let (u, v) = (place % width, place / width);
            let Some(measured_m) = view.depth.depth_m(u, v).map(f64::from) else { continue };
            let [near_m, far_m, back_m] = [&near_m, &far_m, &back_m].map(|image| f64::from(image[place]));
            let is_border = u.min(v) < around || u + around >= width || v + around >= height;
            let own = fronts[place].segment;
            let is_whole = !is_border
                && own > 0
                && segments.iter().all(|image| (image[place] - f32::from(own)).abs() < 0.5);
            let fits = view.sensor.greatest_true_depth_m(measured_m) >= near_m
                && view.sensor.least_true_depth_m(measured_m) <= far_m;
            pixels[place] = match (is_whole, fits) {
                (true, true) if is_transparent(own) => PixelOf::Through(back_m),
                (true, true) => PixelOf::Known(back_m),
                (false, true) => PixelOf::Edge,
                // Features of a body may be narrower than a pixel, or beyond the border of the image.
                (_, false) if near_m.is_finite() || is_border => {
                    let lateral_m = 2.0 * (0.5 + view.sensor.lateral_error_px) * measured_m
                        / camera.focal_x_px.min(camera.focal_y_px);
                    let margin_m =
                        lateral_m + view.sensor.depth_bound_m(measured_m) + pose_error.at_m(measured_m);
                    let point = camera.ray(u as f64, v as f64) * measured_m;
                    let point = camera.world_from_camera * Point::from(point);
                    if known.solids.is_within(&point, margin_m, &all) {
                        PixelOf::Edge
                    } else {
                        PixelOf::Other
                    }
                }
                _ => PixelOf::Other,
            };
        }
        Self { pixels }
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
