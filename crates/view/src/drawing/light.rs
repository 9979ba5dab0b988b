use cranny_spatial::sin_cos;

use crate::Material;
use crate::drawing::draw_list::{DrawList, DrawPoint, DrawVector};
use crate::drawing::scan::{SampleGrid, ceiling, spans};

/// Lighting of a scene: a sun that casts shadows, and a sky whose light arrives from all unoccluded directions. Both use depth
/// maps rendered from the direction of their light.
pub(crate) struct Light {
    sun: DepthMap,
    /// One map for each of the evenly spread directions.
    sky: Vec<DepthMap>,
    /// Light of an open sky, tabulated over the vertical component of the normal, from −1 to 1.
    open: Vec<DrawVector>,
}

/// Visibility of the sky from a point of a surface.
#[derive(Clone, Copy)]
pub(crate) struct SkyShare {
    /// Light that arrives, as a share of what the open sky gives a surface with this normal.
    pub arriving: f32,
    /// Visible share of the sky directions that face the surface.
    pub openness: f32,
}

impl SkyShare {
    /// Unoccluded sky.
    pub const OPEN: Self = Self { arriving: 1.0, openness: 1.0 };
}

/// Visible point of a surface.
pub(crate) struct Seen {
    /// Surface normal, a unit vector.
    pub normal: DrawVector,
    /// Direction to the eye, a unit vector.
    pub to_eye: DrawVector,
    /// Share of the sun that arrives, times the cosine of its angle of incidence.
    pub sun: f32,
}

/// Direction of the sun in degrees: azimuth about z from x, and elevation above the ground. It stands behind the robot on the
/// right, so that shadows fall ahead and surfaces that face the standard views are lit.
const SUN_DEG: (f64, f64) = (-152.0, 52.0);

/// Colour of the sun: warm, and on a surface that faces it about as strong as the whole sky.
const SUN: [f32; 3] = [0.80, 0.75, 0.67];

/// Colours of the sky overhead and at the horizon.
const ZENITH: [f32; 3] = [0.80, 0.84, 0.90];
const HORIZON: [f32; 3] = [0.60, 0.60, 0.61];

/// Light that the ground reflects upwards.
const GROUND: [f32; 3] = [0.33, 0.32, 0.31];

/// Number of sky directions, and texels along a side of their maps: the edges between shadows are too faint to see.
const SKY_PATCHES: u32 = 48;
const SKY_SIDE: usize = 160;
const SUN_SIDE: usize = 2048;

/// Cell size of the simplified scene for the sky, as a share of the radius of the scene: a third of a texel of its maps.
const COARSE_SHARE: f32 = 0.004;

/// Number of entries of the open-sky table over the vertical component of the normal.
const TABLE_STEPS: usize = 64;

/// Offset of a query point from its surface, in texels, so that a surface does not shadow itself.
const LIFT_TEXELS: f32 = 1.6;

/// Half the width of the soft edge of the sun's shadow, in texels.
const SUN_BLUR: f32 = 3.0;

impl Light {
    /// Creates the lighting for the shadows of `casters`, which may be empty.
    pub fn new(casters: &DrawList) -> Self {
        let (center, radius_m) = casters.ball().unwrap_or((DrawPoint::origin(), 1.0));
        let map = |direction: DrawVector, side: usize, casters: &DrawList| {
            let mut map = DepthMap::new(direction, center, radius_m * 1.02, side);
            map.draw(casters);
            map
        };
        let coarse = casters.coarse(radius_m * COARSE_SHARE);
        let sky = (0..SKY_PATCHES).map(|index| map(sky_direction(index), SKY_SIDE, &coarse));
        let open = (0..TABLE_STEPS).map(|step| open_sky(2.0 * step as f32 / (TABLE_STEPS - 1) as f32 - 1.0));
        Self { sun: map(direction(SUN_DEG), SUN_SIDE, casters), sky: sky.collect(), open: open.collect() }
    }

