//! Sampled grasps against the definition of a grasp, checked triangle by triangle.

use cranny_grasp::{
    BoxHand, Finger, FirstApproach, GraspError, GraspSampler, Hand, SampledGrasp, SamplerSettings, Sampling,
    grasp_distance, resume_sampling, sample_grasps,
};
use cranny_shape::{Surface, TriangleSoup};
use cranny_spatial::{Point, Pose, Rotation, Vector};

fn sampled(surface: &Surface, settings: &SamplerSettings) -> Sampling {
    sample_grasps(surface, settings, &|_| true, &mut |_| true).unwrap()
}

fn ball() -> TriangleSoup {
    TriangleSoup::geodesic_sphere(0.03, 3)
}

fn cuboid() -> TriangleSoup {
    Surface::cuboid_soup(&Vector::new(0.02, 0.05, 0.09))
}

fn settings(count: usize) -> SamplerSettings {
    SamplerSettings { count, ..SamplerSettings::default() }
}

/// Distance of a point from a triangle, by its corners, edges and inside in turn.
fn distance_to_triangle(point: &Point, corners: &[Point; 3]) -> f64 {
    let [a, b, c] = corners;
    let normal = (b - a).cross(&(c - a)).normalize();
    let foot = point - normal * (point - a).dot(&normal);
    let is_above =
        [(a, b), (b, c), (c, a)].iter().all(|(p, q)| (*q - *p).cross(&(foot - *p)).dot(&normal) >= 0.0);
    let to_edge = |p: &Point, q: &Point| {
        let along = ((point - p).dot(&(q - p)) / (q - p).norm_squared()).clamp(0.0, 1.0);
        (p + (q - p) * along - point).norm()
    };
    if is_above { (point - foot).norm() } else { to_edge(a, b).min(to_edge(b, c)).min(to_edge(c, a)) }
}

/// Distance of `point` from the nearest triangle, and the angle between a direction and its normal, the most favourable
/// one of equally near triangles.
fn angle_at(soup: &TriangleSoup, point: &Point, outwards: &Vector) -> (f64, f64) {
    let distances: Vec<f64> =
        (0..soup.triangles.len()).map(|t| distance_to_triangle(point, &soup.corners(t))).collect();
    let nearest = distances.iter().copied().fold(f64::INFINITY, f64::min);
    let angles = (0..soup.triangles.len()).filter(|&t| distances[t] <= nearest + 1e-9).map(|t| {
        let [a, b, c] = soup.corners(t);
        (b - a).cross(&(c - a)).angle(outwards)
    });
    (nearest, angles.fold(f64::INFINITY, f64::min))
}

fn check(soup: &TriangleSoup, grasp: &SampledGrasp, settings: &SamplerSettings) {
    let pose = grasp.grasp.world_from_gripper;
    let y = pose.rotation * Vector::y();
    let half = 0.5 * grasp.grasp.width_m.unwrap();
    assert!(2.0 * half <= settings.opening_m + 1e-12);
    let cone = settings.friction.atan();
    let mut steepest = 0.0_f64;
    // The pads touch where the closing axis leaves the object; the depth is 0 here.
    for side in [-1.0, 1.0] {
        let contact = Point::from(pose.translation.vector) + y * (side * half);
        let (distance, angle) = angle_at(soup, &contact, &(y * side));
        assert!(distance < 1e-9, "{distance} m off the surface");
        assert!(angle <= cone + 1e-9, "{angle} rad outside a cone of {cone}");
        steepest = steepest.max(angle);
    }
    let score = grasp.grasp.score.unwrap();
    assert!((score - (1.0 - steepest.tan() / settings.friction)).abs() < 1e-6, "{score}");
}

#[test]
fn every_grasp_closes_on_two_points_of_the_surface_inside_both_cones() {
    for soup in [ball(), cuboid()] {
        let surface = Surface::new(&soup).unwrap();
        for friction in [0.1, 0.24, 0.8] {
            let settings = SamplerSettings { friction, ..settings(300) };
            let found = sampled(&surface, &settings);
            assert_eq!(found.grasps.len(), 300);
            for grasp in &found.grasps {
                check(&soup, grasp, &settings);
            }
        }
    }
}

#[test]
fn nothing_wider_than_the_opening_is_grasped() {
    let surface = Surface::new(&cuboid()).unwrap();
    // 4 cm across x, 10 and 18 cm across the others.
    let found = sampled(&surface, &settings(500));
    for grasp in &found.grasps {
        let y = grasp.grasp.world_from_gripper.rotation * Vector::y();
        assert!(y.x.abs() > 0.9 && grasp.grasp.width_m.unwrap() < 0.05);
    }
    let narrow = SamplerSettings { opening_m: 0.03, most_contacts: 10_000, ..settings(500) };
    let none = sampled(&surface, &narrow);
    assert!(none.grasps.is_empty() && none.first_contacts >= 10_000);
}

