//! The built-in robot's primitives against the detailed link meshes of the released robot.

use std::path::PathBuf;

use cranny_robot::{LinkShape, Robot, RobotOptions};
use cranny_shape::{Solid, separation};
use cranny_spatial::{Point, Pose, Stream, Vector};

/// Maximum distance from a vertex of a link's mesh to the primitives, in metres.
const COVER_M: f64 = 2e-3;

/// Maximum protrusion of the primitives of a link from the hull of its mesh, in metres.
fn bulge_limit_m(link: &str) -> f64 {
    match link {
        "panda_leftfinger" | "panda_rightfinger" => 1e-3,
        "panda_hand" => 3e-3,
        _ => 15e-3,
    }
}

fn distance_m(point: &Point, shape: &LinkShape) -> f64 {
    // A ball far smaller than any tolerance represents the point.
    let probe = Solid::sphere(1e-9).expect("a positive size");
    let at = Pose::translation(point.x, point.y, point.z);
    separation(&probe, &at, &shape.solid, &shape.link_from_shape, f64::MAX).upper_m
}

/// Returns the extreme points of a convex solid in many directions. The distance from a convex hull is a convex function, so
/// its maximum over the solid is attained at one of them.
fn extreme_points(shape: &LinkShape, random: &mut Stream) -> Vec<Point> {
    let extreme = |_| {
        let direction = random.rotation() * Vector::z();
        shape.link_from_shape * shape.solid.support_point(&direction).expect("primitives are convex")
    };
    (0..4000).map(extreme).collect()
}

#[test]
fn its_primitives_cover_the_detailed_meshes_and_hardly_bulge() {
    let Some(data) = std::env::var_os("CRANNY_DATA").map(PathBuf::from) else {
        eprintln!("SKIPPED: the built-in robot against the released meshes (set CRANNY_DATA)");
        return;
    };
    let built_in = cranny_scenario::panda_mobile().expect("the built-in robot loads");
    let urdf = data.join("jogramop/robots/franka_panda/mobile_panda.urdf");
    let options = RobotOptions { tip: Some("panda_grasptarget".into()), ..RobotOptions::default() };
    let detailed = Robot::load(&urdf, &options).expect("the released robot loads");
    let mut random = Stream::new(0, 0);
    let mut faults = Vec::new();
    println!("{:<18} {:>10} {:>9} {:>9}", "link", "primitives", "cover mm", "bulge mm");
    for link in detailed.links().iter().filter(|link| !link.collisions.is_empty()) {
        let own = &built_in.links()[built_in.link_index(&link.name).expect("the same links")].collisions;
        let mut cover_m = 0.0_f64;
        let mut bulge_m = 0.0_f64;
        for mesh in &link.collisions {
            let vertices = mesh.soup.as_ref().map_or_else(
                || mesh.solid.bounding_points().expect("links are bounded").0,
                |soup| soup.vertices.clone(),
            );
            for vertex in vertices {
                let vertex = mesh.link_from_shape * vertex;
                let nearest = own.iter().map(|shape| distance_m(&vertex, shape)).fold(f64::MAX, f64::min);
                cover_m = cover_m.max(nearest);
            }
            for shape in own {
                let points = extreme_points(shape, &mut random);
                bulge_m = points.iter().map(|p| distance_m(p, mesh)).fold(bulge_m, f64::max);
            }
        }
        println!("{:<18} {:>10} {:>9.2} {:>9.2}", link.name, own.len(), cover_m * 1e3, bulge_m * 1e3);
        if cover_m > COVER_M || bulge_m > bulge_limit_m(&link.name) {
            faults.push(link.name.clone());
        }
    }
    assert!(faults.is_empty(), "covers too little or bulges too much: {faults:?}");
}
