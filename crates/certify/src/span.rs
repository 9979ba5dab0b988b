use cranny_collision::{Cell, Part};
use cranny_robot::LinkMotion;
use cranny_shape::{Outline, Solid};
use cranny_spatial::{Point, Pose, Vector};

/// Solid as a certificate has it.
pub(crate) struct PlacedSolid {
    pub pose: Pose,
    pub shape: Shape,
    /// Corners of a box around it, in the frame of the object.
    low: Vector,
    high: Vector,
}

pub(crate) enum Shape {
    Cuboid(Vector),
    Capsule {
        half_length_m: f64,
        radius_m: f64,
    },
    Cylinder {
        half_length_m: f64,
        radius_m: f64,
    },
    HalfSpace,
    Hull {
        points: Vec<Vector>,
        radius_m: f64,
    },
    /// Surface of triangles, ordered so that both halves of a run of triangles are compact.
    Mesh {
        points: Vec<Vector>,
        faces: Vec<[usize; 3]>,
    },
}

impl Shape {
    /// Returns a bound of the distance of its points from its middle, in metres; infinite if it has none.
    pub fn radius_m(&self) -> f64 {
        match self {
            Self::Cuboid(half) => half.norm(),
            Self::Capsule { half_length_m, radius_m } => half_length_m + radius_m,
            Self::Cylinder { half_length_m, radius_m } => half_length_m.hypot(*radius_m),
            Self::HalfSpace | Self::Hull { .. } | Self::Mesh { .. } => f64::INFINITY,
        }
    }
}

/// Link, or body of the world (without a motion).
pub(crate) struct Object {
    pub name: String,
    pub motion: Option<LinkMotion>,
    pub solids: Vec<PlacedSolid>,
}

/// Consecutive solids of an object, or consecutive faces of one mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Span {
    pub solids: [usize; 2],
    pub faces: [usize; 2],
}

impl PlacedSolid {
    pub fn new(object_from_solid: Pose, solid: &Solid) -> Self {
        let shape = match solid.outline() {
            Outline::Cuboid { half_extents } => Shape::Cuboid(half_extents),
            Outline::Segment { half_length_m, radius_m } => Shape::Capsule { half_length_m, radius_m },
            Outline::Cylinder { half_length_m, radius_m } => Shape::Cylinder { half_length_m, radius_m },
            Outline::HalfSpace => Shape::HalfSpace,
            Outline::Other if solid.support_point(&Vector::z()).is_some() => {
                let (points, radius_m) = solid.bounding_points().unwrap_or_default();
                Shape::Hull { points: points.iter().map(|point| point.coords).collect(), radius_m }
            }
            Outline::Union | Outline::Other => mesh(solid),
        };
        let mut placed = Self { pose: object_from_solid, shape, low: Vector::zeros(), high: Vector::zeros() };
        let far = |direction: Vector| placed.support(&direction, placed.all_faces()).1;
        let axes = [Vector::x(), Vector::y(), Vector::z()];
        let corner =
            |sign: f64| Vector::from_iterator(axes.iter().enumerate().map(|(i, axis)| far(axis * sign)[i]));
        (placed.low, placed.high) = (corner(-1.0), corner(1.0));
        placed
    }

    pub fn faces(&self) -> usize {
        if let Shape::Mesh { faces, .. } = &self.shape { faces.len() } else { 0 }
    }

    fn all_faces(&self) -> [usize; 2] {
        [0, self.faces()]
    }

    /// Returns the greatest n·p over the solid, or these faces of it, and the point p, in the frame of the object.
    fn support(&self, n: &Vector, faces: [usize; 2]) -> (f64, Vector) {
        let m = self.pose.rotation.inverse_transform_vector(n);
        let long = m.norm();
        let unit = if long > 0.0 { m / long } else { m };
        let farthest = |points: &mut dyn Iterator<Item = &Vector>| {
            let (mut most, mut best) = (f64::NEG_INFINITY, Vector::zeros());
            for point in points {
                let along = m.dot(point);
                if along > most {
                    (most, best) = (along, *point);
                }
            }
            best
        };
        let local = match &self.shape {
            Shape::Cuboid(half) => {
                Vector::new(half.x.copysign(m.x), half.y.copysign(m.y), half.z.copysign(m.z))
            }
            Shape::Capsule { half_length_m, radius_m } => {
                Vector::new(0.0, 0.0, half_length_m.copysign(m.z)) + unit * *radius_m
            }
            Shape::Cylinder { half_length_m, radius_m } => {
                let across = (m.x * m.x + m.y * m.y).sqrt();
                let scale = if across > 0.0 { radius_m / across } else { 0.0 };
                Vector::new(m.x * scale, m.y * scale, half_length_m.copysign(m.z))
            }
            Shape::HalfSpace => return (f64::INFINITY, Vector::zeros()),
            Shape::Hull { points, radius_m } => farthest(&mut points.iter()) + unit * *radius_m,
            Shape::Mesh { points, .. } if faces == self.all_faces() => farthest(&mut points.iter()),
            Shape::Mesh { points, faces: all } => {
                farthest(&mut all[faces[0]..faces[1]].iter().flatten().map(|index| &points[*index]))
            }
        };
        let point = (self.pose * Point::from(local)).coords;
        (n.dot(&point), point)
    }
}

