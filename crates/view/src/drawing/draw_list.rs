use std::collections::HashMap;

use cranny_spatial::Pose;
use cranny_spatial::nalgebra::{Point3, Vector3};

use crate::{Camera, Colour, Material, Mesh};

/// Single-precision point, in metres in the planning frame.
pub(crate) type DrawPoint = Point3<f32>;
pub(crate) type DrawVector = Vector3<f32>;

/// Triangles in the planning frame, ready for drawing.
#[derive(Default)]
pub(crate) struct DrawList {
    pub positions: Vec<DrawPoint>,
    pub normals: Vec<DrawVector>,
    pub colours: Vec<Colour>,
    pub triangles: Vec<DrawTriangle>,
    pub surfaces: Vec<Surface>,
}

#[derive(Clone, Copy)]
pub(crate) struct DrawTriangle {
    pub corners: [u32; 3],
    /// Index of its surface.
    pub surface: u32,
    /// Quantized normal: triangles of a surface with equal values have equal shading within a pixel.
    pub facing: u16,
}

/// First `thing` number of lines, which have neither outline nor shadow.
pub(crate) const UNLINED: u32 = 3_000_000;

/// Instance of a mesh piece.
#[derive(Clone)]
pub(crate) struct Surface {
    pub material: Material,
    /// Number of the thing it belongs to; outlines are drawn between things.
    pub thing: u32,
}

impl DrawList {
    /// Adds a mesh at a pose, with its materials from `materials` modified by `look`.
    pub fn add(
        &mut self,
        mesh: &Mesh,
        world_from_mesh: &Pose,
        thing: u32,
        materials: &[Material],
        look: impl Fn(&Material) -> Material,
    ) {
        let pose = world_from_mesh.cast::<f32>();
        for piece in &mesh.pieces {
            let first = u32::try_from(self.positions.len()).unwrap_or(u32::MAX);
            let surface = u32::try_from(self.surfaces.len()).unwrap_or(u32::MAX);
            self.surfaces.push(Surface { material: look(&materials[piece.material]), thing });
            self.positions.extend(piece.positions.iter().map(|p| pose * DrawPoint::from(*p)));
            self.normals.extend(piece.normals.iter().map(|n| pose.rotation * DrawVector::from(*n)));
            if piece.colours.is_empty() {
                self.colours.resize(self.positions.len(), Colour::WHITE);
            } else {
                self.colours.extend_from_slice(&piece.colours);
            }
            for triangle in &piece.triangles {
                let corners = triangle.map(|corner| corner + first);
                let facing = self.facing(&corners);
                self.triangles.push(DrawTriangle { corners, surface, facing });
            }
        }
    }

    /// Appends all surfaces of another list.
    pub fn append(&mut self, other: &Self) {
        let count = |items: usize| u32::try_from(items).unwrap_or(u32::MAX);
        let (first, surface) = (count(self.positions.len()), count(self.surfaces.len()));
        self.positions.extend_from_slice(&other.positions);
        self.normals.extend_from_slice(&other.normals);
        self.colours.extend_from_slice(&other.colours);
        self.surfaces.extend_from_slice(&other.surfaces);
        self.triangles.extend(other.triangles.iter().map(|triangle| DrawTriangle {
            corners: triangle.corners.map(|corner| corner + first),
            surface: triangle.surface + surface,
            facing: triangle.facing,
        }));
    }

    pub fn corners(&self, triangle: usize) -> [&DrawPoint; 3] {
        self.triangles[triangle].corners.map(|corner| &self.positions[corner as usize])
    }