#[test]
fn nothing_thinner_than_the_gap_of_the_closed_hand_is_grasped() {
    let surface = Surface::new(&cuboid()).unwrap();
    let loose =
        SamplerSettings { closed_gap_m: 0.06, opening_m: 0.12, most_contacts: 20_000, ..settings(300) };
    let found = sampled(&surface, &loose);
    assert!(!found.grasps.is_empty() && found.grasps.iter().all(|g| g.grasp.width_m.unwrap() >= 0.06));
    let finger = |way_m: f64| Finger { parts: 0..0, stroke_m: Vector::new(0.0, way_m, 0.0) };
    let hand = |way_m: f64| Hand {
        fingers: vec![finger(-way_m), finger(way_m)],
        ..BoxHand::default().hand().unwrap()
    };
    assert!(hand(0.04).closed_gap_m() < 1e-12 && (hand(0.038).closed_gap_m() - 0.004).abs() < 1e-12);
}

/// A box of 60 mm by 50 mm by 70 mm with one of 20 mm in it, off its middle: as a second component, as a cavity, and as a space
/// between six plates of 24 mm. A pad that closes from outside never reaches the inner faces.
#[test]
fn nothing_inside_an_object_is_grasped() {
    let outer = Surface::cuboid_soup(&Vector::new(0.03, 0.025, 0.035));
    let inner = Surface::cuboid_soup(&Vector::repeat(0.01));
    let at = Pose::translation(0.01, 0.0, 0.01);
    let mut body = outer.clone();
    body.append(&inner, &at);
    let mut cavity = body.clone();
    cavity.triangles[12..].iter_mut().for_each(|triangle| triangle.swap(1, 2));
    let mut room = TriangleSoup::default();
    for axis in 0..3 {
        let mut half = Vector::new(0.03, 0.025, 0.035);
        let place = half[axis] - 0.012;
        half[axis] = 0.012;
        for side in [-place, place] {
            let mut shift = Vector::zeros();
            shift[axis] = side;
            room.append(&Surface::cuboid_soup(&half), &Pose::from_parts(shift.into(), Rotation::identity()));
        }
    }
    for (name, soup) in [("body", body), ("cavity", cavity), ("room", room)] {
        let surface = Surface::new(&soup).unwrap();
        let found = sampled(&surface, &settings(300));
        assert!(found.grasps.len() > 200, "{name}: {}", found.grasps.len());
        let to_outside = |point: &Point| {
            (0..12).map(|t| distance_to_triangle(point, &outer.corners(t))).fold(f64::INFINITY, f64::min)
        };
        for grasp in &found.grasps {
            let within = grasp.contacts.map(|contact| to_outside(&contact.point_in_object));
            assert!(within.iter().all(|distance| *distance < 1e-9), "{name}: {grasp:?}");
        }
    }
}

/// The wall of a pipe is grasped where the inner pad fits inside.
#[test]
fn a_wall_is_grasped_where_there_is_room_behind_it() {
    let mut pipe = Surface::cuboid_soup(&Vector::new(0.002, 0.1, 0.05));
    let opposite = Surface::cuboid_soup(&Vector::new(0.002, 0.1, 0.05));
    pipe.append(&opposite, &Pose::translation(0.06, 0.0, 0.0));
    let thin = |opening_m: f64| {
        let surface = Surface::new(&pipe).unwrap();
        let found = sampled(&surface, &SamplerSettings { opening_m, friction: 0.05, ..settings(100) });
        found.grasps.iter().filter(|grasp| grasp.grasp.width_m.unwrap() < 0.01).count()
    };
    assert!(thin(0.05) > 50);
    // From 160 mm apart the inner pad would have to pass the other wall, except near its edges.
    assert!(thin(0.16) < 15);
}

#[test]
fn what_is_too_wide_everywhere_is_known_by_how_wide_it_is() {
    let surface = Surface::new(&cuboid()).unwrap();
    let too_wide_m = |opening_m: f64| {
        let settings = SamplerSettings { opening_m, ..settings(1) };
        GraspSampler::new(&surface, &settings).unwrap().too_wide_m(1000, opening_m)
    };
    // A ray within the friction cone is at most 3 % longer than the width of the object.
    assert!(too_wide_m(0.03).is_some_and(|narrowest_m| (0.04..0.0412).contains(&narrowest_m)));
    assert_eq!(too_wide_m(0.042), None);
}

