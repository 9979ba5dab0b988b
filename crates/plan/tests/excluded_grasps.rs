//! Grasps that are excluded without a search, and the reported reasons.

use cranny_collision::{Margins, World};
use cranny_grasp::Grasp;
use cranny_plan::{Budget, NoGrasp, Outcome, PlanReport, Registry, Unobserved, search};
use cranny_spatial::Pose;
use cranny_task::{FailureReason, Goal, GraspFailure, Problem};

use crate::fixture::{
    GANTRY_START, OBJECT, START, arm, block, easy_grasps, exact, gantry, grasp_at, grasps, still_life,
    without_set,
};

/// Width slightly above the opening of the gantry hand, in metres.
const WIDE_M: f64 = 0.080_000_4;

fn searched(planner: &str, problem: &Problem, budget: Budget) -> PlanReport {
    let planner = Registry::default().planner(planner).expect("a planner of the registry");
    search(planner.as_ref(), problem, &budget, 0, &mut Unobserved).expect("a good problem")
}

/// Returns the failures of a report without a search.
fn excluded(planner: &str, problem: &Problem) -> Vec<GraspFailure> {
    let report = searched(planner, problem, Budget::default());
    assert_eq!((report.outcome, report.statistics.iterations), (Outcome::NoReachableGrasp, 0), "{planner}");
    report.failures
}

#[test]
fn grasps_of_what_is_too_wide_are_excluded_before_the_search() {
    let wide = |grasp: Grasp| Grasp { width_m: Some(WIDE_M), ..grasp };
    let problem = |set: Vec<Grasp>| exact(&gantry(), still_life(), &GANTRY_START, grasps(set));
    let all_wide = problem(easy_grasps().into_iter().map(wide).collect());
    for planner in ["reach", "ik-rrt", "rrt"] {
        let failures = excluded(planner, &all_wide);
        assert_eq!(failures.len(), 3, "{planner}");
        let reason = failures[0].reason.sentence();
        assert_eq!(reason, "the object is 80.0004 mm wide there, and the hand opens 80.0000 mm", "{planner}");
    }
    // The hand of the gantry is free at all of them.
    let one_fits: Vec<Grasp> = easy_grasps()
        .into_iter()
        .enumerate()
        .map(|(index, grasp)| if index == 1 { grasp } else { wide(grasp) })
        .collect();
    for planner in ["reach", "ik-rrt"] {
        let report = searched(planner, &problem(one_fits.clone()), Budget::default());
        let end = report.path.last().expect("a path");
        let frames = gantry().frames_at(end);
        let off = one_fits[1].difference(frames.link(gantry().tip()));
        assert!(off.is_exact(), "{planner}: {off:?}");
    }
    let nearly = [one_fits[0], grasp_at([0.0, 5.0, 0.3], 0.0)];
    let budget = Budget { iterations: 30, ..Budget::default() };
    let report = searched("reach", &problem(nearly.to_vec()), budget);
    assert!(matches!(report.failures[0].reason, FailureReason::TooWide { .. }), "{:?}", report.failures);
}

#[test]
fn a_target_that_is_too_wide_everywhere_ends_a_search_for_own_grasps_at_once() {
    let target = |half_m: f64| vec![block("object", OBJECT, [half_m; 3])];
    for planner in ["grasp-reach", "grasp-rrt"] {
        let problem = without_set(target(0.5 * WIDE_M), &GANTRY_START);
        assert_eq!(excluded(planner, &problem), []);
        let reason = NoGrasp::of(&problem, &[]).expect("a reason");
        assert!(matches!(reason, NoGrasp::TooWide(too_wide) if too_wide.to_string().contains("opens 80.00")));
    }
    let fits = without_set(target(0.03), &GANTRY_START);
    assert_eq!(NoGrasp::of(&fits, &[]), None);
}

#[test]
fn what_is_beyond_reach_is_told_by_how_much_and_by_which_shift_of_the_base_it_is_not() {
    let far = |[x, y, z]: [f64; 3]| {
        vec![
            block("object", [x, y, z], [0.015; 3]),
            block("pedestal", [x, y, z - 0.2], [0.015, 0.015, 0.185]),
        ]
    };
    let at = [3.5, 0.45, 0.3];
    let problem = exact(&arm(), far(at), &START, grasps(vec![grasp_at(at, 0.0)]));
    let failures = excluded("reach", &problem);
    let Some(NoGrasp::OutOfReach(miss)) = NoGrasp::of(&problem, &failures) else { panic!("{failures:?}") };
    assert_eq!(miss.grasp, Some(0));
    assert!(0.5 < miss.beyond_m && miss.beyond_m <= miss.missed_by_m && miss.missed_by_m < 3.5, "{miss:?}");
    assert_eq!(miss.joints_at_limits.first().map(String::as_str), Some("slide"), "{miss:?}");

    // From the proposed position of the base, the search finds a path.
    let [x, y] = miss.base_shift_m.expect("a rail that ends before it");
    let new_from_old = Pose::translation(-x, -y, 0.0);
    let world = World::new(far([at[0] - x, at[1] - y, at[2]])).expect("good poses");
    let Goal::Grasps(set) = problem.goal() else { panic!("grasps") };
    let goal = Goal::Grasps(set.moved(&new_from_old));
    let shifted = Problem::exact(arm(), world, Some(0), START.to_vec(), goal, Margins::default());
    let report = searched("reach", &shifted.expect("a good problem"), Budget::default());
    assert_eq!(report.outcome, Outcome::Solved);

    // The grasp is too high for any position of the base.
    let above = [0.5, 0.45, 9.0];
    let problem = exact(&arm(), far(above), &START, grasps(vec![grasp_at(above, 0.0)]));
    let reason = NoGrasp::of(&problem, &excluded("reach", &problem));
    assert!(matches!(&reason, Some(NoGrasp::OutOfReach(miss)) if miss.base_shift_m.is_none()), "{reason:?}");
}
