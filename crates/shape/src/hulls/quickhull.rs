use std::collections::HashMap;

use parry3d_f64::math::Vector as ParryVector;
use parry3d_f64::transformation::try_convex_hull;
use robust::{Coord, Coord3D, orient2d, orient3d};

/// Corners of a convex hull, and its faces as indices into them, counterclockwise from outside.
pub(crate) type HullFaces = (Vec<ParryVector>, Vec<[u32; 3]>);

/// The convex hull of points; `None` if they lie in one plane.
pub(crate) fn hull_faces(points: &[ParryVector]) -> Option<HullFaces> {
    /// Maximum number of points for the library's hull, whose memory and time are quadratic for points that lie mostly in
    /// few planes (a disc, a flange).
    const MOST_FOR_LIBRARY: usize = 2000;
    if points.len() <= MOST_FOR_LIBRARY { try_convex_hull(points).ok() } else { Quickhull::of(points) }
}

/// Quickhull of Barber, Dobkin & Huhdanpaa 1996, "The Quickhull algorithm for convex hulls", whole, on exact predicates
/// (Shewchuk 1997, §4, in the crate `robust`). Its memory is linear in the number of points.
///
/// 1. Builds a tetrahedron of extreme points. Each other point is assigned to one face that it is above, or is inside.
/// 2. The farthest point of a face replaces all faces that it is above. It also replaces the faces of a plane that contains it
///    if a new face would otherwise have no area.
/// 3. New faces join it to the rim of the gap. Points of the old faces are assigned to new ones, or are inside.
struct Quickhull<'a> {
    points: &'a [ParryVector],
    faces: Vec<Face>,
}

struct Face {
    corners: [u32; 3],
    /// Faces across the sides from each corner to the next.
    neighbours: [usize; 3],
    above: Vec<u32>,
    is_alive: bool,
}

/// Side of a gap: its two corners, the face beyond, and the index of the side there.
type RimSide = (u32, u32, usize, usize);

impl<'a> Quickhull<'a> {
    fn of(points: &'a [ParryVector]) -> Option<HullFaces> {
        let mut hull = Self { points, faces: Vec::new() };
        // 1.
        let [a, b, c, d] = hull.tetrahedron()?;
        for (corners, neighbours) in
            [([a, b, c], [3, 1, 2]), ([b, d, c], [3, 2, 0]), ([c, d, a], [1, 3, 0]), ([a, d, b], [2, 1, 0])]
        {
            hull.faces.push(Face { corners, neighbours, above: Vec::new(), is_alive: true });
        }
        let count = u32::try_from(points.len()).ok()?;
        hull.hand_out(0..count, 0);
        let mut next = 0;
        while next < hull.faces.len() {
            if hull.faces[next].is_alive && !hull.faces[next].above.is_empty() {
                hull.add(next);
            }
            next += 1;
        }
        Some(hull.finish())
    }

    fn at(&self, point: u32) -> ParryVector {
        self.points[point as usize]
    }

    /// Positive for a point above the plane of three corners, which are counterclockwise from there. The sign is exact.
    fn height(&self, [a, b, c]: [u32; 3], point: u32) -> f64 {
        let [a, b, c, p] = [a, b, c, point].map(|index| {
            let ParryVector { x, y, z } = self.at(index);
            Coord3D { x, y, z }
        });
        -orient3d(a, b, c, p)
    }

    fn are_on_one_line(&self, [a, b, c]: [u32; 3]) -> bool {
        let corners = [a, b, c].map(|index| self.at(index));
        [(0, 1), (1, 2), (2, 0)].iter().all(|&(x, y)| {
            let [a, b, c] = corners.map(|corner| Coord { x: corner[x], y: corner[y] });
            orient2d(a, b, c) == 0.0
        })
    }

