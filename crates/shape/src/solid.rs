use std::sync::Arc;

use cranny_spatial::{Point, Pose, Rotation, Vector};
use parry3d_f64::shape::SupportMap;

use crate::distance::convex::{Convex, Core};
use crate::error::positive;
use crate::mesh::Mesh;
use crate::union::box_union::corners;
use crate::{Aabb, Ball, Bounds, BoxUnion, MeshRepairs, ShapeError, TriangleSoup, distance::parry};

/// A solid in its own frame. Cheap to clone.
#[derive(Clone, Debug)]
pub struct Solid {
    kind: Kind,
    bounds: Bounds,
}

#[derive(Clone, Debug)]
pub(crate) enum Kind {
    Convex(Arc<Convex>),
    Mesh(Arc<Mesh>),
    /// All points with z ≤ 0.
    HalfSpace,
    Union(Arc<BoxUnion>),
}

impl Solid {
    /// Returns true if both are clones of one solid, or half-spaces.
    pub fn is_clone_of(&self, other: &Self) -> bool {
        match (&self.kind, &other.kind) {
            (Kind::Convex(a), Kind::Convex(b)) => Arc::ptr_eq(a, b),
            (Kind::Mesh(a), Kind::Mesh(b)) => Arc::ptr_eq(a, b),
            (Kind::Union(a), Kind::Union(b)) => Arc::ptr_eq(a, b),
            (Kind::HalfSpace, Kind::HalfSpace) => true,
            _ => false,
        }
    }
}

/// Kind and dimensions of a solid. All shapes are centred at the origin, with their length along z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Outline {
    /// A cuboid of these half extents, in metres.
    Cuboid {
        /// Half extent along each axis, in metres.
        half_extents: Vector,
    },
    /// A capsule; a sphere if the length is 0.
    Segment {
        /// Half length of the cylindrical section, in metres.
        half_length_m: f64,
        /// Radius, in metres.
        radius_m: f64,
    },
    /// A cylinder.
    Cylinder {
        /// Half length, in metres.
        half_length_m: f64,
        /// Radius, in metres.
        radius_m: f64,
    },
    /// All points with z ≤ 0.
    HalfSpace,
    /// A union of boxes or points.
    Union,
    /// A hull or a mesh, without dimensions.
    Other,
}

impl Solid {
    /// A cuboid centred at the origin.
    ///
    /// # Errors
    /// [`ShapeError::Size`] unless all half extents (m) are positive and finite.
    pub fn cuboid(half_extents: Vector) -> Result<Self, ShapeError> {
        for extent in half_extents.iter() {
            positive("each half extent of a cuboid", *extent)?;
        }
        Ok(Self::convex(Convex::sharp(Core::Cuboid { half_extents })))
    }

    /// A sphere centred at the origin.
    ///
    /// # Errors
    /// [`ShapeError::Size`] unless the radius is positive and finite.
    pub fn sphere(radius_m: f64) -> Result<Self, ShapeError> {
        let radius_m = positive("the radius of a sphere", radius_m)?;
        Ok(Self::convex(Convex { core: Core::Point, radius_m }))
    }

    /// A capsule along z, centred at the origin; `half_length_m` is the half length of its cylindrical section.
    ///
    /// # Errors
    /// [`ShapeError::Size`] unless both sizes are positive and finite.
    pub fn capsule(half_length_m: f64, radius_m: f64) -> Result<Self, ShapeError> {
        let half_length = positive("the half length of a capsule", half_length_m)?;
        let radius_m = positive("the radius of a capsule", radius_m)?;
        Ok(Self::convex(Convex { core: Core::Segment { half_length }, radius_m }))
    }

    /// A cylinder along z, centred at the origin.
    ///
    /// # Errors
    /// [`ShapeError::Size`] unless both sizes are positive and finite.
    pub fn cylinder(half_length_m: f64, radius_m: f64) -> Result<Self, ShapeError> {
        let half_length = positive("the half length of a cylinder", half_length_m)?;
        let radius = positive("the radius of a cylinder", radius_m)?;
        Ok(Self::convex(Convex::sharp(Core::Cylinder { half_length, radius })))
    }

    /// The volume that a closed triangle mesh encloses: all that its surface seals off from the space around it. Faces may be
    /// wound in either direction, doubled, or shared by components that touch or overlap. [`Self::mesh_repairs`] lists the
    /// repairs; a mesh that needs none keeps its triangles.
    ///
    /// A component inside another is a cavity only if all its faces point inwards, all faces of the outer one point outwards,
    /// and the two do not touch. Otherwise it is solid.
    ///
    /// # Errors
    /// [`ShapeError::Empty`], [`ShapeError::VertexIndex`], [`ShapeError::Open`] for a mesh with a hole,
    /// [`ShapeError::OneSided`] for faces with the same space on both sides, or [`ShapeError::WoundBackwards`] for a component
    /// that crosses itself.
    pub fn mesh(soup: &TriangleSoup) -> Result<Self, ShapeError> {
        Ok(Self::of_mesh(Mesh::new(soup)?, soup))
    }

