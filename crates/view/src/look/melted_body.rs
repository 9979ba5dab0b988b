//! Primitives blended into one smooth solid.
//!
//! 1. Each primitive is a signed distance; a polynomial smooth minimum joins them with fillets.
//! 2. The distance is sampled on a grid, and each cell that the surface crosses gets a vertex (surface nets: Gibson 1998,
//!    "Constrained elastic surface nets", whole).
//! 3. The vertices are moved onto the surface along the gradient, their normal, so that a coarse grid appears smooth.

use std::sync::{Mutex, PoisonError};

use cranny_robot::{LinkForm, LinkVisual};
use cranny_shape::Aabb;
use cranny_spatial::{Point, Pose, Vector};

use crate::MeshPiece;

/// Primitive of a blended solid.
#[derive(Clone, PartialEq)]
pub(crate) struct Primitive {
    body_from_here: Pose,
    here_from_body: Pose,
    form: Form,
    blend_m: f64,
}

/// Shape with sizes in metres; `rounding_m` is the inward rounding radius of the edges.
#[derive(Clone, PartialEq)]
enum Form {
    Cuboid { half_extents: Vector, rounding_m: f64 },
    Capsule { half_length_m: f64, radius_m: f64 },
    Cylinder { half_length_m: f64, radius_m: f64, rounding_m: f64 },
}

impl Primitive {
    /// Converts a visual; `None` for a mesh.
    pub fn of(visual: &LinkVisual) -> Option<Self> {
        let rounding_m = visual.rounding_m;
        let form = match visual.form {
            LinkForm::Cuboid { size } => {
                let half_extents = size * 0.5;
                Form::Cuboid { half_extents, rounding_m: rounding_m.min(half_extents.min()) }
            }
            LinkForm::Sphere { radius_m } => Form::Capsule { half_length_m: 0.0, radius_m },
            LinkForm::Capsule { length_m, radius_m } => {
                Form::Capsule { half_length_m: 0.5 * length_m, radius_m }
            }
            LinkForm::Cylinder { length_m, radius_m } => {
                let half_length_m = 0.5 * length_m;
                Form::Cylinder {
                    half_length_m,
                    radius_m,
                    rounding_m: rounding_m.min(half_length_m).min(radius_m),
                }
            }
            LinkForm::Hull { .. } | LinkForm::Mesh { .. } => return None,
        };
        Some(Self {
            body_from_here: visual.link_from_visual,
            here_from_body: visual.link_from_visual.inverse(),
            form,
            blend_m: visual.blend_m,
        })
    }

    fn bounds(&self) -> Aabb {
        let half_extents = match self.form {
            Form::Cuboid { half_extents, .. } => half_extents,
            Form::Capsule { half_length_m, radius_m } => {
                Vector::new(radius_m, radius_m, half_length_m + radius_m)
            }
            Form::Cylinder { half_length_m, radius_m, .. } => Vector::new(radius_m, radius_m, half_length_m),
        };
        Aabb { center: Point::origin(), half_extents }.transformed(&self.body_from_here)
    }

    /// Signed distance from the surface, in metres; negative inside.
    fn distance(&self, point_in_body: &Point) -> f64 {
        let p = self.here_from_body * point_in_body;
        match self.form {
            Form::Cuboid { half_extents, rounding_m } => {
                let beyond = p.coords.abs() - half_extents.add_scalar(-rounding_m);
                beyond.sup(&Vector::zeros()).norm() + beyond.max().min(0.0) - rounding_m
            }
            Form::Capsule { half_length_m, radius_m } => {
                let along = p.z.clamp(-half_length_m, half_length_m);
                Vector::new(p.x, p.y, p.z - along).norm() - radius_m
            }
            Form::Cylinder { half_length_m, radius_m, rounding_m } => {
                let across = (p.x * p.x + p.y * p.y).sqrt() - (radius_m - rounding_m);
                let along = p.z.abs() - (half_length_m - rounding_m);
                let (out_across, out_along) = (across.max(0.0), along.max(0.0));
                let outside = (out_across * out_across + out_along * out_along).sqrt();
                outside + across.max(along).min(0.0) - rounding_m
            }
        }
    }
}

/// Signed distance from the blended solid, in metres, negative inside; at most that from any primitive.
fn distance(primitives: &[Primitive], point: &Point) -> f64 {
    let mut nearest = f64::INFINITY;
    for primitive in primitives {
        let own = primitive.distance(point);
        let blend_m = primitive.blend_m;
        let overlap = (blend_m - (nearest - own).abs()).max(0.0);
        nearest = nearest.min(own);
        if blend_m > 0.0 {
            nearest -= 0.25 * overlap * overlap / blend_m;
        }
    }
    nearest
}

