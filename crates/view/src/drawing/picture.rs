use std::ops::RangeInclusive;

use cranny_spatial::{Point, Pose};

use crate::drawing::draw_list::{DrawList, DrawVector, Lens, UNLINED};
use crate::drawing::ground::Ground;
use crate::drawing::light::Light;
use crate::drawing::painter::{Painter, Translucency};
use crate::drawing::sample_buffer::{Region, SampleBuffer};
use crate::look::colour::ScreenTable;
use crate::scene::Role;
use crate::{Camera, Colour, Material, Scene, StandardView, ViewError};

/// Picture of screen values (sRGB), row by row from the upper left.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    width: usize,
    height: usize,
    pixels: Vec<[u8; 3]>,
}

/// Settings of a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct PictureSettings {
    /// Width in pixels.
    pub width: usize,
    /// Height in pixels.
    pub height: usize,
    /// Samples per pixel for anti-aliasing: 1, 4 or 8. Default 4.
    pub samples: usize,
    /// Index of the instant of the motion to show. Default: the last, or the start of a scene without motion.
    pub frame: Option<usize>,
    /// Number of translucent poses that show the motion up to that instant. Default 3.
    pub ghosts: usize,
    /// Camera that replaces the standard view.
    pub camera: Option<Camera>,
    /// Obstacles shown translucent. Default: those between the eye and the robot or the target.
    pub see_through: SeeThrough,
}

/// Selection of the obstacles that are shown translucent.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum SeeThrough {
    /// Obstacles between the eye and the robot, the path of its gripper or the target.
    #[default]
    WhatHides,
    /// No obstacle.
    Nothing,
}

impl Default for PictureSettings {
    fn default() -> Self {
        Self {
            width: 1280,
            height: 960,
            samples: 4,
            frame: None,
            ghosts: 3,
            camera: None,
            see_through: SeeThrough::default(),
        }
    }
}

/// Colour of ghosts: a robot of light blue glass.
const GHOST: u32 = 0x0046_8ad0;
const GHOST_OPACITY: f32 = 0.44;

/// Increase of the opacity of a ghost at grazing angles, which shows its shape.
const GHOST_RIM: f32 = 0.9;

/// Opacity of translucent obstacles: glass in their own colour, with edges.
const GLASS_OPACITY: f32 = 0.45;
const GLASS_RIM: f32 = 0.35;

/// First `thing` numbers of obstacles and of the target. A link has the number of its node, a body one for the whole.
const FIRST_BODY: usize = 1_000_000;
const TARGET: usize = 2_000_000;

impl Picture {
    /// Valid side lengths, in pixels: beyond them memory and drawing time become impractical.
    pub const SIDES: RangeInclusive<usize> = 16..=8192;

    /// Renders a scene from a standard view.
    ///
    /// # Errors
    /// [`ViewError::Size`].
    ///
    /// # Panics
    /// If the settings name an instant that the motion does not have.
    pub fn of(scene: &Scene, view: StandardView, settings: &PictureSettings) -> Result<Self, ViewError> {
        let &PictureSettings { width, height, .. } = settings;
        if [width, height].iter().any(|side| !Self::SIDES.contains(side)) {
            return Err(ViewError::Size { width, height, most: *Self::SIDES.end() });
        }
        let camera = settings.camera.unwrap_or_else(|| scene.camera(view, width as f64 / height as f64));
        let frame = settings.frame.or(scene.last_frame());
        // 1. Sort solid and translucent things.
        let stage = Stage::of(scene, frame, &camera, settings);
        // 2. Create light and floor.
        let light = Light::new(&stage.solid);
        let lens = Lens::new(&camera, width, height);
        let (middle, reach_m) = scene.middle();
        let ground = Ground::new(scene.world_from_floor.as_ref(), middle, reach_m, &light);
        // 3. Draw solid things in front of the floor.
        let mut buffer = SampleBuffer::new(width, height, settings.samples);
        if let Some(nearness) = ground.nearness(&lens) {
            buffer.draw_floor(nearness);
        }
        buffer.draw(&stage.solid, &lens);
        let painter = Painter { lens: &lens, light: &light, ground: &ground };
        let mut canvas = vec![DrawVector::zeros(); width * height];
        painter.paint_solid(&stage.solid, &buffer, &mut canvas);
        // 4. Blend translucent things from the farthest on, each at most once per ray.
        let depth = buffer.nearness.clone();
        let mut region = Region::whole(&buffer);
        for (list, translucency) in &stage.translucent {
            buffer.restart(&depth, &region);
            region = buffer.draw(list, &lens);
            painter.paint_translucent(list, &buffer, &region, *translucency, &mut canvas);
        }
        // 5. Convert light to screen values.
        let table = ScreenTable::new();
        let pixels = canvas.iter().map(|light| [0, 1, 2].map(|i| table.screen(toned(light[i])))).collect();
        Ok(Self { width, height, pixels })
    }

