//! Kinematics of a robot: poses, Jacobians, random configurations, inverse kinematics.

use std::mem::MaybeUninit;

use cranny::collision::Cell;
use cranny::grasp::rows_of_pose;
use cranny::robot::{IkSearchSettings, IkSolution, IkSolver, solve_restarts};
use cranny::spatial::Stream;

use crate::boundary::{NumberBuffer, Numbers, Text, given, guarded};
use crate::cell::CrannyCell;
use crate::error::{CrannyStatus, Fault};
use crate::options::pose_of;
use crate::robot::CrannyRobot;

/// Computes the pose root_from_link of `link` (NULL: the tip) at each of `rows` configurations `q`, `rows` × `dof`. `poses`
/// receives `rows` × 16 values: homogeneous matrices, row by row, in metres. Limits are not checked.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_robot_fk(
    robot: Option<&CrannyRobot>,
    link: Text<'_>,
    q: Numbers<'_>,
    rows: usize,
    dof: usize,
    mut poses: NumberBuffer<'_>,
) -> CrannyStatus {
    guarded(|| {
        let robot = given(robot, "robot")?;
        robot.check_dof(dof)?;
        let (link, model) = (robot.link(link)?, &robot.robot);
        let mut frames = model.frames();
        let mut found = Vec::new();
        for q in q.finite("q", rows, dof)?.chunks_exact(dof.max(1)) {
            model.forward_kinematics(q, &mut frames);
            found.extend(rows_of_pose(frames.link(link)));
        }
        poses.write("poses", &found)
    })
}

/// Computes the geometric Jacobian of `link` (NULL: the tip) at its origin, in the root frame, at each of `rows`
/// configurations `q`, `rows` × `dof`. `jacobians` receives `rows` × 6 × `dof` values: first three rows of metres of the origin,
/// then three rows of radians of its rotation, per metre or radian of each joint.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_robot_jacobian(
    robot: Option<&CrannyRobot>,
    link: Text<'_>,
    q: Numbers<'_>,
    rows: usize,
    dof: usize,
    mut jacobians: NumberBuffer<'_>,
) -> CrannyStatus {
    guarded(|| {
        let robot = given(robot, "robot")?;
        robot.check_dof(dof)?;
        let (link, model) = (robot.link(link)?, &robot.robot);
        let (mut frames, mut jacobian) = (model.frames(), model.empty_jacobian());
        let mut found = Vec::new();
        for q in q.finite("q", rows, dof)?.chunks_exact(dof.max(1)) {
            model.forward_kinematics(q, &mut frames);
            model.jacobian(&frames, link, &mut jacobian);
            // The matrix is stored in column-major order.
            found.extend(jacobian.transpose().iter());
        }
        jacobians.write("jacobians", &found)
    })
}

/// Writes `rows` uniform samples within the joint limits to `q`, `rows` × `dof`. The same `seed` gives the same samples on
/// every machine.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_robot_sample(
    robot: Option<&CrannyRobot>,
    seed: u64,
    mut q: NumberBuffer<'_>,
    rows: usize,
    dof: usize,
) -> CrannyStatus {
    guarded(|| {
        let robot = given(robot, "robot")?;
        robot.check_dof(dof)?;
        let fits = rows.checked_mul(dof).is_some_and(|count| count <= MOST_NUMBERS);
        if !fits {
            return Err(Fault::TooLong { what: "q", rows, columns: dof });
        }
        let mut random = Stream::new(seed, 0);
        let drawn: Vec<f64> = (0..rows).flat_map(|_| robot.robot.random_configuration(&mut random)).collect();
        q.write("q", &drawn)
    })
}