fn gradient(primitives: &[Primitive], point: &Point) -> Vector {
    /// Finite-difference step, a hundredth of a cell: small against any fillet, large against rounding.
    const STEP_M: f64 = 5e-5;
    let along = |axis: Vector| {
        distance(primitives, &(point + axis * STEP_M)) - distance(primitives, &(point - axis * STEP_M))
    };
    let slopes = Vector::new(along(Vector::x()), along(Vector::y()), along(Vector::z()));
    slopes.try_normalize(0.0).unwrap_or_else(Vector::z)
}

/// Minimum and maximum number of cells on the bounding box of a solid: fine enough at a few metres, few enough for a page.
const FEWEST_CELLS: f64 = 1700.0;
const MOST_CELLS: f64 = 3200.0;

/// Cells across a fillet, within the bounds above.
const CELLS_ACROSS: f64 = 2.0;

/// Cache of the blended solids of this process by their primitives, as a robot appears in many scenes and blending is slow.
static KNOWN: Mutex<Vec<(Vec<Primitive>, MeshPiece)>> = Mutex::new(Vec::new());

/// Capacity of the cache: the links of a few robots.
const MOST_KNOWN: usize = 128;

/// Returns the blended solid of primitives; empty for none.
pub(crate) fn melted(primitives: &[Primitive], material: usize) -> MeshPiece {
    if primitives.is_empty() {
        return MeshPiece::default();
    }
    let known = || KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
    let found = known().iter().find(|(own, _)| own == primitives).map(|(_, piece)| piece.clone());
    let piece = found.unwrap_or_else(|| {
        let piece = melt(primitives);
        let mut known = known();
        if known.len() >= MOST_KNOWN {
            known.clear();
        }
        known.push((primitives.to_vec(), piece.clone()));
        piece
    });
    MeshPiece { material, ..piece }
}

/// Computes the blended solid of `primitives`, which are not empty, with material 0.
fn melt(primitives: &[Primitive]) -> MeshPiece {
    let corners: Vec<Point> =
        primitives.iter().map(Primitive::bounds).flat_map(|bounds| [bounds.low(), bounds.high()]).collect();
    let whole = Aabb::around(&corners, 0.0);
    let [x, y, z] = <[f64; 3]>::from(whole.half_extents * 2.0);
    let cell_of = |count: f64| (2.0 * (x * y + y * z + z * x) / count).sqrt();
    let finest_blend_m = primitives.iter().map(|primitive| primitive.blend_m).fold(f64::INFINITY, f64::min);
    let cell_m = (finest_blend_m / CELLS_ACROSS).clamp(cell_of(MOST_CELLS), cell_of(FEWEST_CELLS));
    Net::over(primitives, &whole, cell_m).mesh(primitives, 0)
}

/// Signed distance sampled on a grid.
struct Net {
    low: Point,
    cell_m: f64,
    /// Number of samples along each axis.
    counts: [usize; 3],
    samples: Vec<f64>,
}

