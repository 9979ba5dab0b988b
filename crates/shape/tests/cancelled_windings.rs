//! Meshes with faces that are reversed, doubled, overlapping or inside out: all that their surface seals off is solid. By a
//! winding number or a parity over the whole mesh, the inside of some of them would be empty, and a link in there free.

use cranny_shape::{ShapeError, Solid, Surface, TriangleSoup, separation};
use cranny_spatial::{Point, Pose, Rotation, Stream, Vector};

/// Corners of the triangles of a mesh, three at a time.
type Corners = Vec<[Point; 3]>;

fn corners(soup: &TriangleSoup) -> Corners {
    (0..soup.triangles.len()).map(|triangle| soup.corners(triangle)).collect()
}

fn soup(corners: &[[Point; 3]]) -> TriangleSoup {
    TriangleSoup::from_corners(corners.iter().flatten().copied()).unwrap()
}

fn turned(corners: &[[Point; 3]]) -> Corners {
    corners.iter().map(|[a, b, c]| [*a, *c, *b]).collect()
}

fn placed(soup: &TriangleSoup, pose: &Pose) -> Corners {
    corners(soup).iter().map(|triangle| triangle.map(|corner| pose * corner)).collect()
}

fn cuboid(low: [f64; 3], high: [f64; 3]) -> Corners {
    let (low, high) = (Point::from(low), Point::from(high));
    let soup = Surface::cuboid_soup(&((high - low) * 0.5));
    // Vertices of boxes that touch must be equal to the last bit.
    let corner = |p: Point| Point::from([0, 1, 2].map(|i| if p[i] < 0.0 { low[i] } else { high[i] }));
    corners(&soup).iter().map(|triangle| triangle.map(corner)).collect()
}

/// Returns the cuboid with the other diagonals.
fn with_other_diagonals(cuboid: &[[Point; 3]]) -> Corners {
    let quads = cuboid.chunks_exact(2).map(|two| [two[0][0], two[0][1], two[0][2], two[1][2]]);
    quads.flat_map(|[a, b, c, d]| [[b, c, d], [b, d, a]]).collect()
}

fn unit() -> Corners {
    cuboid([-0.5; 3], [0.5; 3])
}

fn is_full_at(solid: &Solid, point: [f64; 3]) -> bool {
    let speck = Solid::sphere(1e-4).unwrap();
    let there = Pose::from_parts(Vector::from(point).into(), Rotation::identity());
    separation(&speck, &there, solid, &Pose::identity(), f64::MAX).upper_m <= 0.0
}

/// Checks that the mesh is a solid that is full in the middle and empty beside it; returns its repairs.
fn full_in_the_middle(corners: &[[Point; 3]]) -> String {
    let solid = Solid::mesh(&soup(corners)).unwrap();
    assert!(is_full_at(&solid, [0.1, 0.02, -0.13]));
    assert!(!is_full_at(&solid, [0.6, 0.02, -0.13]));
    // A mesh inside is checked differently from a ball.
    let kernel = Solid::mesh(&Surface::cuboid_soup(&Vector::repeat(0.01))).unwrap();
    let gap = separation(&kernel, &Pose::identity(), &solid, &Pose::identity(), f64::MAX);
    assert!(gap.upper_m <= 0.0);
    solid.mesh_repairs().map(ToString::to_string).unwrap_or_default()
}

#[test]
fn a_mesh_that_needs_no_repair_stays_as_it_is() {
    let mesh = soup(&[unit(), cuboid([2.0; 3], [3.0; 3])].concat());
    let solid = Solid::mesh(&mesh).unwrap();
    assert_eq!(solid.mesh_repairs(), None);
    assert_eq!(solid.tessellation(), Some(mesh));
    // Two boxes that share a face, with its triangles once in each orientation.
    let mesh = soup(&[unit(), cuboid([-0.5, -0.5, 0.5], [0.5, 0.5, 1.5])].concat());
    let solid = Solid::mesh(&mesh).unwrap();
    assert_eq!(solid.mesh_repairs(), None);
    assert_eq!(solid.tessellation(), Some(mesh));
    assert!(is_full_at(&solid, [0.1, 0.2, 0.2]) && is_full_at(&solid, [0.1, 0.2, 1.2]));
}

