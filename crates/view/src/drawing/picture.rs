use std::ops::RangeInclusive;

use cranny_spatial::{Point, Pose};

use crate::drawing::draw_list::{DrawList, DrawVector, Lens, UNLINED};
use crate::drawing::ground::Ground;
use crate::drawing::light::Light;
use crate::drawing::painter::{Painter, Translucency};
use crate::drawing::sample_buffer::SampleBuffer;
use crate::look::colour::ScreenTable;
use crate::scene::Role;
use crate::{Camera, Colour, Material, Scene, StandardView, ViewError};

/// A picture: screen values (sRGB), row by row from the upper left.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    width: usize,
    height: usize,
    pixels: Vec<[u8; 3]>,
}

/// How a picture is made.
#[derive(Clone, Debug, PartialEq)]
pub struct PictureSettings {
    /// Points from left to right.
    pub width: usize,
    /// Points from top to bottom.
    pub height: usize,
    /// Samples a point against jagged edges: 1, 4 or 8. Default 4.
    pub samples: usize,
    /// Which instant of the motion is shown. Default: the last, or the start of a scene without motion.
    pub frame: Option<usize>,
    /// How many translucent poses show the way to that instant. Default 3.
    pub ghosts: usize,
    /// Where the eye is, instead of the standard view that was asked for.
    pub camera: Option<Camera>,
    /// Whether obstacles between the eye and the robot or the target can be seen through. Default: yes.
    pub see_through: SeeThrough,
}

/// Whether obstacles that hide what matters can be seen through.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum SeeThrough {
    /// Those between the eye and the robot, its gripper's way or the target.
    #[default]
    WhatHides,
    /// None: things as they are.
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

/// Ghosts: a robot of light blue glass.
const GHOST: u32 = 0x0046_8ad0;
const GHOST_OPACITY: f32 = 0.44;

/// How much denser a ghost is at its edges, which show its form.
const GHOST_RIM: f32 = 0.9;

/// Opacity of translucent things: glass in their own colour, with edges.
const GLASS_OPACITY: f32 = 0.45;
const GLASS_RIM: f32 = 0.35;

/// Links are things by the number of their node; bodies, as wholes, by theirs after all nodes.
const FIRST_BODY: usize = 1_000_000;
const TARGET: usize = 2_000_000;

impl Picture {
    /// How long a side can be, in points: beyond it memory runs out before patience does.
    pub const SIDES: RangeInclusive<usize> = 16..=8192;

    /// Draws a scene from a standard view.
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
        // 1. What can and what cannot be seen through.
        let stage = Stage::of(scene, frame, &camera, settings);
        // 2. Light, floor.
        let light = Light::new(&stage.solid);
        let lens = Lens::new(&camera, width, height);
        let (middle, reach_m) = scene.middle();
        let ground = Ground::new(scene.world_from_floor.as_ref(), middle, reach_m, &light);
        // 3. Solid things before the floor.
        let mut buffer = SampleBuffer::new(width, height, settings.samples);
        if let Some(nearness) = ground.nearness(&lens) {
            buffer.draw_floor(nearness);
        }
        buffer.draw(&stage.solid, &lens);
        let painter = Painter { lens: &lens, light: &light, ground: &ground };
        let mut canvas = vec![DrawVector::zeros(); width * height];
        painter.paint_solid(&stage.solid, &buffer, &mut canvas);
        // 4. What can be seen through, from the farthest on; each thing once, however often a ray meets it.
        let depth = buffer.nearness.clone();
        for (list, translucency) in &stage.translucent {
            buffer.restart(&depth);
            let region = buffer.draw(list, &lens);
            painter.paint_translucent(list, &buffer, &region, *translucency, &mut canvas);
        }
        // 5. As a screen shows it.
        let table = ScreenTable::new();
        let pixels = canvas.iter().map(|light| [0, 1, 2].map(|i| table.screen(toned(light[i])))).collect();
        Ok(Self { width, height, pixels })
    }

    /// Of one colour.
    pub fn blank(width: usize, height: usize, pixel: [u8; 3]) -> Self {
        Self { width, height, pixels: vec![pixel; width * height] }
    }

    /// Points from left to right.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Points from top to bottom.
    pub fn height(&self) -> usize {
        self.height
    }

    /// Row by row from the upper left: red, green, blue.
    pub fn pixels(&self) -> &[[u8; 3]] {
        &self.pixels
    }

    /// One row.
    pub(crate) fn row_mut(&mut self, row: usize) -> &mut [[u8; 3]] {
        &mut self.pixels[row * self.width..(row + 1) * self.width]
    }

    /// Red, green, blue of all points in a row.
    pub(crate) fn bytes(&self) -> Vec<u8> {
        self.pixels.concat()
    }
}

impl Scene {
    /// Names of the obstacles that [`Picture::of`] shows as glass from any of these views.
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

/// Light as a screen shows it: as it is up to this, then ever more slowly towards white, so that highlights keep
/// their form.
const LINEAR_UP_TO: f32 = 0.72;

fn toned(light: f32) -> f32 {
    if light <= LINEAR_UP_TO {
        return light;
    }
    let room = 1.0 - LINEAR_UP_TO;
    let beyond = (light - LINEAR_UP_TO) / room;
    LINEAR_UP_TO + room * beyond / (1.0 + beyond)
}

/// What is drawn, in the order in which it is drawn.
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
            if hiding.contains(&index) || is_glass {
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
                // An object that stands is no ghost.
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
            // Later ones are denser.
            let opacity = GHOST_OPACITY * (0.6 + 0.4 * (index + 1) as f32 / ghosts.len() as f32);
            let translucency = Translucency { opacity, rim: GHOST_RIM, has_edges: false };
            translucent.push((far, list, translucency));
        }
        translucent.sort_by(|a, b| b.0.total_cmp(&a.0));
        let translucent = translucent.into_iter().map(|(_, list, look)| (list, look)).collect();
        Self { solid, translucent }
    }
}

/// Outlines are drawn between links, and around bodies as wholes.
fn thing_of(node: usize, role: Role) -> u32 {
    let whole = match role {
        Role::Obstacle(body) => FIRST_BODY + body,
        Role::Target => TARGET,
        Role::Grasp { .. } | Role::GripperPath => return UNLINED,
        Role::Link(_) => node,
    };
    u32::try_from(whole).unwrap_or(u32::MAX)
}
