use cranny_shape::{Ball, Solid};
use cranny_spatial::{FARTHEST_M, Point, Pose, Rotation, Vector};

use crate::CollisionError;
use crate::body::tool_bound::ToolBound;

/// A solid of a body, with its pose.
#[derive(Clone, Debug)]
pub struct Part {
    /// Pose of the solid in the planning frame.
    pub world_from_solid: Pose,
    /// Shape of the solid.
    pub solid: Solid,
}

/// A named object in the world: a table, a wall, the object to be grasped, the floor.
#[derive(Clone, Debug)]
pub struct Body {
    /// Name in reports; unique in its world.
    pub name: String,
    /// Solids of the body.
    pub parts: Vec<Part>,
    /// Maximum tilt of the body, once it is held, relative to its pose before the grasp, in radians; `None` for no limit.
    pub tilt_rad: Option<f64>,
    /// Stated centre of mass, in the frame of its first solid (m); `None`: that of uniform density.
    pub center_of_mass: Option<Point>,
}

impl Body {
    /// Creates a body of one solid.
    pub fn new(name: impl Into<String>, world_from_solid: Pose, solid: Solid) -> Self {
        Self {
            name: name.into(),
            parts: vec![Part { world_from_solid, solid }],
            tilt_rad: None,
            center_of_mass: None,
        }
    }

    /// Creates the floor: everything below `height_m` (m) in the planning frame.
    pub fn floor(height_m: f64) -> Self {
        Self::new("floor", Pose::translation(0.0, 0.0, height_m), Solid::half_space())
    }
}

impl Body {
    /// Returns true for a floor: all its solids are half-spaces.
    pub fn is_floor(&self) -> bool {
        self.parts.iter().all(|part| part.solid.is_half_space())
    }

    /// Returns a ball around it, in the planning frame; `None` for an unbounded body, or one without solids.
    pub fn ball(&self) -> Option<Ball> {
        let balls: Vec<Ball> = self
            .parts
            .iter()
            .map(|part| {
                let Ball { center, radius_m } = part.solid.ball();
                Ball { center: part.world_from_solid * center, radius_m: *radius_m }
            })
            .collect();
        let sum = balls.iter().fold(Vector::zeros(), |sum, ball| sum + ball.center.coords);
        let center = Point::from(sum / balls.len() as f64);
        let radius_m =
            balls.iter().map(|ball| (ball.center - center).norm() + ball.radius_m).reduce(f64::max)?;
        radius_m.is_finite().then_some(Ball { center, radius_m })
    }
}

/// All bodies around the robot, with the direction of gravity and bounds on the tool.
#[derive(Clone, Debug, Default)]
pub struct World {
    bodies: Vec<Body>,
    up: Upwards,
    tool_bounds: Vec<ToolBound>,
}

/// Direction against gravity in the planning frame, a unit vector.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Upwards(Vector);

impl Default for Upwards {
    fn default() -> Self {
        Self(Vector::z())
    }
}

/// Distance, as a chord, below which a direction counts as an axis of the planning frame: rounding of a pose.
const ALONG_AXIS: f64 = 1e-9;

impl World {
    /// Creates a world of these bodies. Up is the normal of the floor if exactly one body is a half-space, otherwise the z axis
    /// of the planning frame; [`Self::with_up`] replaces it.
    ///
    /// # Errors
    /// [`CollisionError::Pose`] for a pose that is not finite, or farther away than [`FARTHEST_M`].
    pub fn new(bodies: Vec<Body>) -> Result<Self, CollisionError> {
        let is_usable = |pose: &Pose| {
            pose.translation.vector.iter().chain(pose.rotation.coords.iter()).all(|x| x.abs() <= FARTHEST_M)
        };
        for body in &bodies {
            if !body.parts.iter().all(|part| is_usable(&part.world_from_solid)) {
                return Err(CollisionError::Pose { name: body.name.clone() });
            }
        }
        let mut planes = bodies.iter().flat_map(|body| &body.parts).filter(|part| part.solid.is_half_space());
        let floor = planes.next().filter(|_| planes.next().is_none());
        let up = floor.map(|floor| floor.world_from_solid.rotation * Vector::z());
        let world = Self { bodies, ..Self::default() };
        Ok(match up {
            Some(up) => world.with_up(&up),
            None => world,
        })
    }