#[test]
fn doubled_and_turned_faces_do_not_cancel() {
    let good = unit();
    let interleaved: Corners = good.iter().flat_map(|&[a, b, c]| [[a, b, c], [a, c, b]]).collect();
    let half_turned: Corners = good
        .iter()
        .enumerate()
        .map(|(i, &[a, b, c])| if i % 3 == 0 { [a, c, b] } else { [a, b, c] })
        .collect();
    let other = with_other_diagonals(&good);
    let mut apart = good.clone();
    for (index, triangle) in apart.iter_mut().enumerate() {
        // No two triangles share equal vertices, as in a mesh of a coarse text.
        for corner in triangle.iter_mut() {
            corner.x += 1e-8 * index as f64;
        }
    }
    let [a, b, _] = good[0];
    for (said, mesh) in [
        ("", good.clone()),
        ("12 of 12 triangles turned to face outwards", turned(&good)),
        ("12 of 24 triangles left out that stand there twice", [good.clone(), turned(&good)].concat()),
        ("12 of 24 triangles left out", interleaved),
        ("24 of 36 triangles left out", [good.clone(), good.clone(), good.clone()].concat()),
        ("4 of 12 triangles turned", half_turned),
        ("", [good.clone(), vec![[a, a, b], [b, b, b]]].concat()),
        ("vertices joined", apart),
        ("12 of 24 triangles left out", [good.clone(), turned(&other)].concat()),
        (
            "12 of 36 triangles turned to face outwards, 24 of 36",
            [turned(&good), other.clone(), good.clone()].concat(),
        ),
        (
            "12 of 24 triangles turned",
            [good.clone(), turned(&cuboid([-1.2, -0.3, -0.4], [0.3, 0.4, 0.6]))].concat(),
        ),
    ] {
        let repairs = full_in_the_middle(&mesh);
        assert!(repairs.contains(said), "'{said}' is not in '{repairs}'");
    }
}

#[test]
fn only_a_body_that_looks_inwards_and_touches_nothing_is_a_cavity() {
    let at = [0.02, 0.03, 0.01];
    let (outer, inner) = (cuboid([-1.0; 3], [1.0; 3]), cuboid([-0.1; 3], [0.1; 3]));
    let is_full = |parts: &[Corners]| is_full_at(&Solid::mesh(&soup(&parts.concat())).unwrap(), at);
    assert!(!is_full(&[outer.clone(), turned(&inner)]));
    assert!(is_full(&[outer.clone(), inner.clone()]));
    assert!(is_full(&[turned(&outer), inner.clone()]));
    assert!(is_full(&[turned(&outer), turned(&inner)]));
    // One face of the inner box lies in that of the outer box, or passes through it.
    assert!(is_full(&[outer.clone(), turned(&cuboid([-0.1, -0.1, -1.0], [0.1; 3]))]));
    assert!(is_full(&[outer.clone(), turned(&cuboid([-0.1, -0.1, -1.5], [0.1; 3]))]));
    // Another component fills the cavity, or lies in it.
    assert!(is_full(&[outer.clone(), turned(&inner), cuboid([-0.2; 3], [0.3; 3])]));
    let kernel = cuboid([-0.05; 3], [0.05; 3]);
    let hollow = Solid::mesh(&soup(&[outer, turned(&inner), kernel].concat())).unwrap();
    assert!(
        is_full_at(&hollow, [0.0; 3]) && !is_full_at(&hollow, [0.075; 3]) && is_full_at(&hollow, [0.5; 3])
    );
}

#[test]
fn what_has_no_inside_is_refused() {
    let mut open = unit();
    open.pop();
    assert!(matches!(Solid::mesh(&soup(&open)), Err(ShapeError::Open { edges: 3 })));
    // Both orientations of every triangle do not close it.
    let two_sided = [open.clone(), turned(&open)].concat();
    assert!(matches!(Solid::mesh(&soup(&two_sided)), Err(ShapeError::Open { edges: 3 })));
    let sheet: Corners = [unit()[0], unit()[1]].to_vec();
    assert!(matches!(
        Solid::mesh(&soup(&[sheet.clone(), turned(&sheet)].concat())),
        Err(ShapeError::Open { .. })
    ));
    let line = Point::new(1.0, 0.0, 0.0);
    assert!(matches!(Solid::mesh(&soup(&[[line, line, line]])), Err(ShapeError::Empty)));
}

/// Prism over a polygon; its ends are fans from the first corner.
fn prism(polygon: &[[f64; 2]]) -> Corners {
    let at = |index: usize, z: f64| {
        let [x, y] = polygon[index % polygon.len()];
        Point::new(x, y, z)
    };
    let side =
        |i: usize| [[at(i, 0.0), at(i + 1, 0.0), at(i + 1, 1.0)], [at(i, 0.0), at(i + 1, 1.0), at(i, 1.0)]];
    let ends =
        |i: usize| [[at(0, 1.0), at(i, 1.0), at(i + 1, 1.0)], [at(0, 0.0), at(i + 1, 0.0), at(i, 0.0)]];
    let sides = (0..polygon.len()).flat_map(side);
    sides.chain((1..polygon.len() - 1).flat_map(ends)).collect()
}

