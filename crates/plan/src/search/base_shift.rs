use std::sync::atomic::AtomicBool;

use cranny_collision::{Body, Part};
use cranny_grasp::GraspSet;
use cranny_spatial::{Pose, Vector};
use cranny_task::{Goal, IkAnnotationSettings, IkStatus, Problem, annotate_ik};

/// Maximum number of parts of a world that is rebuilt for a hint.
const MOST_PARTS: usize = 5000;

/// Searches for a displacement of the base with which one of `goals` has a free configuration and the start stays free: along x
/// and y of the planning frame, in metres, in the direction of `way`, which leads from the reached position to a grasp.
pub(crate) fn base_shift_m(problem: &Problem, goals: &GraspSet, way: &Vector) -> Option<[f64; 2]> {
    /// Number of lengths to try, and their spacing, in metres.
    const LENGTHS: u32 = 6;
    const STEP_M: f64 = 0.15;
    /// Multiples of the resolution per metre: shifts are rounded to the centimetre.
    const PER_METRE: f64 = 100.0;
    let parts: usize = problem.cell()?.world().bodies().iter().map(|body| body.parts.len()).sum();
    let across = Vector::new(way.x, way.y, 0.0);
    let length_m = across.norm();
    if parts > MOST_PARTS || length_m * PER_METRE < 1.0 {
        return None;
    }
    (0..LENGTHS).find_map(|step| {
        let shift = across * ((length_m + f64::from(step) * STEP_M) / length_m);
        let [x, y] = [shift.x, shift.y].map(|shift_m| (shift_m * PER_METRE).round() / PER_METRE);
        is_within_reach(problem, goals, [x, y]).then_some([x, y])
    })
}

/// Returns true if a grasp has a free configuration with the base shifted: the world is shifted in the opposite direction.
fn is_within_reach(problem: &Problem, goals: &GraspSet, [x, y]: [f64; 2]) -> bool {
    const SETTINGS: IkAnnotationSettings =
        IkAnnotationSettings { attempts: 192, ..IkAnnotationSettings::DEFAULT };
    let Some(cell) = problem.cell() else { return false };
    let new_from_old = Pose::translation(-x, -y, 0.0);
    let shifted = |body: &Body| {
        let part =
            |part: &Part| Part { world_from_solid: new_from_old * part.world_from_solid, ..part.clone() };
        Body { parts: body.parts.iter().map(part).collect(), ..body.clone() }
    };
    let bodies = cell.world().bodies().iter().map(shifted).collect();
    let bounds = cell.world().tool_bounds().iter().map(|bound| bound.in_frame(&new_from_old)).collect();
    let shifted = cell.world().with_bodies(bodies).and_then(|world| world.with_tool_bounds(bounds));
    let shifted = shifted.map_err(Into::into).and_then(|world| {
        let goal = Goal::Grasps(goals.moved(&new_from_old));
        let (robot, start) = (problem.robot().clone(), problem.start().to_vec());
        Problem::exact(robot, world, problem.target(), start, goal, cell.margins())
    });
    let Ok(shifted) = shifted else { return false };
    let annotated = || annotate_ik(&shifted, &SETTINGS, &|| {}, &AtomicBool::new(false));
    shifted.start_is_free()
        && annotated().is_ok_and(|grasps| grasps.iter().any(|grasp| grasp.status == IkStatus::Solved))
}
