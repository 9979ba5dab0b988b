use cranny_collision::Body;
use cranny_shape::{CoarseHull, ConvexParts, DecompositionSettings, Outline, Solid, TriangleSoup};
use cranny_spatial::nalgebra::Translation3 as Translation;
use cranny_spatial::{Pose, Vector};

use crate::SimError;

/// Convex piece of a rigid body, in a form common to all engines.
#[derive(Clone, Debug)]
pub struct Piece {
    /// Pose of the piece in the body.
    pub body_from_piece: Pose,
    /// Shape of the piece.
    pub shape: PieceShape,
}

/// Shape of a [`Piece`]; lengths in metres, centred at the origin, along z.
#[derive(Clone, Debug)]
pub enum PieceShape {
    /// Cuboid with these half extents.
    Cuboid([f64; 3]),
    /// Ball with this radius.
    Ball(f64),
    /// Capsule: half the length of its cylindrical section, and radius.
    Capsule(f64, f64),
    /// Cylinder: half its length, and radius.
    Cylinder(f64, f64),
    /// Convex hull of these corners, a closed mesh.
    Hull(TriangleSoup),
    /// Half-space of all points with z ≤ 0.
    HalfSpace,
}

impl Piece {
    /// Converts a solid to convex pieces; a mesh that is not convex is decomposed (V-HACD). `of` names it in an error.
    ///
    /// # Errors
    /// [`SimError::Shape`] for a mesh that encloses no volume.
    pub fn of_solid(of: &str, body_from_solid: &Pose, solid: &Solid) -> Result<Vec<Self>, SimError> {
        let shape = match solid.outline() {
            Outline::Cuboid { half_extents } => PieceShape::Cuboid(half_extents.into()),
            Outline::Segment { half_length_m: 0.0, radius_m } => PieceShape::Ball(radius_m),
            Outline::Segment { half_length_m, radius_m } => PieceShape::Capsule(half_length_m, radius_m),
            Outline::Cylinder { half_length_m, radius_m } => PieceShape::Cylinder(half_length_m, radius_m),
            Outline::HalfSpace => PieceShape::HalfSpace,
            Outline::Union => {
                let pieces = solid.pieces().into_iter();
                let of_piece =
                    |(pose, piece): (Pose, Solid)| Self::of_solid(of, &(body_from_solid * pose), &piece);
                return Ok(pieces.map(of_piece).collect::<Result<Vec<_>, _>>()?.concat());
            }
            Outline::Other => {
                if let Some(hull) = coarse_hull(solid) {
                    let shape = PieceShape::Hull(hull);
                    return Ok(vec![Self { body_from_piece: *body_from_solid, shape }]);
                }
                let soup = solid.tessellation().unwrap_or_default();
                let parts = ConvexParts::of_mesh(&soup, &DecompositionSettings::default())
                    .map_err(|reason| SimError::Shape { of: of.to_owned(), reason })?;
                return Ok(Self::of_hulls(body_from_solid, parts.parts));
            }
        };
        Ok(vec![Self { body_from_piece: *body_from_solid, shape }])
    }

    /// Returns one piece for each of these convex meshes.
    pub fn of_hulls(body_from_hulls: &Pose, hulls: impl IntoIterator<Item = TriangleSoup>) -> Vec<Self> {
        let piece = |hull: TriangleSoup| {
            let coarse = Solid::hull(&hull.vertices).ok().and_then(|solid| coarse_hull(&solid));
            Self { body_from_piece: *body_from_hulls, shape: PieceShape::Hull(coarse.unwrap_or(hull)) }
        };
        hulls.into_iter().map(piece).collect()
    }

    /// Returns the piece with its front moved along `outward`, a unit vector of the body, to `least_m` from the origin, but by at
    /// most `most_m` and nine tenths of its thickness. Its back stays. Lengths in metres.
    pub(crate) fn thinned(&self, outward: &Vector, least_m: f64, most_m: f64) -> Self {
        let own = self.body_from_piece.rotation.inverse() * outward;
        let middle_m = outward.dot(&self.body_from_piece.translation.vector);
        let surface = self.shape.surface().unwrap_or_default();
        let along = surface.vertices.iter().map(|vertex| middle_m + own.dot(&vertex.coords));
        let (front_m, back_m) = along.fold((f64::INFINITY, f64::NEG_INFINITY), |(front_m, back_m), at_m| {
            (front_m.min(at_m), back_m.max(at_m))
        });
        let depth_m = (least_m - front_m).clamp(0.0, most_m.min(0.9 * (back_m - front_m).max(0.0)));
        if let PieceShape::Cuboid(half_m) = self.shape {
            let axis = own.iamax();
            let mut half_m = half_m;
            let depth_m = depth_m.min(1.8 * half_m[axis]);
            half_m[axis] -= 0.5 * depth_m;
            let mut shift_m = Vector::zeros();
            shift_m[axis] = 0.5 * depth_m * own[axis].signum();
            let body_from_piece = self.body_from_piece * Translation::from(shift_m);
            return Self { body_from_piece, shape: PieceShape::Cuboid(half_m) };
        }
        if depth_m <= 0.0 {
            return self.clone();
        }
        let share = depth_m / (back_m - front_m);
        let thinner = surface.vertices.iter().map(|vertex| {
            let behind_m = back_m - middle_m - own.dot(&vertex.coords);
            vertex + own * (share * behind_m)
        });
        let vertices = thinner.collect();
        let hull = TriangleSoup { vertices, ..surface };
        Self::of_hulls(&self.body_from_piece, [hull]).remove(0)
    }

