use std::collections::BTreeMap;

use cranny_collision::{Body, Part, ToolBound, World};
use cranny_grasp::GraspSet;
use cranny_robot::Location;
use cranny_shape::{Outline, ShapeError, Solid, TriangleSoup};
use cranny_spatial::{Pose, Vector};
use cranny_task::{PlaceGoal, Region};

use crate::layout::own_bounds::bounded;
use crate::scenario::in_frame;
use crate::{
    BodyColours, NamedTask, ObjectSource, OpenOptions, RecipeRobot, RobotSource, Scenario, ScenarioError,
    StatedSpeed, TargetPhysics,
};

/// Scenario before it is written to files. Poses are in the scene, whose floor is z = 0; grasps are in the planning frame.
#[derive(Clone, Debug)]
pub struct Recipe {
    /// Title of the scenario, in one line.
    pub title: String,
    /// Robot, and its pose in the scene.
    pub robot: RecipeRobot,
    /// Obstacles.
    pub obstacles: Vec<RecipeBody>,
    /// Object to grasp.
    pub target: Option<RecipeBody>,
    /// Mass and friction that the scenario states for the target; they take precedence over those of its object.
    pub given_physics: TargetPhysics,
    /// Start configuration (m, rad).
    pub start: Vec<f64>,
    /// Poses of the gripper in the planning frame.
    pub grasps: GraspSet,
    /// Known configurations at grasps (m, rad).
    pub ik: Vec<Vec<f64>>,
    /// Place goals of the target, in the scene.
    pub places: Vec<PlaceGoal>,
    /// Goal regions by name, in the scene.
    pub regions: BTreeMap<String, Region>,
    /// Tasks of several stages.
    pub tasks: Vec<NamedTask>,
    /// Mass and friction of obstacles, by name.
    pub physics: BTreeMap<String, TargetPhysics>,
    /// Bounds of the tool, in the scene.
    pub tool_bounds: Vec<ToolBound>,
    /// As [`Scenario::colours`].
    pub colours: BodyColours,
    /// As [`Scenario::joint_bounds`].
    pub joint_bounds: BTreeMap<String, [f64; 2]>,
    /// As [`Scenario::speeds`].
    pub speeds: Vec<StatedSpeed>,
}

/// A body of a [`Recipe`].
#[derive(Clone, Debug)]
pub struct RecipeBody {
    /// Name, unique in the scenario.
    pub name: String,
    /// Pose of the body in the scene.
    pub scene_from_body: Pose,
    /// Shapes of the body, each with its pose in the body.
    pub shapes: Vec<(Pose, RecipeShape)>,
    /// As [`Body::tilt_rad`].
    pub tilt_rad: Option<f64>,
}

/// Shape of a [`RecipeBody`]; sizes in metres.
#[derive(Clone, Debug)]
pub enum RecipeShape {
    /// Box with full lengths along x, y, z.
    Cuboid(Vector),
    /// Sphere of this radius.
    Sphere(f64),
    /// Cylinder: radius, and length along z.
    Cylinder(f64, f64),
    /// Capsule: radius, and length of the cylindrical section along z.
    Capsule(f64, f64),
    /// Object, with its mesh.
    Object(ObjectSource),
    /// Volume of a closed mesh.
    Mesh(TriangleSoup),
    /// Convex hull of a mesh.
    Hull(TriangleSoup),
}

impl Recipe {
    /// Returns a recipe for the files of a scenario in Cranny's layout: robot, bodies, start, grasps and known configurations.
    ///
    /// # Errors
    /// [`ScenarioError::OtherRobot`] if the files of the scenario's robot do not define it completely.
    pub fn of_scenario(scenario: &Scenario) -> Result<Self, ScenarioError> {
        let robot = RecipeRobot::of(&scenario.robot_source, scenario.robot.clone())?;
        let scene_from_planning = robot.scene_from_root;
        let mut obstacles = Vec::new();
        let mut target = None;
        for (index, body) in scenario.world.bodies().iter().enumerate() {
            if body.is_floor() {
                continue;
            }
            let frame = scenario.body_frames.get(&body.name);
            let mut body = RecipeBody::of(body, &scene_from_planning, frame)?;
            if let (Some(source), [(_, shape)]) = (scenario.source_of(index), &mut body.shapes[..]) {
                *shape = RecipeShape::Object(source.clone());
            }
            if scenario.target == Some(index) {
                target = Some(body);
            } else {
                obstacles.push(body);
            }
        }
        Ok(Self {
            title: format!("scenario {}", scenario.id),
            robot,
            obstacles,
            target,
            given_physics: scenario.given_physics,
            start: scenario.start.clone(),
            grasps: scenario.grasps.clone(),
            ik: scenario.ik.clone(),
            tasks: scenario.tasks.iter().map(|task| task.in_frame(&scene_from_planning)).collect(),
            physics: scenario.physics.clone(),
            colours: scenario.colours.clone(),
            tool_bounds: scenario
                .world
                .tool_bounds()
                .iter()
                .map(|b| b.in_frame(&scene_from_planning))
                .collect(),
            joint_bounds: scenario.joint_bounds.clone(),
            speeds: scenario.speeds.clone(),
            places: scenario.places.iter().map(|place| place.in_frame(&scene_from_planning)).collect(),
            regions: in_frame(&scenario.regions, &scene_from_planning),
        })
    }

