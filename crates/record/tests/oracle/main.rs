//! An oracle for the collision crate: it reads the released files itself, samples a motion every half millimetre and tests
//! edges against triangles. It shares no distance code with the code under test.

#![allow(clippy::disallowed_methods, reason = "what is compared to may come from the system")]

mod built_in_tasks;
mod cases;
mod hull;
mod judge;
mod mesh;
mod scene;

use std::collections::BTreeMap;
use std::time::Instant;

use cranny_collision::Motion;
use cranny_spatial::{Point, Pose, Stream, Vector};

use crate::cases::{Case, cases, for_each, is_long};
use crate::hull::{convex_hull, height_above};
use crate::judge::{LIMITS, STEP_M, between, random_configuration};
use crate::mesh::{Mesh, goes_through};

#[test]
fn no_planned_path_touches_anything() {
    let Some(cases) = cases() else { return };
    let judge = |case: &Case| {
        let path = case.path()?;
        let begin = Instant::now();
        let mut faults = case.oracle.faults_of_way_points(path);
        let mut pictures = case.oracle.pictures();
        let mut samples = 0;
        for (edge, ends) in path.windows(2).enumerate() {
            let sight = case.oracle.watch(&ends[0], &ends[1], &mut pictures);
            samples += sight.samples;
            faults.extend(sight.touch.map(|(t, touch)| format!("edge {edge} at {t}: {touch:?}")));
        }
        let (edges, seconds) = (path.len() - 1, begin.elapsed().as_secs_f64());
        println!("{}: {edges} edges, {samples} samples, {seconds:.1} s, {faults:?}", case.id);
        Some(faults)
    };
    let verdicts = for_each(cases, judge);
    let unsolved: Vec<&str> =
        cases.iter().filter(|case| case.path().is_none()).map(|case| case.id.as_str()).collect();
    println!("not solved: {unsolved:?}");
    assert!(unsolved.len() <= 2, "not solved: {unsolved:?}");
    for (case, faults) in cases.iter().zip(verdicts) {
        assert!(faults.is_none_or(|faults| faults.is_empty()), "{}: see above", case.id);
    }
}

#[test]
fn no_carried_target_touches_anything() {
    let Some(cases) = cases() else { return };
    let judge = |case: &Case| {
        let ways = case.carried()?;
        let rest_m = case.oracle.resting_depth_m();
        let mut faults = Vec::new();
        let mut samples = 0;
        // During the lift-off, the target penetrates its support no deeper than at rest, to 0.1 mm; after it, nothing.
        for (way, raised_m) in ways.iter().zip([rest_m + 1e-4, 0.0]) {
            for (edge, ends) in way.windows(2).enumerate() {
                let (seen, touch) = case.oracle.watch_carried(&ways[0][0], raised_m, [&ends[0], &ends[1]]);
                samples += seen;
                faults.extend(touch.map(|(t, touch)| format!("edge {edge} at {t}: {touch:?}")));
            }
        }
        println!("{}: {:.1} mm deep, {samples} samples, {faults:?}", case.id, 1e3 * rest_m);
        Some(faults)
    };
    for (case, faults) in cases.iter().zip(for_each(cases, judge)) {
        assert_eq!(faults, Some(Vec::new()), "{}", case.id);
    }
    // The target is checked as an obstacle: in this motion it would hit the table.
    let [lift_off, _] = cases[0].carried().unwrap();
    let grasp = &lift_off[0];
    let mut sunk = grasp.clone();
    sunk[0] += 0.3;
    assert!(cases.iter().any(|case| case.oracle.watch_carried(grasp, 0.0, [grasp, &sunk]).1.is_some()));
}

#[test]
fn no_target_that_is_put_down_touches_anything_and_nothing_touches_it() {
    let Some(cases) = cases() else { return };
    assert!(cases.len() >= 8);
    let judge = |case: &Case| {
        let pieces = case.placed()?.try_into().ok()?;
        // It is released a third of a millimetre above its support, so that it penetrates nothing during the set-down.
        let (samples, faults) = case.oracle.watch_task(&pieces, 0.0);
        println!("{}: {samples} samples, {faults:?}", case.id);
        Some(faults)
    };
    for (case, faults) in cases.iter().zip(for_each(cases, judge)) {
        assert_eq!(faults, Some(Vec::new()), "{}", case.id);
    }
}

