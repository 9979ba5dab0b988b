//! Choice of grasps by score in J⁺-RRT.

use cranny_path::audit;
use cranny_plan::{Budget, GraspChoice, JPlusRrt, Outcome, Planner, Unobserved};

use crate::fixture::{START, arm, easy_grasps, exact, grasp_out_of_reach, grasps, still_life};

fn assert_solves(scores: [Option<f64>; 3]) {
    let scored =
        easy_grasps().into_iter().zip(scores).map(|(grasp, score)| cranny_grasp::Grasp { score, ..grasp });
    let problem = exact(&arm(), still_life(), &START, grasps(scored.collect()));
    let planner = JPlusRrt { choice: GraspChoice::ByScore, ..JPlusRrt::default() };
    let budget = Budget { iterations: 1_000_000, ..Budget::default() };
    let report = planner.plan(&problem, &budget, 5, &mut Unobserved).expect("a good problem");
    assert_eq!(report.outcome, Outcome::Solved, "{scores:?}");
    assert!(audit(&problem, &report.path).is_ok_and(|verification| verification.valid), "{scores:?}");
}

#[test]
fn choice_by_score_works_without_scores_and_with_scores_of_zero() {
    assert_solves([None; 3]);
    assert_solves([Some(0.0); 3]);
    assert_solves([Some(0.0), None, Some(0.0)]);
    assert_solves([Some(0.2), Some(0.9), None]);
}

#[test]
fn a_grasp_of_score_zero_is_not_gone_for_beside_one_with_a_score() {
    let scored = |grasp, score| cranny_grasp::Grasp { score: Some(score), ..grasp };
    let far = scored(grasp_out_of_reach(), 0.0);
    let near = scored(easy_grasps()[0], 1.0);
    let problem = exact(&arm(), still_life(), &START, grasps(vec![far, near]));
    let with = |grasps_of: &cranny_task::Problem| {
        // The planner only extends towards grasps.
        let planner = JPlusRrt { choice: GraspChoice::ByScore, p_goal: 1.0, ..JPlusRrt::default() };
        let budget = Budget { iterations: 200, ..Budget::default() };
        planner.plan(grasps_of, &budget, 5, &mut Unobserved).expect("a good problem")
    };
    let alone = exact(&arm(), still_life(), &START, grasps(vec![near]));
    assert_eq!(with(&problem).path, with(&alone).path);
    assert_eq!(with(&problem).outcome, with(&alone).outcome);
}
