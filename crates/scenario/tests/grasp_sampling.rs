//! Grasps on the released scans against the released grasps, with independent code for triangles.
//!
//! These tests need the released data, and print a message if they are skipped.

use std::collections::BTreeMap;
use std::io::{Write as _, stderr};
use std::path::PathBuf;

use crate::released_object::ReleasedObject;
use cranny_grasp::{COVERAGE_THRESHOLD, Grasp, covering_subset, nearest_distances, sample_grasps};
use cranny_shape::{Surface, TriangleSoup, VolumeMoments, stable_poses};
use cranny_spatial::{Point, Vector};

fn data() -> Option<PathBuf> {
    let data = std::env::var_os("CRANNY_DATA").map(|data| PathBuf::from(data).join("jogramop"));
    if data.is_none() {
        assert!(std::env::var_os("CRANNY_REQUIRE_ALL").is_none(), "CRANNY_DATA is not set");
        // Written directly to the stream, because the test runner captures the output of a passing test.
        let _ = writeln!(stderr(), "SKIPPED: CRANNY_DATA is not set, so no released scan is sampled");
    }
    data
}

#[test]
fn two_thousand_grasps_cover_the_released_ones_and_each_passes_the_test_of_its_contacts() {
    let Some(data) = data() else { return };
    let mut of_object: BTreeMap<String, (usize, usize)> = BTreeMap::new();
    // The stored run covers all twenty; this test is limited to the first level of each environment, in the long form to the
    // first and the last.
    let levels: &[u32] = if std::env::var_os("CRANNY_LONG").is_some() { &[1, 5] } else { &[1] };
    for id in (1..=4).flat_map(|environment| levels.iter().map(move |level| format!("0{environment}{level}")))
    {
        let released = ReleasedObject::open(&data, &id).unwrap();
        let surface = Surface::new(&released.mesh).unwrap();
        let settings = released.settings(crate::released_object::CANDIDATES, 0);
        let found = sample_grasps(&surface, &settings, &|_| true, &mut |_| true).unwrap().grasps;
        let all: Vec<Grasp> = found.iter().map(|sampled| sampled.grasp).collect();
        let chosen = covering_subset(&all, crate::released_object::KEPT, COVERAGE_THRESHOLD);
        assert_eq!(chosen.len(), 2000);
        let kept: Vec<Grasp> = chosen.into_iter().map(|index| all[index]).collect();
        for grasp in &kept {
            check_contacts(&released.mesh, grasp, settings.friction, settings.opening_m);
        }
        let nearest = nearest_distances(&released.grasps, &kept);
        let covered = nearest.iter().filter(|distance| **distance <= COVERAGE_THRESHOLD).count();
        let sum = of_object.entry(released.object.clone()).or_default();
        *sum = (sum.0 + covered, sum.1 + released.grasps.len());
    }
    for (object, (covered, all)) in of_object {
        let coverage = covered as f64 / all as f64;
        assert!(coverage >= 0.8, "{object}: {coverage}");
    }
}

/// Checks the two contacts of a grasp: on the surface to 0.1 mm, on triangles whose normals are within the friction cone of the
/// closing axis, no farther apart than the gripper opens.
fn check_contacts(mesh: &TriangleSoup, grasp: &Grasp, friction: f64, opening_m: f64) {
    let pose = grasp.world_from_gripper;
    let width_m = grasp.width_m.unwrap();
    assert!(width_m <= opening_m, "{width_m}");
    for side in [-1.0, 1.0] {
        let outwards = pose.rotation * Vector::y() * side;
        let contact = Point::from(pose.translation.vector + outwards * (0.5 * width_m));
        let holds = (0..mesh.triangles.len()).any(|index| {
            let corners = mesh.corners(index);
            // Skips distant triangles, which are the majority.
            let size = (corners[1] - corners[0]).norm().max((corners[2] - corners[0]).norm());
            if (contact - corners[0]).norm() > size + 1e-4 {
                return false;
            }
            let normal = (corners[1] - corners[0]).cross(&(corners[2] - corners[0]));
            distance_to_triangle(&contact, &corners) < 1e-4
                && normal.angle(&outwards) <= friction.atan() + 1e-9
        });
        assert!(holds, "no surface inside the cone at {contact}");
    }
}

fn distance_to_triangle(point: &Point, corners: &[Point; 3]) -> f64 {
    let [a, b, c] = corners;
    let normal = (b - a).cross(&(c - a)).normalize();
    let foot = point - normal * (point - a).dot(&normal);
    let edges = [(a, b), (b, c), (c, a)];
    if edges.iter().all(|(p, q)| (*q - *p).cross(&(foot - *p)).dot(&normal) >= 0.0) {
        return (point - foot).norm();
    }
    let to_edge = |(p, q): &(&Point, &Point)| {
        let along = ((point - *p).dot(&(*q - *p)) / (*q - *p).norm_squared()).clamp(0.0, 1.0);
        (*p + (*q - *p) * along - point).norm()
    };
    edges.iter().map(to_edge).fold(f64::INFINITY, f64::min)
}

/// The released library gives stable poses of its scans, with probabilities.
#[test]
fn stable_poses_of_the_released_screwdriver_are_as_likely_as_in_the_release() {
    let Some(data) = data() else { return };
    let released = ReleasedObject::open(&data, "011").unwrap();
    let center = VolumeMoments::of_mesh(&released.mesh).unwrap().center;
    let poses = stable_poses(&released.mesh.vertices, &center).unwrap();
    // Values of `object_library.yaml`, where the poses are those of samples.
    for (pose, expected) in poses.iter().zip([0.1007, 0.1006, 0.0414, 0.0363]) {
        assert!((pose.probability - expected).abs() < 0.004, "{}, {expected}", pose.probability);
    }
}