impl Object {
    /// Returns a link of a cell under this name, with its pose there.
    pub fn link(cell: &Cell, name: String, link: usize, motion: LinkMotion) -> Self {
        let solids =
            cell.solids_of(link).iter().map(|(pose, solid)| PlacedSolid::new(*pose, solid)).collect();
        Self::ordered(name, Some(motion), solids)
    }

    /// Returns an object of these parts of the world of a cell.
    pub fn body(cell: &Cell, name: String, parts: &[usize]) -> Self {
        let part = |index: &usize| &cell.parts()[*index].1;
        let pieces = |part: &Part| {
            let placed =
                |(pose, solid): (Pose, Solid)| PlacedSolid::new(part.world_from_solid * pose, &solid);
            part.solid.pieces().into_iter().map(placed).collect::<Vec<_>>()
        };
        let solids = parts.iter().map(part).flat_map(pieces);
        Self::ordered(name, None, solids.collect())
    }

    /// Orders the solids so that both halves of a run of them are compact.
    fn ordered(name: String, motion: Option<LinkMotion>, mut solids: Vec<PlacedSolid>) -> Self {
        order(&mut solids, &|solid| (solid.low + solid.high) * 0.5);
        Self { name, motion, solids }
    }

    pub fn whole(&self) -> Span {
        self.span(0, self.solids.len())
    }

    pub fn span(&self, begin: usize, end: usize) -> Span {
        Span {
            solids: [begin, end],
            faces: if end == begin + 1 { self.solids[begin].all_faces() } else { [0, 0] },
        }
    }

    /// Returns the halves of a span; `None` for a convex solid and a single face.
    pub fn halves(&self, Span { solids: [begin, end], faces: [first, last] }: Span) -> Option<[Span; 2]> {
        if end > begin + 1 {
            let middle = begin + (end - begin) / 2;
            return Some([self.span(begin, middle), self.span(middle, end)]);
        }
        let middle = first + (last - first) / 2;
        let of = |faces| Span { solids: [begin, end], faces };
        (last > first + 1).then(|| [of([first, middle]), of([middle, last])])
    }

    pub fn has_whole_meshes(&self, Span { solids: [begin, end], faces }: Span) -> bool {
        end > begin + 1 || faces == self.solids[begin].all_faces()
    }

    /// Returns the pose, in the frame of the object, of the single half-space of a span.
    pub fn half_space(&self, Span { solids: [begin, end], .. }: Span) -> Option<&Pose> {
        let solid = &self.solids[begin];
        (end == begin + 1 && matches!(solid.shape, Shape::HalfSpace)).then_some(&solid.pose)
    }

    pub fn support(&self, span: Span, n: &Vector) -> (f64, Vector) {
        let [begin, end] = span.solids;
        let of = |solid: &PlacedSolid| {
            solid.support(n, if end == begin + 1 { span.faces } else { solid.all_faces() })
        };
        let all = self.solids[begin..end].iter().map(of);
        all.fold((f64::NEG_INFINITY, Vector::zeros()), |best, next| if next.0 > best.0 { next } else { best })
    }

    /// Returns centre and radius of a ball around a span, by the boxes of its solids.
    pub fn ball(&self, span: Span) -> (Vector, f64) {
        let solids = &self.solids[span.solids[0]..span.solids[1]];
        let low = solids.iter().map(|solid| solid.low).reduce(|a, b| a.inf(&b)).unwrap_or_default();
        let high = solids.iter().map(|solid| solid.high).reduce(|a, b| a.sup(&b)).unwrap_or_default();
        ((low + high) * 0.5, (high - low).norm() * 0.5)
    }

    /// Returns the normals of the faces of a single cuboid, in the frame of the object.
    pub fn face_normals(&self, Span { solids: [begin, end], .. }: Span) -> Vec<Vector> {
        let solid = &self.solids[begin];
        if end > begin + 1 || !matches!(solid.shape, Shape::Cuboid(_)) {
            return Vec::new();
        }
        let axes = [Vector::x(), Vector::y(), Vector::z()].map(|axis| solid.pose.rotation * axis);
        axes.into_iter().flat_map(|axis| [axis, -axis]).collect()
    }
}

fn mesh(solid: &Solid) -> Shape {
    let soup = solid.tessellation().unwrap_or_default();
    let points: Vec<Vector> = soup.vertices.iter().map(|point| point.coords).collect();
    let mut faces: Vec<[usize; 3]> =
        soup.triangles.iter().map(|face| face.map(|index| index as usize)).collect();
    order(&mut faces, &|face| face.iter().fold(Vector::zeros(), |sum, index| sum + points[*index]) / 3.0);
    Shape::Mesh { points, faces }
}

/// Divides elements at the median along the longest side of the box around their places, and so on within both halves.
fn order<T>(elements: &mut [T], place: &impl Fn(&T) -> Vector) {
    if elements.len() < 3 {
        return;
    }
    let (mut low, mut high) = (place(&elements[0]), place(&elements[0]));
    for element in &*elements {
        (low, high) = (low.inf(&place(element)), high.sup(&place(element)));
    }
    let axis = (high - low).imax();
    let middle = elements.len() / 2;
    elements.select_nth_unstable_by(middle, |a, b| place(a)[axis].total_cmp(&place(b)[axis]));
    let (first, second) = elements.split_at_mut(middle);
    order(first, place);
    order(second, place);
}
