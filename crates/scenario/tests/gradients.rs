//! Gradients of signed distances on the built-in scenarios.

use cranny_collision::{Cell, Margins, PairDistance, Scratch};
use cranny_scenario::{OpenOptions, Scenario, catalogue};
use cranny_spatial::Stream;

/// Distance up to which pairs are compared, in metres.
const WITHIN_M: f64 = 0.3;

/// Returns the distance at `q` of the pair that was `pair` nearby. Two bodies can have several pairs of solids, of which some are
/// equally near: the one whose closest points moved least is the same. In an overlap, points jump, and only the distance decides.
fn distance_m(cell: &Cell, q: &[f64], pair: &PairDistance, scratch: &mut Scratch) -> Option<f64> {
    let mut found = Vec::new();
    cell.pair_distances(q, WITHIN_M + 0.05, scratch, &mut found);
    let same = found.iter().filter(|other| (other.link, other.second) == (pair.link, pair.second));
    let change = |other: &PairDistance| {
        let points = (other.on_link - pair.on_link).norm() + (other.on_second - pair.on_second).norm();
        let points = if pair.distance_m > 0.0 { points } else { 0.0 };
        points + (other.distance_m - pair.distance_m).abs()
    };
    same.min_by(|a, b| change(a).total_cmp(&change(b))).map(|nearest| nearest.distance_m)
}

/// Returns the derivative of the distance by a joint, by differences of fourth order.
fn slope(
    cell: &Cell,
    q: &[f64],
    joint: usize,
    pair: &PairDistance,
    step: f64,
    scratch: &mut Scratch,
) -> Option<f64> {
    let mut at = |steps: f64| {
        let mut q = q.to_vec();
        q[joint] += steps * step;
        distance_m(cell, &q, pair, scratch)
    };
    let near = at(1.0)? - at(-1.0)?;
    let far = at(2.0)? - at(-2.0)?;
    Some((8.0 * near - far) / (12.0 * step))
}

#[test]
fn gradients_are_those_of_finite_differences() {
    // Distances err by 10⁻¹⁵ m or so, hence differences by 10⁻¹¹; where the nearest features change, differences of two steps
    // disagree, and decide nothing.
    const STEP: f64 = 1e-4;
    const AGREEMENT: f64 = 1e-6;
    const TOLERANCE: f64 = 1e-5;
    // Every third pair in the long form, every twelfth otherwise.
    let every = if std::env::var_os("CRANNY_LONG").is_some() { 3 } else { 12 };
    let (mut compared, mut undecided) = (0, 0);
    for entry in catalogue() {
        let scenario = Scenario::open(entry.id, &OpenOptions::default()).unwrap();
        let problem = scenario.problem(Margins::default()).unwrap();
        let cell = problem.cell().unwrap();
        let (robot, mut scratch, mut pairs) = (cell.robot().clone(), cell.scratch(), Vec::new());
        let mut random = Stream::new(1, 0);
        let configurations = (0..5).map(|index| match index {
            0 => problem.start().to_vec(),
            _ => robot.random_configuration(&mut random),
        });
        for q in configurations.collect::<Vec<_>>() {
            cell.pair_distances(&q, WITHIN_M, &mut scratch, &mut pairs);
            let frames = scratch.frames().clone();
            for pair in pairs.iter().filter(|pair| pair.distance_m > 1e-3).step_by(every) {
                let mut gradient = vec![0.0; q.len()];
                pair.add_gradient(&robot, &frames, 1.0, &mut gradient);
                let norm = gradient.iter().map(|x| x * x).sum::<f64>().sqrt().max(1e-2);
                for (joint, exact) in gradient.iter().enumerate() {
                    let slopes =
                        [STEP, 0.5 * STEP].map(|step| slope(cell, &q, joint, pair, step, &mut scratch));
                    let [Some(slope), Some(finer)] = slopes else { continue };
                    if (slope - finer).abs() > AGREEMENT * norm {
                        undecided += 1;
                        continue;
                    }
                    compared += 1;
                    assert!(
                        (exact - slope).abs() <= TOLERANCE * norm,
                        "{}: {pair:?}, joint {joint}: {exact} instead of {slope}",
                        entry.id
                    );
                }
            }
        }
    }
    assert!(
        compared * every > 30_000 && undecided * 20 < compared,
        "{compared} compared, {undecided} undecided"
    );
}

// Where a face is parallel to another, a turn lifts one end of it and lowers the other: there a step can lead deeper.
#[test]
fn a_step_along_the_gradient_leads_out_of_an_overlap() {
    let (mut deeper, mut compared) = (0, 0);
    for entry in catalogue() {
        let scenario = Scenario::open(entry.id, &OpenOptions::default()).unwrap();
        let problem = scenario.problem(Margins::default()).unwrap();
        let cell = problem.cell().unwrap();
        let (robot, mut scratch, mut pairs) = (cell.robot().clone(), cell.scratch(), Vec::new());
        let mut random = Stream::new(2, 0);
        for _ in 0..30 {
            let q = robot.random_configuration(&mut random);
            cell.pair_distances(&q, 0.0, &mut scratch, &mut pairs);
            let frames = scratch.frames().clone();
            for pair in pairs.clone().iter().filter(|pair| pair.distance_m < -1e-3) {
                let mut gradient = vec![0.0; q.len()];
                pair.add_gradient(&robot, &frames, 1.0, &mut gradient);
                let square: f64 = gradient.iter().map(|x| x * x).sum();
                // A tenth of a millimetre.
                let scale = 1e-4 / square.max(1e-4);
                let moved: Vec<f64> = q.iter().zip(&gradient).map(|(q, slope)| q + scale * slope).collect();
                if let Some(distance_m) = distance_m(cell, &moved, pair, &mut scratch) {
                    compared += 1;
                    deeper += usize::from(distance_m < pair.distance_m);
                }
            }
        }
    }
    assert!(compared > 1000 && deeper * 20 < compared, "{deeper} of {compared} are deeper");
}
