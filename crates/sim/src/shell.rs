//! Surface of an object with thin walls, such as a bowl: the hand meets it instead of the convex parts, because walls that
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

/// Error of the convex parts, as a share of the volume, up to which the hand meets these: they are faster.
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

    /// Returns true if a point, in the frame of the object, lies inside.
    pub fn contains(&self, point: &Point) -> bool {
        self.is_inside(point, &Vector::z(), 2.0 * self.surface.aabb().half_extents.norm())
    }

    /// Returns true if a ray leaves the object where it first meets its surface.
    fn is_inside(&self, origin: &Point, along: &Vector, reach_m: f64) -> bool {
        let hits = self.surface.ray_hits(origin, along, reach_m);
        hits.first().is_some_and(|hit| hit.normal.dot(along) > 0.0)
    }

    /// Convex pieces just below the surface, for an engine without colliders of meshes: a frustum below each triangle, which
    /// narrows to half of its size and is at most [`THICKEST_M`] thick, less where it would protrude by more than
    /// [`THINNEST_M`]. `None` for more than [`MOST_PRISMS`] triangles.
    pub fn prisms(&self) -> Option<Vec<Piece>> {
        let count = self.mesh.triangles.len();
        (count <= MOST_PRISMS).then(|| (0..count).filter_map(|triangle| self.prism(triangle)).collect())
    }

    fn prism(&self, triangle: usize) -> Option<Piece> {
        let corners = self.mesh.corners(triangle);
        let [a, b, c] = &corners;
        let (inward, double_area_m2) = Unit::try_new_and_get((c - a).cross(&(b - a)), 0.0)?;
        let middle = (a.coords + b.coords + c.coords) / 3.0;
        let below = |thickness_m: f64| {
            corners.map(|corner| {
                Point::from(corner.coords.lerp(&middle, 0.5) + inward.into_inner() * thickness_m)
            })
        };
        let thicknesses_m = (0..HALVINGS).map(|times| THICKEST_M * 0.5_f64.powi(times));
        let is_in = |thickness_m: &f64| {
            below(*thickness_m).iter().all(|corner| self.is_inside(corner, &-inward, 2.0 * THICKEST_M))
        };
        let thickness_m = thicknesses_m.into_iter().find(is_in).unwrap_or(THINNEST_M);
        let below = below(thickness_m);
        if 0.25 * double_area_m2 * thickness_m < LEAST_VOLUME_M3 {
            return None;
        }
        let vertices = [corners, below].concat();
        let triangles =
            vec![[0, 1, 2], [3, 5, 4], [0, 4, 1], [0, 3, 4], [1, 5, 2], [1, 4, 5], [2, 3, 0], [2, 5, 3]];
        let shape = PieceShape::Hull(TriangleSoup { vertices, triangles });
        Some(Piece { body_from_piece: Pose::identity(), shape })
    }
}

/// Maximum number of triangles that become prisms: MuJoCo tests each for contacts.
const MOST_PRISMS: usize = 2000;
/// Maximum thickness of a prism, in metres.
const THICKEST_M: f64 = 2e-3;
/// Minimum thickness of a prism, in metres.
const THINNEST_M: f64 = 5e-5;
/// Number of thicknesses that are tried, each half of the one before; the last is near [`THINNEST_M`].
const HALVINGS: i32 = 6;
/// Minimum volume of a prism: MuJoCo refuses smaller meshes.
const LEAST_VOLUME_M3: f64 = 1e-13;

#[cfg(test)]
mod tests {
    use cranny_scenario::ObjectSettings;

    use super::*;

    const SIDES: usize = 24;
    const RADII_M: [f64; 2] = [0.036, 0.04];
    const HEIGHT_M: f64 = 0.06;

    /// A pipe along z, whose wall is 4 mm thick below and this thick above.
    fn pipe(above_m: f64) -> ObjectType {
        let mut soup = TriangleSoup::default();
        for side in 0..SIDES {
            let angle = std::f64::consts::TAU * side as f64 / SIDES as f64;
            let (sine, cosine) = cranny_spatial::sin_cos(angle);
            for (radius_m, z) in [
                (RADII_M[0], 0.0),
                (RADII_M[1], 0.0),
                (RADII_M[0] + above_m, HEIGHT_M),
                (RADII_M[0], HEIGHT_M),
            ] {
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

    /// The prisms of a wall do not protrude from it, even where it tapers to 0.2 mm.
    #[test]
    fn the_prisms_of_a_wall_lie_within_it() {
        for above_m in [0.004, 0.0002] {
            let pipe = pipe(above_m);
            let surface = Surface::new(&pipe.mesh).unwrap();
            let shell = Shell::of(&pipe, &surface).expect("a thin wall");
            let prisms = shell.prisms().unwrap();
            assert_eq!(prisms.len(), pipe.mesh.triangles.len());
            for prism in &prisms {
                let PieceShape::Hull(hull) = &prism.shape else { panic!("{prism:?}") };
                assert!(hull.signed_volume_m3() > 0.0, "{hull:?}");
                let outside = hull.vertices[3..].iter().filter(|corner| !shell.contains(corner)).count();
                assert_eq!(outside, 0, "{hull:?}");
            }
        }
    }

    #[test]
    fn the_wall_of_a_pipe_is_inside_and_its_bore_is_not() {
        let pipe = pipe(0.004);
        let shell = Shell::of(&pipe, &Surface::new(&pipe.mesh).unwrap()).expect("a thin wall");
        for (x, is_inside) in [(0.0, false), (0.03, false), (0.038, true), (0.045, false)] {
            assert_eq!(shell.contains(&Point::new(x, 0.0, 0.5 * HEIGHT_M)), is_inside, "{x}");
        }
    }

    #[test]
    fn a_convex_object_has_no_shell() {
        let cube = Surface::cuboid_soup(&Vector::repeat(0.02));
        let object = ObjectType::from_mesh(&cube, &ObjectSettings::new("cube", 0.2)).unwrap().0;
        assert!(Shell::of(&object, &Surface::new(&cube).unwrap()).is_none());
    }
}
