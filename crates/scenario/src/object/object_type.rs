use std::path::Path;

use cranny_grasp::{ASSUMED_FRICTION, HeldObject};
use cranny_shape::{
    ConvexParts, DecompositionSettings, RepairedMesh, Roundness, ShapeError, Solid, StablePose, TriangleSoup,
    UnionMoments, VolumeMoments, distinct_poses, stable_poses,
};
use cranny_spatial::nalgebra::Matrix3;
use cranny_spatial::{Point, Pose};

use crate::{ObjectError, ScenarioError};

/// A type of object that can be grasped: its shape, and how it weighs, slides and rests. Everything is in the
/// object's frame, the frame of its mesh; density is uniform.
#[derive(Clone, Debug)]
pub struct ObjectType {
    /// What it is called.
    pub name: String,
    /// Its surface: closed, normals outwards, in metres.
    pub mesh: TriangleSoup,
    /// Convex bodies that stand for it, and how well.
    pub parts: ConvexParts,
    /// Its shape, exactly, as far as it is one or several of boxes, balls, cylinders and capsules, each at its pose; else
    /// empty. A ball that is a mesh rolls from facet to facet.
    pub solids: Vec<(Pose, Solid)>,
    /// Its rotational symmetry.
    pub roundness: Roundness,
    /// Its mass, in kilograms.
    pub mass_kg: f64,
    /// The coefficient of friction between it and the pads of a gripper.
    pub friction: f64,
    /// Its volume, in cubic metres.
    pub volume_m3: f64,
    /// Its centre of mass.
    pub center_of_mass: Point,
    /// Its inertia about the centre of mass, along the axes of the object's frame, in kg m².
    pub inertia_kg_m2: Matrix3<f64>,
    /// How it comes to rest, the likeliest first; of poses that differ by a turn about the vertical and its own
    /// symmetry one (see [`distinct_poses`]). What is missing to a sum of 1 are poses that are too
    /// unlikely to be listed.
    pub stable_poses: Vec<StablePose>,
}

/// What a mesh does not say of an object, and how it is worked up.
#[derive(Clone, Debug, PartialEq)]
pub struct ObjectSettings {
    /// What the object is called.
    pub name: String,
    /// Its mass, in kilograms; positive.
    pub mass_kg: f64,
    /// The coefficient of friction; positive. Default [`DEFAULT_FRICTION`].
    pub friction: f64,
    /// How the mesh is cut into convex parts.
    pub decomposition: DecompositionSettings,
    /// Stable poses less likely than this are not listed; the likeliest always is. Default 0.005: a polyhedron
    /// with more than 200 equal faces is round.
    pub least_probability: f64,
}

impl ObjectSettings {
    /// The defaults, for an object of that name and mass (kg).
    pub fn new(name: impl Into<String>, mass_kg: f64) -> Self {
        Self {
            name: name.into(),
            mass_kg,
            friction: DEFAULT_FRICTION,
            decomposition: DecompositionSettings::default(),
            least_probability: 0.005,
        }
    }
}

/// The coefficient of friction of an object of which none is stated.
pub const DEFAULT_FRICTION: f64 = ASSUMED_FRICTION;

/// The coefficient of friction that the paper's object library gives all its objects: it is what another tool assumes of
/// the unknown, and stays what the paper's grasps are measured with.
pub const PAPER_FRICTION: f64 = 0.24;

/// Nothing that a hand grasps is longer, in metres.
const LONGEST_M: f64 = 3.0;

/// Nothing that a hand grasps is shorter, in metres.
const SHORTEST_M: f64 = 0.003;

impl ObjectType {
    /// An object from its mesh, repaired where that is safe, cut into convex parts by V-HACD.
    ///
    /// # Errors
    /// [`ObjectError::Size`] for a mesh in other units, [`ObjectError::Number`] for a mass or
    /// friction that is none, [`ScenarioError::ShapeFile`] for a mesh that cannot be repaired.
    pub fn from_mesh(
        soup: &TriangleSoup,
        settings: &ObjectSettings,
    ) -> Result<(Self, RepairedMesh), ScenarioError> {
        check_size(soup)?;
        let repaired = RepairedMesh::of(soup)?;
        let parts = ConvexParts::of_mesh(&repaired.soup, &settings.decomposition)?;
        Ok((Self::of_parts(repaired.soup.clone(), parts, settings)?, repaired))
    }

    /// An object from a sound mesh and its convex parts.
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
        })
    }

    /// The same object of another mass (kg), with the same distribution of it, and another friction.
    ///
    /// # Errors
    /// [`ObjectError::Number`] for a number that is not positive.
    pub fn with_mass_and_friction(self, mass_kg: f64, friction: f64) -> Result<Self, ScenarioError> {
        check_numbers(mass_kg, friction)?;
        let inertia_kg_m2 = self.inertia_kg_m2 * (mass_kg / self.mass_kg);
        Ok(Self { mass_kg, friction, inertia_kg_m2, ..self })
    }

    /// The object in its own frame, as a hand holds it ([`LoadMeasure`](cranny_grasp::LoadMeasure)); `None` for one without
    /// a surface.
    pub fn held(&self) -> Option<HeldObject> {
        HeldObject::new(&self.mesh, &self.mass_moments(), Some(self.mass_kg), self.friction).ok()
    }

    /// Its moments in its own frame, as its file states them.
    pub fn mass_moments(&self) -> VolumeMoments {
        VolumeMoments {
            volume_m3: self.volume_m3,
            center: self.center_of_mass,
            inertia_per_mass_m2: self.inertia_kg_m2 / self.mass_kg,
        }
    }

    /// The volume of its mesh, as a body of a world.
    ///
    /// # Errors
    /// None for an object that was made here.
    pub fn solid(&self) -> Result<Solid, ShapeError> {
        Solid::mesh(&self.mesh)
    }
}

/// That a mass (kg) and a coefficient of friction are positive.
pub(crate) fn check_numbers(mass_kg: f64, friction: f64) -> Result<(), ScenarioError> {
    check_number("mass", mass_kg)?;
    check_number("friction", friction)
}

/// That a number of an object is positive.
pub(crate) fn check_number(what: &'static str, value: f64) -> Result<(), ScenarioError> {
    if value > 0.0 && value.is_finite() { Ok(()) } else { Err(ObjectError::Number { what, value }.into()) }
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
    /// The same fault, said of the mesh file that it was found in.
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