    /// Creates a picture of a single colour.
    pub fn blank(width: usize, height: usize, pixel: [u8; 3]) -> Self {
        Self { width, height, pixels: vec![pixel; width * height] }
    }

    /// Width in pixels.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Height in pixels.
    pub fn height(&self) -> usize {
        self.height
    }

    /// Pixels row by row from the upper left: red, green, blue.
    pub fn pixels(&self) -> &[[u8; 3]] {
        &self.pixels
    }

    /// Returns one row of pixels.
    pub(crate) fn row_mut(&mut self, row: usize) -> &mut [[u8; 3]] {
        &mut self.pixels[row * self.width..(row + 1) * self.width]
    }

    /// Returns the picture with 32 shades of each colour instead of 256, whose PNG file takes less than half the bytes.
    #[must_use]
    pub fn in_few_shades(mut self) -> Self {
        // The darkest shade stays black, the brightest white.
        self.pixels.iter_mut().flatten().for_each(|value| *value = (*value & 0xf8) | (*value >> 5));
        self
    }

    /// Returns red, green and blue of all pixels in sequence.
    pub(crate) fn bytes(&self) -> Vec<u8> {
        self.pixels.concat()
    }
}

impl Scene {
    /// Returns the names of the obstacles that [`Picture::of`] shows translucent in any of these views.
    pub fn seen_through(&self, views: &[StandardView], settings: &PictureSettings) -> Vec<String> {
        if settings.see_through == SeeThrough::Nothing {
            return Vec::new();
        }
        let aspect = settings.width as f64 / settings.height.max(1) as f64;
        let camera = |view: &StandardView| settings.camera.unwrap_or_else(|| self.camera(*view, aspect));
        let hiding = views.iter().flat_map(|view| self.hiding(&camera(view)));
        let mut names: Vec<String> = hiding.map(|node| self.nodes[node].name.clone()).collect();
        names.sort();
        names.dedup();
        names
    }
}

/// Upper end of the linear range of tone mapping; above it, light approaches white slowly, and highlights keep their shape.
const LINEAR_UP_TO: f32 = 0.72;

fn toned(light: f32) -> f32 {
    if light <= LINEAR_UP_TO {
        return light;
    }
    let room = 1.0 - LINEAR_UP_TO;
    let beyond = (light - LINEAR_UP_TO) / room;
    LINEAR_UP_TO + room * beyond / (1.0 + beyond)
}

/// Lists to draw, in order of drawing.
struct Stage {
    solid: DrawList,
    translucent: Vec<(DrawList, Translucency)>,
}

