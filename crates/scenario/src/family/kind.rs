use cranny_shape::TriangleSoup;
use cranny_spatial::{Pose, Rotation, Vector, sin_cos};
use cranny_task::{PlaceGoal, PlaceRegion};
use strum::{EnumString, IntoStaticStr, VariantArray};

use crate::family::resized::{resized, scaled};
use crate::object::builtin::{self, builtin_object};
use crate::{
    FamilyError, ObjectSource, ObjectType, Obstacle, RecipeBody, RecipeShape, ScenarioError, TargetPhysics,
};

/// Environments of the paper, each with one difficulty parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, EnumString, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "kebab-case")]
pub enum Family {
    /// Screwdriver in an open shelf on a table (01); the parameter is its distance behind the front edge.
    Shelf,
    /// Ball under a table (02); the parameter is its distance behind the front edge.
    Table,
    /// Box behind two wall segments (03); the parameter is the gap between them.
    Gap,
    /// Banana on a pedestal behind a gate (04); the parameter is the opening of the gate.
    Gate,
}

/// Placement of an object in the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// Centre of its bounds along x of the scene, across the viewing direction of the robot, in metres.
    pub x_m: f64,
    /// Centre of its bounds along y of the scene, away from the robot, in metres.
    pub y_m: f64,
    /// Yaw relative to the orientation in the paper, in radians.
    pub yaw_rad: f64,
}

/// Region of the floor, or of an object's support, in metres in the scene.
#[derive(Clone, Copy, Debug)]
#[allow(clippy::struct_field_names, reason = "units, as everywhere")]
pub(crate) struct Region {
    /// Bounds: from, to.
    pub across_m: [f64; 2],
    pub away_m: [f64; 2],
    pub floor_m: f64,
    /// Maximum height of objects in it.
    pub tallest_m: f64,
}

/// Object of a family in its resting pose.
#[derive(Clone, Debug)]
pub(crate) struct Resting {
    /// Mesh of the object, in its own frame.
    pub mesh: TriangleSoup,
    /// Name in scenarios.
    pub name: &'static str,
    shape: RecipeShape,
    /// Mass and friction that the scenario must state because the shape does not.
    pub given_physics: TargetPhysics,
    /// Mass and friction, from any source.
    pub physics: TargetPhysics,
    /// Resting orientation, as in the paper.
    pub ground_from_object: Rotation,
    /// Height of the origin of its frame above the ground, in metres.
    pub lift_m: f64,
    /// Vector from the origin of its frame to the centre of its bounds, in axes of the ground, in metres.
    middle: Vector,
}

/// Position of the front of shelf and table in the scene, in metres along y.
const FRONT_M: f64 = 0.6;

/// Middle of the scene, in front of the robot, in metres along x.
const MIDDLE_M: f64 = 1.0;