    /// Returns the visibility of the sky from a surface point. It varies slowly across a surface.
    pub fn sky_share(&self, place: &DrawPoint, normal: &DrawVector) -> SkyShare {
        let (mut arriving, mut full, mut open, mut faced) = (0.0, 0.0, 0.0, 0.0);
        for patch in &self.sky {
            let cosine = normal.dot(&patch.towards);
            // Directions behind the surface count for neither.
            if cosine > 0.0 {
                let is_open = patch.is_open(place, normal);
                open += is_open;
                faced += 1.0;
                full += cosine;
                arriving += cosine * is_open;
            }
        }
        if faced == 0.0 {
            // The surface faces down: its only light comes from the ground.
            let up = place + DrawVector::z() * (2.0 / self.sun.texels_per_m);
            return SkyShare { arriving: 0.0, openness: 0.5 * self.sky[0].is_open(&up, normal) };
        }
        SkyShare { arriving: arriving / full, openness: open / faced }
    }

    /// Returns the share of the sun that reaches a surface, times the cosine of its angle of incidence.
    pub fn sun_share(&self, place: &DrawPoint, normal: &DrawVector) -> f32 {
        let cosine = normal.dot(&self.sun.towards).max(0.0);
        if cosine > 0.0 { cosine * self.sun.share_open(place, normal) } else { 0.0 }
    }

    /// Returns the cosine of the angle of incidence of the sun, without shadows.
    pub fn open_sun(&self, normal: &DrawVector) -> f32 {
        normal.dot(&self.sun.towards).max(0.0)
    }

    /// Returns the light of an open sky on a surface, which depends only on the vertical component of its normal.
    fn open_sky(&self, normal: &DrawVector) -> DrawVector {
        let step = (normal.z.clamp(-1.0, 1.0) + 1.0) * 0.5 * (TABLE_STEPS - 1) as f32;
        #[allow(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "between 0 and the number of steps"
        )]
        let below = (step as usize).min(TABLE_STEPS - 2);
        self.open[below].lerp(&self.open[below + 1], step - below as f32)
    }

    /// Computes the light that a surface sends to the eye.
    pub fn shade(
        &self,
        seen: &Seen,
        share: SkyShare,
        albedo: &DrawVector,
        material: &Material,
    ) -> DrawVector {
        let Seen { normal, to_eye, sun } = seen;
        let sun = DrawVector::from(SUN) * *sun;
        let below = (0.5 - 0.5 * normal.z) * share.openness.sqrt();
        let arriving = self.open_sky(normal) * share.arriving + sun + DrawVector::from(GROUND) * below;
        let diffuse = albedo.component_mul(&arriving) * (1.0 - 0.85 * material.metallic);
        // The sun's highlight (Blinn 1977, "Models of light reflection for computer synthesized pictures", whole), and the sky
        // mirrored at grazing angles (Schlick 1994, "An inexpensive BRDF model for physically-based rendering", whole).
        let cos_eye = normal.dot(to_eye).clamp(0.0, 1.0);
        let base = DrawVector::repeat(0.04).lerp(albedo, material.metallic);
        let grazing = (1.0 - cos_eye).powi(5) * (1.0 - material.roughness);
        let fresnel = base + (DrawVector::repeat(1.0) - base) * grazing;
        let mirrored = normal * (2.0 * normal.dot(to_eye)) - to_eye;
        let height = mirrored.z.clamp(0.0, 1.0);
        let around = if mirrored.z < 0.0 {
            DrawVector::from(GROUND)
        } else {
            DrawVector::from(HORIZON).lerp(&DrawVector::from(ZENITH), height) * 1.1
        };
        let mirror = fresnel.component_mul(&around) * share.openness;
        let half = (self.sun.towards + to_eye).try_normalize(1e-6).unwrap_or(*normal);
        let sharpness = 2.0 / (material.roughness * material.roughness).max(0.01);
        let lobe = raised(normal.dot(&half).max(0.0), sharpness * sharpness * 0.25 + 2.0);
        let highlight = fresnel.component_mul(&sun) * (lobe * (sharpness * sharpness * 0.04 + 0.4));
        diffuse + mirror + highlight
    }
}

