//! Tests that a world of many parts agrees with small groups of its parts: the broad phase skips distant parts only.

use cranny_collision::{Body, Cell};
use cranny_shape::Solid;
use cranny_spatial::{Pose, Stream, Vector};

/// Number of parts that are checked one by one.
const HANDFUL: usize = 10;

fn random_bodies(random: &mut Stream, count: usize) -> Vec<Body> {
    let body = |index: usize| {
        let [x, y] = [1.2, 1.0].map(|far| random.uniform_between(-far, far));
        let z = random.uniform_between(-0.1, 0.8);
        let half_extents = Vector::zeros().map(|_: f64| random.uniform_between(0.005, 0.08));
        let solid = match index % 3 {
            0 => Solid::sphere(half_extents.x),
            1 => Solid::capsule(half_extents.x, half_extents.y),
            _ => Solid::cuboid(half_extents),
        };
        let pose = Pose::from_parts(Vector::new(x, y, z).into(), random.rotation());
        Body::new(format!("body {index}"), pose, solid.expect("a positive size"))
    };
    let mut bodies: Vec<Body> = (0..count).map(body).collect();
    bodies.insert(count / 2, Body::floor(-0.1));
    bodies
}

#[test]
fn many_parts_answer_as_they_do_by_the_handful() {
    let (robot, mut random) = (crate::fixture::arm(), Stream::new(0, 0));
    let (mut free, mut proven) = (0, 0);
    for _ in 0..3 {
        let bodies = random_bodies(&mut random, 150);
        let handfuls: Vec<Cell> =
            bodies.chunks(HANDFUL).map(|few| crate::fixture::cell(&robot, few.to_vec(), 0.01)).collect();
        let cell = crate::fixture::cell(&robot, bodies, 0.01);
        let mut scratch = cell.scratch();
        let mut scratches: Vec<_> = handfuls.iter().map(Cell::scratch).collect();

        let configurations: Vec<f64> =
            (0..2000).flat_map(|_| robot.random_configuration(&mut random)).collect();
        let mut in_batches = Vec::new();
        cell.are_free(&configurations, &mut scratch, &mut in_batches);
        for (q, in_batch) in configurations.chunks(robot.dof()).zip(in_batches) {
            let expected = handfuls.iter().zip(&mut scratches).all(|(few, scratch)| few.is_free(q, scratch));
            assert_eq!(cell.is_free(q, &mut scratch), expected, "one at a time, {q:?}");
            assert_eq!(in_batch, expected, "in a batch, {q:?}");
            assert_eq!(cell.first_contact(q, &mut scratch).is_none(), expected, "first contact, {q:?}");
            free += u32::from(expected);
        }
        for ends in configurations.chunks(2 * robot.dof()) {
            let (a, target) = ends.split_at(robot.dof());
            let b = &crate::fixture::between(a, target, 0.1);
            let expected = handfuls
                .iter()
                .zip(&mut scratches)
                .all(|(few, scratch)| few.motion_is_free(a, b, scratch).is_proven());
            assert_eq!(cell.motion_is_free(a, b, &mut scratch).is_proven(), expected, "{a:?} to {b:?}");
            proven += u32::from(expected);
        }
    }
    assert!((500..5500).contains(&free) && (100..2500).contains(&proven), "{free} free, {proven} proven");
}
