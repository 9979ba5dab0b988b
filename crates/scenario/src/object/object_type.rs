use std::path::Path;

use cranny_grasp::{ASSUMED_FRICTION, HeldObject};
use cranny_shape::{
    ConvexParts, DecompositionSettings, RepairedMesh, Roundness, ShapeError, Solid, StablePose, TriangleSoup,
    UnionMoments, VolumeMoments, distinct_poses, stable_poses,
};
use cranny_spatial::nalgebra::Matrix3;
use cranny_spatial::{Point, Pose};

use crate::object::error::check_number;
use crate::{Friction, ObjectError, ScenarioError};

/// Type of graspable object: shape, mass, friction and stable poses. All quantities are in the object's frame, the frame of its
/// mesh; the density is uniform.
#[derive(Clone, Debug)]
pub struct ObjectType {
    /// Name of the object.
    pub name: String,
    /// Surface: closed, normals outwards, in metres.
    pub mesh: TriangleSoup,
    /// Convex parts that approximate the mesh, with the error of the approximation.
    pub parts: ConvexParts,
    /// Exact shape if it consists of boxes, balls, cylinders and capsules, each at its pose, or else empty; the mesh of a ball
    /// would roll from facet to facet.
    pub solids: Vec<(Pose, Solid)>,
    /// Rotational symmetry.
    pub roundness: Roundness,
    /// Mass, in kilograms.
    pub mass_kg: f64,
    /// Coefficient of friction between the object and the pads of a gripper.
    pub friction: Friction,
    /// Volume, in cubic metres.
    pub volume_m3: f64,
    /// Centre of mass, in metres.
    pub center_of_mass: Point,
    /// Inertia about the centre of mass, along the axes of the object's frame, in kg m².
    pub inertia_kg_m2: Matrix3<f64>,
    /// Stable poses, in order of decreasing probability; poses that differ by a rotation about the vertical and by the object's
    /// symmetry count as one (see [`distinct_poses`]). Poses that are too unlikely are not listed.
    pub stable_poses: Vec<StablePose>,
    /// Colour in pictures, if it has one: red, green and blue, 0 to 1, sRGB.
    pub colour: Option<[f64; 3]>,
}

/// Properties that a mesh does not define, and processing options.
#[derive(Clone, Debug, PartialEq)]
pub struct ObjectSettings {
    /// Name of the object.
    pub name: String,
    /// Mass, in kilograms; positive.
    pub mass_kg: f64,
    /// Coefficient of friction. Default [`DEFAULT_FRICTION`].
    pub friction: Friction,
    /// Settings for cutting the mesh into convex parts.
    pub decomposition: DecompositionSettings,
    /// Minimum probability of a listed stable pose, unless it is the most likely one. Default 0.005: a polyhedron with more
    /// than 200 equal faces counts as round.
    pub least_probability: f64,
}

impl ObjectSettings {
    /// Returns the defaults for an object of that name and mass (kg).
    pub fn new(name: impl Into<String>, mass_kg: f64) -> Self {
        Self {
            name: name.into(),
            mass_kg,
            friction: DEFAULT_FRICTION.into(),
            decomposition: DecompositionSettings::default(),
            least_probability: 0.005,
        }
    }
}

/// Coefficient of friction of an object if none is stated.
pub const DEFAULT_FRICTION: f64 = ASSUMED_FRICTION;

/// Coefficient of friction of all objects in the paper's object library, which another tool assumes for unknown objects; used
/// to evaluate the paper's grasps.
pub const PAPER_FRICTION: f64 = 0.24;

/// Maximum extent of a graspable object, in metres.
const LONGEST_M: f64 = 3.0;

/// Minimum extent of a graspable object, in metres.
const SHORTEST_M: f64 = 0.003;

impl ObjectType {
    /// Creates an object from its mesh, which is repaired if that is safe, and cut into convex parts by V-HACD.
    ///
    /// # Errors
    /// [`ObjectError::Size`] for a mesh in other units, [`ObjectError::Number`] for an invalid mass or friction,
    /// [`ScenarioError::ShapeFile`] for a mesh that cannot be repaired.
    pub fn from_mesh(
        soup: &TriangleSoup,
        settings: &ObjectSettings,
    ) -> Result<(Self, RepairedMesh), ScenarioError> {
        check_size(soup)?;
        let repaired = RepairedMesh::of(soup)?;
        let parts = ConvexParts::of_mesh(&repaired.soup, &settings.decomposition)?;
        Ok((Self::of_parts(repaired.soup.clone(), parts, settings)?, repaired))
    }

