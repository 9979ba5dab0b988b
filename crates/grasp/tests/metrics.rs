//! Distances between grasps, coverage of sets, and subsets of them.

use cranny_grasp::{
    Contact, Grasp, coverage, covering_subset, farthest_subset, friction_needed, friction_score,
    grasp_distance, nearest_distances, random_subset, spread,
};
use cranny_spatial::{Point, Pose, PoseDifference, Rotation, Stream, Vector};
use proptest::prelude::*;

fn grasps(count: usize, seed: u64) -> Vec<Grasp> {
    let mut random = Stream::new(seed, 0);
    (0..count)
        .map(|_| {
            let origin = Vector::new(random.uniform(), random.uniform(), random.uniform()) * 0.05;
            let world_from_gripper = Pose::from_parts(origin.into(), random.rotation());
            Grasp::at(world_from_gripper)
        })
        .collect()
}

/// Millimetres plus degrees to the nearer of the grasp and its twin, by angles of rotations.
fn distance_by_angles(a: &Grasp, b: &Grasp) -> f64 {
    let to = |b: &Grasp| {
        let difference = PoseDifference::between(&a.world_from_gripper, &b.world_from_gripper);
        1000.0 * difference.translation_m + difference.rotation_rad.to_degrees()
    };
    to(b).min(to(&b.twin()))
}

#[test]
fn distance_is_millimetres_plus_degrees() {
    let a = grasps(1, 0)[0];
    let step = Pose::from_parts(
        Vector::new(0.0, 0.003, 0.004).into(),
        Rotation::from_axis_angle(&Vector::x_axis(), 10.0_f64.to_radians()),
    );
    let b = Grasp { world_from_gripper: a.world_from_gripper * step, ..a };
    assert!((grasp_distance(&a, &b) - 15.0).abs() < 1e-6);
    assert!((grasp_distance(&a, &b.twin()) - 15.0).abs() < 1e-6);
}

#[test]
fn coverage_counts_what_is_near() {
    let set = grasps(400, 1);
    assert!((coverage(&set, &set, 1e-3) - 1.0).abs() < 1e-15);
    assert!(coverage(&set, &[], 1e9) == 0.0 && coverage(&[], &set, 1e9) == 0.0);
    let reference = grasps(300, 2);
    for threshold in [20.0, 40.0, 80.0] {
        let near =
            reference.iter().filter(|r| set.iter().any(|g| distance_by_angles(r, g) <= threshold)).count();
        assert!((coverage(&reference, &set, threshold) - near as f64 / 300.0).abs() < 1e-12);
    }
    let nearest = nearest_distances(&reference, &set);
    for (r, nearest) in reference.iter().zip(nearest) {
        let expected = set.iter().map(|g| distance_by_angles(r, g)).fold(f64::INFINITY, f64::min);
        assert!((nearest - expected).abs() < 1e-6);
    }
}

#[test]
fn the_farthest_subset_is_that_of_the_plain_algorithm() {
    let set = grasps(300, 4);
    let found = farthest_subset(&set, 40, 7);
    let mut expected = vec![found[0]];
    while expected.len() < 40 {
        let nearest = |i: usize| {
            expected.iter().map(|&c| grasp_distance(&set[i], &set[c])).fold(f64::INFINITY, f64::min)
        };
        let best = (0..300).fold(0, |best, i| if nearest(i) > nearest(best) { i } else { best });
        expected.push(best);
    }
    assert_eq!(found, expected);
}

#[test]
fn the_covering_subset_takes_the_best_each_time() {
    let set = grasps(400, 5);
    let threshold = 45.0;
    let found = covering_subset(&set, 60, threshold);
    let near = |a: usize, b: usize| distance_by_angles(&set[a], &set[b]) <= threshold;
    let mut covered = vec![false; set.len()];
    for &chosen in &found {
        let gain = |i: usize| (0..400).filter(|&j| !covered[j] && near(i, j)).count();
        let best = (0..400).map(gain).max().unwrap();
        if best == 0 {
            break;
        }
        assert_eq!(gain(chosen), best);
        for (other, covered) in covered.iter_mut().enumerate() {
            *covered |= near(chosen, other);
        }
    }
    let share = |subset: &[usize]| {
        let subset: Vec<Grasp> = subset.iter().map(|&i| set[i]).collect();
        coverage(&set, &subset, threshold)
    };
    assert!(share(&found) > share(&random_subset(400, 60, 1)));
}

#[test]
fn subsets_have_the_size_that_was_asked_for_and_no_index_twice() {
    let set = grasps(50, 6);
    for count in [0, 1, 20, 50, 80] {
        let subsets = [
            random_subset(50, count, 3),
            farthest_subset(&set, count, 3),
            covering_subset(&set, count, 1e3),
            covering_subset(&set, count, 1e-9),
        ];
        for mut subset in subsets {
            assert_eq!(subset.len(), count.min(50));
            subset.sort_unstable();
            subset.dedup();
            assert_eq!(subset.len(), count.min(50));
        }
    }
    assert!(farthest_subset(&[], 5, 0).is_empty() && covering_subset(&[], 5, 1.0).is_empty());
}