    /// The volume that a mesh encloses after its small holes, up to a tenth of it across, are closed. The space behind
    /// them is solid, as suits an obstacle. [`Self::mesh_repairs`] counts the holes.
    ///
    /// # Errors
    /// As [`Self::mesh`]; [`ShapeError::Open`] for a mesh with a larger hole.
    pub fn mesh_with_small_holes(soup: &TriangleSoup) -> Result<Self, ShapeError> {
        Ok(Self::of_mesh(Mesh::with_small_holes(soup)?, soup))
    }

    /// Makes a solid of a mesh. The bounds of `soup` contain the triangles that close its holes.
    fn of_mesh(mesh: Mesh, soup: &TriangleSoup) -> Self {
        let mut is_used = vec![false; soup.vertices.len()];
        soup.triangles.iter().flatten().for_each(|vertex| is_used[*vertex as usize] = true);
        let used = soup.vertices.iter().zip(is_used).filter(|(_, is_used)| *is_used);
        let bounds = Bounds::around(&used.map(|(vertex, _)| (*vertex, 0.0)).collect::<Vec<_>>());
        Self { kind: Kind::Mesh(Arc::new(mesh)), bounds }
    }

    /// The half-space z ≤ 0: a floor whose surface is the plane z = 0.
    pub fn half_space() -> Self {
        let everywhere = f64::INFINITY;
        Self {
            kind: Kind::HalfSpace,
            bounds: Bounds {
                ball: Ball { center: Point::origin(), radius_m: everywhere },
                aabb: Aabb { center: Point::origin(), half_extents: Vector::repeat(everywhere) },
            },
        }
    }

    /// A union of boxes, or of balls around the points of a cloud.
    pub fn union(union: BoxUnion) -> Self {
        let aabb = union.around();
        let ball = Ball { center: aabb.center, radius_m: aabb.half_extents.norm() };
        Self { kind: Kind::Union(Arc::new(union)), bounds: Bounds { ball, aabb } }
    }

    /// A ball that contains the solid; of infinite radius for a half-space.
    pub fn ball(&self) -> &Ball {
        &self.bounds.ball
    }

    /// Axis-aligned box around the solid in its own frame; infinite for a half-space.
    pub fn aabb(&self) -> &Aabb {
        &self.bounds.aabb
    }

    /// Bounding ball and box of the solid; infinite for a half-space.
    pub fn bounds(&self) -> &Bounds {
        &self.bounds
    }

    /// Returns true if the solid is the half-space z ≤ 0.
    pub fn is_half_space(&self) -> bool {
        matches!(self.kind, Kind::HalfSpace)
    }

    /// Half extents (m) that a cuboid was made with; `None` for any other solid.
    pub fn as_cuboid(&self) -> Option<Vector> {
        match self.outline() {
            Outline::Cuboid { half_extents } => Some(half_extents),
            _ => None,
        }
    }

    /// Kind of the solid, with the dimensions that it was made with.
    pub fn outline(&self) -> Outline {
        match &self.kind {
            Kind::HalfSpace => Outline::HalfSpace,
            Kind::Union(_) => Outline::Union,
            Kind::Mesh(_) => Outline::Other,
            Kind::Convex(convex) => match convex.core {
                Core::Cuboid { half_extents } => Outline::Cuboid { half_extents },
                Core::Point => Outline::Segment { half_length_m: 0.0, radius_m: convex.radius_m },
                Core::Segment { half_length } => {
                    Outline::Segment { half_length_m: half_length, radius_m: convex.radius_m }
                }
                Core::Cylinder { half_length, radius } => {
                    Outline::Cylinder { half_length_m: half_length, radius_m: radius }
                }
                Core::Hull(_) | Core::Triangle(_) => Outline::Other,
            },
        }
    }

    /// Points and a radius (m): the solid lies within that radius of the convex hull of the points. `None` for a half-space.
    pub fn bounding_points(&self) -> Option<(Vec<Point>, f64)> {
        match &self.kind {
            Kind::Convex(convex) => Some((convex.bounding_points(), convex.radius_m)),
            Kind::Mesh(mesh) => Some((mesh.vertices().collect(), 0.0)),
            Kind::Union(union) => Some((corners(&union.around()).to_vec(), 0.0)),
            Kind::HalfSpace => None,
        }
    }