#[test]
fn a_body_that_is_twisted_through_itself_is_refused() {
    // Two lobes, one of them inside out; then lobes that overlap.
    let bow = prism(&[[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]]);
    assert!(matches!(Solid::mesh(&soup(&bow)), Err(ShapeError::WoundBackwards { .. })));
    let loops =
        [[0.0, 0.0], [3.0, 0.0], [3.0, 2.0], [1.0, 2.0], [1.0, 1.0], [2.0, 1.0], [2.0, 3.0], [0.0, 3.0]];
    let solid = Solid::mesh(&soup(&prism(&loops)));
    assert!(solid.is_ok(), "a body that winds twice around a part of it is full there: {solid:?}");
    assert!(is_full_at(&solid.unwrap(), [1.5, 1.7, 0.4]));
}

#[test]
fn boxes_that_overlap_at_a_common_edge_or_base_are_full() {
    // One of the components is inside out.
    let wedge = Pose::from_parts(Vector::zeros().into(), Rotation::from_euler_angles(0.0, 0.0, 0.5));
    let corner = cuboid([0.0; 3], [1.0; 3]);
    let leaning: Corners = corner.iter().map(|triangle| triangle.map(|p| wedge * p)).collect();
    let both = Solid::mesh(&soup(&[corner, turned(&leaning)].concat())).unwrap();
    assert!(is_full_at(&both, [0.5, 0.6, 0.5]) && is_full_at(&both, [-0.2, 0.6, 0.5]));
    assert!(is_full_at(&both, [0.5, 0.1, 0.5]) && !is_full_at(&both, [-0.5, 0.1, 0.5]));
    // Their bases are one face. Components in sequence in the file can be separated, mixed ones cannot.
    let (low, high) = (cuboid([0.0; 3], [1.0; 3]), turned(&cuboid([0.0; 3], [1.0, 1.0, 2.0])));
    let both = Solid::mesh(&soup(&[low.clone(), high.clone()].concat())).unwrap();
    assert!(is_full_at(&both, [0.5, 0.6, 0.5]) && is_full_at(&both, [0.5, 0.6, 1.5]));
    let mixed: Corners = low.iter().zip(&high).flat_map(|(a, b)| [*a, *b]).collect();
    assert!(matches!(Solid::mesh(&soup(&mixed)), Err(ShapeError::OneSided { .. })));
}

/// Convex solid, given by the planes of its faces.
struct Convex {
    mesh: Corners,
    /// Outward unit normal, and distance of the plane along it, in metres.
    planes: Vec<(Vector, f64)>,
    /// True if the mesh in the file is inside out as a whole.
    is_inward: bool,
}

/// Distance from a face below which points are not tested, in metres.
const NEAR_M: f64 = 1e-3;

impl Convex {
    fn of(mesh: Corners) -> Self {
        let plane = |[a, b, c]: &[Point; 3]| {
            let normal = (b - a).cross(&(c - a)).normalize();
            (normal, normal.dot(&a.coords))
        };
        Self { planes: mesh.iter().map(plane).collect(), mesh, is_inward: false }
    }

    /// Height of a point above the highest plane, in metres.
    fn height_m(&self, p: &Point) -> f64 {
        self.planes.iter().map(|(normal, at)| normal.dot(&p.coords) - at).fold(f64::NEG_INFINITY, f64::max)
    }

    fn contains_all_of(&self, other: &Self) -> bool {
        other.mesh.iter().flatten().all(|corner| self.height_m(corner) < 0.0)
    }
}

fn point(random: &mut Stream, reach_m: f64) -> Point {
    [0; 3].map(|_| (2.0 * random.uniform() - 1.0) * reach_m).into()
}

fn below(random: &mut Stream, count: usize) -> usize {
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "small counts")]
    let drawn = (random.uniform() * count as f64) as usize;
    drawn.min(count - 1)
}

fn body(random: &mut Stream) -> Convex {
    let mesh = if below(random, 2) == 0 {
        let half = point(random, 0.5).coords.abs().add_scalar(0.05);
        let pose = Pose::new(point(random, 0.4).coords, point(random, 2.0).coords);
        placed(&Surface::cuboid_soup(&half), &pose)
    } else {
        let center = point(random, 0.4).coords;
        let points: Vec<Point> = (0..12).map(|_| point(random, 0.5) + center).collect();
        corners(&TriangleSoup::convex_hull(&points).unwrap())
    };
    Convex::of(mesh)
}