#[test]
fn subsets_do_not_depend_on_the_number_of_threads() {
    let set = grasps(5000, 8);
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| (farthest_subset(&set, 100, 1), covering_subset(&set, 100, 15.0)))
    };
    assert_eq!(with(1), with(3));
}

#[test]
fn contacts_that_face_each_other_need_no_friction_and_tilted_ones_their_tangent() {
    let contact = |y: f64, tilt: f64| Contact {
        point_in_object: Point::new(0.0, y, 0.0),
        normal_in_object: Rotation::from_axis_angle(&Vector::x_axis(), tilt) * Vector::y() * y.signum(),
    };
    assert!(friction_needed(&contact(-0.02, 0.0), &contact(0.02, 0.0)) == 0.0);
    for (first, second) in [(0.1, 0.2), (-0.3, 0.1), (0.0, 0.7)] {
        let needed = friction_needed(&contact(-0.02, first), &contact(0.02, second));
        assert!((needed - f64::tan(first.abs().max(second.abs()))).abs() < 1e-12);
    }
    assert!(friction_needed(&contact(-0.02, 2.0), &contact(0.02, 0.0)).is_infinite());
    assert!(friction_score(0.0, 0.5) > 1.0 - 1e-15 && friction_score(0.5, 0.5) < 1e-15);
    assert!(friction_score(f64::INFINITY, 0.5) < 1e-15 && (friction_score(0.1, 0.4) - 0.75).abs() < 1e-15);
}

/// Returns true if two contacts with friction `friction` can press on each other with forces inside the inner half of
/// their cones. Tries many forces: an oracle for force closure that measures no angle to a line.
fn can_squeeze(a: &Contact, b: &Contact, friction: f64) -> bool {
    let line = (b.point_in_object - a.point_in_object).normalize();
    let inside = |force: &Vector, normal: &Vector| {
        let along = force.dot(normal);
        along > 0.0 && (force - normal * along).norm() <= friction * along
    };
    // Equal and opposite forces along the line are the only ones without torque.
    inside(&line, &-a.normal_in_object) && inside(&-line, &-b.normal_in_object)
}

proptest! {
    #[test]
    fn distance_of_a_grasp_is_symmetric_and_blind_to_twins(seed in 0_u64..500) {
        let set = grasps(2, seed);
        let distance = grasp_distance(&set[0], &set[1]);
        prop_assert!((distance - distance_by_angles(&set[0], &set[1])).abs() < 1e-6);
        prop_assert!((distance - grasp_distance(&set[1], &set[0])).abs() < 1e-9);
        prop_assert!((distance - grasp_distance(&set[0], &set[1].twin())).abs() < 1e-6);
        prop_assert!(grasp_distance(&set[0], &set[0].twin()) < 1e-4);
    }

    #[test]
    fn needed_friction_is_where_squeezing_begins(seed in 0_u64..500) {
        let mut random = Stream::new(seed, 0);
        let mut unit = || Vector::new(random.normal(), random.normal(), random.normal()).normalize();
        let (line, tilt_a, tilt_b) = (unit(), unit() * 0.4, unit() * 0.4);
        let a = Contact {
            point_in_object: Point::origin(),
            normal_in_object: (tilt_a - line).normalize(),
        };
        let b = Contact {
            point_in_object: Point::from(line * 0.05),
            normal_in_object: (tilt_b + line).normalize(),
        };
        let needed = friction_needed(&a, &b);
        prop_assert!((needed - friction_needed(&b, &a)).abs() < 1e-12);
        prop_assert!(can_squeeze(&a, &b, needed + 1e-9) && !can_squeeze(&a, &b, needed - 1e-9));
    }
}

/// Guards against storing all distances: 6.4 GB for 10⁵ grasps.
#[test]
fn the_spread_is_that_of_all_distances_sorted() {
    for (count, seed) in [(2, 1), (3, 2), (40, 3), (151, 4)] {
        let set = grasps(count, seed);
        let pairs = (0..count).flat_map(|a| (a + 1..count).map(move |b| (a, b)));
        let mut all: Vec<f64> = pairs.map(|(a, b)| grasp_distance(&set[a], &set[b])).collect();
        all.sort_by(f64::total_cmp);
        let found = spread(&set).unwrap();
        assert_eq!((found.least, found.median), (all[0], all[all.len() / 2]), "{count} grasps");
        assert_eq!(Some(&found.greatest), all.last());
    }
    let same = vec![grasps(1, 5)[0]; 10];
    assert!(spread(&same).is_some_and(|spread| spread.greatest < 1e-5));
    assert_eq!((spread(&[]), spread(&same[..1])), (None, None));
}