#[test]
fn the_same_seed_gives_the_same_bytes_on_any_number_of_threads() {
    let surface = Surface::new(&ball()).unwrap();
    let bits = |threads: usize| -> Vec<u64> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let accept = |grasp: &SampledGrasp| grasp.grasp.world_from_gripper.translation.x < 1e-3;
        let found =
            pool.install(|| sample_grasps(&surface, &settings(2000), &accept, &mut |_| true).unwrap());
        let numbers = |grasp: &SampledGrasp| {
            let pose = grasp.grasp.world_from_gripper;
            let coordinates: Vec<f64> =
                pose.translation.vector.iter().chain(pose.rotation.coords.iter()).copied().collect();
            [coordinates, vec![grasp.grasp.score.unwrap(), grasp.grasp.width_m.unwrap()]].concat()
        };
        found.grasps.iter().flat_map(numbers).map(f64::to_bits).collect()
    };
    let one = bits(1);
    assert_eq!(one.len(), 2000 * 9);
    assert!(one == bits(2) && one == bits(5));
}

#[test]
fn approaches_stand_evenly_about_the_closing_axis_from_level_on() {
    let surface = Surface::new(&cuboid()).unwrap();
    let all = SamplerSettings { kept_approaches: 12, ..settings(600) };
    let found = sampled(&surface, &all);
    assert_eq!(found.grasps.len(), 600);
    for pair in found.grasps.chunks(12) {
        let axes = |grasp: &SampledGrasp| {
            let rotation = grasp.grasp.world_from_gripper.rotation;
            (rotation * Vector::y(), rotation * Vector::z())
        };
        let (y, first) = axes(&pair[0]);
        assert!(first.z.abs() < 1e-9, "the first approach is level");
        for (index, grasp) in pair.iter().enumerate() {
            let (other_y, z) = axes(grasp);
            assert!((other_y - y).norm() < 1e-9);
            let expected = (std::f64::consts::TAU * index as f64 / 12.0).cos();
            assert!((first.dot(&z) - expected).abs() < 1e-9);
        }
    }
    let from_above = sampled(&surface, &SamplerSettings { steepest_rise_rad: 0.0, ..all.clone() });
    let rise = |g: &SampledGrasp| (g.grasp.world_from_gripper.rotation * Vector::z()).z;
    assert!(from_above.grasps.iter().all(|g| rise(g) < 1e-8));
    let turned = sampled(&surface, &SamplerSettings { first_approach: FirstApproach::Random, ..all });
    assert!(turned.grasps.iter().filter(|g| rise(g).abs() < 1e-6).count() < 10);
}

#[test]
fn depths_and_ground_are_kept_to() {
    let surface = Surface::new(&ball()).unwrap();
    let deep = SamplerSettings { depth_m: [-0.02, 0.01], ground_m: Some(-0.03), ..settings(500) };
    for sampled in &sampled(&surface, &deep).grasps {
        let pose = sampled.grasp.world_from_gripper;
        let [a, b] = sampled.contacts.map(|contact| contact.point_in_object);
        let from_middle = pose.translation.vector - (a.coords + b.coords) * 0.5;
        let z = pose.rotation * Vector::z();
        let depth_m = from_middle.dot(&z);
        assert!((from_middle - z * depth_m).norm() < 1e-12 && (-0.02..=0.01).contains(&depth_m));
        let y = pose.rotation * Vector::y();
        assert!(pose.translation.z - 0.04 * y.z.abs() >= -0.03);
    }
}

#[test]
fn no_object_is_deeper_between_the_fingers_than_to_the_palm() {
    let half = Vector::new(0.02, 0.05, 0.09);
    let surface = Surface::new(&cuboid()).unwrap();
    let finger_depth_m = 0.0466;
    // Distance from the gripper frame back to the exit of the box, axis by axis.
    let way_out_m = |grasp: &SampledGrasp| {
        let pose = grasp.grasp.world_from_gripper;
        let (origin, back) = (pose.translation.vector, pose.rotation * -Vector::z());
        (0..3).map(|k| (half[k] - origin[k] * back[k].signum()) / back[k].abs()).fold(f64::INFINITY, f64::min)
    };
    let free = sampled(&surface, &settings(500));
    assert!(free.grasps.iter().any(|grasp| way_out_m(grasp) > finger_depth_m));
    let asked = SamplerSettings { finger_depth_m: Some(finger_depth_m), ..settings(500) };
    let found = sampled(&surface, &asked);
    assert_eq!(found.grasps.len(), 500);
    for grasp in &found.grasps {
        assert!(way_out_m(grasp) <= finger_depth_m + 1e-9, "{}", way_out_m(grasp));
    }
    let none = SamplerSettings { finger_depth_m: Some(0.0), ..settings(1) };
    let refused = sample_grasps(&surface, &none, &|_| true, &mut |_| true);
    assert!(matches!(refused, Err(GraspError::Setting { setting: "depth of the fingers", .. })));
}