/// Returns `base` to the power of `exponent` by repeated squaring. Powers of two suffice for a highlight, and are the same on
/// every machine.
fn raised(base: f32, exponent: f32) -> f32 {
    let (mut power, mut reached) = (base, 1.0);
    while reached < exponent {
        power *= power;
        reached *= 2.0;
    }
    power
}

fn direction((turn_deg, rise_deg): (f64, f64)) -> DrawVector {
    let (sin_turn, cos_turn) = sin_cos(turn_deg.to_radians());
    let (sin_rise, cos_rise) = sin_cos(rise_deg.to_radians());
    cranny_spatial::Vector::new(cos_rise * cos_turn, cos_rise * sin_turn, sin_rise).cast()
}

/// Returns one of the directions spread evenly over the upper hemisphere (spherical Fibonacci points; Keinert et al. 2015,
/// "Spherical Fibonacci mapping", whole).
fn sky_direction(index: u32) -> DrawVector {
    const GOLDEN_TURN_DEG: f64 = 137.507_764;
    let height = (f64::from(index) + 0.5) / f64::from(SKY_PATCHES);
    let across = (1.0 - height * height).sqrt();
    let (sine, cosine) = sin_cos((f64::from(index) * GOLDEN_TURN_DEG).to_radians());
    cranny_spatial::Vector::new(across * cosine, across * sine, height).cast()
}

/// Computes the light of the whole sky on a surface with this vertical component of its normal: the sum over evenly spread
/// directions. The mean of the cosine over a hemisphere is ½.
fn open_sky(height: f32) -> DrawVector {
    let normal = DrawVector::new((1.0 - height * height).max(0.0).sqrt(), 0.0, height);
    let light = |index: u32| {
        let direction = sky_direction(index);
        let light = DrawVector::from(HORIZON).lerp(&DrawVector::from(ZENITH), direction.z);
        light * normal.dot(&direction).max(0.0)
    };
    (0..SKY_PATCHES).map(light).sum::<DrawVector>() * (2.0 / SKY_PATCHES as f32)
}

/// Depth map of the scene, seen from a directional light.
struct DepthMap {
    /// Unit vector to the light.
    towards: DrawVector,
    right: DrawVector,
    up: DrawVector,
    /// Centre of the map.
    center: DrawPoint,
    texels_per_m: f32,
    side: usize,
    /// Height of the surface nearest to the light, along `towards` from the centre, in metres.
    height_m: Vec<f32>,
}

impl DepthMap {
    fn new(towards: DrawVector, center: DrawPoint, radius_m: f32, side: usize) -> Self {
        let aside = if towards.z.abs() > 0.9 { DrawVector::x() } else { DrawVector::z() };
        let right = aside.cross(&towards).normalize();
        let up = towards.cross(&right);
        let texels_per_m = 0.5 * side as f32 / radius_m.max(1e-3);
        let height_m = vec![f32::NEG_INFINITY; side * side];
        Self { towards, right, up, center, texels_per_m, side, height_m }
    }

    fn texel(&self, place: &DrawPoint) -> [f32; 3] {
        let from_center = place - self.center;
        let middle = 0.5 * self.side as f32;
        [
            middle + from_center.dot(&self.right) * self.texels_per_m,
            middle + from_center.dot(&self.up) * self.texels_per_m,
            from_center.dot(&self.towards),
        ]
    }