#[test]
fn most_straight_lines_from_start_to_goal_touch_something() {
    let Some(cases) = cases() else { return };
    let touch = |case: &Case| {
        let path = case.path()?;
        let mut pictures = case.oracle.pictures();
        case.oracle.watch(&path[0], &path[path.len() - 1], &mut pictures).touch
    };
    let touches = for_each(cases, touch).into_iter().flatten().count();
    println!("{touches} of {} straight lines touch something", cases.len());
    assert!(2 * touches >= cases.len(), "{touches}");
}

#[test]
fn a_path_that_runs_backwards_or_leaves_the_limits_is_faulty() {
    let Some(cases) = cases() else { return };
    for case in cases {
        let (oracle, Some(path)) = (&case.oracle, case.path()) else { continue };
        assert!(oracle.faults_of_way_points(path).is_empty());
        let mut bad = path.clone();
        bad.reverse();
        let expected = ["it does not begin at the start", "it does not end at a grasp"];
        assert_eq!(oracle.faults_of_way_points(&bad), expected);
        bad.clone_from(path);
        bad.insert(1, path[0].clone());
        bad[1][5] = 0.01;
        assert_eq!(oracle.faults_of_way_points(&bad), ["way point 1 is outside the limits"]);
    }
}

#[test]
fn a_grasp_is_reached_by_itself_and_its_twin_but_not_from_beside() {
    let Some(cases) = cases() else { return };
    for case in cases {
        let (oracle, Some(end)) = (&case.oracle, case.path().and_then(|path| path.last())) else { continue };
        let grasp = oracle.grasps.iter().find(|grasp| oracle.is_reached(grasp, end)).unwrap();
        let moved = |joint: usize, by: f64| {
            let mut q = end.clone();
            q[joint] += by;
            oracle.is_reached(grasp, &q)
        };
        // The base by 3 mm; the last joint, which turns the hand about the approach direction, by 3°.
        assert!(!moved(0, 3e-3) && !moved(1, -3e-3) && !moved(8, 3f64.to_radians()));
        assert!(moved(8, std::f64::consts::PI));
    }
}

#[test]
fn the_oracle_looks_at_every_pair_of_links_that_the_collision_room_looks_at() {
    let Some(cases) = cases() else { return };
    for Case { id, oracle, cell, .. } in cases {
        let link = |mesh: usize| oracle.links[mesh].link;
        let seen: Vec<_> = oracle.pairs.iter().map(|&(first, second)| (link(first), link(second))).collect();
        for (a, b) in cell.self_pairs() {
            assert!(seen.contains(&(a.min(b), a.max(b))), "{id}: {a} and {b}");
        }
    }
}

/// Counts of motions by the verdicts of oracle and proof, and of the touched things.
#[derive(Debug, Default)]
struct Tally {
    proven: usize,
    touched: usize,
    deep_contacts: usize,
    /// Counts by the name of the first touched thing.
    touches: BTreeMap<String, usize>,
}

#[test]
fn what_is_proven_the_oracle_sees_free_and_what_it_sees_touch_is_not_proven() {
    let Some(cases) = cases() else { return };
    let mut total = Tally::default();
    for (case, tally) in cases.iter().zip(for_each(cases, agreement)) {
        println!("{}: {tally:?}", case.id);
        // The start is free and the limits are wide: of many motions, both kinds occur in every scenario.
        assert!(tally.touched >= if is_long() { 5 } else { 2 }, "{}: {tally:?}", case.id);
        assert!(tally.proven >= 3 || !is_long(), "{}: {tally:?}", case.id);
        total.proven += tally.proven;
        total.touched += tally.touched;
        total.deep_contacts += tally.deep_contacts;
        for (what, count) in tally.touches {
            *total.touches.entry(what).or_default() += count;
        }
    }
    println!("all: {total:?}");
    for what in ["floor", "target", "table", "open_shelf", "wall_segment", "gate", "panda_"] {
        assert!(total.touches.keys().any(|key| key.starts_with(what)), "nothing touched {what}: {total:?}");
    }
    let [proven, touched] = if is_long() { [100, 200] } else { [14, 30] };
    assert!(
        total.proven >= proven && total.touched >= touched && total.deep_contacts >= touched,
        "{total:?}"
    );
}