    /// Corners of an initial tetrahedron, the first three counterclockwise from outside.
    fn tetrahedron(&self) -> Option<[u32; 4]> {
        let all = || 0..u32::try_from(self.points.len()).unwrap_or(u32::MAX);
        let farthest =
            |measure: &dyn Fn(u32) -> f64| all().max_by(|a, b| measure(*a).total_cmp(&measure(*b)));
        let a = farthest(&|point| -self.at(point).x)?;
        let b = farthest(&|point| (self.at(point) - self.at(a)).length())?;
        let along = self.at(b) - self.at(a);
        let c = farthest(&|point| along.cross(self.at(point) - self.at(a)).length())?;
        let d = farthest(&|point| self.height([a, b, c], point).abs())?;
        let height = self.height([a, b, c], d);
        if height > 0.0 { Some([a, c, b, d]) } else { (height < 0.0).then_some([a, b, c, d]) }
    }

    /// Assigns each point to the first face from `first` on that it is above.
    fn hand_out(&mut self, points: impl IntoIterator<Item = u32>, first: usize) {
        for point in points {
            let face =
                (first..self.faces.len()).find(|&face| self.height(self.faces[face].corners, point) > 0.0);
            if let Some(face) = face {
                self.faces[face].above.push(point);
            }
        }
    }

    fn add(&mut self, face: usize) {
        // 2.
        let height = |point: &u32| self.height(self.faces[face].corners, *point);
        let Some(&top) = self.faces[face].above.iter().max_by(|a, b| height(a).total_cmp(&height(b))) else {
            return;
        };
        let (gap, rim) = self.gap(face, top);
        // 3.
        let first = self.faces.len();
        let mut begins_at = HashMap::new();
        for (index, &(from, to, outer, side)) in rim.iter().enumerate() {
            begins_at.insert(from, first + index);
            self.faces[outer].neighbours[side] = first + index;
            let neighbours = [outer, usize::MAX, usize::MAX];
            self.faces.push(Face { corners: [from, to, top], neighbours, above: Vec::new(), is_alive: true });
        }
        for new in first..self.faces.len() {
            let after = begins_at[&self.faces[new].corners[1]];
            self.faces[new].neighbours[1] = after;
            self.faces[after].neighbours[2] = new;
        }
        let mut left = Vec::new();
        for old in gap {
            left.append(&mut self.faces[old].above);
        }
        self.hand_out(left, first);
    }

    /// Removes the faces that a point replaces, and returns them with their rim.
    fn gap(&mut self, face: usize, top: u32) -> (Vec<usize>, Vec<RimSide>) {
        let mut gap = vec![face];
        self.faces[face].is_alive = false;
        loop {
            let mut next = 0;
            while next < gap.len() {
                for beyond in self.faces[gap[next]].neighbours {
                    if self.faces[beyond].is_alive && self.height(self.faces[beyond].corners, top) > 0.0 {
                        self.faces[beyond].is_alive = false;
                        gap.push(beyond);
                    }
                }
                next += 1;
            }
            let rim = self.rim(&gap);
            let flat = rim.iter().find(|(from, to, ..)| self.are_on_one_line([*from, *to, top]));
            let Some(&(_, _, outer, _)) = flat else { return (gap, rim) };
            // The point replaces all faces of that plane.
            let mut plane = vec![outer];
            self.faces[outer].is_alive = false;
            while let Some(flat) = plane.pop() {
                gap.push(flat);
                for beyond in self.faces[flat].neighbours {
                    if self.faces[beyond].is_alive && self.height(self.faces[beyond].corners, top) == 0.0 {
                        self.faces[beyond].is_alive = false;
                        plane.push(beyond);
                    }
                }
            }
        }
    }

    fn rim(&self, gap: &[usize]) -> Vec<RimSide> {
        let sides = gap.iter().flat_map(|&face| (0..3).map(move |side| (face, side)));
        sides
            .filter_map(|(face, side)| {
                let Face { corners, neighbours, .. } = &self.faces[face];
                let outer = neighbours[side];
                let back = self.faces[outer].neighbours.iter().position(|&neighbour| neighbour == face)?;
                self.faces[outer].is_alive.then_some((corners[side], corners[(side + 1) % 3], outer, back))
            })
            .collect()
    }

