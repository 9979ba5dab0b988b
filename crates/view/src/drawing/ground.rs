use cranny_spatial::Pose;

use crate::Colour;
use crate::drawing::draw_list::{DrawPoint, DrawVector, Lens};
use crate::drawing::light::{Light, SkyShare};

/// Floor and background: a light page with a grid that fades into it and receives shadows.
pub(crate) struct Ground {
    /// `None` if there is no floor.
    plane: Option<Plane>,
    page: DrawVector,
    line: DrawVector,
    /// Radius around the centre of the scene within which the grid is clear, in metres; it vanishes at twice this radius.
    reach_m: f32,
    middle: DrawPoint,
    spacing_m: f32,
    /// Direct sunlight on an unshadowed location of the floor.
    open_sun: f32,
}

struct Plane {
    normal: DrawVector,
    along: [DrawVector; 2],
    origin: DrawPoint,
}

/// Colours of the page and of its grid lines.
const PAGE: u32 = 0x00fb_fcfd;
const LINE: u32 = 0x00a3_aebb;

/// Candidate spacings of the grid for large scenes, a table top and a hand, in metres; every fourth line is stronger.
const SPACINGS_M: [f32; 3] = [0.25, 0.05, 0.01];

/// Minimum number of grid lines between the centre of the scene and its border.
const FEWEST_LINES: f32 = 2.0;

/// Weight of the sky in the light of the floor.
const SKY_WEIGHT: f32 = 0.62;

/// Width of the grid lines, in pixels.
const LINE_POINTS: f32 = 1.0;

impl Ground {
    pub fn new(world_from_floor: Option<&Pose>, middle: DrawPoint, reach_m: f32, light: &Light) -> Self {
        let plane = world_from_floor.map(|pose| {
            let pose = pose.cast::<f32>();
            Plane {
                normal: pose.rotation * DrawVector::z(),
                along: [pose.rotation * DrawVector::x(), pose.rotation * DrawVector::y()],
                origin: pose.translation.vector.into(),
            }
        });
        let open_sun = plane
            .as_ref()
            .map_or(1.0, |plane| light.sun_share(&(plane.origin + plane.normal * 1e4), &plane.normal));
        let color = |hex: u32| DrawVector::from(Colour::hex(hex).0);
        let spacing = SPACINGS_M.iter().find(|&spacing_m| spacing_m * FEWEST_LINES < reach_m);
        let spacing_m = *spacing.unwrap_or(&SPACINGS_M[2]);
        Self { plane, page: color(PAGE), line: color(LINE), spacing_m, reach_m, middle, open_sun }
    }

    /// Returns the reciprocal of the depth of the floor, negative where it is invisible: at the first pixel, and its increments
    /// to the right and down.
    pub fn nearness(&self, lens: &Lens) -> Option<[f32; 3]> {
        let plane = self.plane.as_ref()?;
        let height_m = (lens.eye - plane.origin).dot(&plane.normal);
        let down = |ray: DrawVector| -ray.dot(&plane.normal) / height_m;
        let first = down(lens.ray(0.0, 0.0));
        (height_m > 0.0).then(|| [first, down(lens.ray(1.0, 0.0)) - first, down(lens.ray(0.0, 1.0)) - first])
    }

    /// Returns the point of the floor at a position of the picture and its normal; `None` where it is absent or has faded.
    pub fn place(&self, lens: &Lens, x: f32, y: f32) -> Option<(DrawPoint, DrawVector)> {
        let (plane, place) = self.meet(lens, x, y)?;
        (self.fade(&place) > 0.0).then_some((place, plane.normal))
    }

    fn fade(&self, place: &DrawPoint) -> f32 {
        smooth_step((2.0 * self.reach_m - (place - self.middle).norm()) / self.reach_m)
    }

    /// Colour of the empty background.
    pub fn page(&self) -> DrawVector {
        self.page
    }

    /// Returns the colour of the floor at a position of the picture.
    pub fn colour(&self, lens: &Lens, x: f32, y: f32, light: &Light, share: SkyShare) -> DrawVector {
        let Some((plane, place)) = self.meet(lens, x, y) else { return self.page };
        let fade = self.fade(&place);
        let sun = light.sun_share(&place, &plane.normal) / self.open_sun.max(1e-3);
        let shadow = 1.0 - (SKY_WEIGHT * share.arriving + (1.0 - SKY_WEIGHT) * sun);
        let mut colour = self.page;
        let right = self.meet(lens, x + 1.0, y).map_or(place, |(_, place)| place);
        let below = self.meet(lens, x, y + 1.0).map_or(place, |(_, place)| place);
        for along in &plane.along {
            let at = |p: &DrawPoint| (p - plane.origin).dot(along);
            let point_m = (at(&right) - at(&place)).abs() + (at(&below) - at(&place)).abs();
            for (spacing_m, strength) in [(self.spacing_m, 0.28), (4.0 * self.spacing_m, 0.5)] {
                let cover = line_cover(at(&place), spacing_m, point_m) * strength * fade;
                colour = colour.lerp(&self.line, cover);
            }
        }
        colour * (1.0 - (shadow * fade).clamp(0.0, 0.9))
    }

    fn meet(&self, lens: &Lens, x: f32, y: f32) -> Option<(&Plane, DrawPoint)> {
        let plane = self.plane.as_ref()?;
        let ray = lens.ray(x, y);
        let distance = (plane.origin - lens.eye).dot(&plane.normal) / ray.dot(&plane.normal);
        (distance > 0.0 && distance.is_finite()).then(|| (plane, lens.eye + ray * distance))
    }
}

/// Returns the share of a pixel that a grid line covers. Lines fade where their spacing is below a few pixels.
fn line_cover(at_m: f32, spacing_m: f32, point_m: f32) -> f32 {
    let from_line_m = (at_m / spacing_m - (at_m / spacing_m).round()).abs() * spacing_m;
    let cover = (0.5 + 0.5 * LINE_POINTS - from_line_m / point_m.max(1e-9)).clamp(0.0, 1.0);
    cover * smooth_step(spacing_m / point_m.max(1e-9) / 6.0 - 0.5)
}

fn smooth_step(share: f32) -> f32 {
    let share = share.clamp(0.0, 1.0);
    share * share * (3.0 - 2.0 * share)
}