/// Compares oracle and proof on many motions of one scenario.
fn agreement(case: &Case) -> Tally {
    /// Depth beyond which an overlap cannot be a matter of tolerance, in metres.
    const DEEP_M: f64 = 1e-4;
    let (mut pictures, mut scratch) = (case.oracle.pictures(), case.cell.scratch());
    let mut tally = Tally::default();
    for (a, b) in motions(case) {
        let sight = case.oracle.watch(&a, &b, &mut pictures);
        let motion = case.cell.motion_is_free(&a, &b, &mut scratch);
        if let Some((t, touch)) = &sight.touch {
            assert!(!motion.is_proven(), "{}: {touch:?} at {t} from {a:?} to {b:?}", case.id);
            tally.touched += 1;
            *tally.touches.entry(touch.second.clone()).or_default() += 1;
        }
        tally.proven += usize::from(motion.is_proven());
        if let Motion::Contact { at, contact } = motion
            && contact.depth_m > DEEP_M
        {
            let touch = case.oracle.touch_at(&between(&a, &b, at), &mut pictures);
            assert!(touch.is_some(), "{}: {contact:?} at {at} from {a:?} to {b:?}", case.id);
            tally.deep_contacts += 1;
        }
    }
    tally
}

/// Returns motions of all kinds: across the whole configuration space, short ones near the path, displacements of the hand at
/// the end of the path, and the one from start to end.
fn motions(case: &Case) -> Vec<(Vec<f64>, Vec<f64>)> {
    let of_each = if is_long() { 8 } else { 3 };
    /// Displacement of the base, in metres: more than the width of the open hand.
    const PUSH_M: f64 = 0.1;
    let mut random = Stream::new(1, case.id.parse().unwrap());
    let mut motions = Vec::new();
    for _ in 0..of_each {
        motions.push((random_configuration(&mut random), random_configuration(&mut random)));
    }
    let beside = case.path().cloned().unwrap_or_else(|| vec![case.start.clone()]);
    for _ in 0..of_each {
        let from = beside[random.index(beside.len())].clone();
        let to = between(&from, &random_configuration(&mut random), 0.1);
        motions.push((from, to));
    }
    if let Some(end) = case.path().and_then(|path| path.last()) {
        for push in 0..of_each {
            let (sine, cosine) = (f64::from(push) * std::f64::consts::TAU / f64::from(of_each)).sin_cos();
            let mut pushed = end.clone();
            for (joint, by) in [cosine, sine].into_iter().enumerate() {
                let [low, high] = LIMITS[joint];
                pushed[joint] = (pushed[joint] + by * PUSH_M).clamp(low, high);
            }
            motions.push((end.clone(), pushed));
        }
        motions.push((case.start.clone(), end.clone()));
    }
    motions
}

#[test]
fn between_two_samples_no_point_of_a_link_moves_more_than_half_a_millimetre() {
    let Some(cases) = cases() else { return };
    let oracle = &cases[0].oracle;
    let mut random = Stream::new(2, 0);
    for _ in 0..3 {
        let (a, b) = (random_configuration(&mut random), random_configuration(&mut random));
        let samples: Vec<f64> = oracle.samples(&a, &b).collect();
        assert_eq!((samples[0], samples[samples.len() - 1]), (0.0, 1.0));
        let mut earlier = oracle.pictures();
        oracle.look_at(&a, &mut earlier);
        for t in samples {
            let mut later = earlier.clone();
            oracle.look_at(&between(&a, &b, t), &mut later);
            for (from, to) in earlier.links.iter().zip(&later.links) {
                let way = |(from, to): (&Point, &Point)| (to - from).norm();
                assert!(from.vertices.iter().zip(&to.vertices).map(way).all(|way| way <= STEP_M));
            }
            earlier = later;
        }
    }
}

#[test]
fn hulls_of_the_links_are_convex_and_hold_every_vertex() {
    let Some(cases) = cases() else { return };
    let Case { oracle, cell, .. } = &cases[0];
    // Platform, links 0 to 7, hand and two fingers.
    assert_eq!(oracle.links.len(), 12);
    for link in &oracle.links {
        let Mesh { vertices, triangles, .. } = &link.mesh;
        let shape = &cell.robot().links()[link.link].collisions[0];
        let soup = shape.soup.iter().flat_map(|soup| &soup.vertices);
        let all: Vec<Point> = soup.map(|vertex| shape.link_from_shape * vertex).collect();
        // Euler's formula for a closed surface without handles.
        assert_eq!(vertices.len() + triangles.len() - triangles.len() / 2 * 3, 2, "{}", link.name);
        for face in triangles {
            let is_outside = |vertex: &&Point| height_above(vertices, face, vertex) > 1e-8;
            assert!(vertices.iter().chain(&all).find(is_outside).is_none(), "{}", link.name);
        }
    }
}