#[test]
fn twins_are_found_once() {
    // Two parallel triangles, nearly points: every sample there is one of few grasps.
    let tiny = |y: f64, flip: bool| {
        let corners = [(0.0, 0.0), (1e-6, 0.0), (0.0, 1e-6)].map(|(x, z)| Point::new(x, y, z));
        if flip { [corners[0], corners[2], corners[1]] } else { corners }
    };
    let soup = TriangleSoup::from_corners([tiny(0.01, true), tiny(-0.01, false)].concat()).unwrap();
    let surface = Surface::new(&soup).unwrap();
    let few = SamplerSettings { friction: 1e-6, kept_approaches: 12, most_contacts: 2000, ..settings(1000) };
    let found = sampled(&surface, &few);
    assert_eq!(found.grasps.len(), 12, "{found:?}");
    assert!(found.merged > 12);
    for (index, a) in found.grasps.iter().enumerate() {
        for b in &found.grasps[..index] {
            assert!(grasp_distance(&a.grasp, &b.grasp) > 1.0);
        }
    }
}

#[test]
fn settings_that_are_none_are_refused() {
    let surface = Surface::new(&ball()).unwrap();
    let good = SamplerSettings::default;
    let bad = [
        SamplerSettings { friction: 0.0, ..good() },
        SamplerSettings { friction: f64::NAN, ..good() },
        SamplerSettings { opening_m: -1.0, ..good() },
        SamplerSettings { up: Vector::zeros(), ..good() },
        SamplerSettings { depth_m: [0.1, 0.0], ..good() },
        SamplerSettings { depth_m: [f64::NAN, 0.0], ..good() },
        SamplerSettings { ground_m: Some(f64::INFINITY), ..good() },
        SamplerSettings { steepest_rise_rad: f64::NAN, ..good() },
        SamplerSettings { rays: 0, ..good() },
        SamplerSettings { approaches: 0, ..good() },
        SamplerSettings { kept_approaches: 0, ..good() },
    ];
    for settings in &bad {
        let answer = sample_grasps(&surface, settings, &|_| true, &mut |_| true);
        assert!(matches!(answer, Err(GraspError::Setting { .. })), "{settings:?}");
    }
    let flat = TriangleSoup::from_corners([Point::origin(); 3]).unwrap();
    let answer = sample_grasps(&Surface::new(&flat).unwrap(), &good(), &|_| true, &mut |_| true);
    assert!(matches!(answer, Err(GraspError::NoArea)));
}

#[test]
fn a_gripper_of_boxes_leaves_its_opening_free() {
    let boxes = BoxHand::default();
    let hand = boxes.hand().unwrap();
    assert_eq!(hand.parts.len(), 3);
    assert!((hand.finger_depth_m - 0.0466).abs() < 1e-12);
    for finger in &hand.fingers {
        let [(pose, solid)] = &hand.parts[finger.parts.clone()] else { panic!("a box each") };
        assert!((pose.translation.y.abs() - solid.as_cuboid().unwrap().y - 0.04).abs() < 1e-12);
        // With the hand closed on nothing, each pad is in the middle.
        assert!((finger.stroke_m + pose.translation.y.signum() * 0.04 * Vector::y()).norm() < 1e-12);
    }
    for (bad, says) in [
        (BoxHand { finger_width_m: -0.01, ..boxes.clone() }, "the finger_width_m of a hand must be between"),
        (BoxHand { opening_m: f64::INFINITY, ..boxes.clone() }, "opening_m"),
        (BoxHand { closing_force_n: f64::NAN, ..boxes.clone() }, "closing_force_n"),
        (BoxHand { palm_size_m: [0.1, 5e-324, 0.1], ..boxes.clone() }, "second palm_size_m"),
    ] {
        let fault = bad.hand().unwrap_err().to_string();
        assert!(fault.contains(says), "{fault}");
    }
}

#[test]
fn a_sampling_that_was_stopped_goes_on_to_the_same_end() {
    let surface = Surface::new(&ball()).unwrap();
    let whole = sampled(&surface, &settings(30_000));
    let (mut waves, mut known) = (0, Sampling::default());
    while known != whole {
        let mut one_wave = |_| false;
        known = resume_sampling(known, &surface, &settings(30_000), &|_| true, &mut one_wave).unwrap();
        known = serde_json::from_str(&serde_json::to_string(&known).unwrap()).unwrap();
        waves += 1;
        assert!(waves < 1000);
    }
    assert!(waves > 2, "{waves}");
}
