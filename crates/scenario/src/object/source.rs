use std::sync::Arc;

use cranny_shape::{Solid, TriangleSoup};

use crate::object::builtin::{self, Recipe};
use crate::object::physics::BUILTIN_ROLLING_M;
use crate::{DEFAULT_FRICTION, ObjectType, ScenarioError, TargetPhysics};

/// An object that a scenario names: a built-in one, which is made when it is asked for, or one that was read.
#[derive(Clone, Debug)]
pub struct ObjectSource(Kind);

#[derive(Clone, Debug)]
enum Kind {
    BuiltIn(&'static Recipe),
    /// Kept, because the folder of a packed scenario is gone by the time it is asked for.
    Own(Arc<ObjectType>),
}

impl ObjectSource {
    /// The built-in object of that name.
    ///
    /// # Errors
    /// [`ObjectError::Unknown`](crate::ObjectError::Unknown), which lists the names that there are.
    pub fn builtin(name: &str) -> Result<Self, ScenarioError> {
        Ok(Self(Kind::BuiltIn(builtin::recipe(name)?)))
    }

    /// The object with convex parts and stable poses; a built-in one is made now.
    ///
    /// # Errors
    /// None on a sound build.
    pub fn object(&self) -> Result<ObjectType, ScenarioError> {
        match &self.0 {
            Kind::BuiltIn(recipe) => recipe.object(),
            Kind::Own(object) => Ok(ObjectType::clone(object)),
        }
    }

    /// Mass and friction of the object, and of a built-in one its resistance to rolling.
    pub fn physics(&self) -> TargetPhysics {
        let (mass_kg, friction, rolling_m) = match &self.0 {
            Kind::BuiltIn(recipe) => (recipe.mass_kg, DEFAULT_FRICTION, Some(BUILTIN_ROLLING_M)),
            Kind::Own(object) => (object.mass_kg, object.friction, None),
        };
        TargetPhysics { mass_kg: Some(mass_kg), friction: Some(friction), rolling_m }
    }

    /// The name of a built-in object; None for one that was read.
    pub fn builtin_name(&self) -> Option<&'static str> {
        match &self.0 {
            Kind::BuiltIn(recipe) => Some(recipe.name),
            Kind::Own(_) => None,
        }
    }

    /// An object that was read; None for a built-in one.
    pub(crate) fn own(&self) -> Option<&ObjectType> {
        match &self.0 {
            Kind::BuiltIn(_) => None,
            Kind::Own(object) => Some(object),
        }
    }

    /// The mesh alone, in the object's frame.
    pub(crate) fn mesh(&self) -> Result<TriangleSoup, ScenarioError> {
        match &self.0 {
            Kind::BuiltIn(recipe) => recipe.mesh(),
            Kind::Own(object) => Ok(object.mesh.clone()),
        }
    }

    /// The volume of the mesh, in the object's frame.
    pub(crate) fn solid(&self) -> Result<Solid, ScenarioError> {
        Ok(match &self.0 {
            Kind::BuiltIn(recipe) => Solid::mesh(&recipe.mesh()?)?,
            Kind::Own(object) => object.solid()?,
        })
    }
}

impl From<ObjectType> for ObjectSource {
    fn from(object: ObjectType) -> Self {
        Self(Kind::Own(Arc::new(object)))
    }
}