    fn finish(self) -> HullFaces {
        let alive = || self.faces.iter().filter(|face| face.is_alive).map(|face| face.corners);
        let mut corners: Vec<u32> = alive().flatten().collect();
        corners.sort_unstable();
        corners.dedup();
        let place =
            |corner: u32| corners.binary_search(&corner).map_or(0, |at| u32::try_from(at).unwrap_or(0));
        let faces = alive().map(|face| face.map(place)).collect();
        (corners.iter().map(|&corner| self.at(corner)).collect(), faces)
    }
}

#[cfg(test)]
mod tests {
    use cranny_spatial::{Point, Rotation, Stream, Vector, sin_cos};

    use super::*;
    use crate::inside::closed_mesh::check_closed;
    use crate::{TriangleSoup, distance::parry};

    fn hull(points: &[Point]) -> TriangleSoup {
        let given: Vec<_> = points.iter().map(parry::point).collect();
        let (vertices, triangles) = Quickhull::of(&given).expect("it has a volume");
        let hull = TriangleSoup {
            vertices: vertices.into_iter().map(|v| parry::to_vector(v).into()).collect(),
            triangles,
        };
        check_closed(&hull).expect("it is closed");
        for plane in hull.planes() {
            assert!(points.iter().all(|point| plane.height(point) < 1e-12));
        }
        hull
    }

    fn ring(corners: u32, radius_m: f64, z: f64) -> impl Iterator<Item = Point> {
        (0..corners).map(move |corner| {
            let angle = std::f64::consts::TAU * f64::from(corner) / f64::from(corners);
            let (sine, cosine) = sin_cos(angle);
            Point::new(radius_m * cosine, radius_m * sine, z)
        })
    }

    #[test]
    fn a_flange_of_eight_thousand_points_has_its_rim_for_a_hull() {
        let circles = [(0.1, 0.0), (0.1, 0.01), (0.04, 0.0), (0.04, 0.01)];
        let points: Vec<Point> = circles.iter().flat_map(|&(radius_m, z)| ring(2000, radius_m, z)).collect();
        let flange = hull(&points);
        assert_eq!(flange.vertices.len(), 4000);
        let prism = 0.5 * 2000.0 * 0.1_f64.powi(2) * sin_cos(std::f64::consts::TAU / 2000.0).0 * 0.01;
        assert!((flange.signed_volume_m3() - prism).abs() < 1e-9 * prism);
    }

    #[test]
    fn a_grid_of_points_is_a_cuboid() {
        let points: Vec<Point> = (0..9 * 8 * 7)
            .map(|index| Point::new(f64::from(index % 9), f64::from(index / 9 % 8), f64::from(index / 72)))
            .collect();
        assert!((hull(&points).signed_volume_m3() - 8.0 * 7.0 * 6.0).abs() < 1e-9);
    }

    #[test]
    fn hulls_are_those_of_the_library() {
        let mut random = Stream::new(7, 0);
        for count in [5, 12, 100, 600] {
            let turn = Rotation::from_euler_angles(random.uniform(), random.uniform(), random.uniform());
            let mut draw = || turn * Vector::new(random.normal(), random.normal(), random.normal().round());
            let points: Vec<Point> = (0..count).map(|_| draw().into()).collect();
            let expected = TriangleSoup::convex_hull(&points).expect("it has a volume").signed_volume_m3();
            assert!((hull(&points).signed_volume_m3() - expected).abs() < 1e-9 * expected);
        }
    }

    #[test]
    fn points_in_one_plane_have_none() {
        let flat: Vec<_> = ring(50, 1.0, 0.5).map(|point| parry::point(&point)).collect();
        assert!(Quickhull::of(&flat).is_none());
    }
}