impl Net {
    fn over(primitives: &[Primitive], around: &Aabb, cell_m: f64) -> Self {
        // Fillets lie within the hull, which lies within the bounds. Two additional cells keep the surface inside.
        let whole = around.grown(2.0 * cell_m);
        #[allow(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "sizes of links over sizes of cells: small whole numbers"
        )]
        let counts = [0, 1, 2].map(|axis| (2.0 * whole.half_extents[axis] / cell_m) as usize + 2);
        let mut net = Self { low: whole.low(), cell_m, counts, samples: Vec::new() };
        let total = counts.iter().product();
        net.samples = (0..total).map(|index| distance(primitives, &net.corner(net.place(index)))).collect();
        net
    }

    fn place(&self, index: usize) -> [usize; 3] {
        let [x, y, _] = self.counts;
        [index % x, index / x % y, index / (x * y)]
    }

    fn index(&self, [x, y, z]: [usize; 3]) -> usize {
        (z * self.counts[1] + y) * self.counts[0] + x
    }

    fn corner(&self, place: [usize; 3]) -> Point {
        let [x, y, z] = place.map(|count| count as f64);
        self.low + Vector::new(x, y, z) * self.cell_m
    }

    /// Returns the mean of the points at which the surface crosses the edges of a cell; `None` if there are none.
    fn crossing(&self, cell: [usize; 3]) -> Option<Point> {
        let corner = |bits: usize| [cell[0] + (bits & 1), cell[1] + (bits >> 1 & 1), cell[2] + (bits >> 2)];
        let value = |bits: usize| self.samples[self.index(corner(bits))];
        let (mut sum, mut crossings) = (Vector::zeros(), 0.0);
        for from in 0..8_usize {
            for axis in [1, 2, 4] {
                let to = from | axis;
                let (a, b) = (value(from), value(to));
                if to == from || (a < 0.0) == (b < 0.0) {
                    continue;
                }
                let (start, end) = (self.corner(corner(from)), self.corner(corner(to)));
                sum += start.coords + (end - start) * (a / (a - b));
                crossings += 1.0;
            }
        }
        (crossings > 0.0).then(|| (sum / crossings).into())
    }

    fn mesh(&self, primitives: &[Primitive], material: usize) -> MeshPiece {
        let mut piece = MeshPiece { material, ..MeshPiece::default() };
        let mut vertices: Vec<Option<u32>> = vec![None; self.samples.len()];
        for (index, vertex) in vertices.iter_mut().enumerate() {
            let cell = self.place(index);
            if (0..3).any(|axis| cell[axis] + 1 >= self.counts[axis]) {
                continue;
            }
            let Some(crossing) = self.crossing(cell) else { continue };
            let (position, normal) = self.onto_surface(primitives, crossing);
            *vertex = Some(piece.push_point(&position, &normal));
        }
        for index in 0..self.samples.len() {
            let place = self.place(index);
            for axis in 0..3 {
                piece.triangles.extend(self.faces(place, axis, &vertices));
            }
        }
        piece
    }

    /// Returns two triangles across the edge from `place` along `axis`, if the surface crosses it.
    fn faces(&self, place: [usize; 3], axis: usize, vertices: &[Option<u32>]) -> Vec<[u32; 3]> {
        let (second, third) = ((axis + 1) % 3, (axis + 2) % 3);
        let mut end = place;
        end[axis] += 1;
        if end[axis] >= self.counts[axis] || place[second] == 0 || place[third] == 0 {
            return Vec::new();
        }
        let is_inside = self.samples[self.index(place)] < 0.0;
        if is_inside == (self.samples[self.index(end)] < 0.0) {
            return Vec::new();
        }
        // Four cells around the edge, counterclockwise seen from its end.
        let cell = |back_second: usize, back_third: usize| {
            let mut cell = place;
            cell[second] -= back_second;
            cell[third] -= back_third;
            vertices[self.index(cell)]
        };
        let (Some(a), Some(b), Some(c), Some(d)) = (cell(1, 1), cell(0, 1), cell(0, 0), cell(1, 0)) else {
            return Vec::new();
        };
        if is_inside { vec![[a, b, c], [a, c, d]] } else { vec![[a, c, b], [a, d, c]] }
    }

    /// Moves a point onto the surface, by at most a cell per iteration, and returns it with the normal there.
    fn onto_surface(&self, primitives: &[Primitive], start: Point) -> (Point, Vector) {
        let mut point = start;
        let mut normal = gradient(primitives, &point);
        for _ in 0..2 {
            let step = distance(primitives, &point).clamp(-self.cell_m, self.cell_m);
            point -= normal * step;
            normal = gradient(primitives, &point);
        }
        (point, normal)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use cranny_shape::TriangleSoup;

    fn visual(form: LinkForm, x: f64) -> LinkVisual {
        let link_from_visual = Pose::translation(x, 0.0, 0.0);
        LinkVisual { link_from_visual, form, colour: None, rounding_m: 0.01, blend_m: 0.02 }
    }

    /// Returns the volume after checking that the surface is closed and faces outwards.
    fn volume_m3(primitives: &[Primitive]) -> f64 {
        let piece = melted(primitives, 0);
        let point = |corner: &u32| Point::from(piece.positions[*corner as usize].map(f64::from));
        let soup = TriangleSoup::from_corners(piece.triangles.iter().flatten().map(point)).unwrap();
        cranny_shape::Solid::mesh(&soup).expect("a closed surface");
        for (position, normal) in piece.positions.iter().zip(&piece.normals) {
            let outside = Point::from(position.map(f64::from)) + Vector::from(normal.map(f64::from)) * 1e-3;
            assert!(distance(primitives, &outside) > 0.0);
        }
        soup.signed_volume_m3()
    }

    #[test]
    fn one_primitive_keeps_its_volume() {
        let ball = Primitive::of(&visual(LinkForm::Sphere { radius_m: 0.05 }, 0.0)).unwrap();
        let expected = 4.0 / 3.0 * std::f64::consts::PI * 0.05_f64.powi(3);
        let volume = volume_m3(&[ball]);
        assert!((volume / expected - 1.0).abs() < 0.02, "{volume} {expected}");
    }

    #[test]
    fn two_melt_into_one_closed_body_larger_than_either() {
        let forms = [
            (LinkForm::Cylinder { length_m: 0.1, radius_m: 0.04 }, 0.0),
            (LinkForm::Cuboid { size: Vector::new(0.1, 0.06, 0.05) }, 0.05),
        ];
        let primitives = forms.map(|(form, x)| Primitive::of(&visual(form, x)).unwrap());
        let volume = volume_m3(&primitives);
        let [cylinder, cuboid] = primitives.map(|primitive| volume_m3(&[primitive]));
        assert!(volume > cylinder && volume > cuboid && volume < cylinder + cuboid);
    }
}