/// Faces of a solid as a bad program writes them: reversed, doubled.
fn spoilt(body: &mut Convex, random: &mut Stream) -> Corners {
    let good = body.mesh.clone();
    match below(random, 6) {
        0 => good,
        1 => {
            body.is_inward = true;
            turned(&good)
        }
        2 => {
            let turn = |t: &[Point; 3]| if random.uniform() < 0.4 { [t[0], t[2], t[1]] } else { *t };
            good.iter().map(turn).collect()
        }
        3 => [good.clone(), turned(&good)].concat(),
        4 => good.iter().flat_map(|&[a, b, c]| [[a, c, b], [c, a, b]]).collect(),
        _ => [good.clone(), good.clone(), turned(&good)].concat(),
    }
}

fn shuffle<T>(items: &mut [T], random: &mut Stream) {
    for last in (1..items.len()).rev() {
        items.swap(last, below(random, last + 1));
    }
}

/// Asserts at random points that the solid is full exactly inside the union of the convex ones.
fn is_union(solid: &Solid, bodies: &[Convex], random: &mut Stream, about: &str) {
    for _ in 0..60 {
        let p = point(random, 1.3);
        let heights: Vec<f64> = bodies.iter().map(|body| body.height_m(&p)).collect();
        if heights.iter().any(|height| height.abs() < NEAR_M) {
            continue;
        }
        // An inner solid may be meant as a cavity.
        let may_be_cavity = |(body, height): (&Convex, &f64)| {
            body.is_inward && *height < 0.0 && bodies.iter().any(|other| other.contains_all_of(body))
        };
        if bodies.iter().zip(&heights).any(may_be_cavity) {
            continue;
        }
        let is_inside = heights.iter().any(|height| *height < 0.0);
        assert_eq!(is_full_at(solid, p.into()), is_inside, "{about}, {p}");
    }
}

#[test]
fn a_spoilt_mesh_of_random_bodies_is_their_union() {
    for seed in 0..150 {
        let mut random = Stream::new(seed, 0);
        let mut bodies: Vec<Convex> = (0..=below(&mut random, 4)).map(|_| body(&mut random)).collect();
        let mut mesh: Corners = bodies.iter_mut().flat_map(|body| spoilt(body, &mut random)).collect();
        if below(&mut random, 3) == 0 {
            // The copy of the first solid has the same position, but other faults.
            mesh.extend(spoilt(&mut bodies[0], &mut random));
            bodies[0].is_inward = false;
        }
        if below(&mut random, 2) == 0 {
            shuffle(&mut mesh, &mut random);
        }
        let solid = Solid::mesh(&soup(&mesh)).unwrap_or_else(|fault| panic!("seed {seed}: {fault}"));
        is_union(&solid, &bodies, &mut random, &format!("seed {seed}"));
    }
}

#[test]
fn boxes_that_share_corners_edges_and_faces_are_united_or_refused() {
    let mut refused = 0;
    const CASES: u64 = 300;
    for seed in 0..CASES {
        let mut random = Stream::new(seed, 1);
        let count = 2 + below(&mut random, 3);
        let mut bodies = Vec::new();
        let mut mesh = Vec::new();
        for _ in 0..count {
            // On a coarse grid they often touch.
            let mut low = [0.0; 3];
            let mut high = [0.0; 3];
            for axis in 0..3 {
                low[axis] = 0.4 * below(&mut random, 3) as f64 - 0.6;
                high[axis] = low[axis] + 0.4 * (1 + below(&mut random, 2)) as f64;
                // Coordinates must be equal to the last bit, however they were computed.
                high[axis] = (high[axis] * 1024.0).round() / 1024.0;
                low[axis] = (low[axis] * 1024.0).round() / 1024.0;
            }
            let mut body = Convex::of(cuboid(low, high));
            let diagonals = below(&mut random, 2) == 0;
            let faces = spoilt(&mut body, &mut random);
            // Two triangles form a side only in the order in which they were made.
            let is_as_made = faces == body.mesh;
            mesh.extend(if diagonals && is_as_made { with_other_diagonals(&faces) } else { faces });
            bodies.push(body);
        }
        if below(&mut random, 2) == 0 {
            shuffle(&mut mesh, &mut random);
        }
        match Solid::mesh(&soup(&mesh)) {
            Ok(solid) => is_union(&solid, &bodies, &mut random, &format!("seed {seed}")),
            Err(_) => refused += 1,
        }
    }
    assert!(refused < CASES / 2, "{refused} of {CASES} are refused");
}
