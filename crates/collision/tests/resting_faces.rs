//! Tests that a support face has the surface normal at the contact, and that its gap is measured there.

use std::sync::Arc;

use cranny_collision::{Body, Cell, CollisionError, Extent, Margins, Part, Resting, World};
use cranny_robot::{Robot, RobotOptions};
use cranny_shape::{Solid, TriangleSoup};
use cranny_spatial::{Point, Pose, Stream, Vector};
use proptest::prelude::*;

/// A robot far from all bodies.
const ROBOT: &str = r#"<robot name="slide">
  <link name="rail"/>
  <link name="tip"><collision><origin xyz="0 0 9"/><geometry><sphere radius="0.01"/></geometry></collision></link>
  <joint name="up" type="prismatic"><parent link="rail"/><child link="tip"/><axis xyz="0 0 1"/>
    <limit lower="0" upper="1" velocity="1" effort="1"/></joint>
</robot>"#;

/// Returns the supports of the first of these bodies among the others.
fn standing(bodies: Vec<Body>) -> Resting {
    let options = RobotOptions { tip: Some("tip".to_owned()), ..RobotOptions::default() };
    let robot = Robot::from_urdf_text(ROBOT, "slide.urdf", None, &options).unwrap();
    let (extent, pose) = (Extent::of(&bodies[0]).unwrap(), bodies[0].parts[0].world_from_solid);
    let cell = Cell::new(Arc::new(robot), World::new(bodies).unwrap(), Margins::default()).unwrap();
    // Both entry points agree.
    let resting = cell.resting_at(0, &extent, &pose);
    match cell.resting(0) {
        Ok(same) => {
            let same: Vec<_> = same.supports().collect();
            let of_other: Vec<_> = resting.supports().collect();
            let is_alike = |(a, b): (&(usize, f64), &(usize, f64))| a.0 == b.0 && (a.1 - b.1).abs() < 1e-9;
            assert!(same.len() == of_other.len() && same.iter().zip(&of_other).all(is_alike));
        }
        Err(CollisionError::Touches { .. } | CollisionError::Topples { .. }) => {
            assert_eq!(resting.supports().count(), 0);
        }
        Err(other) => panic!("{other}"),
    }
    resting
}

fn soup(boxes: &[([f64; 3], [f64; 3])]) -> TriangleSoup {
    let mut soup = TriangleSoup::default();
    for ([x, y, z], half_m) in boxes {
        let solid = Solid::cuboid((*half_m).into()).unwrap();
        soup.append(&solid.tessellation().unwrap(), &Pose::translation(*x, *y, *z));
    }
    soup
}

fn body(name: &str, boxes: &[([f64; 3], [f64; 3])]) -> Body {
    let part = |([x, y, z], half_m): &([f64; 3], [f64; 3])| Part {
        world_from_solid: Pose::translation(*x, *y, *z),
        solid: Solid::cuboid((*half_m).into()).unwrap(),
    };
    Body {
        name: name.to_owned(),
        parts: boxes.iter().map(part).collect(),
        tilt_rad: None,
        center_of_mass: None,
    }
}

/// Returns the corners of a wedge whose upper face rises along x through the origin.
fn wedge(slope: f64) -> Vec<Point> {
    let mut corners = Vec::new();
    for (x, y) in [(-0.15, -0.1), (-0.15, 0.1), (0.15, -0.1), (0.15, 0.1)] {
        corners.extend([Point::new(x, y, -0.06), Point::new(x, y, slope * x)]);
    }
    corners
}

fn wedge_as(kind: usize, slope: f64) -> Body {
    let corners = wedge(slope);
    let solid = match kind {
        0 => Solid::mesh(&TriangleSoup::convex_hull(&corners).unwrap()),
        _ => Solid::hull(&corners),
    };
    Body::new("wedge", Pose::identity(), solid.unwrap())
}