    /// Creates an object from a sound mesh and its convex parts.
    ///
    /// # Errors
    /// As [`Self::from_mesh`].
    pub(crate) fn of_parts(
        mesh: TriangleSoup,
        parts: ConvexParts,
        settings: &ObjectSettings,
    ) -> Result<Self, ScenarioError> {
        check_numbers(settings.mass_kg, settings.friction)?;
        let moments = UnionMoments::of_mesh(&mesh)?.moments;
        let mut poses = distinct_poses(&stable_poses(&mesh.vertices, &moments.center)?, &mesh)?;
        let likely = poses.iter().take_while(|pose| pose.probability >= settings.least_probability).count();
        poses.truncate(likely.max(1));
        Ok(Self {
            name: settings.name.clone(),
            roundness: Roundness::of_mesh(&mesh)?,
            mesh,
            parts,
            solids: Vec::new(),
            mass_kg: settings.mass_kg,
            friction: settings.friction,
            volume_m3: moments.volume_m3,
            center_of_mass: moments.center,
            inertia_kg_m2: moments.inertia_per_mass_m2 * settings.mass_kg,
            stable_poses: poses,
            colour: None,
        })
    }

    /// Returns the object with another mass (kg), distributed as before, and another friction.
    ///
    /// # Errors
    /// [`ObjectError::Number`] for a number that is not positive.
    pub fn with_mass_and_friction(self, mass_kg: f64, friction: Friction) -> Result<Self, ScenarioError> {
        check_numbers(mass_kg, friction)?;
        let inertia_kg_m2 = self.inertia_kg_m2 * (mass_kg / self.mass_kg);
        Ok(Self { mass_kg, friction, inertia_kg_m2, ..self })
    }

    /// Returns the held object in its own frame ([`LoadMeasure`](cranny_grasp::LoadMeasure)); `None` without a surface.
    pub fn held(&self) -> Option<HeldObject> {
        HeldObject::new(&self.mesh, &self.mass_moments(), Some(self.mass_kg), self.friction.low).ok()
    }

    /// Returns the mass moments in the object's frame, as stated in its file.
    pub fn mass_moments(&self) -> VolumeMoments {
        VolumeMoments {
            volume_m3: self.volume_m3,
            center: self.center_of_mass,
            inertia_per_mass_m2: self.inertia_kg_m2 / self.mass_kg,
        }
    }

    /// Returns the volume of the mesh, as a solid for a body.
    ///
    /// # Errors
    /// None for an object that was created here.
    pub fn solid(&self) -> Result<Solid, ShapeError> {
        Solid::mesh(&self.mesh)
    }
}

/// Checks that a mass (kg) and a coefficient of friction are positive.
pub(crate) fn check_numbers(mass_kg: f64, friction: Friction) -> Result<(), ObjectError> {
    check_number("mass", mass_kg)?;
    friction.check().map(|_| ())
}

fn check_size(soup: &TriangleSoup) -> Result<(), ScenarioError> {
    let Some(first) = soup.vertices.first() else { return Err(ShapeError::Empty.into()) };
    let corners = soup.vertices.iter().fold((*first, *first), |(low, high), p| (low.inf(p), high.sup(p)));
    let size_m = (corners.1 - corners.0).max();
    if size_m > LONGEST_M {
        Err(ObjectError::Size { file: String::new(), size_m, unit: "millimetres", scale: 0.001 }.into())
    } else if size_m < SHORTEST_M {
        Err(ObjectError::Size { file: String::new(), size_m, unit: "kilometres", scale: 1000.0 }.into())
    } else {
        Ok(())
    }
}

impl ScenarioError {
    /// Returns the error with the mesh file in which it was found.
    #[must_use]
    pub fn in_mesh(self, path: &Path) -> Self {
        match self {
            Self::ShapeFile(fault) => Self::ShapeFile(fault.in_file(path)),
            Self::Object(ObjectError::Size { size_m, unit, scale, .. }) => {
                ObjectError::Size { file: format!("{}: ", path.display()), size_m, unit, scale }.into()
            }
            fault => fault,
        }
    }
}
