use crate::drawing::draw_list::{DrawList, DrawPoint, DrawVector, Lens, UNLINED};
use crate::drawing::ground::Ground;
use crate::drawing::light::{Light, Seen, SkyShare};
use crate::drawing::sample_buffer::{NOTHING, Region, SampleBuffer, weights};

/// Computes the light of each pixel from its samples.
pub(crate) struct Painter<'a> {
    pub lens: &'a Lens,
    pub light: &'a Light,
    pub ground: &'a Ground,
}

/// Translucency of a thing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Translucency {
    /// Share of the light behind it that it blocks where seen head-on.
    pub opacity: f32,
    /// Increase of the opacity where seen at a grazing angle, so that the shape is visible.
    pub rim: f32,
    /// True if its edges are drawn too: a flat thing could otherwise not be distinguished from its background.
    pub has_edges: bool,
}

/// Cosine of the angle between normals above which faces form an edge: 30°, more than between the triangles of round solids.
const SMOOTH: f32 = 0.866;

/// Share by which the outline of a thing is darker.
const OUTLINE: f32 = 0.5;

/// Opacity of the edges of a translucent thing, and their darkening: on a bright floor its faces are hardly visible.
const EDGE: [f32; 2] = [0.95, 0.75];

/// Maximum number of surfaces distinguished in a pixel: the number of its samples.
const MOST_SURFACES: usize = 8;

/// Samples of a pixel that show the same surface.
#[derive(Clone, Copy)]
struct Share {
    key: u64,
    samples: u32,
    triangle: u32,
    row: usize,
}

impl Painter<'_> {
    /// Paints every pixel of the canvas.
    pub fn paint_solid(&self, list: &DrawList, buffer: &SampleBuffer, canvas: &mut [DrawVector]) {
        let things = Things { list, buffer, has_edges: false };
        let per_point = buffer.offsets.len();
        let mut skies = SkyMemory::new(buffer.width);
        for row in 0..buffer.height {
            for column in 0..buffer.width {
                let sky = skies.block(row, column);
                let mut light = DrawVector::zeros();
                for share in things.shares(row, column).iter().filter(|share| share.samples > 0) {
                    let x = column as f32 + buffer.offsets[share.row];
                    let y = row as f32 + (share.row as f32 + 0.5) / per_point as f32;
                    let seen = if share.triangle == NOTHING {
                        self.floor(x, y, sky)
                    } else {
                        self.surface(list, share, x, y, Some(&mut *sky)).0
                    };
                    light += seen * share.samples as f32;
                }
                let line = things.edge(row, column);
                canvas[row * buffer.width + column] = light * ((1.0 - OUTLINE * line) / per_point as f32);
            }
        }
    }

    /// Blends a translucent thing over the canvas.
    pub fn paint_translucent(
        &self,
        list: &DrawList,
        buffer: &SampleBuffer,
        region: &Region,
        look: Translucency,
        canvas: &mut [DrawVector],
    ) {
        let things = Things { list, buffer, has_edges: look.has_edges };
        let per_point = buffer.offsets.len();
        for row in region.rows.clone() {
            for column in region.columns.clone() {
                let (mut light, mut cover) = (DrawVector::zeros(), 0.0);
                let line = things.edge(row, column);
                for share in things.shares(row, column).iter().filter(|share| share.samples > 0) {
                    if share.triangle == NOTHING {
                        continue;
                    }
                    let x = column as f32 + buffer.offsets[share.row];
                    let y = row as f32 + (share.row as f32 + 0.5) / per_point as f32;
                    let (seen, cosine) = self.surface(list, share, x, y, None);
                    let side = (1.0 - cosine) * (1.0 - cosine);
                    let opacity = (look.opacity * (1.0 - 0.4 * look.rim + 1.8 * look.rim * side)).min(0.95);
                    let [dense, dark] = if look.has_edges { EDGE } else { [0.75, OUTLINE] };
                    let opacity = opacity + (dense - opacity).max(0.0) * line;
                    let weight = opacity * share.samples as f32 / per_point as f32;
                    light += seen * (weight * (1.0 - dark * line));
                    cover += weight;
                }
                if cover > 0.0 {
                    let point = &mut canvas[row * buffer.width + column];
                    *point = *point * (1.0 - cover) + light;
                }
            }
        }
    }

    /// Returns the light from the floor at a position of the picture, or from the background.
    fn floor(&self, x: f32, y: f32, sky: &mut SkyBlock) -> DrawVector {
        let Some((place, normal)) = self.ground.place(self.lens, x, y) else { return self.ground.page() };
        let share = sky.share(u64::MAX, || self.light.sky_share(&place, &normal));
        self.ground.colour(self.lens, x, y, self.light, share)
    }

    /// Returns the light from a triangle at a position of the picture, and the cosine between its normal and the ray; without
    /// `sky`, there are no shadows.
    fn surface(
        &self,
        list: &DrawList,
        share: &Share,
        x: f32,
        y: f32,
        sky: Option<&mut SkyBlock>,
    ) -> (DrawVector, f32) {
        let triangle = share.triangle as usize;
        let ray = self.lens.ray(x, y);
        let corners = list.triangles[triangle].corners.map(|corner| corner as usize);
        let weights = weights(&self.lens.eye, &ray, list.corners(triangle));
        let (mut place, mut normal, mut tint) =
            (DrawVector::zeros(), DrawVector::zeros(), DrawVector::zeros());
        for (corner, weight) in corners.into_iter().zip(weights) {
            place += list.positions[corner].coords * weight;
            normal += list.normals[corner] * weight;
            tint += DrawVector::from(list.colours[corner].0) * weight;
        }
        let to_eye = -ray.normalize();
        let mut normal = normal.try_normalize(0.0).unwrap_or(to_eye);
        // Faces of a file may be wound in the wrong order; a visible face points to the eye. The face decides, because a smooth
        // normal may point slightly away at the silhouette of a round solid.
        let [a, b, c] = list.corners(triangle);
        let face = (b - a).cross(&(c - a));
        if (normal.dot(&face) < 0.0) != (face.dot(&to_eye) < 0.0) {
            normal = -normal;
        }
        let material = &list.surfaces[list.triangles[triangle].surface as usize].material;
        let albedo = DrawVector::from(material.colour.0).component_mul(&tint);
        let place = DrawPoint::from(place);
        let (sky_share, sun) = match sky {
            Some(sky) => (
                sky.share(share.key, || self.light.sky_share(&place, &normal)),
                self.light.sun_share(&place, &normal),
            ),
            None => (SkyShare::OPEN, self.light.open_sun(&normal)),
        };
        let seen = Seen { normal, to_eye, sun };
        (self.light.shade(&seen, sky_share, &albedo, material), normal.dot(&to_eye).max(0.0))
    }
}