#[test]
fn a_slope_of_a_mesh_is_no_level_face() {
    let half_m = [0.006, 0.006, 0.05];
    for degrees in [2.0_f64, 5.0, 9.5] {
        let slope = degrees.to_radians().tan();
        for gap_m in [0.0, 0.0002] {
            let stick = body("stick", &[([0.0, 0.0, slope * half_m[0] + gap_m + half_m[2]], half_m)]);
            let resting = [0, 1].map(|kind| standing(vec![stick.clone(), wedge_as(kind, slope)]));
            for resting in resting {
                let found = resting.slope_rad(&Vector::z()).to_degrees();
                assert!((found - degrees).abs() < 0.01, "{found}");
                assert_eq!(resting.supports().count(), 1);
            }
        }
    }
}

/// Returns two boxes side by side, the right one heavier, with its bottom higher by `step_m` (m).
fn stepped(step_m: f64) -> [([f64; 3], [f64; 3]); 2] {
    [([-0.0225, 0.0, 0.05], [0.0225, 0.02, 0.05]), ([0.05, 0.0, 0.05 + step_m], [0.05, 0.02, 0.05])]
}

#[test]
fn what_hovers_carries_nothing() {
    let at = |height_m: f64, step_m: f64, first: f64, last: f64| {
        let boxes = stepped(step_m).map(|([x, y, z], half_m)| ([x, y, z + height_m], half_m));
        let half_m = 0.5 * (last - first);
        let ledge = ([first + half_m, 0.0, -0.01], [half_m, 0.1, 0.01]);
        let of_mesh = Body::new("ledge", Pose::identity(), Solid::mesh(&soup(&[ledge])).unwrap());
        let resting =
            [body("ledge", &[ledge]), of_mesh].map(|ledge| standing(vec![body("thing", &boxes), ledge]));
        resting.map(|resting| (resting.supports().next().map(|(_, gap_m)| gap_m), resting.overhang_m()))
    };
    for (carried, off_m) in at(5e-5, 1.75e-3, -0.2715, 0.0285) {
        assert_eq!(carried, None);
        assert!((off_m.unwrap() - 0.0275).abs() < 1e-3, "{off_m:?}");
    }
    // Over the ledge the gap is the height above the ledge.
    for (carried, _) in at(5e-5, 1.9e-3, 0.01, 0.31) {
        assert!((carried.unwrap() - 1.95e-3).abs() < 1e-9, "{carried:?}");
    }
    // Within its reach it lies on both ends.
    for (carried, _) in at(0.0, 1.7e-3, -0.2, 0.2) {
        assert!(carried.unwrap().abs() < 1e-9);
    }
}

#[test]
fn a_wall_of_the_same_mesh_is_not_taken_for_its_floor() {
    for (gap_m, height_m) in [(0.0005, 0.0019), (0.0001, 0.0014), (0.0, 0.0025)] {
        let profile = soup(&[
            ([0.0, 0.0, -0.005], [0.12, 0.1, 0.005]),
            ([0.0351 + gap_m, 0.0, 0.006], [0.005, 0.1, 0.0059]),
        ]);
        let tray = Body::new("tray", Pose::identity(), Solid::mesh(&profile).unwrap());
        let can = Body::new(
            "can",
            Pose::translation(0.0, 0.0, 0.06 + height_m),
            Solid::cylinder(0.06, 0.03).unwrap(),
        );
        let supports: Vec<_> = standing(vec![can, tray]).supports().map(|(_, gap_m)| gap_m).collect();
        if height_m > 2e-3 {
            assert!(supports.is_empty());
        } else {
            assert!((supports[0] - height_m).abs() < 1e-9, "{supports:?}");
        }
    }
}

#[test]
fn what_parts_of_an_object_share_weighs_once() {
    let plate = ([0.0, 0.0, 0.015], [0.1, 0.02, 0.015]);
    let inner = ([0.07, 0.0, 0.015], [0.03, 0.02, 0.015]);
    let ledge = |first: f64| body("ledge", &[([first + 0.1, 0.0, -0.01], [0.1, 0.1, 0.01])]);
    let boxes = [plate, inner, inner, inner, inner, inner];
    let mesh = Body::new("plate", Pose::identity(), Solid::mesh(&soup(&boxes)).unwrap());
    for plate in [body("plate", &boxes), mesh] {
        let (right, left) =
            (standing(vec![plate.clone(), ledge(0.005)]), standing(vec![plate, ledge(-0.005)]));
        let off_m = right.overhang_m().unwrap();
        assert!((off_m - 0.005).abs() < 2e-4, "{off_m}");
        assert_eq!(left.supports().count(), 1);
    }
}