impl Family {
    /// Returns the name in flags.
    pub fn name(self) -> &'static str {
        self.into()
    }

    /// Returns the family of that name.
    ///
    /// # Errors
    /// [`FamilyError::UnknownFamily`], which lists the names of the families.
    pub fn of_name(name: &str) -> Result<Self, ScenarioError> {
        let known = || Self::VARIANTS.iter().map(|family| family.name()).collect::<Vec<_>>().join(", ");
        name.parse().map_err(|_| FamilyError::UnknownFamily { name: name.to_owned(), known: known() }.into())
    }

    /// Returns the name of its difficulty parameter.
    pub fn parameter(self) -> &'static str {
        match self {
            Self::Shelf | Self::Table => "depth",
            Self::Gap => "gap",
            Self::Gate => "opening",
        }
    }

    /// Returns the range of the parameter, in metres: the object stays on its support, and walls and gate keep their legs.
    pub fn range_m(self) -> [f64; 2] {
        match self {
            Self::Shelf => [0.02, 0.78],
            Self::Table => [0.04, 0.76],
            Self::Gap => [0.02, 1.9],
            Self::Gate => [0.1, 1.9],
        }
    }

    /// Returns the default range of the parameter in large sets, in metres: the levels of the paper, and a little beyond.
    pub fn usual_range_m(self) -> [f64; 2] {
        match self {
            Self::Shelf => [0.10, 0.45],
            Self::Table => [0.15, 0.65],
            Self::Gap => [0.30, 0.64],
            Self::Gate => [0.54, 0.86],
        }
    }

    /// Returns the placement of the object in the paper at that parameter value (m): centres of bounds in the released scenes.
    pub fn paper_placement(self, parameter_m: f64) -> Placement {
        let (x_m, y_m) = match self {
            Self::Shelf => (0.993, FRONT_M + parameter_m),
            Self::Table => (MIDDLE_M, FRONT_M + parameter_m),
            Self::Gap => (0.912, 0.744),
            Self::Gate => (1.002, 1.242),
        };
        Placement { x_m, y_m, yaw_rad: 0.0 }
    }

    /// Returns the obstacles at that parameter value (m).
    pub(crate) fn obstacles(self, parameter_m: f64) -> Vec<RecipeBody> {
        let at = |name: &str, obstacle: Obstacle, x: f64, y: f64, z: f64| {
            let shape = |(middle, size): (Vector, Vector)| {
                (Pose::translation(middle.x, middle.y, middle.z), RecipeShape::Cuboid(size))
            };
            RecipeBody {
                name: name.to_owned(),
                scene_from_body: Pose::translation(x, y, z),
                shapes: obstacle.boxes().into_iter().map(shape).collect(),
                tilt_rad: None,
            }
        };
        let wall = Obstacle::WALL_SEGMENT;
        /// Width of a segment, in metres.
        const WALL_M: f64 = 0.8;
        let half_gap = 0.5 * parameter_m;
        match self {
            Self::Shelf => vec![
                at("table", Obstacle::TABLE, 0.0, FRONT_M, 0.0),
                at("shelf", Obstacle::SHELF, 0.77, FRONT_M, 0.5),
            ],
            Self::Table => vec![at("table", Obstacle::TABLE, 0.0, FRONT_M, 0.0)],
            Self::Gap => vec![
                at("left wall", wall, MIDDLE_M - half_gap - WALL_M, 0.5, 0.0),
                at("right wall", wall, MIDDLE_M + half_gap, 0.5, 0.0),
            ],
            Self::Gate => vec![
                at("gate", Obstacle::gate(parameter_m), 0.0, 0.4, 0.0),
                at("pedestal", Obstacle::PEDESTAL, 0.8, 1.1, 0.0),
            ],
        }
    }

    /// Returns the place goal outside of the narrow space, at least half a metre from the object's initial position.
    pub(crate) fn outside(self) -> PlaceGoal {
        let (on, middle, size_m) = match self {
            Self::Shelf => ("table", [0.25, 0.95, 0.5], [0.4, 0.6]),
            Self::Table => ("table", [0.4, 0.85, 0.5], [0.6, 0.4]),
            Self::Gap | Self::Gate => ("floor", [0.35, 0.05, 0.0], [0.5, 0.4]),
        };
        let [x, y, z] = middle;
        let spot = PlaceRegion::Surface { on: on.to_owned(), pose: Pose::translation(x, y, z), size_m };
        PlaceGoal { name: Self::OUTSIDE.to_owned(), spot }
    }

    /// Returns the mirror image of the place goal outside.
    pub(crate) fn other_side(self) -> PlaceGoal {
        let PlaceGoal { spot, .. } = self.outside();
        let spot = match spot {
            PlaceRegion::Surface { on, pose, size_m } => {
                let mirror_m = 2.0 * (MIDDLE_M - pose.translation.x);
                PlaceRegion::Surface { on, pose: Pose::translation(mirror_m, 0.0, 0.0) * pose, size_m }
            }
            target @ PlaceRegion::Target(_) => target,
        };
        PlaceGoal { name: Self::OTHER_SIDE.to_owned(), spot }
    }

    /// Returns columns that block the access, each one hand wide.
    pub(crate) fn columns(self) -> Vec<RecipeBody> {
        /// Width that a hand can grasp, in metres.
        const WIDTH_M: f64 = 0.07;
        let (across_m, away_m, height_m): (&[f64], f64, f64) = match self {
            Self::Shelf => (&[0.915, 1.065], 0.7, 0.33),
            Self::Table => (&[0.9, 1.1], 0.7, 0.3),
            Self::Gap => (&[0.92, 1.08], 0.55, 0.7),
            Self::Gate => (&[0.83, 1.0, 1.17], 0.45, 0.48),
        };
        let floor_m = if self == Self::Shelf { self.support_m() } else { 0.0 };
        let column = |(index, x_m): (usize, &f64)| {
            let middle = Pose::translation(*x_m, away_m, floor_m + 0.5 * height_m);
            let size = Vector::new(WIDTH_M, WIDTH_M, height_m);
            RecipeBody::new(&format!("column {}", index + 1), middle, RecipeShape::Cuboid(size))
        };
        across_m.iter().enumerate().map(column).collect()
    }

    /// Name of the place goal on the other side of the object.
    pub const OTHER_SIDE: &str = "other side";
    /// Name of the place goal outside.
    pub const OUTSIDE: &str = "outside";
    /// Name of the place goal at the object's position in the paper, in scenarios where the object starts outside.
    pub const INSIDE: &str = "inside";

    /// Returns the smallest width of the object between the fingers, in metres.
    pub(crate) fn object_width_m(self) -> f64 {
        match self {
            Self::Shelf => 0.032,
            Self::Table => 0.067,
            Self::Gap => 0.038,
            Self::Gate => 0.036,
        }
    }

    /// Returns the maximum distance of the object behind the front of the obstacles, in metres, with a small reserve: the
    /// required reach of a robot that drives up to them.
    pub(crate) fn beyond_front_m(self) -> f64 {
        match self {
            Self::Shelf | Self::Gap => 0.55,
            Self::Table => 0.7,
            Self::Gate => 1.0,
        }
    }

    /// Returns the height of the object's support, in metres.
    pub(crate) fn support_m(self) -> f64 {
        match self {
            Self::Shelf | Self::Gate => 0.5,
            Self::Table | Self::Gap => 0.0,
        }
    }

    /// Returns the region of the object in large sets; `None` along y if the parameter determines it.
    pub(crate) fn object_region(self) -> ([f64; 2], Option<[f64; 2]>) {
        match self {
            Self::Shelf => ([0.9, 1.1], None),
            Self::Table => ([0.5, 1.5], None),
            Self::Gap => ([0.85, 1.15], Some([0.7, 0.95])),
            Self::Gate => ([0.92, 1.08], Some([1.18, 1.38])),
        }
    }

    /// Returns the region of clutter in large sets.
    pub(crate) fn clutter_region(self) -> Region {
        let region = |across_m, away_m, floor_m, tallest_m| Region { across_m, away_m, floor_m, tallest_m };
        match self {
            Self::Shelf => region([0.85, 1.15], [0.65, 1.05], 0.5, 0.2),
            Self::Table => region([0.2, 1.8], [0.6, 1.35], 0.0, 0.25),
            Self::Gap => region([0.4, 1.6], [0.65, 1.2], 0.0, 0.4),
            Self::Gate => region([0.4, 1.6], [0.6, 1.05], 0.0, 0.5),
        }
    }

    /// Returns the object, scaled by `scale`, in the resting pose of the paper.
    pub(crate) fn resting(self, scale: f64) -> Result<Resting, ScenarioError> {
        let about_z = |degrees: f64| Rotation::from_axis_angle(&Vector::z_axis(), degrees.to_radians());
        let (object, name, ground_from_object) = match self {
            Self::Shelf => {
                let stable = &builtin_object("flat_screwdriver")?.stable_poses[0];
                let rest = stable.ground_from_body.rotation;
                let blade = rest * Vector::x();
                let heading = Rotation::from_axis_angle(&Vector::z_axis(), -libm::atan2(blade.y, blade.x));
                // The blade points towards the robot.
                ("flat_screwdriver", "screwdriver", about_z(-107.7) * heading * rest)
            }
            Self::Table => ("tennis_ball", "ball", Rotation::identity()),
            Self::Gap => {
                // The box lies on its narrow side, along the wall.
                let on_side = Rotation::from_axis_angle(&Vector::x_axis(), std::f64::consts::FRAC_PI_2);
                ("sugar_box", "box", about_z(90.0) * on_side)
            }
            Self::Gate => {
                // The banana is bent away from the robot, and upside down as far as a stable pose allows.
                let upside_down = Rotation::from_axis_angle(&Vector::x_axis(), std::f64::consts::PI);
                ("banana", "banana", at_rest(&builtin_object("banana")?, &(about_z(90.0) * upside_down)))
            }
        };
        let mesh = builtin::mesh(object)?;
        let source = ObjectSource::builtin(object)?;
        let physics = source.physics();
        // Spheres and boxes are checked faster than their meshes, but do not define a mass.
        let (shape, given_physics) = match self {
            Self::Table => (RecipeShape::Sphere(bounds(&mesh, &Rotation::identity()).1.x), physics),
            Self::Gap => (RecipeShape::Cuboid(bounds(&mesh, &Rotation::identity()).1 * 2.0), physics),
            Self::Shelf | Self::Gate => (RecipeShape::Object(source), TargetPhysics::default()),
        };
        let (mesh, shape, given_physics) = if scale < 1.0 {
            let (shape, physics) = resized(&shape, &physics, &mesh, scale);
            (scaled(&mesh, scale), shape, physics)
        } else {
            (mesh, shape, given_physics)
        };
        let physics = given_physics.or(physics);
        let (middle, half) = bounds(&mesh, &ground_from_object);
        let lift_m = half.z - middle.z;
        Ok(Resting { mesh, name, shape, given_physics, physics, ground_from_object, lift_m, middle })
    }
}

