//! Times the placement of a robot in its first world and in another one: of 100 boxes, and of each named scenario. Prints
//! the minimum and the median of 21 times, in milliseconds.
//!
//! `cargo run --release -p cranny-measure --bin second_world -- SCENARIO…`

use std::sync::Arc;
use std::time::Instant;

use cranny_collision::{Body, Cell, Margins, World};
use cranny_robot::Robot;
use cranny_scenario::{OpenOptions, Scenario};
use cranny_shape::Solid;
use cranny_spatial::{Pose, Stream, Vector};

/// Returns the minimum and the median of 21 times, in milliseconds.
fn timed(mut work: impl FnMut()) -> [f64; 2] {
    let mut times_ms: Vec<f64> = (0..21)
        .map(|_| {
            let begin = Instant::now();
            work();
            begin.elapsed().as_secs_f64() * 1e3
        })
        .collect();
    times_ms.sort_by(f64::total_cmp);
    [times_ms[0], times_ms[10]]
}

fn boxes(random: &mut Stream) -> World {
    let mut draw = |low, high| random.uniform_between(low, high);
    let bodies = (0..100).map(|index| {
        let pose = Pose::translation(draw(-2.0, 2.0), draw(-2.0, 2.0), draw(0.0, 2.0));
        let half_extents = Vector::new(draw(0.01, 0.2), draw(0.01, 0.2), draw(0.01, 0.2));
        Body::new(format!("box{index}"), pose, Solid::cuboid(half_extents).expect("positive sizes"))
    });
    World::new(bodies.collect()).expect("finite poses")
}

fn main() {
    let mut random = Stream::new(1, 0);
    for id in std::iter::once("021".to_owned()).chain(std::env::args().skip(1)) {
        let scenario = Scenario::open(&id, &OpenOptions::default()).expect("a scenario");
        let cell = |robot: &Arc<Robot>, world: &World| {
            let cell = Cell::new(robot.clone(), world.clone(), Margins::default()).expect("good margins");
            assert!(!cell.self_pairs().is_empty());
        };
        // A clone has no cached values.
        let first = timed(|| cell(&Arc::new(scenario.robot.as_ref().clone()), &World::default()));
        let again = timed(|| cell(&scenario.robot, &scenario.world));
        let worlds: Vec<World> = (0..21).map(|_| boxes(&mut random)).collect();
        let mut next = worlds.iter();
        let hundred = timed(|| cell(&scenario.robot, next.next().expect("as many as are timed")));
        let show = |[least, median]: [f64; 2]| format!("{least:.2} ({median:.2})");
        println!("{id}: robot {}, this world {}, 100 boxes {}", show(first), show(again), show(hundred));
    }
}