#[test]
fn edges_and_corners_carry_what_is_right_above_them() {
    // A plank balanced on the ridge of a roof of either kind, a cone, a ball and a lying cylinder.
    let ridge =
        [(-0.05, -0.05), (0.05, -0.05), (0.0, 0.0)].map(|(x, z)| [-0.1, 0.1].map(|y| Point::new(x, y, z)));
    let roof = ridge.concat();
    let tip: Vec<Point> = [(-0.05, -0.05), (0.05, -0.05), (0.0, 0.06)]
        .map(|(x, y)| Point::new(x, y, -0.05))
        .into_iter()
        .chain([Point::origin()])
        .collect();
    let ball = Body::new("ball", Pose::translation(0.0, 0.0, -0.03), Solid::sphere(0.03).unwrap());
    let lying =
        Pose::translation(0.0, 0.0, -0.03) * Pose::rotation(Vector::x() * std::f64::consts::FRAC_PI_2);
    let cylinder = Body::new("cylinder", lying, Solid::cylinder(0.1, 0.03).unwrap());
    let mesh = |corners: &[Point]| Solid::mesh(&TriangleSoup::convex_hull(corners).unwrap()).unwrap();
    let other = |solid: Solid| Body::new("other", Pose::identity(), solid);
    let below = [
        other(mesh(&roof)),
        other(Solid::hull(&roof).unwrap()),
        other(mesh(&tip)),
        other(Solid::hull(&tip).unwrap()),
        ball,
        cylinder,
    ];
    for below in below {
        for gap_m in [0.0, 5e-4] {
            let plank = |x: f64| body("plank", &[([x, 0.0, 0.01 + gap_m], [0.1, 0.05, 0.01])]);
            let resting = standing(vec![plank(0.0), below.clone()]);
            assert_eq!(resting.supports().count(), 1, "{below:?}");
            assert!(resting.slope_rad(&Vector::z()) < 1e-6);
            let (_, found_m) = resting.supports().next().unwrap();
            assert!((found_m - gap_m).abs() < 2e-5, "{found_m} {gap_m}");
            assert_eq!(standing(vec![plank(0.03), below.clone()]).supports().count(), 0, "{below:?}");
        }
        let on = Body::new("ball", Pose::translation(0.0, 0.0, 0.02), Solid::sphere(0.02).unwrap());
        assert_eq!(standing(vec![on, below.clone()]).supports().count(), 1, "{below:?}");
    }
}

/// Returns the distance of a point from the convex hull of others, negative inside, by sampled directions.
fn beyond(points: &[[f64; 2]], [x, y]: [f64; 2]) -> f64 {
    let directions = (0..720).map(|step| f64::from(step) * std::f64::consts::TAU / 720.0);
    let over = directions.map(|angle| {
        let (sine, cosine) = angle.sin_cos();
        let reach = points.iter().map(|[u, v]| u * cosine + v * sine).fold(f64::NEG_INFINITY, f64::max);
        x * cosine + y * sine - reach
    });
    over.fold(f64::NEG_INFINITY, f64::max)
}