/// Returns the stable orientation of an object nearest to the given one.
fn at_rest(object: &ObjectType, ground_from_object: &Rotation) -> Rotation {
    let tilt = |rest: &Rotation| (ground_from_object * (rest.inverse() * Vector::z())).angle(&Vector::z());
    let rests = object.stable_poses.iter().map(|stable| stable.ground_from_body.rotation);
    let Some(rest) = rests.min_by(|a, b| tilt(a).total_cmp(&tilt(b))) else { return *ground_from_object };
    let (_, _, yaw) = (ground_from_object * rest.inverse()).euler_angles();
    Rotation::from_axis_angle(&Vector::z_axis(), yaw) * rest
}

/// Returns centre and half size of the bounds of a rotated mesh.
fn bounds(mesh: &TriangleSoup, turn: &Rotation) -> (Vector, Vector) {
    let infinity = Vector::repeat(f64::INFINITY);
    let turned = mesh.vertices.iter().map(|vertex| turn * vertex.coords);
    let (low, high) = turned.fold((infinity, -infinity), |(low, high), v| (low.inf(&v), high.sup(&v)));
    ((low + high) * 0.5, (high - low) * 0.5)
}

impl Resting {
    /// Returns the object as a body in the scene, on a support at height `support_m` above the floor.
    pub fn body(&self, placement: &Placement, support_m: f64) -> RecipeBody {
        RecipeBody::new(self.name, self.scene_from_object(placement, support_m), self.shape.clone())
    }

    pub fn scene_from_object(&self, placement: &Placement, support_m: f64) -> Pose {
        let turn = Rotation::from_axis_angle(&Vector::z_axis(), placement.yaw_rad);
        // The bounds are those in the paper; a yaw rotates their centre about the origin.
        let (sine, cosine) = sin_cos(placement.yaw_rad);
        let middle_x = cosine * self.middle.x - sine * self.middle.y;
        let middle_y = sine * self.middle.x + cosine * self.middle.y;
        let origin = Vector::new(placement.x_m - middle_x, placement.y_m - middle_y, support_m + self.lift_m);
        Pose::from_parts(origin.into(), turn * self.ground_from_object)
    }
}