    /// Quantizes the normal of a triangle to about 20°.
    fn facing(&self, corners: &[u32; 3]) -> u16 {
        let [a, b, c] = corners.map(|corner| self.positions[corner as usize]);
        let normal = (b - a).cross(&(c - a)).try_normalize(0.0).unwrap_or_else(DrawVector::z);
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "each between 0 and 6")]
        let step = |x: f32| ((x + 1.0) * 3.0 + 0.5) as u16;
        step(normal.x) * 49 + step(normal.y) * 7 + step(normal.z)
    }

    /// Returns a simplified list that merges all corners in a cube of a grid (Rossignac & Borrel 1993, "Multi-resolution 3D
    /// approximations for rendering complex scenes", whole): fewer triangles that cover the same area, without colours and
    /// surfaces.
    pub fn coarse(&self, cell_m: f32) -> Self {
        #[allow(
            clippy::cast_possible_truncation,
            reason = "things are metres away and cells millimetres large"
        )]
        let cell = |p: &DrawPoint| [p.x, p.y, p.z].map(|x| (x / cell_m).floor() as i32);
        let mut known: HashMap<[i32; 3], u32> = HashMap::new();
        let mut coarse = Self::default();
        let moved: Vec<u32> = self
            .positions
            .iter()
            .map(|place| {
                *known.entry(cell(place)).or_insert_with(|| {
                    coarse.positions.push(*place);
                    u32::try_from(coarse.positions.len() - 1).unwrap_or(u32::MAX)
                })
            })
            .collect();
        for triangle in self.casters() {
            let corners = triangle.corners.map(|corner| moved[corner as usize]);
            let [a, b, c] = corners;
            if a != b && b != c && c != a {
                coarse.triangles.push(DrawTriangle { corners, ..*triangle });
            }
        }
        coarse
    }

    /// Returns the triangles that cast shadows. Lines are annotations and cast none.
    pub fn casters(&self) -> impl Iterator<Item = &DrawTriangle> {
        let is_line = |surface: u32| self.surfaces.get(surface as usize).is_some_and(|s| s.thing >= UNLINED);
        self.triangles.iter().filter(move |triangle| !is_line(triangle.surface))
    }

    /// Returns a ball around all corners, as centre and radius in metres; `None` if there are no corners.
    pub fn ball(&self) -> Option<(DrawPoint, f32)> {
        let first = *self.positions.first()?;
        let (low, high) =
            self.positions.iter().fold((first, first), |(low, high), p| (low.inf(p), high.sup(p)));
        let center = DrawPoint::from((low.coords + high.coords) * 0.5);
        let reach = self.positions.iter().map(|p| (p - center).norm_squared()).fold(0.0, f32::max);
        Some((center, reach.sqrt()))
    }
}

/// Camera with the size of its picture.
pub(crate) struct Lens {
    pub eye: DrawPoint,
    pub right: DrawVector,
    pub up: DrawVector,
    pub ahead: DrawVector,
    /// Focal length: pixels of the picture per unit of slope.
    pub focal: f32,
    pub middle: [f32; 2],
}

/// Near plane: minimum distance ahead of the eye at which anything is drawn, in metres.
pub(crate) const NEAR_M: f32 = 0.02;

impl Lens {
    pub fn new(camera: &Camera, width: usize, height: usize) -> Self {
        let single = |v: &cranny_spatial::Vector| v.cast::<f32>();
        #[allow(clippy::cast_possible_truncation, reason = "single precision is what is meant")]
        let slope = libm::tan(0.5 * camera.height_rad) as f32;
        Self {
            eye: camera.eye.cast::<f32>(),
            right: single(&camera.right),
            up: single(&camera.up),
            ahead: -single(&camera.back()),
            focal: 0.5 * height as f32 / slope,
            middle: [0.5 * width as f32, 0.5 * height as f32],
        }
    }

    /// Transforms a point to the camera frame: right, up, ahead.
    pub fn seen(&self, point: &DrawPoint) -> DrawVector {
        let from_eye = point - self.eye;
        DrawVector::new(from_eye.dot(&self.right), from_eye.dot(&self.up), from_eye.dot(&self.ahead))
    }

    /// Projects a point to the picture: pixel coordinates, then the reciprocal of the depth, which is linear there.
    pub fn on_screen(&self, seen: &DrawVector) -> [f32; 3] {
        let nearness = 1.0 / seen.z;
        let [x, y] = self.middle;
        [x + self.focal * seen.x * nearness, y - self.focal * seen.y * nearness, nearness]
    }

    /// Returns the ray through a position of the picture, one unit ahead.
    pub fn ray(&self, x: f32, y: f32) -> DrawVector {
        self.ahead
            + self.right * ((x - self.middle[0]) / self.focal)
            + self.up * ((self.middle[1] - y) / self.focal)
    }
}