/// Uncertainty of random samples, in metres.
const BLUR_M: f64 = 1.5e-3;
const EVEN_M: f64 = 1e-4;
const UNEVEN_M: f64 = 1.8e-3;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    /// Puts an object of any shape on a slope, of a mesh or a hull: the face has the slope's normal and the gap of the lowest
    /// corner across it, and supports the object if its centre is over samples of its surface that are as near.
    #[test]
    fn on_a_slope_the_samples_decide(
        degrees in 0.0..14.0_f64, kind in 0_usize..2, shape in 0_usize..3, gap_m in 0.0..1.9e-3_f64,
        turn in proptest::array::uniform3(-0.06..0.06_f64), seed in 0_u64..1 << 32,
    ) {
        let mut random = Stream::new(seed, 7);
        let slope = degrees.to_radians().tan();
        let normal = Vector::new(-slope, 0.0, 1.0).normalize();
        let corners: Vec<Point> = match shape {
            0 => soup(&[([0.0; 3], [0.012, 0.02, 0.03])]).vertices,
            _ => (0..14).map(|_| Point::from(Vector::from([0.03, 0.02, 0.02].map(|s| random.uniform_between(-s, s))))).collect(),
        };
        let hull = TriangleSoup::convex_hull(&corners).unwrap();
        let solid = if shape == 2 { Solid::mesh(&hull) } else { Solid::hull(&corners) }.unwrap();
        let turned = Pose::rotation(Vector::from(turn));
        let low_m = corners.iter().map(|corner| normal.dot(&(turned * corner).coords)).fold(f64::INFINITY, f64::min);
        let up_m = (gap_m - low_m) / normal.z;
        let pose = Pose::translation(0.0, 0.0, up_m) * turned;
        let resting = standing(vec![Body::new("object", pose, solid), wedge_as(kind, slope)]);
        let mut samples: Vec<Point> = Vec::new();
        for _ in 0..60_000 {
            let [a, b, c] = hull.corners(random.index(hull.triangles.len()));
            let (mut s, mut t) = (random.uniform(), random.uniform());
            if s + t > 1.0 {
                (s, t) = (1.0 - s, 1.0 - t);
            }
            samples.push(pose * (a + (b - a) * s + (c - a) * t));
        }
        samples.extend(hull.vertices.iter().map(|vertex| pose * vertex));
        let center = pose * cranny_shape::VolumeMoments::of_mesh(&hull).unwrap().center;
        let off_m = |most_m: f64| {
            let near = samples.iter().filter(|sample| normal.dot(&sample.coords) <= gap_m + most_m + 1e-9);
            beyond(&near.map(|sample| [sample.x, sample.y]).collect::<Vec<_>>(), [center.x, center.y])
        };
        let (even_m, uneven_m) = (off_m(EVEN_M), off_m(UNEVEN_M));
        let is_carried = resting.supports().count() == 1;
        if even_m < -BLUR_M || uneven_m < -BLUR_M {
            prop_assert!(is_carried, "{even_m} {uneven_m} {:?}", resting);
        } else if uneven_m > BLUR_M {
            prop_assert!(!is_carried && resting.overhang_m().is_some(), "{even_m} {uneven_m}");
        }
        if is_carried {
            let (_, found_m) = resting.supports().next().unwrap();
            prop_assert!((found_m - gap_m).abs() < 1e-6, "{found_m} {gap_m}");
            prop_assert!((resting.slope_rad(&Vector::z()).to_degrees() - degrees).abs() < 0.06);
        }
    }

    /// Puts an object with two bottoms on columns of a mesh: it is supported as the points of a grid are.
    #[test]
    fn on_steps_the_grid_decides(
        tops in proptest::collection::vec(proptest::option::of(0_u32..25), 8),
        step in 0_u32..30, height in 0_u32..20, shift in -0.02..0.02_f64,
    ) {
        let tenth = |count: u32| f64::from(count) * 1e-4;
        // Columns of 2 cm, with gaps of 0.2 mm.
        let column = |index: usize, top_m: f64| {
            ([(index as f64 - 3.5) * 0.02, 0.0, top_m - 0.02], [0.0099, 0.05, 0.02])
        };
        let columns: Vec<_> =
            tops.iter().enumerate().filter_map(|(index, top)| Some(column(index, tenth((*top)?)))).collect();
        prop_assume!(!columns.is_empty());
        let ground = Body::new("ground", Pose::identity(), Solid::mesh(&soup(&columns)).unwrap());
        let bottom_m = tenth(24 + height) - tenth(12);
        let boxes = stepped(tenth(step)).map(|([x, y, z], half_m)| ([x + shift, y, z + bottom_m], half_m));
        // Heights at samples along x; all is constant along y.
        let lower = |x: f64| {
            let over = boxes.iter().filter(|([at, ..], half_m)| (x - at).abs() < half_m[0]);
            over.map(|([.., z], half_m)| z - half_m[2]).fold(f64::INFINITY, f64::min)
        };
        let upper = |x: f64| {
            let under = columns.iter().filter(|([at, ..], half_m)| (x - at).abs() < half_m[0]);
            under.map(|([.., z], half_m)| z + half_m[2]).fold(f64::NEG_INFINITY, f64::max)
        };
        let corners: Vec<[f64; 2]> = boxes
            .iter()
            .flat_map(|([x, _, z], half_m)| [[x - half_m[0], z - half_m[2]], [x + half_m[0], z - half_m[2]]])
            .collect();
        let on_hull = |x: f64| {
            let pairs = corners.iter().flat_map(|a| corners.iter().map(move |b| (a, b)));
            let spanning = pairs.filter(|(a, b)| a[0] <= x && x <= b[0] && a[0] < b[0]);
            spanning.map(|(a, b)| a[1] + (x - a[0]) / (b[0] - a[0]) * (b[1] - a[1])).fold(f64::INFINITY, f64::min)
        };
        let samples: Vec<f64> = (0..3200).map(|index| -0.08 + f64::from(index) * 5e-5 + 2.1e-6).collect();
        let low_m = boxes.iter().map(|([.., z], half_m)| z - half_m[2]).fold(f64::INFINITY, f64::min);
        let both = |x: &&f64| lower(**x).is_finite() && upper(**x).is_finite();
        let over: Vec<f64> = samples.iter().filter(both).copied().collect();
        let deep_m = over.iter().map(|x| upper(*x) - lower(*x)).fold(f64::NEG_INFINITY, f64::max);
        // A depth of exactly the allowance is decided by rounding.
        prop_assume!((deep_m - 1e-4).abs() > 5e-6);
        let resting = standing(vec![body("thing", &boxes), ground]);
        let carried = resting.supports().next().map(|(_, gap_m)| gap_m);
        let places: Vec<(f64, f64)> = over
            .iter()
            .filter(|x| upper(**x) <= low_m + 1.01e-4)
            .map(|x| (*x, lower(*x) - upper(*x)))
            .filter(|(_, gap_m)| *gap_m >= -1.01e-4)
            .collect();
        let nearest_m = places.iter().map(|(_, gap_m)| *gap_m).fold(f64::INFINITY, f64::min);
        let volume = |index: usize| boxes[index].1.iter().product::<f64>();
        let center = (boxes[0].0[0] * volume(0) + boxes[1].0[0] * volume(1)) / (volume(0) + volume(1));
        let off_m = |most_m: f64, hull_m: f64| {
            let near = places.iter().filter(|(x, gap_m)| {
                *gap_m <= nearest_m + most_m && lower(*x) <= on_hull(*x) + hull_m
            });
            let (first, last) = near.fold((f64::INFINITY, f64::NEG_INFINITY), |(first, last), (x, _)| (first.min(*x), last.max(*x)));
            (first - center).max(center - last)
        };
        if deep_m > 1.05e-4 || nearest_m > 2.01e-3 {
            prop_assert!(carried.is_none(), "{deep_m} {nearest_m}");
        } else if off_m(EVEN_M + 1e-6, 1.0) > 2.5e-4 && off_m(UNEVEN_M + 1e-6, EVEN_M + 1e-6) > 2.5e-4 {
            prop_assert!(carried.is_none(), "{nearest_m}");
        } else if let Some(gap_m) = carried {
            prop_assert!((gap_m - nearest_m).abs() < 1e-8, "{gap_m} {nearest_m}");
            prop_assert!(resting.slope_rad(&Vector::z()) < 1e-9);
        } else {
            // Skip cases in which it touches a higher portion of the mesh, or samples do not decide.
            let touches = |x: &f64| upper(*x) > low_m + 0.99e-4 && lower(*x) - upper(*x) < 2e-5;
            let is_sure = nearest_m < 1.99e-3
                && !over.iter().any(touches)
                && (off_m(EVEN_M - 1e-6, 1.0) < -1e-4 || off_m(UNEVEN_M - 1e-6, EVEN_M - 1e-6) < -1e-4);
            prop_assert!(!is_sure, "{nearest_m} {:?}", resting);
        }
    }
}
