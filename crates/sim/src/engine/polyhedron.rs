//! Convex polyhedra whose faces have more than four corners.
//!
//! The engine supports a face at four corners at most, and takes the first four in their order around the face: a cone would
//! stand on a quarter of its rim and fall over.

use rapier3d_f64::math::{Pose, Real, Vector};
use rapier3d_f64::parry::bounding_volume::{Aabb, BoundingSphere};
use rapier3d_f64::parry::mass_properties::MassProperties;
use rapier3d_f64::parry::query::{PointProjection, PointQuery, Ray, RayCast, RayIntersection};
use rapier3d_f64::parry::shape::{
    ConvexPolyhedron, FeatureId, PackedFeatureId, PolygonalFeature, PolygonalFeatureMap, Shape, ShapeType,
    SharedShape, SupportMap, TypedShape,
};

/// Number of corners of a face that the engine supports.
const CORNERS: usize = 4;

/// Difference of the depths of a face's corners below which the face is flat on what it meets, in metres.
const FLAT_M: f64 = 1e-6;

/// Returns the convex hull of points; `None` if they have none.
pub(crate) fn convex_hull(points: &[Vector]) -> Option<SharedShape> {
    let hull = ConvexPolyhedron::from_convex_hull(points)?;
    let has_many_corners = hull.faces().iter().any(|face| face.num_vertices_or_edges as usize > CORNERS);
    Some(if has_many_corners { SharedShape::new(Polyhedron(hull)) } else { SharedShape::new(hull) })
}

/// Convex polyhedron whose faces are supported at four corners that lie far apart.
#[derive(Clone)]
struct Polyhedron(ConvexPolyhedron);

impl Polyhedron {
    /// Returns the corners of the face in a direction, in order around it, each with its edge.
    fn face_towards(&self, direction: Vector) -> (usize, Vec<(u32, u32)>) {
        let along = |index: &usize| self.0.faces()[*index].normal.dot(direction);
        let faces = 0..self.0.faces().len();
        let best = faces.max_by(|a, b| along(a).total_cmp(&along(b))).unwrap_or(0);
        let face = &self.0.faces()[best];
        let begin = face.first_vertex_or_edge as usize;
        let of_face = begin..begin + face.num_vertices_or_edges as usize;
        let corners = self.0.vertices_adj_to_face()[of_face.clone()].iter().copied();
        (best, corners.zip(self.0.edges_adj_to_face()[of_face].iter().copied()).collect())
    }

    /// Returns at most four corners of a face: the one that is farthest in a direction, the one farthest from it, and the one
    /// farthest from their connection on each side of it.
    fn chosen(&self, corners: &[(u32, u32)], direction: Vector) -> Vec<usize> {
        let count = corners.len();
        if count <= CORNERS {
            return (0..count).collect();
        }
        let at = |index: usize| self.0.points()[corners[index % count].0 as usize];
        let farthest = |among: std::ops::Range<usize>, measure: &dyn Fn(usize) -> f64| {
            among.max_by(|a, b| measure(*a).total_cmp(&measure(*b)))
        };
        let depths = (0..count).map(|index| at(index).dot(direction));
        let [least, most] = depths.fold([f64::INFINITY, f64::NEG_INFINITY], |[least, most], depth| {
            [least.min(depth), most.max(depth)]
        });
        let first = if most - least < FLAT_M {
            0
        } else {
            farthest(0..count, &|index| at(index).dot(direction)).unwrap_or(0)
        };
        let from_first = |index: usize| (at(index) - at(first)).length();
        let opposite = farthest(first + 1..first + count, &from_first).unwrap_or(first + 1);
        let line = (at(opposite) - at(first)).normalize_or_zero();
        let from_line = |index: usize| (at(index) - at(first)).cross(line).length();
        let sides = [first + 1..opposite, opposite + 1..first + count].map(|side| farthest(side, &from_line));
        let all = [Some(first), sides[0], Some(opposite), sides[1]];
        all.into_iter().flatten().map(|index| index % count).collect()
    }
}

impl PolygonalFeatureMap for Polyhedron {
    fn local_support_feature(&self, direction: Vector, out_feature: &mut PolygonalFeature) {
        let (face, corners) = self.face_towards(direction);
        let chosen = self.chosen(&corners, direction);
        for (place, index) in chosen.iter().enumerate() {
            let (vertex, edge) = corners[*index];
            out_feature.vertices[place] = self.0.points()[vertex as usize];
            out_feature.vids[place] = PackedFeatureId::vertex(vertex);
            out_feature.eids[place] = PackedFeatureId::edge(edge);
        }
        out_feature.fid = PackedFeatureId::face(u32::try_from(face).unwrap_or(u32::MAX));
        out_feature.num_vertices = chosen.len();
    }