#[test]
fn a_hull_of_a_cube_with_points_inside_and_on_it_is_the_cube() {
    let mut points = Mesh::cuboid(Vector::new(0.1, 0.2, 0.3)).vertices;
    let mut random = Stream::new(3, 0);
    for _ in 0..50 {
        let inside = Vector::new(0.1, 0.2, 0.3).map(|half| half * random.uniform_between(-1.0, 1.0));
        points.extend([inside, Vector::new(0.1, inside.y, inside.z)].map(Point::from));
    }
    let Mesh { vertices, triangles, .. } = convex_hull(&points);
    let corner = |face: &[usize; 3], which: usize| vertices[face[which]].coords;
    let wedge = |face: &[usize; 3]| corner(face, 0).cross(&corner(face, 1)).dot(&corner(face, 2)) / 6.0;
    assert!((triangles.iter().map(wedge).sum::<f64>() - 0.2 * 0.4 * 0.6).abs() < 1e-9);
    assert!(triangles.iter().all(|face| points.iter().all(|p| height_above(&vertices, face, p) < 1e-8)));
}

#[test]
fn an_edge_goes_through_a_triangle_or_passes_it() {
    let triangle = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]].map(Point::from);
    let edge = |from: [f64; 3], to: [f64; 3]| goes_through(&[from.into(), to.into()], &triangle);
    assert!(edge([0.2, 0.2, -1.0], [0.3, 0.3, 1.0]) && edge([0.3, 0.3, 1.0], [0.2, 0.2, -1.0]));
    assert!(edge([0.2, 0.2, 0.0], [0.2, 0.2, 1.0]));
    assert!(!edge([0.6, 0.6, -1.0], [0.6, 0.6, 1.0]));
    assert!(!edge([0.2, 0.2, 0.001], [0.2, 0.2, 1.0]));
    assert!(!edge([-1.0, 0.2, 0.5], [1.0, 0.2, 0.5]));
}

#[test]
fn boxes_meet_where_they_cross_and_where_one_holds_the_other() {
    let (small, large) = (Mesh::cuboid(Vector::repeat(0.1)), Mesh::cuboid(Vector::repeat(1.0)));
    let at = |x: f64| small.placed(&Pose::new(Vector::new(x, 0.2, 0.3), Vector::new(0.1, 0.2, 0.3)));
    let room = large.placed(&Pose::identity());
    for (x, expected) in [(0.0, true), (0.95, true), (-1.05, true), (1.3, false), (-5.0, false)] {
        assert_eq!((at(x).meets(&room), room.meets(&at(x))), (expected, expected), "{x}");
    }
}

#[test]
fn a_plate_of_a_tenth_of_a_millimetre_is_seen() {
    let plate = Mesh::cuboid(Vector::new(1.0, 1.0, 0.5e-4)).placed(&Pose::identity()).vertices;
    let plate = convex_hull(&plate);
    let rod = Mesh::cuboid(Vector::new(0.01, 0.01, 0.3));
    let at = |z: f64| rod.placed(&Pose::translation(0.2, 0.1, z));
    let plate = plate.placed(&Pose::identity());
    assert!(at(0.0).meets(&plate) && at(0.3).meets(&plate) && !at(0.3002).meets(&plate));
}

#[test]
fn bodies_that_share_no_vertex_come_apart() {
    let (a, b) = (Mesh::cuboid(Vector::repeat(0.1)), Mesh::cuboid(Vector::repeat(0.2)));
    let both = Mesh::new(
        a.vertices.iter().chain(&b.vertices).copied().collect(),
        a.triangles.iter().copied().chain(b.triangles.iter().map(|t| t.map(|vertex| vertex + 8))).collect(),
    );
    let pieces = both.pieces();
    assert_eq!(pieces.iter().map(|piece| piece.vertices.len()).collect::<Vec<_>>(), [8, 8]);
}
