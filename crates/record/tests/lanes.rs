//! Law of the vector lanes on the twenty released scenarios: their verdict equals that of the exact check, for every
//! instruction set, for 10⁵ configurations each, half of them at contact.

use std::io::{Write as _, stderr};
use std::path::{Path, PathBuf};

use cranny_collision::{Cell, Collider, Margins};
use cranny_plan::Unobserved;
use cranny_scenario::{OpenOptions, Scenario};
use cranny_solve::{Request, solve};
use cranny_spatial::{Stream, simd_levels};
use cranny_task::{Carrier, LiftOffSettings, Stage};

/// Number of configurations of each kind in a scenario, in the plain run and in the long one.
const OF_EACH: [usize; 2] = [10_000, 50_000];

fn is_long() -> bool {
    std::env::var_os("CRANNY_LONG").is_some()
}

/// Joint difference at which the bisection ends, in metres or radians: links then move less than 0.1 mm.
const BISECTED: f64 = 2e-5;

#[test]
fn verdicts_are_exact_in_the_shelf() {
    verdicts_are_exact(1);
}

#[test]
fn verdicts_are_exact_under_the_table() {
    verdicts_are_exact(2);
}

#[test]
fn verdicts_are_exact_behind_the_wall() {
    verdicts_are_exact(3);
}

#[test]
fn verdicts_are_exact_behind_the_gate() {
    verdicts_are_exact(4);
}

/// Number of configurations of each kind in a hold, in the plain run and in the long one.
const HELD: [usize; 2] = [1_000, 50_000];

/// The law while the hand holds the target, in two grasps: half of the configurations are at contact of the held object.
#[test]
fn verdicts_are_exact_with_the_target_in_the_hand() {
    let Some(data) = data() else { return };
    for index in 0..20 {
        let id = format!("0{}{}", 1 + index / 5, 1 + index % 5);
        let scenario = released(&data, &id);
        let problem = scenario.problem(Margins::default()).unwrap();
        let carrier = Carrier::new(&problem, LiftOffSettings::default()).unwrap();
        for seed in 0..2 {
            let stages = vec![Stage::pick(), Stage::home()];
            let request = Request { stages, seed, hold: None, ..Request::default() };
            let answer = solve(&problem, &request, &mut Unobserved).unwrap();
            let grip = carrier.close(answer.segments[0].waypoints.last().unwrap()).unwrap();
            let cell = grip.cells()[1];
            let mut random = Stream::new(seed, index);
            let count = HELD[usize::from(is_long())];
            let along: Vec<&Vec<f64>> = answer.segments[2].waypoints.iter().collect();
            let (rows, exact) = judged_held(cell, &along, count, &mut random);
            let mut verdicts = Vec::new();
            for (_, level) in simd_levels() {
                cell.are_free_with(level, &rows, &mut cell.scratch(), &mut verdicts);
                let differ = exact.iter().zip(&verdicts).filter(|(a, b)| a != b).count();
                assert_eq!(differ, 0, "{id}, seed {seed}, {level:?}");
            }
        }
    }
}

/// Works as [`judged`], with the second half near `along`, where the held object is about to touch.
fn judged_held(cell: &Cell, along: &[&Vec<f64>], count: usize, random: &mut Stream) -> (Vec<f64>, Vec<bool>) {
    /// Greatest distance of a joint of these configurations from a way point, in metres or radians.
    const NEAR: f64 = 0.4;
    let (mut scratch, held) = (cell.scratch(), cell.robot().held_link().map(Collider::Link));
    let (mut rows, mut verdicts) = (Vec::new(), Vec::new());
    for _ in 0..count {
        let q = cell.robot().random_configuration(random);
        verdicts.push(cell.is_free(&q, &mut scratch));
        rows.extend(q);
    }
    while verdicts.len() < 2 * count {
        let free = along[random.index(along.len())];
        let near = |value: &f64| value + random.uniform_between(-NEAR, NEAR);
        let mut ends = [free.clone(), free.iter().map(near).collect()];
        if cell.is_free(&ends[1], &mut scratch) {
            continue;
        }
        while ends[0].iter().zip(&ends[1]).any(|(a, b)| (a - b).abs() > BISECTED) {
            let middle: Vec<f64> = ends[0].iter().zip(&ends[1]).map(|(a, b)| 0.5 * (a + b)).collect();
            let end = usize::from(!cell.is_free(&middle, &mut scratch));
            ends[end] = middle;
        }
        let contact = cell.first_contact(&ends[1], &mut scratch);
        if contact.is_some_and(|contact| [Some(contact.first), Some(contact.second)].contains(&held)) {
            for (q, is_free) in ends.iter().zip([true, false]) {
                rows.extend_from_slice(q);
                verdicts.push(is_free);
            }
        }
    }
    (rows, verdicts)
}