    fn is_convex_polyhedron(&self) -> bool {
        true
    }
}

impl SupportMap for Polyhedron {
    fn local_support_point(&self, direction: Vector) -> Vector {
        self.0.local_support_point(direction)
    }
}

impl PointQuery for Polyhedron {
    fn project_local_point(&self, point: Vector, solid: bool) -> PointProjection {
        self.0.project_local_point(point, solid)
    }

    fn project_local_point_and_get_feature(&self, point: Vector) -> (PointProjection, FeatureId) {
        self.0.project_local_point_and_get_feature(point)
    }
}

impl RayCast for Polyhedron {
    fn cast_local_ray_and_get_normal(
        &self,
        ray: &Ray,
        longest: Real,
        solid: bool,
    ) -> Option<RayIntersection> {
        self.0.cast_local_ray_and_get_normal(ray, longest, solid)
    }
}

impl Shape for Polyhedron {
    fn clone_dyn(&self) -> Box<dyn Shape> {
        Box::new(self.clone())
    }

    fn scale_dyn(&self, scale: Vector, _subdivisions: u32) -> Option<Box<dyn Shape>> {
        Some(Box::new(Self(self.0.clone().scaled(scale)?)))
    }

    fn compute_local_aabb(&self) -> Aabb {
        self.0.compute_local_aabb()
    }

    fn compute_local_bounding_sphere(&self) -> BoundingSphere {
        self.0.compute_local_bounding_sphere()
    }

    fn compute_aabb(&self, position: &Pose) -> Aabb {
        self.0.compute_aabb(position)
    }

    fn mass_properties(&self, density: Real) -> MassProperties {
        self.0.mass_properties(density)
    }

    fn is_convex(&self) -> bool {
        true
    }

    fn shape_type(&self) -> ShapeType {
        ShapeType::Custom
    }

    fn as_typed_shape(&self) -> TypedShape<'_> {
        TypedShape::Custom(self)
    }

    fn ccd_thickness(&self) -> Real {
        self.0.ccd_thickness()
    }

    fn ccd_angular_thickness(&self) -> Real {
        self.0.ccd_angular_thickness()
    }

    fn as_support_map(&self) -> Option<&dyn SupportMap> {
        Some(self)
    }

    fn as_polygonal_feature_map(&self) -> Option<(&dyn PolygonalFeatureMap, Real)> {
        Some((self, 0.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Regular prism of radius 1 and height 1 that stands on z = 0.
    fn prism(corners: u32) -> Polyhedron {
        let at = |index: u32| f64::from(index) * std::f64::consts::TAU / f64::from(corners);
        let points: Vec<Vector> = (0..corners)
            .flat_map(|index| [0.0, 1.0].map(|z| Vector::new(libm::cos(at(index)), libm::sin(at(index)), z)))
            .collect();
        Polyhedron(ConvexPolyhedron::from_convex_hull(&points).expect("a prism"))
    }

    #[test]
    fn a_face_is_supported_around_its_centre_and_at_its_deepest_corner() {
        for corners in [5, 6, 7, 8, 12, 48] {
            let prism = prism(corners);
            for index in 0..200 {
                let turn = f64::from(index) * 0.37;
                let tilt = 1e-3 * f64::from(index);
                let [(ts, tc), (us, uc)] = [tilt, turn].map(libm::sincos);
                let down = Vector::new(ts * uc, ts * us, -tc);
                let mut face = PolygonalFeature::default();
                prism.local_support_feature(down, &mut face);
                assert_eq!(face.num_vertices, CORNERS);
                let depth = |point: &Vector| point.dot(down);
                let deepest = face.vertices.iter().map(depth).fold(f64::NEG_INFINITY, f64::max);
                let support = depth(&prism.local_support_point(down));
                assert!(support - deepest < 1e-6 || tilt > 0.5, "{corners} corners, tilt {tilt}");
                // The centre is on the inner side of each edge.
                for side in 0..CORNERS {
                    let (a, b) = (face.vertices[side], face.vertices[(side + 1) % CORNERS]);
                    let normal = (b - a).cross(down);
                    assert!(normal.dot(Vector::new(0.0, 0.0, a.z) - a) < 1e-9, "{corners} corners");
                }
            }
        }
    }
}