/// Searches configurations that bring the tip to `pose`, root_from_tip, 16 values row by row. `q` receives at most `rows`
/// distinct solutions within the joint limits, `rows` × `dof`, and `found` their number; 0 proves nothing.
///
/// At most `attempts` searches (200 is usual, 100000 the most) start at random configurations drawn from `seed`. `cell`: NULL,
/// or a cell in which the solutions must be free.
#[unsafe(no_mangle)]
#[allow(clippy::too_many_arguments, reason = "arrays of C come with their lengths")]
pub extern "C" fn cranny_robot_ik(
    robot: Option<&CrannyRobot>,
    pose: Numbers<'_>,
    cell: Option<&CrannyCell>,
    attempts: usize,
    seed: u64,
    mut q: NumberBuffer<'_>,
    rows: usize,
    dof: usize,
    found: Option<&mut MaybeUninit<usize>>,
) -> CrannyStatus {
    guarded(|| {
        let robot = given(robot, "robot")?;
        robot.check_dof(dof)?;
        if attempts > MOST_ATTEMPTS {
            let expected = "at most 100000 are made";
            return Err(Fault::Range { what: "attempts", value: attempts as f64, expected });
        }
        let world_from_tip = pose_of(pose, "pose")?;
        let mut random = Stream::new(seed, 0);
        let settings = IkSearchSettings::default();
        let solutions = accepting(robot, cell, |accept| {
            solve_restarts(&robot.robot, &world_from_tip, &mut random, settings, rows, attempts, accept)
        })?;
        write_solutions(&solutions, &mut q, found)
    })
}

/// Searches a configuration that brings the tip to `pose`, root_from_tip, 16 values row by row, from `start`, `dof` values. `q`
/// receives `dof` values if there is one, and `found` 1, else 0. `cell` as in cranny_robot_ik.
#[unsafe(no_mangle)]
pub extern "C" fn cranny_robot_ik_from(
    robot: Option<&CrannyRobot>,
    pose: Numbers<'_>,
    start: Numbers<'_>,
    cell: Option<&CrannyCell>,
    mut q: NumberBuffer<'_>,
    dof: usize,
    found: Option<&mut MaybeUninit<usize>>,
) -> CrannyStatus {
    guarded(|| {
        let robot = given(robot, "robot")?;
        robot.check_dof(dof)?;
        let world_from_tip = pose_of(pose, "pose")?;
        let start = start.finite("start", 1, dof)?;
        let solutions = accepting(robot, cell, |accept| {
            let mut solver = IkSolver::new(&robot.robot, IkSearchSettings::default().ik);
            let solution = solver.solve_from(&world_from_tip, start);
            solution.into_iter().filter(|solution| accept(&solution.q)).collect()
        })?;
        write_solutions(&solutions, &mut q, found)
    })
}

/// Most values of a call that draws random configurations; more would be a mistake.
const MOST_NUMBERS: usize = 100_000_000;

/// Most attempts of a search; more would be a mistake. An attempt takes some ten microseconds.
const MOST_ATTEMPTS: usize = 100_000;

/// Runs a search that accepts configurations that are free in `cell`, or all without one.
fn accepting(
    robot: &CrannyRobot,
    cell: Option<&CrannyCell>,
    search: impl FnOnce(&mut dyn FnMut(&[f64]) -> bool) -> Vec<IkSolution>,
) -> Result<Vec<IkSolution>, Fault> {
    let Some(cell) = cell else { return Ok(search(&mut |_| true)) };
    if cell.cell.robot().joint_names() != robot.robot.joint_names() {
        return Err(Fault::Lacking { what: "cell", problem: "it holds another robot, with other joints" });
    }
    let mut scratch = cell.scratch();
    Ok(search(&mut |q| Cell::is_free(&cell.cell, q, &mut scratch.check)))
}

fn write_solutions(
    solutions: &[IkSolution],
    q: &mut NumberBuffer<'_>,
    found: Option<&mut MaybeUninit<usize>>,
) -> Result<(), Fault> {
    let values: Vec<f64> = solutions.iter().flat_map(|solution| &solution.q).copied().collect();
    let found = given(found, "found")?;
    q.write("q", &values)?;
    found.write(solutions.len());
    Ok(())
}
