//! Oracle for tasks that are not in the release: insertions and tasks of several stages. The shapes are those of the built-in
//! scenarios; the check is the oracle's own.

use cranny_collision::{Body, Margins, Part};
use cranny_plan::Unobserved;
use cranny_scenario::{OpenOptions, STEPS, Scenario, insertions, sequences};
use cranny_solve::{Request, solve};
use cranny_task::{Stage, StateSequence, picks_apart};

use crate::cases::{for_each, is_long};
use crate::judge::Oracle;
use crate::mesh::Mesh;
use crate::scene::Obstacle;

/// Converts a body to closed meshes; the floor is skipped, because the oracle checks it itself.
fn obstacle(body: &Body) -> Option<Obstacle> {
    let part = |part: &Part| {
        let Mesh { vertices, triangles, .. } = Mesh::of_soup(&part.solid.tessellation()?);
        let vertices = vertices.iter().map(|vertex| part.world_from_solid * vertex).collect();
        Some(Mesh::new(vertices, triangles))
    };
    let parts: Vec<Mesh> = body.parts.iter().filter_map(part).collect();
    (!parts.is_empty()).then(|| Obstacle { name: body.name.clone(), parts })
}

fn oracle(scenario: &Scenario) -> Oracle {
    let target = scenario.target.expect("a target");
    let (of_target, others): (Vec<_>, Vec<_>) =
        scenario.world.bodies().iter().enumerate().partition(|(index, _)| *index == target);
    let bodies = others.into_iter().chain(of_target);
    let obstacles = bodies.filter_map(|(_, body)| obstacle(body)).collect();
    Oracle::among(scenario.robot.clone(), obstacles, scenario.start.clone(), Vec::new())
}

/// Returns the ids to check: some, or with `CRANNY_LONG` all.
fn chosen(ids: impl Iterator<Item = &'static str>, few: &[&str]) -> Vec<&'static str> {
    ids.filter(|id| is_long() || few.contains(id)).collect()
}

fn judged(name: &str, oracle: &Oracle, pieces: Vec<Vec<Vec<f64>>>, most_sunk_m: f64) -> Vec<String> {
    let pieces: [Vec<Vec<f64>>; 6] = pieces.try_into().expect("six pieces");
    let (samples, faults) = oracle.watch_task(&pieces, most_sunk_m);
    println!("{name}: {samples} samples, {faults:?}");
    faults
}

#[test]
fn nothing_that_is_brought_in_touches_anything() {
    let ids = chosen(insertions().iter().map(|entry| entry.id), &["113", "131"]);
    assert!(ids.len() > 1);
    let faults = for_each(&ids, |id| {
        let scenario = Scenario::open(id, &OpenOptions::default()).unwrap();
        let problem = scenario.problem(Margins::default()).unwrap();
        let stages = vec![Stage::pick(), Stage::place("inside"), Stage::home()];
        let answer = solve(&problem, &Request { stages, ..Request::default() }, &mut Unobserved).unwrap();
        assert!(answer.is_solved(), "{id}");
        let pieces = answer.segments.into_iter().map(|segment| segment.waypoints).collect();
        // At the pose of the paper the target rests on something, within 1 mm.
        judged(id, &oracle(&scenario), pieces, 1e-3)
    });
    assert!(faults.iter().all(Vec::is_empty), "{ids:?}: {faults:?}");
}

#[test]
fn no_step_of_several_touches_anything() {
    let ids = chosen(sequences().iter().map(|entry| entry.id), &["213"]);
    assert!(!ids.is_empty());
    let faults = for_each(&ids, |id| {
        let scenario = Scenario::open(id, &OpenOptions::default()).unwrap();
        let problem = scenario.problem(Margins::default()).unwrap();
        let stages = scenario.task(STEPS).unwrap().stages.clone();
        let request = Request { stages: stages.clone(), ..Request::default() };
        let answer = solve(&problem, &request, &mut Unobserved).unwrap();
        assert!(answer.is_solved(), "{id}");
        let along = StateSequence::of(&problem, &stages, &answer.segments).unwrap().unwrap();
        let (mut faults, mut first) = (Vec::new(), 0);
        for (segments, pick) in picks_apart(&stages, &answer.segments).into_iter().zip(&along.picks) {
            let now = along.states[first].empty_cell().world();
            first += segments.len();
            let pieces = segments.iter().map(|segment| segment.waypoints.clone()).collect();
            let there = Scenario { world: now.clone(), target: pick.target(), ..scenario.clone() };
            faults.extend(judged(id, &oracle(&there), pieces, 0.0));
        }
        faults
    });
    assert!(faults.iter().all(Vec::is_empty), "{ids:?}: {faults:?}");
}