    /// Union of boxes or points of the solid; `None` for any other solid.
    pub fn as_union(&self) -> Option<&Arc<BoxUnion>> {
        match &self.kind {
            Kind::Union(union) => Some(union),
            _ => None,
        }
    }

    /// Solids, each with its pose in the frame of this one, that make it up: the boxes or balls of a union, else itself.
    pub fn pieces(&self) -> Vec<(Pose, Self)> {
        let Some(union) = self.as_union() else { return vec![(Pose::identity(), self.clone())] };
        let piece = |aabb: Aabb| {
            let core = if aabb.half_extents.amax() > 0.0 {
                Core::Cuboid { half_extents: aabb.half_extents }
            } else {
                Core::Point
            };
            let pose = Pose::from_parts(aabb.center.coords.into(), Rotation::identity());
            (pose, Self::convex(Convex { core, radius_m: union.radius_m() }))
        };
        union.boxes().map(piece).collect()
    }

    /// Farthest point of a convex solid along `direction`; `None` for a mesh, a union or a half-space.
    pub fn support_point(&self, direction: &Vector) -> Option<Point> {
        match &self.kind {
            Kind::Convex(convex) => Some(support(convex, direction)),
            _ => None,
        }
    }

    /// Surface of a mesh higher than `height_m` (m) along the unit vector `direction`, in the mesh's own frame; it encloses
    /// nothing. `None` if nothing is that high, or if the solid is not a mesh.
    #[must_use]
    pub fn surface_above(&self, direction: &Vector, height_m: f64) -> Option<Self> {
        let Kind::Mesh(mesh) = &self.kind else { return None };
        let mesh = mesh.above(direction, height_m)?;
        let bounds = Bounds::around(&mesh.vertices().map(|vertex| (vertex, 0.0)).collect::<Vec<_>>());
        Some(Self { kind: Kind::Mesh(Arc::new(mesh)), bounds })
    }

    /// Triangles of [`Self::tessellation`] whose boxes meet `region` (solid's own frame), or more, with normals outwards.
    /// Empty for a half-space.
    pub fn triangles_near(&self, region: &Aabb) -> Vec<[Point; 3]> {
        if let Kind::Mesh(mesh) = &self.kind {
            return mesh.corners_near(region).collect();
        }
        let soup = self.tessellation().unwrap_or_default();
        (0..soup.triangles.len()).map(|triangle| soup.corners(triangle)).collect()
    }

    /// Lowest z of the solid placed by `target_from_solid`, in metres; minus infinity for a half-space.
    pub fn lowest_z(&self, target_from_solid: &Pose) -> f64 {
        match &self.kind {
            Kind::Convex(convex) => lowest(convex, target_from_solid),
            Kind::Mesh(mesh) => {
                mesh.vertices().map(|v| (target_from_solid * v).z).fold(f64::INFINITY, f64::min)
            }
            Kind::Union(union) => {
                let lowest = |aabb: Aabb| aabb.transformed(target_from_solid).low().z;
                union.boxes().map(lowest).fold(f64::INFINITY, f64::min) - union.radius_m()
            }
            Kind::HalfSpace => f64::NEG_INFINITY,
        }
    }

    /// Repairs to the triangles of a mesh; `None` for a mesh that needed none, and for any other solid.
    pub fn mesh_repairs(&self) -> Option<&MeshRepairs> {
        match &self.kind {
            Kind::Mesh(mesh) => Some(mesh.repairs()).filter(|repairs| repairs.is_any()),
            _ => None,
        }
    }

    pub(crate) fn kind(&self) -> &Kind {
        &self.kind
    }

    pub(crate) fn convex(convex: Convex) -> Self {
        let points: Vec<(Point, f64)> =
            convex.bounding_points().into_iter().map(|point| (point, convex.radius_m)).collect();
        let mut bounds = Bounds::around(&points);
        if let Core::Cylinder { half_length, radius } = convex.core {
            // The points are those of a prism around the cylinder, whose own box is narrower.
            bounds.aabb.half_extents = Vector::new(radius, radius, half_length);
        }
        Self { kind: Kind::Convex(Arc::new(convex)), bounds }
    }
}

fn lowest(convex: &Convex, target_from_solid: &Pose) -> f64 {
    let down = target_from_solid.rotation.inverse_transform_vector(&-Vector::z());
    (target_from_solid * support(convex, &down)).z
}

fn support(convex: &Convex, direction: &Vector) -> Point {
    let core = parry::to_vector(convex.core.local_support_point(parry::vector(direction)));
    let rounding = direction.try_normalize(0.0).unwrap_or_else(Vector::zeros) * convex.radius_m;
    (core + rounding).into()
}
