//! The law of the vector lanes on the twenty released scenarios: their verdict is that of the exact check,
//! whatever the instruction set, for 10⁵ configurations each, half of them at contact.

use std::io::{Write as _, stderr};
use std::path::PathBuf;

use cranny_collision::{Cell, Margins};
use cranny_scenario::{OpenOptions, Scenario};
use cranny_spatial::Stream;
use fearless_simd::Level;

/// Configurations of each kind in a scenario.
const UNIFORM: usize = 50_000;
const AT_CONTACT: usize = 50_000;

/// Bisection ends where no joint differs by more, in metres or radians: links move less than 0.1 mm then.
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

fn verdicts_are_exact(environment: usize) {
    let Some(data) = std::env::var_os("CRANNY_DATA").map(PathBuf::from) else {
        assert!(std::env::var_os("CRANNY_REQUIRE_ALL").is_none(), "CRANNY_DATA is not set");
        // Straight to the stream, because the test runner keeps back what a passing test prints.
        let _ = writeln!(stderr(), "SKIPPED: CRANNY_DATA is not set, so no verdict in a released scenario");
        return;
    };
    for level in 1..=5 {
        let id = format!("0{environment}{level}");
        let folder = data.join("jogramop/scenarios").join(&id);
        let scenario = Scenario::open(folder.to_str().unwrap(), &OpenOptions::default()).unwrap();
        let problem = scenario.problem(Margins::default()).unwrap();
        let cell = problem.cell().expect("the default criterion is exact");
        let (configurations, exact) = judged(cell, &mut Stream::new(level, environment as u64));
        let mut verdicts = Vec::new();
        for level in levels() {
            cell.are_free_with(level, &configurations, &mut cell.scratch(), &mut verdicts);
            let differ = exact.iter().zip(&verdicts).filter(|(a, b)| a != b).count();
            assert_eq!(differ, 0, "{id} {level:?}");
        }
    }
}

/// Configurations in rows, and the verdict of the exact check on each.
fn judged(cell: &Cell, random: &mut Stream) -> (Vec<f64>, Vec<bool>) {
    let mut scratch = cell.scratch();
    let (mut rows, mut verdicts) = (Vec::new(), Vec::new());
    let mut add = |q: &[f64], is_free: bool| {
        rows.extend_from_slice(q);
        verdicts.push(is_free);
    };
    let mut draw = || -> Vec<f64> { cell.robot().random_configuration(random) };
    let mut last: Option<(Vec<f64>, bool)> = None;
    let mut at_contact = 0;
    for index in 0.. {
        let q = draw();
        let is_free = cell.is_free(&q, &mut scratch);
        if index < UNIFORM {
            add(&q, is_free);
        } else if at_contact >= AT_CONTACT {
            break;
        }
        if let Some((other, was_free)) = last.take().filter(|(_, was_free)| *was_free != is_free) {
            let mut ends = [(other, was_free), (q.clone(), is_free)];
            let apart =
                |[a, b]: &[(Vec<f64>, bool); 2]| a.0.iter().zip(&b.0).any(|(a, b)| (a - b).abs() > BISECTED);
            while apart(&ends) && at_contact < AT_CONTACT {
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

/// Every level that this machine can run, the fallback without vector instructions among them.
fn levels() -> Vec<Level> {
    let best = Level::new();
    let mut levels = vec![Level::fallback(), best];
    #[cfg(target_arch = "x86_64")]
    {
        levels.extend(best.as_sse2().map(Level::Sse2));
        levels.extend(best.as_sse4_2().map(Level::Sse4_2));
        levels.extend(best.as_avx2().map(Level::Avx2));
    }
    levels
}