    /// Returns the scenario that the files describe.
    ///
    /// # Errors
    /// [`ScenarioError`] for an invalid shape, or another robot with other joints.
    pub fn scenario(&self, id: &str, options: &OpenOptions) -> Result<Scenario, ScenarioError> {
        if let Some(other) = &options.robot {
            let robot = RecipeRobot::load(other)?;
            let options = OpenOptions { robot: None, ..options.clone() };
            return self.for_robot(robot).scenario(id, &options);
        }
        let planning_from_scene = self.robot.planning_from_scene();
        let place = Location { file: id.to_owned(), line: 1 };
        let bounds = self.joint_bounds.iter().map(|(joint, between)| (joint, *between, &place));
        Scenario {
            id: id.to_owned(),
            criterion: options.criterion.unwrap_or_default(),
            robot: bounded(self.robot.robot.clone(), bounds)?,
            robot_source: RobotSource::Other,
            world: self.world()?,
            target: self.target.as_ref().map(|_| self.obstacles.len()),
            sources: self
                .obstacles
                .iter()
                .chain(&self.target)
                .filter_map(|body| Some((body.name.clone(), body.source()?.clone())))
                .collect(),
            body_frames: self
                .obstacles
                .iter()
                .chain(&self.target)
                .filter_map(|body| Some((body.name.clone(), body.first_from_body()?)))
                .collect(),
            given_physics: self.given_physics,
            start: self.start.clone(),
            grasps: self.grasps.clone(),
            has_grasp_set: true,
            tasks: self.tasks.iter().map(|task| task.in_frame(&planning_from_scene)).collect(),
            physics: self.physics.clone(),
            colours: self.colours.clone(),
            joint_bounds: self.joint_bounds.clone(),
            speeds: self.speeds.clone(),
            places: self.places.iter().map(|place| place.in_frame(&planning_from_scene)).collect(),
            regions: in_frame(&self.regions, &planning_from_scene),
            ik: self.ik.clone(),
            export: None,
            seen: None,
            clouds: Vec::new(),
        }
        .with_checked_start(id)
    }

    /// Returns the recipe for another robot, with the start of that robot's files if they give one, and without the loads of
    /// grasps, which belong to the previous hand.
    fn for_robot(&self, robot: RecipeRobot) -> Self {
        let moved = robot.planning_from_scene() * self.robot.scene_from_root;
        let start = robot.robot.default_start().map_or_else(|| self.start.clone(), <[f64]>::to_vec);
        let grasps = self.grasps.moved(&moved).without_loads();
        Self { grasps, ik: Vec::new(), start, robot, ..self.clone() }
    }

    /// Returns mass and friction of the target: those of the recipe, otherwise those of its object.
    pub fn target_physics(&self) -> TargetPhysics {
        let source = self.target.as_ref().and_then(RecipeBody::source);
        self.given_physics.or(source.map(ObjectSource::physics).unwrap_or_default())
    }

    /// Returns the world in the planning frame: obstacles, target, floor.
    ///
    /// # Errors
    /// [`ScenarioError::ShapeFile`] for an invalid shape.
    pub fn world(&self) -> Result<World, ScenarioError> {
        let planning_from_scene = self.robot.planning_from_scene();
        let bodies = self.obstacles.iter().chain(&self.target).map(|body| body.body(&planning_from_scene));
        let mut bodies: Vec<Body> = bodies.collect::<Result<_, _>>()?;
        bodies.push(Body::floor(-self.robot.scene_from_root.translation.z));
        let bounds = self.tool_bounds.iter().map(|bound| bound.in_frame(&planning_from_scene)).collect();
        Ok(World::new(bodies)?.with_tool_bounds(bounds)?)
    }
}