/// Visibility of the sky for the surfaces in a block of pixels: it varies so slowly that one query per surface is enough.
#[derive(Clone, Default)]
struct SkyBlock {
    known: Vec<(u64, SkyShare)>,
}

impl SkyBlock {
    fn share(&mut self, key: u64, ask: impl FnOnce() -> SkyShare) -> SkyShare {
        if let Some((_, share)) = self.known.iter().find(|(known, _)| *known == key) {
            return *share;
        }
        let share = ask();
        self.known.push((key, share));
        share
    }
}

/// Cached blocks of the current rows.
struct SkyMemory {
    blocks: Vec<SkyBlock>,
    /// Row of blocks that is cached.
    row: usize,
}

/// Pixels along a side of a block.
const BLOCK: usize = 2;

impl SkyMemory {
    fn new(width: usize) -> Self {
        Self { blocks: vec![SkyBlock::default(); width.div_ceil(BLOCK)], row: usize::MAX }
    }

    fn block(&mut self, row: usize, column: usize) -> &mut SkyBlock {
        if self.row != row / BLOCK {
            self.row = row / BLOCK;
            self.blocks.iter_mut().for_each(|block| block.known.clear());
        }
        &mut self.blocks[column / BLOCK]
    }
}

/// Assignment of the samples of a buffer to things.
struct Things<'a> {
    list: &'a DrawList,
    buffer: &'a SampleBuffer,
    /// True if the edges between faces of one thing are lines too.
    has_edges: bool,
}

impl Things<'_> {
    /// Returns the different surfaces in a pixel, each with the number of its samples; unused entries have none.
    fn shares(&self, row: usize, column: usize) -> [Share; MOST_SURFACES] {
        let mut shares = [Share { key: 0, samples: 0, triangle: 0, row: 0 }; MOST_SURFACES];
        for sample in 0..self.buffer.offsets.len() {
            let triangle = self.triangle(row, column, sample);
            let key = if triangle == NOTHING {
                u64::MAX
            } else {
                let known = &self.list.triangles[triangle as usize];
                u64::from(known.surface) << 16 | u64::from(known.facing)
            };
            for share in &mut shares {
                if share.samples == 0 {
                    *share = Share { key, samples: 1, triangle, row: sample };
                    break;
                }
                if share.key == key {
                    share.samples += 1;
                    break;
                }
            }
        }
        shares
    }

    /// Returns the share of a pixel at the edge between two things.
    fn edge(&self, row: usize, column: usize) -> f32 {
        let samples = self.buffer.offsets.len();
        let (right, below) = ((column + 1).min(self.buffer.width - 1), (row + 1).min(self.buffer.height - 1));
        let mut count = 0;
        for sample in 0..samples {
            let here = self.triangle(row, column, sample);
            let (beside, under) = (self.triangle(row, right, sample), self.triangle(below, column, sample));
            if here == beside && here == under {
                continue;
            }
            let is_lined = |thing: u32| thing < UNLINED || thing == NOTHING;
            let differs = |other: u32| {
                let things = [self.thing(here), self.thing(other)];
                things.into_iter().all(is_lined)
                    && (things[0] != things[1] || (self.has_edges && self.is_edge(here, other)))
            };
            count += u32::from(differs(beside) || differs(under));
        }
        count as f32 / samples as f32
    }

    fn triangle(&self, row: usize, column: usize, sample: usize) -> u32 {
        self.buffer.triangle[(row * self.buffer.offsets.len() + sample) * self.buffer.width + column]
    }

    /// Returns true if two triangles of the same thing meet at an edge.
    fn is_edge(&self, one: u32, other: u32) -> bool {
        let normal = |triangle: u32| {
            let [a, b, c] = self.list.corners(triangle as usize);
            (b - a).cross(&(c - a)).try_normalize(0.0)
        };
        one != NOTHING
            && other != NOTHING
            && one != other
            && normal(one).zip(normal(other)).is_some_and(|(one, other)| one.dot(&other).abs() < SMOOTH)
    }

    fn thing(&self, triangle: u32) -> u32 {
        if triangle == NOTHING {
            return NOTHING;
        }
        self.list.surfaces[self.list.triangles[triangle as usize].surface as usize].thing
    }
}
