//! The target of a scenario as a physical object.

use cranny_collision::{Body, Part};
use cranny_shape::{ConvexParts, DecompositionSettings, Outline, TriangleSoup};
use cranny_spatial::{Pose, Vector};
use cranny_task::{LoadModel, Weight, robot_hand};

use crate::object::physics::TargetPhysics;
use crate::{
    DEFAULT_FRICTION, ObjectError, ObjectSettings, ObjectSource, ObjectType, RecipeBody, Scenario,
    ScenarioError,
};

/// Target of a scenario, with its pose.
#[derive(Clone, Debug)]
pub struct TargetObject {
    /// Object type of the target.
    pub object: ObjectType,
    /// Pose of the object's frame in the planning frame.
    pub world_from_object: Pose,
}

impl Scenario {
    /// Returns the triangles of the target, in the planning frame, normals outwards; `None` without a target. Each of several
    /// shapes contributes all its triangles, also those inside another shape.
    ///
    /// # Errors
    /// [`ScenarioError::ShapeFile`] for a shape without triangles.
    pub fn target_mesh(&self) -> Result<Option<TriangleSoup>, ScenarioError> {
        let body = self.target.map(|target| &self.world.bodies()[target]);
        body.map(|body| RecipeBody::of(body, &Pose::identity(), None)?.placed_soup()).transpose()
    }

    /// Returns mass and friction of the target: those of the scenario, otherwise those of its object.
    pub fn target_physics(&self) -> TargetPhysics {
        self.target.map_or(self.given_physics, |target| self.physics_of(target))
    }

    /// Returns the load model of grasps of the target by the robot's hand, for the mass and friction of [`Self::target_physics`];
    /// `None` if it cannot be computed ([`LoadModel`]).
    pub fn load_model(&self) -> Option<LoadModel> {
        self.robot.hand()?;
        let (friction, weight) = (self.target_physics().least_friction(), self.target_weight()?);
        LoadModel::by_hand(&self.world, self.target?, &robot_hand(&self.robot), (friction, weight))
    }

    /// Returns mass and rolling resistance of the target, and the mass distribution that the file of an object states; `None`
    /// without a target.
    pub fn target_weight(&self) -> Option<Weight> {
        self.target.map(|target| self.weight_of(target))
    }

    /// Returns the target as an object with mass and stable poses; `None` without a target. Mass and friction are those of
    /// `instead`, otherwise those of [`Self::target_physics`]; the friction is [`DEFAULT_FRICTION`] if neither states it.
    ///
    /// A target that is one object has that object's frame, convex parts and stable poses. Any other target has the mesh of
    /// [`Self::target_mesh`], with each shape cut into convex parts separately, and uniform density; the volume that shapes
    /// share counts once. Its frame is that of its only shape; for several shapes it is the one in which the scenario states
    /// them, or, if it states none, has the axes of the planning frame and its origin at the centre of their bounds. For a shape that is far from convex this takes up to several seconds.
    ///
    /// # Errors
    /// [`ObjectError::NoMass`] if the mass of the target is not given, [`ObjectError::Number`] for a number of `instead` that
    /// is not positive, [`ScenarioError::ShapeFile`] for a mesh that encloses no volume.
    pub fn target_object(&self, instead: &TargetPhysics) -> Result<Option<TargetObject>, ScenarioError> {
        let Some(target) = self.target else { return Ok(None) };
        let body = &self.world.bodies()[target];
        let physics = instead.or(self.target_physics());
        let Some(mass_kg) = physics.mass_kg else {
            return Err(ObjectError::NoMass { id: self.id.clone(), target: body.name.clone() }.into());
        };
        let friction = physics.friction.unwrap_or(DEFAULT_FRICTION.into());
        if let Some((source, world_from_object)) = self.placed_object() {
            let object = source.object()?.with_mass_and_friction(mass_kg, friction)?;
            return Ok(Some(TargetObject { object, world_from_object }));
        }
        let settings = ObjectSettings { friction, ..ObjectSettings::new(&body.name, mass_kg) };
        object_of_shapes(body, self.body_frames.get(&body.name), &settings).map(Some)
    }

    /// Returns the frame of the target, `world_from_object`, if it is one object: that of the object's mesh and grasps.
    pub fn world_from_object(&self) -> Option<Pose> {
        self.placed_object().map(|(_, world_from_object)| world_from_object)
    }

    /// Returns the object that the target consists of, if it is a single one, and its frame in the planning frame.
    pub(crate) fn placed_object(&self) -> Option<(&ObjectSource, Pose)> {
        let source = self.source_of(self.target?)?;
        self.world.bodies()[self.target?].parts.first().map(|part| (source, part.world_from_solid))
    }
}

/// Creates an object that is defined only by its shapes.
fn object_of_shapes(
    body: &Body,
    first_from_body: Option<&Pose>,
    settings: &ObjectSettings,
) -> Result<TargetObject, ScenarioError> {
    let placed = RecipeBody::of(body, &Pose::identity(), first_from_body)?;
    let world_from_object = match (&placed.shapes[..], first_from_body) {
        ([_], _) | (_, Some(_)) => placed.scene_from_body,
        _ => middle_of_bounds(&placed.placed_soup()?),
    };
    let object_from_body = world_from_object.inverse() * placed.scene_from_body;
    let (mut mesh, mut hulls) = (TriangleSoup::default(), Vec::new());
    for (body_from_shape, shape) in &placed.shapes {
        let mut soup = TriangleSoup::default();
        soup.append(&shape.soup()?, &(object_from_body * body_from_shape));
        hulls.extend(ConvexParts::of_mesh(&soup, &DecompositionSettings::default())?.parts);
        mesh.append(&soup, &Pose::identity());
    }
    let parts = ConvexParts::measured(&mesh, hulls)?;
    let is_exact = |part: &Part| !matches!(part.solid.outline(), Outline::Other | Outline::HalfSpace);
    let in_object = |part: &Part| (world_from_object.inverse() * part.world_from_solid, part.solid.clone());
    let solids =
        if body.parts.iter().all(is_exact) { body.parts.iter().map(in_object).collect() } else { Vec::new() };
    let object = ObjectType { solids, ..ObjectType::of_parts(mesh, parts, settings)? };
    Ok(TargetObject { object, world_from_object })
}

fn middle_of_bounds(soup: &TriangleSoup) -> Pose {
    let infinity = Vector::repeat(f64::INFINITY);
    let (low, high) = soup
        .vertices
        .iter()
        .fold((infinity, -infinity), |(low, high), v| (low.inf(&v.coords), high.sup(&v.coords)));
    let middle = (low + high) * 0.5;
    Pose::translation(middle.x, middle.y, middle.z)
}