impl RecipeBody {
    /// Returns a body of one shape.
    pub(crate) fn new(name: &str, scene_from_body: Pose, shape: RecipeShape) -> Self {
        Self {
            name: name.to_owned(),
            scene_from_body,
            shapes: vec![(Pose::identity(), shape)],
            tilt_rad: None,
        }
    }

    /// Returns the object that the body consists of, if it is a single one.
    fn source(&self) -> Option<&ObjectSource> {
        match &self.shapes[..] {
            [(_, RecipeShape::Object(source))] => Some(source),
            _ => None,
        }
    }

    /// Returns the body, in the planning frame.
    pub(crate) fn body(&self, planning_from_scene: &Pose) -> Result<Body, ScenarioError> {
        let planning_from_body = planning_from_scene * self.scene_from_body;
        let part = |(body_from_shape, shape): &(Pose, RecipeShape)| -> Result<Part, ScenarioError> {
            Ok(Part { world_from_solid: planning_from_body * body_from_shape, solid: shape.solid()? })
        };
        let parts = self.shapes.iter().map(part).collect::<Result<_, _>>()?;
        let own = self.source().and_then(ObjectSource::own);
        let center_of_mass = own.map(|own| own.center_of_mass);
        Ok(Body { name: self.name.clone(), parts, tilt_rad: self.tilt_rad, center_of_mass })
    }

    /// Returns the frame of a body of several shapes in that of its first shape.
    fn first_from_body(&self) -> Option<Pose> {
        let [(body_from_first, _), _, ..] = &self.shapes[..] else { return None };
        Some(body_from_first.inverse())
    }

    /// Converts a body of the planning frame. Its frame is that of its only shape; the frame of several is given in that of the
    /// first, or lies at their mean position.
    pub(crate) fn of(
        body: &Body,
        scene_from_planning: &Pose,
        first_from_body: Option<&Pose>,
    ) -> Result<Self, ScenarioError> {
        let places: Vec<Pose> =
            body.parts.iter().map(|part| scene_from_planning * part.world_from_solid).collect();
        let scene_from_body = match (&places[..], first_from_body) {
            ([only], _) => *only,
            ([first, ..], Some(first_from_body)) => first * first_from_body,
            _ => {
                let sum = places.iter().fold(Vector::zeros(), |sum, pose| sum + pose.translation.vector);
                Pose::from_parts((sum / places.len() as f64).into(), cranny_spatial::Rotation::identity())
            }
        };
        let shape = |(part, place): (&Part, &Pose)| -> Result<(Pose, RecipeShape), ScenarioError> {
            Ok((scene_from_body.inverse() * place, RecipeShape::of(&part.solid)?))
        };
        Ok(Self {
            name: body.name.clone(),
            scene_from_body,
            shapes: body.parts.iter().zip(&places).map(shape).collect::<Result<_, _>>()?,
            tilt_rad: body.tilt_rad,
        })
    }
}

impl RecipeShape {
    pub(crate) fn solid(&self) -> Result<Solid, ScenarioError> {
        Ok(match self {
            Self::Cuboid(size) => Solid::cuboid(size * 0.5)?,
            Self::Sphere(radius_m) => Solid::sphere(*radius_m)?,
            Self::Cylinder(radius_m, length_m) => Solid::cylinder(0.5 * length_m, *radius_m)?,
            Self::Capsule(radius_m, length_m) => Solid::capsule(0.5 * length_m, *radius_m)?,
            Self::Object(source) => source.solid()?,
            Self::Mesh(soup) => Solid::mesh(soup)?,
            Self::Hull(soup) => Solid::hull(&soup.vertices)?,
        })
    }

    pub(crate) fn of(solid: &Solid) -> Result<Self, ShapeError> {
        Ok(match solid.outline() {
            Outline::Cuboid { half_extents } => Self::Cuboid(half_extents * 2.0),
            Outline::Segment { half_length_m: 0.0, radius_m } => Self::Sphere(radius_m),
            Outline::Segment { half_length_m, radius_m } => Self::Capsule(radius_m, 2.0 * half_length_m),
            Outline::Cylinder { half_length_m, radius_m } => Self::Cylinder(radius_m, 2.0 * half_length_m),
            Outline::HalfSpace => return Err(ShapeError::Empty),
            Outline::Union => return Err(ShapeError::NoMesh),
            Outline::Other => {
                let is_convex = solid.support_point(&Vector::z()).is_some();
                let (points, _) = solid.bounding_points().unwrap_or_default();
                if is_convex {
                    Self::Hull(TriangleSoup::convex_hull(&points)?)
                } else {
                    // The points of a mesh are the corners of its triangles.
                    Self::Mesh(TriangleSoup::from_corners(points)?)
                }
            }
        })
    }
}