    fn draw(&mut self, casters: &DrawList) {
        let texels: Vec<[f32; 3]> = casters.positions.iter().map(|place| self.texel(place)).collect();
        let grid = SampleGrid { width: self.side, rows: self.side, offsets: &[0.5] };
        // First sample to the right of and below each corner. A triangle whose corners all lie between the same rows or columns
        // of samples covers none, as most triangles for the sky with its many directions.
        let below = |[x, y, _]: &[f32; 3]| [ceiling(x - 0.5, self.side), ceiling(y - 0.5, self.side)];
        let samples: Vec<[usize; 2]> = texels.iter().map(below).collect();
        for triangle in casters.casters() {
            let [a, b, c] = triangle.corners.map(|corner| samples[corner as usize]);
            if (a[0] == b[0] && b[0] == c[0]) || (a[1] == b[1] && b[1] == c[1]) {
                continue;
            }
            let corners = triangle.corners.map(|corner| texels[corner as usize]);
            spans(&corners, &grid, |span| {
                let begin = span.row * self.side;
                let row = &mut self.height_m[begin + span.columns.start..begin + span.columns.end];
                let mut height = span.depth;
                for texel in row {
                    *texel = texel.max(height);
                    height += span.step;
                }
            });
        }
    }

    /// Offsets a point from its surface, against self-shadowing, by texels whose number grows with the angle of incidence.
    fn lifted(&self, place: &DrawPoint, normal: &DrawVector, texels: f32) -> [f32; 3] {
        let cosine = normal.dot(&self.towards).abs();
        let lift_m = texels * (1.2 - cosine) / self.texels_per_m;
        let [x, y, height] = self.texel(&(place + normal * lift_m));
        [x, y, height + 0.6 * texels / self.texels_per_m]
    }

    /// Returns 1 if nothing lies between a point and the light, else 0, interpolated between four texels.
    fn is_open(&self, place: &DrawPoint, normal: &DrawVector) -> f32 {
        let [x, y, height] = self.lifted(place, normal, LIFT_TEXELS);
        let (x, y) = (x - 0.5, y - 0.5);
        let last = (self.side - 2) as f32;
        if !(x >= 0.0 && y >= 0.0 && x <= last && y <= last) {
            return 1.0;
        }
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "within the map")]
        let (column, row) = (x as usize, y as usize);
        let (across, down) = (x - column as f32, y - row as f32);
        let begin = row * self.side + column;
        let open = |index: usize| if self.height_m[index] <= height { 1.0 } else { 0.0 };
        let upper = open(begin) * (1.0 - across) + open(begin + 1) * across;
        let lower = open(begin + self.side) * (1.0 - across) + open(begin + self.side + 1) * across;
        upper * (1.0 - down) + lower * down
    }

    /// Returns the unoccluded share of a square of texels around a point, which gives the shadow a soft edge.
    fn share_open(&self, place: &DrawPoint, normal: &DrawVector) -> f32 {
        let [x, y, height] = self.lifted(place, normal, SUN_BLUR);
        let (x, y) = (x - 0.5, y - 0.5);
        let (low, high) = (SUN_BLUR, self.side as f32 - 2.0 - SUN_BLUR);
        if !(x >= low && y >= low && x <= high && y <= high) {
            return 1.0;
        }
        // Usually all texels are open or none is.
        let corners = [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0), (0.0, 0.0)];
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "within the map")]
        let probe = |(a, b): (f32, f32)| {
            let (column, row) = ((x + a * SUN_BLUR) as usize, (y + b * SUN_BLUR) as usize);
            u32::from(self.height_m[row * self.side + column] <= height)
        };
        match corners.into_iter().map(probe).sum::<u32>() {
            0 => return 0.0,
            5 => return 1.0,
            _ => {}
        }
        let (mut sum, mut weights) = (0.0, 0.0);
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "within the map")]
        let [columns, rows] =
            [x, y].map(|middle| (middle - SUN_BLUR).ceil() as usize..=(middle + SUN_BLUR).floor() as usize);
        for row in rows {
            let down = 1.0 - ((row as f32 - y) / (SUN_BLUR + 0.5)).abs();
            for column in columns.clone() {
                let weight = down * (1.0 - ((column as f32 - x) / (SUN_BLUR + 0.5)).abs());
                weights += weight;
                if self.height_m[row * self.side + column] <= height {
                    sum += weight;
                }
            }
        }
        sum / weights
    }
}
