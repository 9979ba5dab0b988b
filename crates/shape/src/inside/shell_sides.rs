use cranny_spatial::{Point, Vector};
use robust::{Coord3D, orient3d};

use crate::distance::triangle_tree::TriangleTree;
use crate::inside::shell::Facet;

/// Closed surfaces of which each triangle of a mesh is a wall.
#[derive(Clone, Debug)]
pub(crate) struct ShellSides {
    /// Shell behind the face of each triangle, and shell in front of it.
    sides: Vec<[Option<u32>; 2]>,
}

/// Intersection of a segment and a triangle.
enum Crossing {
    Missed,
    /// The segment passes through; `leaves` is true from back to front.
    Through {
        leaves: bool,
    },
    /// The segment begins on the triangle.
    Begins,
    /// The segment meets an edge, or lies in the triangle's plane.
    Undecided,
}

impl ShellSides {
    /// `ShellSides` of a mesh of `triangles` triangles, in shells of these facets.
    pub fn new<'a>(triangles: usize, shells: impl IntoIterator<Item = &'a [Facet]>) -> Self {
        let mut sides = vec![[None; 2]; triangles];
        for (shell, facets) in (0..).zip(shells) {
            for facet in facets {
                sides[facet.triangle as usize][usize::from(facet.is_inward)] = Some(shell);
            }
        }
        Self { sides }
    }

    /// Shells that wind around a point or pass through it, other than `except`.
    ///
    /// A segment from the point to a region without triangles meets each shell as often from inside as from outside if
    /// the point is outside (the winding number, counted). An exact predicate decides on which side of an edge the
    /// segment passes (Shewchuk 1997, "Adaptive precision floating-point arithmetic and fast robust geometric
    /// predicates", §4). If the segment meets an edge, another segment is tried.
    pub fn around(
        &self,
        tree: &TriangleTree,
        corners: impl Fn(u32) -> [Point; 3],
        point: &Point,
        except: Option<u32>,
    ) -> Vec<u32> {
        let Some(reach_m) = tree.reach_from(point) else { return Vec::new() };
        let mut windings: Vec<(u32, i32)> = Vec::new();
        let add = |windings: &mut Vec<(u32, i32)>, shell: Option<u32>, step: i32| {
            let Some(shell) = shell.filter(|shell| Some(*shell) != except) else { return };
            match windings.iter_mut().find(|(of, _)| *of == shell) {
                Some((_, winding)) => *winding += step,
                None => windings.push((shell, step)),
            }
        };
        'directions: for index in 0..DIRECTIONS {
            windings.clear();
            let end = point + direction(index) * reach_m;
            let mut passing = Vec::new();
            for triangle in tree.along_segment(point, &end) {
                let [behind, ahead] = self.sides[triangle as usize];
                if [behind, ahead].iter().all(|shell| shell.is_none() || *shell == except) {
                    continue;
                }
                match crossing(&corners(triangle), point, &end) {
                    Crossing::Missed => {}
                    Crossing::Through { leaves } => {
                        let step = if leaves { 1 } else { -1 };
                        add(&mut windings, behind, step);
                        add(&mut windings, ahead, -step);
                    }
                    Crossing::Begins => passing.extend([behind, ahead]),
                    Crossing::Undecided => continue 'directions,
                }
            }
            windings.retain(|(_, winding)| *winding != 0);
            for shell in passing {
                if windings.iter().all(|(of, _)| Some(*of) != shell) {
                    add(&mut windings, shell, 1);
                }
            }
            break;
        }
        windings.into_iter().map(|(shell, _)| shell).collect()
    }
}

/// Number of directions. Another is tried only if a segment meets an edge within the last bit of its coordinates.
const DIRECTIONS: usize = 32;