fn data() -> Option<PathBuf> {
    let data = std::env::var_os("CRANNY_DATA").map(PathBuf::from);
    if data.is_none() {
        assert!(std::env::var_os("CRANNY_REQUIRE_ALL").is_none(), "CRANNY_DATA is not set");
        // Write to the stream directly, because the test runner hides the output of a passing test.
        let _ = writeln!(stderr(), "SKIPPED: CRANNY_DATA is not set, so no verdict in a released scenario");
    }
    data
}

fn released(data: &Path, id: &str) -> Scenario {
    let folder = data.join("jogramop/scenarios").join(id);
    Scenario::open(folder.to_str().unwrap(), &OpenOptions::default()).unwrap()
}

fn verdicts_are_exact(environment: usize) {
    let Some(data) = data() else { return };
    for level in 1..=5 {
        let id = format!("0{environment}{level}");
        let scenario = released(&data, &id);
        let problem = scenario.problem(Margins::default()).unwrap();
        let cell = problem.cell().expect("the default criterion is exact");
        let (configurations, exact) = judged(cell, &mut Stream::new(level, environment as u64));
        let mut verdicts = Vec::new();
        for (_, level) in simd_levels() {
            cell.are_free_with(level, &configurations, &mut cell.scratch(), &mut verdicts);
            let differ = exact.iter().zip(&verdicts).filter(|(a, b)| a != b).count();
            assert_eq!(differ, 0, "{id} {level:?}");
        }
    }
}

/// Returns configurations in rows, and the verdict of the exact check on each.
fn judged(cell: &Cell, random: &mut Stream) -> (Vec<f64>, Vec<bool>) {
    let mut scratch = cell.scratch();
    let (mut rows, mut verdicts) = (Vec::new(), Vec::new());
    let mut add = |q: &[f64], is_free: bool| {
        rows.extend_from_slice(q);
        verdicts.push(is_free);
    };
    let mut draw = || -> Vec<f64> { cell.robot().random_configuration(random) };
    let mut last: Option<(Vec<f64>, bool)> = None;
    let (mut at_contact, of_each) = (0, OF_EACH[usize::from(is_long())]);
    for index in 0.. {
        let q = draw();
        let is_free = cell.is_free(&q, &mut scratch);
        if index < of_each {
            add(&q, is_free);
        } else if at_contact >= of_each {
            break;
        }
        if let Some((other, was_free)) = last.take().filter(|(_, was_free)| *was_free != is_free) {
            let mut ends = [(other, was_free), (q.clone(), is_free)];
            let apart =
                |[a, b]: &[(Vec<f64>, bool); 2]| a.0.iter().zip(&b.0).any(|(a, b)| (a - b).abs() > BISECTED);
            while apart(&ends) && at_contact < of_each {
                let middle: Vec<f64> = ends[0].0.iter().zip(&ends[1].0).map(|(a, b)| 0.5 * (a + b)).collect();
                let is_free = cell.is_free(&middle, &mut scratch);
                ends[usize::from(is_free != ends[0].1)] = (middle, is_free);
            }
            for (q, is_free) in &ends {
                add(q, *is_free);
                at_contact += 1;
            }
        }
        last = Some((q, is_free));
    }
    (rows, verdicts)
}