    /// Surfaces of pieces for display, in the frame of the body.
    pub(crate) fn surface_of(pieces: &[Self]) -> TriangleSoup {
        let mut surface = TriangleSoup::default();
        for piece in pieces {
            surface.append(&piece.shape.surface().unwrap_or_default(), &piece.body_from_piece);
        }
        surface
    }

    /// Returns the pieces of a body of a world, in the planning frame.
    ///
    /// # Errors
    /// See [`Self::of_solid`].
    pub fn of_body(body: &Body) -> Result<Vec<Self>, SimError> {
        let mut pieces = Vec::new();
        for part in &body.parts {
            pieces.extend(Self::of_solid(&body.name, &part.world_from_solid, &part.solid)?);
        }
        Ok(pieces)
    }
}

impl PieceShape {
    /// Surface for display, in the frame of the shape; `None` for a half-space.
    pub fn surface(&self) -> Option<TriangleSoup> {
        let solid = match self {
            Self::Cuboid(half_extents) => Solid::cuboid((*half_extents).into()),
            Self::Ball(radius_m) => Solid::sphere(*radius_m),
            Self::Capsule(half_m, radius_m) => Solid::capsule(*half_m, *radius_m),
            Self::Cylinder(half_m, radius_m) => Solid::cylinder(*half_m, *radius_m),
            Self::Hull(hull) => return Some(hull.clone()),
            Self::HalfSpace => return None,
        };
        solid.ok()?.tessellation()
    }
}

/// Returns a hull with few corners, because the time of a simulation step grows with them; the convex solid protrudes from it
/// by at most [`BULGE_M`]. `None` if the solid is not a convex hull.
fn coarse_hull(solid: &Solid) -> Option<TriangleSoup> {
    let coarse = [32, 64, 128, 256].into_iter().find_map(|most| {
        CoarseHull::of(solid, most).filter(|hull| hull.radius_m == 0.0 && hull.bulge_m <= BULGE_M)
    })?;
    TriangleSoup::convex_hull(&coarse.corners).ok()
}

/// Maximum error of a simplified hull, in metres: a tenth of the tolerance of a result.
const BULGE_M: f64 = 1e-4;

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns least and greatest distance of a piece along y.
    fn along_y(piece: &Piece) -> [f64; 2] {
        let surface = piece.shape.surface().expect("bounded");
        let along = surface.vertices.iter().map(|vertex| (piece.body_from_piece * vertex).y);
        along.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], y| [low.min(y), high.max(y)])
    }

    #[test]
    fn the_back_of_a_thinned_piece_stays() {
        let corners =
            Solid::cuboid(Vector::new(0.01, 0.007, 0.02)).expect("a box").tessellation().expect("a surface");
        let shapes =
            [PieceShape::Cuboid([0.01, 0.007, 0.02]), PieceShape::Hull(corners), PieceShape::Ball(0.007)];
        for shape in shapes {
            let piece = Piece { body_from_piece: Pose::translation(0.0, 0.04, 0.01), shape };
            let [front_m, back_m] = along_y(&piece);
            for (least_m, most_m, moved_m) in
                [(0.038, 0.005, 0.005), (0.035, 0.005, 0.002), (0.02, 0.005, 0.0)]
            {
                let [thin_m, same_m] = along_y(&piece.thinned(&Vector::y(), least_m, most_m));
                assert!((same_m - back_m).abs() < 1e-4, "{piece:?}: back at {same_m}, not {back_m}");
                assert!(
                    (thin_m - front_m - moved_m).abs() < 1e-4,
                    "{piece:?}: front at {thin_m}, {front_m} + {moved_m}"
                );
            }
        }
    }
}
