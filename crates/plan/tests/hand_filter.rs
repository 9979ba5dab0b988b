//! Grasps that are free for the hand alone.

use cranny_collision::{Body, World};
use cranny_grasp::{BoxHand, Grasp, Hand};
use cranny_shape::{Solid, Surface, TriangleSoup, separation};
use cranny_spatial::{CONTACT_M, Pose, Rotation, Stream, Vector};
use cranny_task::HandFilter;

fn hand() -> Hand {
    BoxHand::default().hand().unwrap()
}

fn world(bodies: Vec<Body>) -> World {
    World::new(bodies).unwrap()
}

/// Returns a ball of 3 cm radius at the origin.
fn ball() -> Body {
    Body::new("ball", Pose::identity(), Solid::sphere(0.03).unwrap())
}

fn grasp(pose: Pose) -> Grasp {
    Grasp::at(pose)
}

/// Returns the rotation of a grasp from above: z of the gripper points down.
fn downwards() -> Rotation {
    Rotation::from_axis_angle(&Vector::x_axis(), std::f64::consts::PI)
}

#[test]
fn a_hand_about_a_ball_is_free_until_ground_or_ceiling_come_too_near() {
    let at_ball = grasp(Pose::from_parts(Vector::zeros().into(), downwards()));
    let free = |height_m: f64, ceiling_m: f64| {
        let ceiling = Body::new(
            "ceiling",
            Pose::translation(0.0, 0.0, ceiling_m + 0.1),
            Solid::cuboid(Vector::new(1.0, 1.0, 0.1)).unwrap(),
        );
        let world = world(vec![ball(), Body::floor(height_m), ceiling]);
        HandFilter::new(&hand(), world, 0.05).unwrap().is_free(&at_ball)
    };
    // The tips reach 7 mm beyond the origin.
    assert!(free(-0.0071, 0.3) && !free(-0.0069, 0.3));
    // Palm and fingers are 0.1126 m long behind it, and approach from 5 cm higher.
    assert!(free(-0.05, 0.1627) && !free(-0.05, 0.1625));
    let filter = HandFilter::new(&hand(), world(vec![ball(), Body::floor(-0.006)]), 0.0).unwrap();
    assert_eq!(filter.blocking_body(&at_ball.world_from_gripper), Some(1));
}

#[test]
fn an_obstacle_on_the_way_blocks_though_the_grasp_itself_is_free() {
    let at_ball = grasp(Pose::from_parts(Vector::zeros().into(), downwards()));
    // The bar is right above the end of the palm: the grasp is free, but the approach to it is not.
    let bar = Body::new(
        "bar",
        Pose::translation(0.0, 0.0, 0.13),
        Solid::cuboid(Vector::new(0.2, 0.01, 0.01)).unwrap(),
    );
    let free = |approach_m: f64| {
        HandFilter::new(&hand(), world(vec![ball(), bar.clone()]), approach_m).unwrap().is_free(&at_ball)
    };
    assert!(free(0.0) && free(0.007) && !free(0.01) && !free(0.05));
}

#[test]
fn the_sweep_blocks_exactly_where_some_place_on_the_way_does() {
    let filter_world = world(vec![ball(), Body::floor(-0.05)]);
    let approach_m = 0.06;
    let filter = HandFilter::new(&hand(), filter_world.clone(), approach_m).unwrap();
    let parts = hand().parts;
    let mut random = Stream::new(3, 0);
    let (mut free, mut blocked) = (0, 0);
    for _ in 0..400 {
        let origin = Vector::new(random.normal(), random.normal(), random.normal()) * 0.05;
        let pose = Pose::from_parts(origin.into(), random.rotation());
        let mut least_m = f64::INFINITY;
        for step in 0..=60 {
            let back = Pose::translation(0.0, 0.0, -approach_m * f64::from(step) / 60.0);
            for (gripper_from_part, solid) in &parts {
                for part in filter_world.bodies().iter().flat_map(|body| &body.parts) {
                    let there = pose * back * gripper_from_part;
                    let gap = separation(solid, &there, &part.solid, &part.world_from_solid, 1.0);
                    least_m = least_m.min(gap.lower_m);
                }
            }
        }
        // Between two samples of the approach no point of the hand moves more than half a millimetre from the nearer one.
        let is_free = filter.pose_is_free(&pose);
        if least_m <= CONTACT_M {
            assert!(!is_free);
        } else if least_m > 6e-4 {
            assert!(is_free, "{least_m}");
        }
        free += usize::from(is_free);
        blocked += usize::from(!is_free);
    }
    assert!(free > 50 && blocked > 50, "{free} free, {blocked} blocked");
}

#[test]
fn a_surface_with_a_hole_blocks_like_the_closed_one() {
    let whole = TriangleSoup::geodesic_sphere(0.03, 3);
    let closed = Body::new("scan", Pose::identity(), Solid::mesh(&whole).unwrap());
    let of_solid = HandFilter::new(&hand(), world(vec![closed]), 0.05).unwrap();
    let mut holed = whole.clone();
    holed.triangles.truncate(holed.triangles.len() - 3);
    let surface = Surface::new(&holed).unwrap();
    let of_surface =
        HandFilter::new(&hand(), World::default(), 0.05).unwrap().with_surface(Pose::identity(), surface);
    let mut random = Stream::new(5, 0);
    let (mut blocked, mut different) = (0, 0);
    for _ in 0..500 {
        let origin = Vector::new(random.normal(), random.normal(), random.normal()) * 0.03;
        let pose = Pose::from_parts(origin.into(), random.rotation());
        let verdicts = (of_solid.pose_is_free(&pose), of_surface.pose_is_free(&pose));
        blocked += usize::from(!verdicts.0);
        different += usize::from(verdicts.0 != verdicts.1);
    }
    // They differ only if the hand is within rounding of the ball, passes through the hole, or encloses the ball.
    assert!(blocked > 100 && different <= 5, "{blocked} blocked, {different} different");
}

#[test]
fn an_approach_that_is_none_is_refused() {
    for approach_m in [-0.01, f64::NAN, f64::INFINITY] {
        assert!(HandFilter::new(&hand(), World::default(), approach_m).is_err());
    }
}
