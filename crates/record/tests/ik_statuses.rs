//! Quick IK status of each grasp: from attempts, and from known configurations.

use std::sync::atomic::AtomicBool;

use cranny_collision::Margins;
use cranny_scenario::{OpenOptions, Scenario};
use cranny_solve::ik_statuses;
use cranny_task::{IkAnnotationSettings, IkStatus, annotate_ik};

#[test]
fn a_known_configuration_solves_the_grasps_that_it_holds() {
    let scenario = Scenario::open("015", &OpenOptions::default()).unwrap();
    let problem = scenario.problem(Margins::default()).unwrap();
    let few = ik_statuses(&problem, &[]).unwrap();
    let many =
        annotate_ik(&problem, &IkAnnotationSettings::default(), &|| (), &AtomicBool::new(false)).unwrap();
    let hard = many.iter().find(|grasp| !grasp.solutions.is_empty() && few[grasp.grasp] != IkStatus::Solved);
    let hard = hard.expect("a grasp that few attempts do not solve");
    // Configurations of another robot are skipped.
    let known = [vec![0.0], hard.solutions[0].q.clone()];
    let told = ik_statuses(&problem, &known).unwrap();
    assert_eq!(told[hard.grasp], IkStatus::Solved);
    let others = told.iter().zip(&few).filter(|(told, few)| told != few);
    assert!(others.clone().all(|(told, _)| *told == IkStatus::Solved) && others.count() > 0);
}
