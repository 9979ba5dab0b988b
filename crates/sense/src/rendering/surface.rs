use std::sync::Arc;

use cranny_shape::{Outline, Solid};
use cranny_spatial::{Point, Pose, Vector};

use crate::Camera;
use crate::rendering::interval::{Side, meeting};
use crate::rendering::pixel_range::PixelRange;

/// Solid with its pose, in a form that rays are cast at.
#[derive(Clone, Debug)]
pub(crate) struct Surface {
    pub world_from_solid: Pose,
    pub solid: Solid,
    /// Triangles of a hull or a mesh, in the frame of the solid; empty for any other solid.
    triangles: Arc<[[Point; 3]]>,
}

/// Surface in the frame of one camera.
pub(crate) enum Cast {
    /// A cuboid, ball, capsule, cylinder or half-space.
    Outline { outline: Outline, origin: Point, solid_from_camera: Pose, range: PixelRange },
    /// Triangles of a hull or a mesh.
    Triangles(Vec<CastTriangle>),
}

/// Triangle in the camera frame.
pub(crate) struct CastTriangle {
    /// Normal of each plane through the camera and an edge, whose sign of the product with a ray states its side.
    edges: [Vector; 3],
    normal: Vector,
    /// Product of the normal with a corner.
    height: f64,
    pub range: PixelRange,
}

impl Surface {
    /// Returns a surface; `None` if it has none that can be rendered.
    pub fn new(world_from_solid: Pose, solid: &Solid) -> Option<Self> {
        let triangles: Arc<[_]> = if solid.outline() == Outline::Other {
            let soup = solid.tessellation()?;
            (0..soup.triangles.len()).map(|triangle| soup.corners(triangle)).collect()
        } else {
            Arc::default()
        };
        Some(Self { world_from_solid, solid: solid.clone(), triangles })
    }

    /// Returns the surface in the frame of a camera whose rays are shifted by at most `shift_px` (px); `None` if no ray meets it.
    pub fn cast(&self, camera: &Camera, shift_px: f64) -> Option<Cast> {
        let solid_from_camera = self.world_from_solid.inv_mul(&camera.world_from_camera);
        let camera_from_solid = solid_from_camera.inverse();
        let outline = self.solid.outline();
        let range = if outline == Outline::HalfSpace {
            PixelRange::whole(camera)
        } else {
            let aabb = self.solid.aabb();
            let corner = |index: usize| {
                let sign = |bit: usize| if index & bit == 0 { -1.0 } else { 1.0 };
                let offset = Vector::new(sign(1), sign(2), sign(4)).component_mul(&aabb.half_extents);
                camera_from_solid * (aabb.center + offset)
            };
            PixelRange::of(camera, &std::array::from_fn::<Point, 8, _>(corner), shift_px)?
        };
        if outline == Outline::Other {
            let cast = |corners: &[Point; 3]| {
                CastTriangle::new(corners.map(|corner| camera_from_solid * corner), camera, shift_px)
            };
            return Some(Cast::Triangles(self.triangles.iter().filter_map(cast).collect()));
        }
        let origin = solid_from_camera.translation.vector.into();
        Some(Cast::Outline { outline, origin, solid_from_camera, range })
    }
}

impl CastTriangle {
    fn new(corners: [Point; 3], camera: &Camera, shift_px: f64) -> Option<Self> {
        let range = PixelRange::of(camera, &corners, shift_px)?;
        let [a, b, c] = corners.map(|corner| corner.coords);
        let normal = (b - a).cross(&(c - a));
        let height = normal.dot(&a);
        Some(Self { edges: [a.cross(&b), b.cross(&c), c.cross(&a)], normal, height, range })
    }

    /// Returns the depth (m) at which a ray with z = 1 from the camera meets the triangle, from its back alone for [`Side::Back`]. Exact negation of `a × b` is `b × a`,
    /// so a ray between two triangles with a common edge meets one of them at least.
    pub fn depth_m(&self, ray: &Vector, side: Side) -> Option<f64> {
        let sides = self.edges.map(|edge| edge.dot(ray));
        let is_met = sides.iter().all(|side| *side >= 0.0) || sides.iter().all(|side| *side <= 0.0);
        let speed = self.normal.dot(ray);
        let is_side = side == Side::Front || speed > 0.0;
        if !is_met || !is_side || speed == 0.0 {
            return None;
        }
        let depth_m = self.height / speed;
        (depth_m >= 0.0).then_some(depth_m)
    }
}

impl Cast {
    /// Calls `visit` with each pixel in these rows whose ray may meet the surface, and the depth (m) where it does, or where it leaves it. `ray` gives
    /// the direction of the ray of a pixel (u, v) in the camera frame, with z = 1.
    pub fn visit(
        &self,
        rows: &std::ops::Range<usize>,
        ray: &impl Fn(usize, usize) -> Vector,
        side: Side,
        mut visit: impl FnMut(usize, usize, f64),
    ) {
        match self {
            Self::Outline { outline, origin, solid_from_camera, range } => {
                let turn = solid_from_camera.rotation.to_rotation_matrix();
                for (u, v) in pixels(range, rows) {
                    if let Some(depth_m) = meeting(outline, origin, &(turn * ray(u, v)), side) {
                        visit(u, v, depth_m);
                    }
                }
            }
            Self::Triangles(triangles) => {
                for triangle in triangles {
                    for (u, v) in pixels(&triangle.range, rows) {
                        if let Some(depth_m) = triangle.depth_m(&ray(u, v), side) {
                            visit(u, v, depth_m);
                        }
                    }
                }
            }
        }
    }
}

fn pixels(range: &PixelRange, rows: &std::ops::Range<usize>) -> impl Iterator<Item = (usize, usize)> {
    let columns = range.columns.clone();
    let rows = range.rows.start.max(rows.start)..range.rows.end.min(rows.end);
    rows.flat_map(move |v| columns.clone().map(move |u| (u, v)))
}
