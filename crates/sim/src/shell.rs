//! Surface of an object with thin walls, such as a bowl: the fingers meet it instead of the convex parts, because walls that
//! bulge by some millimetres would push the object out of the pads.

use cranny_scenario::ObjectType;
use cranny_shape::{Surface, TriangleSoup};
use cranny_spatial::nalgebra::Unit;
use cranny_spatial::{Point, Pose, Vector};
use rapier3d_f64::prelude::Collider;

use crate::{Piece, PieceShape, engine};

/// Surface of an object in its frame, in the form of the engine.
#[derive(Clone, Debug)]
pub(crate) struct Shell {
    mesh: TriangleSoup,
    surface: Surface,
    pub collider: Collider,
}

/// Error of the convex parts, as a share of the volume, up to which the fingers meet these: they are faster.
const MOST_ERROR: f64 = 0.05;

impl Shell {
    /// Shell of an object with this surface; `None` if its solids or its convex parts are accurate enough.
    pub fn of(object: &ObjectType, surface: &Surface) -> Option<Self> {
        let error = object.parts.error;
        if !object.solids.is_empty() || error.excess + error.missing <= MOST_ERROR {
            return None;
        }
        let collider = engine::shell(&object.mesh)?;
        Some(Self { mesh: object.mesh.clone(), surface: surface.clone(), collider })
    }

    /// Convex pieces just below the surface, for an engine without colliders of meshes: a prism for each triangle, as thick as
    /// half of the object there and at most [`THICKEST_M`]. `None` for more than [`MOST_PRISMS`] triangles.
    pub fn prisms(&self) -> Option<Vec<Piece>> {
        let count = self.mesh.triangles.len();
        (count <= MOST_PRISMS).then(|| (0..count).filter_map(|triangle| self.prism(triangle)).collect())
    }

    fn prism(&self, triangle: usize) -> Option<Piece> {
        let corners = self.mesh.corners(triangle);
        let [a, b, c] = &corners;
        let (inward, double_area_m2) = Unit::try_new_and_get((c - a).cross(&(b - a)), 0.0)?;
        let thickness_m = self.half_thickness_m(&corners, &inward);
        let below = corners.map(|corner| corner + inward.into_inner() * thickness_m);
        if 0.5 * double_area_m2 * thickness_m < LEAST_VOLUME_M3 {
            return None;
        }
        let vertices = [corners, below].concat();
        let triangles =
            vec![[0, 1, 2], [3, 5, 4], [0, 4, 1], [0, 3, 4], [1, 5, 2], [1, 4, 5], [2, 3, 0], [2, 5, 3]];
        let shape = PieceShape::Hull(TriangleSoup { vertices, triangles });
        Some(Piece { body_from_piece: Pose::identity(), shape })
    }

    /// Half of the least thickness of the object below the middle of a triangle and near its corners, within limits, in metres.
    fn half_thickness_m(&self, corners: &[Point; 3], inward: &Vector) -> f64 {
        let [a, b, c] = corners.map(|corner| corner.coords);
        let middle = (a + b + c) / 3.0;
        let probes = [middle, middle.lerp(&a, 0.8), middle.lerp(&b, 0.8), middle.lerp(&c, 0.8)];
        let below = probes.map(|probe| {
            let origin = Point::from(probe + inward * BELOW_M);
            let hits = self.surface.ray_hits(&origin, inward, 2.0 * THICKEST_M);
            hits.first().map_or(2.0 * THICKEST_M, |hit| hit.distance_m)
        });
        (0.5 * below.into_iter().fold(f64::INFINITY, f64::min)).clamp(THINNEST_M, THICKEST_M)
    }
}

/// Maximum number of triangles that become prisms: MuJoCo tests each for contacts.
const MOST_PRISMS: usize = 2000;
/// Maximum thickness of a prism, in metres.
const THICKEST_M: f64 = 3e-3;
/// Minimum thickness of a prism, in metres.
const THINNEST_M: f64 = 1e-4;
/// Distance below a triangle at which the search for its far side begins, in metres.
const BELOW_M: f64 = 1e-7;
/// Minimum volume of a prism: MuJoCo refuses smaller meshes.
const LEAST_VOLUME_M3: f64 = 1e-13;

#[cfg(test)]
mod tests {
    use cranny_scenario::ObjectSettings;

    use super::*;

    const SIDES: usize = 24;
    const RADII_M: [f64; 2] = [0.036, 0.04];
    const HEIGHT_M: f64 = 0.06;

    /// A pipe along z, whose wall is 4 mm thick.
    fn pipe() -> ObjectType {
        let mut soup = TriangleSoup::default();
        for side in 0..SIDES {
            let angle = std::f64::consts::TAU * side as f64 / SIDES as f64;
            let (sine, cosine) = cranny_spatial::sin_cos(angle);
            for (radius_m, z) in
                [(RADII_M[0], 0.0), (RADII_M[1], 0.0), (RADII_M[1], HEIGHT_M), (RADII_M[0], HEIGHT_M)]
            {
                soup.vertices.push(Point::new(radius_m * cosine, radius_m * sine, z));
            }
        }
        let at = |side: usize, corner: usize| u32::try_from(4 * (side % SIDES) + corner % 4).unwrap();
        for side in 0..SIDES {
            for corner in 0..4 {
                let [a, b, c, d] =
                    [at(side, corner), at(side + 1, corner), at(side + 1, corner + 1), at(side, corner + 1)];
                soup.triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
        ObjectType::from_mesh(&soup, &ObjectSettings::new("pipe", 0.2)).unwrap().0
    }

    /// The prisms of a thin wall have its triangles as outer faces and do not protrude.
    #[test]
    fn the_prisms_of_a_wall_lie_within_it() {
        let pipe = pipe();
        let surface = Surface::new(&pipe.mesh).unwrap();
        let prisms = Shell::of(&pipe, &surface).expect("a thin wall").prisms().unwrap();
        assert_eq!(prisms.len(), pipe.mesh.triangles.len());
        let (_, cosine) = cranny_spatial::sin_cos(std::f64::consts::PI / SIDES as f64);
        let innermost_m = RADII_M[0] * cosine;
        for prism in &prisms {
            let PieceShape::Hull(hull) = &prism.shape else { panic!("{prism:?}") };
            assert!(hull.signed_volume_m3() > 0.0, "{hull:?}");
            for corner in &hull.vertices {
                let radius_m = corner.x.hypot(corner.y);
                let is_in = radius_m > innermost_m - THINNEST_M && radius_m < RADII_M[1] + THINNEST_M;
                assert!(is_in && corner.z > -THINNEST_M && corner.z < HEIGHT_M + THINNEST_M, "{corner}");
            }
        }
    }

    #[test]
    fn a_convex_object_has_no_shell() {
        let cube = Surface::cuboid_soup(&Vector::repeat(0.02));
        let object = ObjectType::from_mesh(&cube, &ObjectSettings::new("cube", 0.2)).unwrap().0;
        assert!(Shell::of(&object, &Surface::new(&cube).unwrap()).is_none());
    }
}