/// Direction with which no mesh is aligned by design: evenly spread over the sphere by the golden angle.
fn direction(index: usize) -> Vector {
    const GOLDEN_ANGLE_RAD: f64 = 2.399_963_229_728_653;
    let z = 1.0 - (2.0 * index as f64 + 0.866_025_4) / DIRECTIONS as f64;
    let (across, turn) = ((1.0 - z * z).sqrt(), GOLDEN_ANGLE_RAD * index as f64 + 0.577_215_66);
    Vector::new(across * libm::cos(turn), across * libm::sin(turn), z)
}

fn crossing([a, b, c]: &[Point; 3], from: &Point, to: &Point) -> Crossing {
    let exact = |p: &Point| Coord3D { x: p.x, y: p.y, z: p.z };
    let [a, b, c, from, to] = [a, b, c, from, to].map(exact);
    let sides = [orient3d(from, to, a, b), orient3d(from, to, b, c), orient3d(from, to, c, a)];
    if sides.iter().any(|side| *side > 0.0) && sides.iter().any(|side| *side < 0.0) {
        return Crossing::Missed;
    }
    // Positive behind the face.
    match (orient3d(a, b, c, from), orient3d(a, b, c, to)) {
        (0.0, 0.0) => Crossing::Undecided,
        (0.0, _) => Crossing::Begins,
        (at, end) if (at > 0.0) == (end > 0.0) => Crossing::Missed,
        _ if sides.contains(&0.0) => Crossing::Undecided,
        (at, _) => Crossing::Through { leaves: at > 0.0 },
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::signed_solid_angle;
    use cranny_spatial::Stream;

    fn ball(center: Vector, radius_m: f64, is_inward: bool) -> Vec<[Point; 3]> {
        let sphere = crate::TriangleSoup::geodesic_sphere(radius_m, 2);
        let corners = |[a, b, c]: [u32; 3]| {
            [a, if is_inward { c } else { b }, if is_inward { b } else { c }]
                .map(|vertex| sphere.vertices[vertex as usize] + center)
        };
        sphere.triangles.iter().map(|triangle| corners(*triangle)).collect()
    }

    /// The summed solid angles of all faces are a winding number too (Jacobson et al. 2013, "Robust inside-outside
    /// segmentation using generalized winding numbers", whole).
    #[test]
    fn crossings_count_what_solid_angles_sum_to() {
        let shells = [
            ball(Vector::zeros(), 1.0, false),
            ball(Vector::x() * 0.8, 0.7, false),
            ball(Vector::zeros(), 0.4, true),
        ];
        let corners: Vec<[Point; 3]> = shells.iter().flatten().copied().collect();
        let mut begin = 0;
        let mut facets = Vec::new();
        for shell in &shells {
            let end = begin + u32::try_from(shell.len()).expect("few");
            facets
                .push((begin..end).map(|triangle| Facet { triangle, is_inward: false }).collect::<Vec<_>>());
            begin = end;
        }
        let walls = ShellSides::new(corners.len(), facets.iter().map(Vec::as_slice));
        let tree = TriangleTree::new(&corners);
        let mut random = Stream::new(5, 0);
        let mut draw = |_| {
            // Some numbers are round, because planes, edges and vertices of the mesh lie there.
            let x = 3.6 * random.uniform() - 1.8;
            if random.uniform() < 0.3 { (x * 4.0).round() / 4.0 } else { x }
        };
        for _ in 0..5000 {
            let point = Point::from([0, 1, 2].map(&mut draw));
            let mut around = walls.around(&tree, |t| corners[t as usize], &point, None);
            around.sort_unstable();
            let summed = (0..3_u32).filter(|&shell| {
                let angles = shells[shell as usize].iter().map(|corners| signed_solid_angle(corners, &point));
                angles.sum::<f64>().abs() > std::f64::consts::TAU
            });
            assert_eq!(around, summed.collect::<Vec<_>>(), "{point:?}");
        }
        let vertex = shells[1][0][0];
        assert!(walls.around(&tree, |t| corners[t as usize], &vertex, None).contains(&1));
        assert!(!walls.around(&tree, |t| corners[t as usize], &vertex, Some(1)).contains(&1));
    }
}
