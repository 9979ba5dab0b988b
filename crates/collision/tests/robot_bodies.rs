//! Tests that cached data of a robot do not change the verdicts of its cells.

use std::sync::Arc;

use crate::fixture::{arm, random_blocks};
use cranny_collision::{Body, Cell, Margins, World};
use cranny_robot::Robot;
use cranny_spatial::Stream;

fn cell(robot: &Arc<Robot>, bodies: &[Body], margin_m: f64) -> Cell {
    let world = World::new(bodies.to_vec()).expect("finite poses");
    Cell::new(robot.clone(), world, Margins { margin_m, ..Margins::default() }).expect("a good margin")
}

#[test]
fn cells_of_one_robot_answer_as_cells_of_their_own_do() {
    let shared = arm();
    let mut random = Stream::new(4, 0);
    let mut free = 0;
    // More margins than cached tables, and some of them again.
    for margin_m in [0.0, 0.01, 0.02, 0.0, 0.03, 0.04, 0.05, 0.01] {
        let bodies = random_blocks(6, &mut random);
        let cells =
            [cell(&shared, &bodies, margin_m), cell(&Arc::new(shared.as_ref().clone()), &bodies, margin_m)];
        assert_eq!(cells[0].self_pairs(), cells[1].self_pairs());
        let mut scratches = [cells[0].scratch(), cells[1].scratch()];
        let configurations: Vec<Vec<f64>> =
            (0..400).map(|_| shared.random_configuration(&mut random)).collect();
        let verdicts = [0, 1].map(|which| {
            let (cell, scratch) = (&cells[which], &mut scratches[which]);
            let mut in_lanes = Vec::new();
            cell.are_free(&configurations.concat(), scratch, &mut in_lanes);
            let alone: Vec<bool> = configurations.iter().map(|q| cell.is_free(q, scratch)).collect();
            assert_eq!(in_lanes, alone);
            let pairs = configurations.windows(2);
            let motions: Vec<_> = pairs.map(|two| cell.motion_is_free(&two[0], &two[1], scratch)).collect();
            (alone, motions)
        });
        assert_eq!(verdicts[0], verdicts[1], "margin {margin_m}");
        free += verdicts[0].0.iter().filter(|is_free| **is_free).count();
    }
    assert!(free > 200, "{free}");
}
