use cranny_spatial::Vector;
use rayon::prelude::*;

use crate::rendering::interval::Side;
use crate::rendering::surface::Cast;
use crate::{Camera, DepthImage, SensedScene};

/// Depth image without error, and the segment that each pixel shows.
#[derive(Clone, Debug, PartialEq)]
pub struct Render {
    /// True depths at the centres of the pixels; not valid where a ray meets nothing, or starts within a solid.
    pub depth: DepthImage,
    /// Segment of each pixel, row by row: 0 for none, otherwise the number of an entry of [`SensedScene::segments`], from 1.
    pub segments: Vec<u16>,
}

impl Render {
    /// Returns true if all surfaces are at least this depth (m) before the camera, and it is in none of the solids.
    pub fn has_room(&self, least_m: f64) -> bool {
        // Rays that start within a solid have a segment, but no depth.
        let mut pixels = self.segments.iter().zip(self.depth.depths_m());
        pixels.all(|(segment, depth_m)| *segment == 0 || f64::from(*depth_m) >= least_m)
    }
}

/// Meeting of a ray with the scene.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Meeting {
    /// Depth along the optical axis (m); infinite for none.
    pub depth_m: f64,
    pub segment: u16,
}

const NOTHING: Meeting = Meeting { depth_m: f64::INFINITY, segment: 0 };

/// Rows that one task renders.
const ROWS: usize = 16;

/// Rays of all pixels.
pub(crate) struct Rays<'a> {
    pub camera: &'a Camera,
    /// Shift of the ray of each pixel along both image axes (px), row by row; empty for none.
    pub shifts_px: &'a [[f64; 2]],
    /// Maximum shift, in pixels.
    pub most_shift_px: f64,
}

impl<'a> Rays<'a> {
    /// Rays through the centres of all pixels.
    pub fn centres(camera: &'a Camera) -> Self {
        Self { camera, shifts_px: &[], most_shift_px: 0.0 }
    }

    fn ray(&self, u: usize, v: usize) -> Vector {
        let [du, dv] = self.shifts_px.get(v * self.camera.width_px + u).copied().unwrap_or_default();
        self.camera.ray(u as f64 + du, v as f64 + dv)
    }
}

impl SensedScene {
    /// Renders the depths and segments that a camera sees, without error.
    ///
    /// The ray through the centre of each pixel is intersected with the true solids: cuboids, balls, capsules, cylinders and
    /// half-spaces by their equations, hulls and meshes by their triangles. The nearest surface counts, at any distance; of
    /// equally near ones, the first in the order of the segments.
    pub fn render(&self, camera: &Camera) -> Render {
        let met = self.meetings(&Rays::centres(camera), Side::Front, |_| true);
        #[allow(clippy::cast_possible_truncation, reason = "depths are stored as f32")]
        let depths_m = met.iter().map(|met| met.depth_m as f32).collect();
        Render {
            depth: DepthImage::of_camera(camera, depths_m),
            segments: met.iter().map(|met| met.segment).collect(),
        }
    }

    /// Returns the nearest meeting of each ray with this side of the segments in question, row by row. For the back, the depth is that at
    /// which the ray first leaves a solid, [`f64::MAX`] for a half-space.
    pub(crate) fn meetings(&self, rays: &Rays, side: Side, is_meant: impl Fn(u16) -> bool) -> Vec<Meeting> {
        let camera = rays.camera;
        let casts: Vec<(u16, Cast)> = self
            .surfaces()
            .filter(|(segment, _)| is_meant(*segment))
            .filter_map(|(segment, surface)| Some((segment, surface.cast(camera, rays.most_shift_px)?)))
            .collect();
        let mut met = vec![NOTHING; camera.pixel_count()];
        met.par_chunks_mut(ROWS * camera.width_px).enumerate().for_each(|(band, met)| {
            let rows = band * ROWS..((band + 1) * ROWS).min(camera.height_px);
            for (segment, cast) in &casts {
                cast.visit(&rows, &|u, v| rays.ray(u, v), side, |u, v, depth_m| {
                    let place = &mut met[(v - rows.start) * camera.width_px + u];
                    if depth_m < place.depth_m {
                        *place = Meeting { depth_m, segment: *segment };
                    }
                });
            }
        });
        met
    }
}