impl Stage {
    fn of(scene: &Scene, frame: Option<usize>, camera: &Camera, settings: &PictureSettings) -> Self {
        let world_from_nodes = scene.world_from_nodes(frame);
        let hiding = match settings.see_through {
            SeeThrough::WhatHides => scene.hiding(camera),
            SeeThrough::Nothing => Vec::new(),
        };
        let mut solid = DrawList::default();
        let mut translucent: Vec<(f64, DrawList, Translucency)> = Vec::new();
        let distance = |pose: &Pose| -(Point::from(pose.translation.vector) - camera.eye).dot(&camera.back());
        for (index, node) in scene.nodes.iter().enumerate() {
            let Some(mesh) = node.mesh.map(|mesh| &scene.meshes[mesh]) else { continue };
            let thing = thing_of(index, node.role);
            let pose = &world_from_nodes[index];
            let is_glass = mesh.pieces.iter().any(|piece| scene.materials[piece.material].opacity < 1.0);
            if hiding.binary_search(&index).is_ok() || is_glass {
                let mut list = DrawList::default();
                list.add(mesh, pose, thing, &scene.materials, Material::clone);
                let opacity = if is_glass { scene.opacity(mesh) } else { GLASS_OPACITY };
                translucent.push((
                    distance(pose),
                    list,
                    Translucency { opacity, rim: GLASS_RIM, has_edges: true },
                ));
            } else {
                solid.add(mesh, pose, thing, &scene.materials, Material::clone);
            }
        }
        let ghosts = scene.ghost_frames(frame, settings.ghosts);
        for (index, &ghost) in ghosts.iter().enumerate() {
            let poses = scene.world_from_nodes(Some(ghost));
            let mut list = DrawList::default();
            let mut far = 0.0;
            let look = |material: &Material| Material {
                colour: material.colour.mix(Colour::hex(GHOST), 0.75),
                roughness: 0.4,
                metallic: 0.0,
                ..material.clone()
            };
            for (node, pose) in scene.nodes.iter().zip(&poses) {
                // An object that does not move has no ghost.
                let is_moved = match node.role {
                    Role::Link(_) => true,
                    Role::Target => *pose != node.parent_from_node,
                    _ => false,
                };
                if let (true, Some(mesh)) = (is_moved, node.mesh) {
                    list.add(&scene.meshes[mesh], pose, 0, &scene.materials, look);
                    far = distance(pose);
                }
            }
            // Later ghosts are denser.
            let opacity = GHOST_OPACITY * (0.6 + 0.4 * (index + 1) as f32 / ghosts.len() as f32);
            let translucency = Translucency { opacity, rim: GHOST_RIM, has_edges: false };
            translucent.push((far, list, translucency));
        }
        translucent.sort_by(|a, b| b.0.total_cmp(&a.0));
        let layers = translucent.into_iter().map(|(_, list, look)| (list, look)).collect();
        Self { solid, translucent: joined(layers) }
    }
}

/// Maximum number of translucent things of equal translucency that are drawn one by one: each may cover the whole picture.
const MOST_LAYERS: usize = 256;

/// Joins consecutive layers if there are too many: those of equal translucency, and if more than twice [`MOST_LAYERS`] remain,
/// any, with the translucency of the farthest. Things of one layer do not show through each other.
fn joined(layers: Vec<(DrawList, Translucency)>) -> Vec<(DrawList, Translucency)> {
    let layers = joined_if(layers, |one, other| one == other);
    if layers.len() <= 2 * MOST_LAYERS { layers } else { joined_if(layers, |_, _| true) }
}

fn joined_if(
    layers: Vec<(DrawList, Translucency)>,
    fit: impl Fn(&Translucency, &Translucency) -> bool,
) -> Vec<(DrawList, Translucency)> {
    let at_once = layers.len().div_ceil(MOST_LAYERS);
    let mut joined: Vec<(DrawList, Translucency)> = Vec::new();
    let mut count = 0;
    for (list, look) in layers {
        if let Some((known, _)) = joined.last_mut().filter(|(_, known)| fit(known, &look) && count < at_once)
        {
            known.append(&list);
            count += 1;
        } else {
            joined.push((list, look));
            count = 1;
        }
    }
    joined
}

/// Number of the thing that a node belongs to: outlines are drawn between links, and around whole bodies.
fn thing_of(node: usize, role: Role) -> u32 {
    let whole = match role {
        Role::Obstacle(body) => FIRST_BODY + body,
        Role::Target => TARGET,
        Role::Grasp { .. } | Role::GripperPath => return UNLINED,
        Role::Link(_) => node,
    };
    u32::try_from(whole).unwrap_or(u32::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn many_translucent_things_become_few_layers_of_one_look() {
        let look = |opacity| Translucency { opacity, rim: GLASS_RIM, has_edges: true };
        let layers = |count: usize, opacity| (0..count).map(move |_| (DrawList::default(), look(opacity)));
        assert_eq!(joined(layers(MOST_LAYERS, 0.5).collect()).len(), MOST_LAYERS);
        let many: Vec<_> = layers(100_000, 0.5).chain(layers(1, 0.25)).chain(layers(100_000, 0.5)).collect();
        let few = joined(many);
        assert!(few.len() <= MOST_LAYERS + 2, "{}", few.len());
        assert_eq!(few.iter().filter(|(_, own)| *own == look(0.25)).count(), 1);
        let mixed = (0..10_000).flat_map(|_| layers(1, 0.5).chain(layers(1, 0.25)));
        assert_eq!(joined(mixed.collect()).len(), 254);
    }
}
