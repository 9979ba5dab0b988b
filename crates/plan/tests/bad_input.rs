//! Checks that malformed input is an error that names the fault, not an outcome.

use cranny_collision::{CollisionError, Margins, World};
use cranny_path::{PathError, audit};
use cranny_plan::{Budget, JPlusRrt, PlanError, Planner, Reach, Registry, Unobserved};
use cranny_task::{Goal, Problem, TaskError};

use crate::fixture::{START, arm, ball, easy, easy_grasps, exact, grasps, makes_grasps, paper};

fn built(start: Vec<f64>, goal: Goal) -> Result<Problem, TaskError> {
    Problem::exact(ball(), World::default(), None, start, goal, Margins::default())
}

fn to(q: Vec<f64>) -> Goal {
    Goal::Configurations(vec![vec![0.0; 3], q])
}

#[test]
fn a_configuration_of_the_wrong_length_is_refused() {
    for length in [0, 2, 4] {
        let bad = vec![0.0; length];
        let starts = built(bad.clone(), to(vec![0.0; 3])).map(|_| ());
        let goals = built(vec![0.0; 3], to(bad.clone())).map(|_| ());
        let other_goal =
            exact(&ball(), Vec::new(), &[0.0; 3], to(vec![0.0; 3])).with_goal(to(bad)).map(|_| ());
        for (refused, whose) in [(starts, "start"), (goals, "goal"), (other_goal, "goal")] {
            assert!(matches!(
                refused,
                Err(TaskError::JointCount { what, expected: 3, actual }) if what == whose && actual == length
            ));
        }
    }
}

#[test]
fn a_value_that_is_not_finite_is_refused_by_the_name_of_its_joint() {
    for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let bad = vec![0.0, value, 0.0];
        let starts = built(bad.clone(), to(vec![0.0; 3])).map(|_| ());
        let goals = built(vec![0.0; 3], to(bad)).map(|_| ());
        for (refused, whose) in [(starts, "start"), (goals, "goal")] {
            assert!(
                matches!(refused, Err(TaskError::NotFinite { what, joint }) if what == whose && joint == "y")
            );
        }
    }
}

#[test]
fn a_problem_under_the_papers_criterion_is_held_to_the_same() {
    let check = |start: Vec<f64>| {
        let check = cranny_collision::ReleasedCheck::new(ball(), Vec::new(), Vec::new(), 0.0);
        Problem::paper(check.expect("good triangles"), World::default(), start, to(vec![0.0; 3])).map(|_| ())
    };
    assert!(matches!(check(vec![0.0; 2]), Err(TaskError::JointCount { what: "start", .. })));
    assert!(matches!(check(vec![0.0, f64::NAN, 0.0]), Err(TaskError::NotFinite { what: "start", .. })));
}

#[test]
fn a_margin_that_is_no_distance_is_refused() {
    for value in [-0.01, f64::NAN] {
        let margins = Margins { margin_m: value, ..Margins::default() };
        let refused = Problem::exact(ball(), World::default(), None, vec![0.0; 3], to(vec![0.0; 3]), margins);
        assert!(matches!(refused, Err(TaskError::Collision(CollisionError::Margin { .. }))));
    }
}

#[test]
fn a_problem_without_goals_is_refused_by_every_planner() {
    let no_grasps = exact(&arm(), Vec::new(), &START, grasps(Vec::new()));
    let no_configurations = exact(&arm(), Vec::new(), &START, Goal::Configurations(Vec::new()));
    for name in Registry::default().names() {
        let run = |problem| {
            Registry::default()
                .planner(name)
                .and_then(|p| p.plan(problem, &Budget::default(), 0, &mut Unobserved))
        };
        if makes_grasps(name) {
            // An empty set is a set of grasps, too.
            assert!(matches!(run(&no_grasps), Err(PlanError::Task(TaskError::GraspSet { .. }))), "{name}");
            assert!(
                matches!(run(&no_configurations), Err(PlanError::Task(TaskError::GraspSet { .. }))),
                "{name}"
            );
            continue;
        }
        assert!(matches!(run(&no_grasps), Err(PlanError::Task(TaskError::NoGoal))), "{name}");
        assert!(
            matches!(
                run(&no_configurations),
                Err(PlanError::Task(TaskError::NoGoal | TaskError::Goal { .. }))
            ),
            "{name}"
        );
    }
}

#[test]
fn a_planner_refuses_a_kind_of_problem_that_it_cannot_take() {
    let budget = Budget::default();
    let configurations = exact(&arm(), Vec::new(), &START, Goal::Configurations(vec![START.to_vec()]));
    let refused = JPlusRrt::default().plan(&configurations, &budget, 0, &mut Unobserved);
    assert!(matches!(refused, Err(PlanError::Task(TaskError::Goal { planner: "j-plus-rrt", .. }))));
    let released = paper(&arm(), Vec::new(), &START, grasps(easy_grasps()));
    let refused = Reach::default().plan(&released, &budget, 0, &mut Unobserved);
    assert!(matches!(refused, Err(PlanError::Task(TaskError::Goal { planner: "reach", .. }))));
}

#[test]
fn an_unknown_planner_is_refused_with_the_names_that_there_are() {
    let message = Registry::default().planner("rech").map(|_| ()).expect_err("there is none").to_string();
    assert!(message.contains("'rech'"), "{message}");
    for name in Registry::default().names() {
        assert!(message.contains(name), "{message}");
    }
}

#[test]
fn a_path_that_is_none_of_the_robot_is_not_judged() {
    let problem = easy();
    let start = START.to_vec();
    assert!(matches!(audit(&problem, &[]), Err(PathError::EmptyPath)));
    let short = audit(&problem, &[start.clone(), vec![0.0; 4]]);
    assert!(matches!(
        short,
        Err(PathError::Task(TaskError::JointCount { what: "way point", expected: 5, actual: 4 }))
    ));
    let mut bad = start.clone();
    bad[2] = f64::NAN;
    let not_finite = audit(&problem, &[start.clone(), bad, start]);
    assert!(
        matches!(not_finite, Err(PathError::Task(TaskError::NotFinite { what: "way point", joint })) if joint == "elbow")
    );
}