    /// Returns this world with gravity opposite to this direction of the planning frame, a unit vector.
    #[must_use]
    pub fn with_up(self, up: &Vector) -> Self {
        let is_z = (up - Vector::z()).norm() < ALONG_AXIS;
        Self { up: Upwards(if is_z { Vector::z() } else { *up }), ..self }
    }

    /// Returns this world with these bounds on the tool along every motion; they replace all earlier ones.
    ///
    /// # Errors
    /// [`CollisionError::ToolBound`] for a bound that is out of range.
    pub fn with_tool_bounds(self, tool_bounds: Vec<ToolBound>) -> Result<Self, CollisionError> {
        tool_bounds.iter().try_for_each(ToolBound::check)?;
        Ok(Self { tool_bounds, ..self })
    }

    /// Returns the bounds on the tool along every motion.
    pub fn tool_bounds(&self) -> &[ToolBound] {
        &self.tool_bounds
    }

    /// Returns a world of other bodies, with the gravity and the bounds of this one.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn with_bodies(&self, bodies: Vec<Body>) -> Result<Self, CollisionError> {
        Ok(Self { tool_bounds: self.tool_bounds.clone(), ..Self::new(bodies)?.with_up(&self.up.0) })
    }

    /// Returns the direction against gravity in the planning frame, a unit vector.
    pub fn up(&self) -> Vector {
        self.up.0
    }

    /// Returns a rotation that takes the z axis upwards; the identity if up is the z axis.
    pub fn world_from_level(&self) -> Rotation {
        Rotation::rotation_between(&Vector::z(), &self.up.0)
            .unwrap_or_else(|| Rotation::from_axis_angle(&Vector::x_axis(), std::f64::consts::PI))
    }

    /// Returns all bodies, in the given order.
    pub fn bodies(&self) -> &[Body] {
        &self.bodies
    }

    /// Returns the index of the body of that name.
    ///
    /// # Errors
    /// [`CollisionError::UnknownBody`], which lists the known names.
    pub fn body_index(&self, name: &str) -> Result<usize, CollisionError> {
        self.bodies.iter().position(|body| body.name == name).ok_or_else(|| CollisionError::UnknownBody {
            name: name.to_owned(),
            known: self.bodies.iter().map(|body| body.name.as_str()).collect::<Vec<_>>().join(", "),
        })
    }

    /// Returns the supports of `body`: the bodies that it touches when lowered by 1 cm, with a part whose box reaches no higher
    /// than the centre of `body`.
    pub fn supports_of(&self, body: usize) -> Vec<usize> {
        let level_from_world = Pose::from_parts(Vector::zeros().into(), self.world_from_level().inverse());
        let lowered = Pose::from_parts((-self.up.0 * SUPPORT_GAP_M).into(), Rotation::identity());
        let middle = self.bodies[body]
            .parts
            .iter()
            .map(|part| (level_from_world * part.world_from_solid * part.solid.ball().center).z)
            .fold(f64::INFINITY, f64::min);
        let is_support = |other: &Body| {
            other.parts.iter().any(|part| {
                let level_from_part = level_from_world * part.world_from_solid;
                let top = if part.solid.is_half_space() {
                    level_from_part.translation.z
                } else {
                    part.solid.aabb().transformed(&level_from_part).high().z
                };
                top <= middle
                    && self.bodies[body].parts.iter().any(|own| {
                        let gap = cranny_shape::separation(
                            &own.solid,
                            &(lowered * own.world_from_solid),
                            &part.solid,
                            &part.world_from_solid,
                            SUPPORT_GAP_M,
                        );
                        gap.upper_m <= 0.0
                    })
            })
        };
        (0..self.bodies.len()).filter(|&other| other != body && is_support(&self.bodies[other])).collect()
    }
}

/// Maximum gap below a resting object, in metres: the released objects float up to a few millimetres above their supports.
const SUPPORT_GAP_M: f64 = 0.01;
