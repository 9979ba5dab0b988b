//! Tests of scenes and clearances of plans that set their object down.

use cranny_collision::Margins;
use cranny_plan::Unobserved;
use cranny_record::{PlanFile, PlanSource};
use cranny_scenario::{OpenOptions, STEPS, Scenario};
use cranny_solve::{CLOSING_S, Request, Timing, solve};
use cranny_spatial::Pose;
use cranny_task::{Mode, Pick, Stage};
use cranny_view::{ClearanceProfile, Role, SampledPath, Scene, SceneSettings};

fn source(id: &str) -> PlanSource {
    PlanSource { scenario: id.to_owned(), ..PlanSource::default() }
}

#[test]
fn the_object_stays_where_the_hand_let_it_go() {
    let scenario = Scenario::open("031", &OpenOptions::default()).unwrap();
    let problem = scenario.problem(Margins::default()).unwrap();
    let pick = Stage::Pick(Pick { approach_m: 0.05, ..Pick::default() });
    let stages = vec![pick, Stage::place("outside"), Stage::home()];
    let request = Request { stages, timing: Some(Timing::default()), ..Request::default() };
    let answer = solve(&problem, &request, &mut Unobserved).unwrap();
    let plan = PlanFile::of(&answer, &source("031"));
    let timed = plan.trajectory(&scenario.robot).unwrap();
    for timed in [timed.as_ref(), None] {
        let path = SampledPath::of_plan(&scenario.robot, &plan, timed, 20.0).unwrap().unwrap();
        let [carry] = &path.carries[..] else { panic!("one thing is carried") };
        let modes: Vec<Mode> = carry.modes.iter().map(|mode| mode.mode).collect();
        assert_eq!(modes, Mode::ALL);
        let [opens_s, has_opened_s] = carry.opens_s().unwrap();
        assert!((has_opened_s - opens_s - CLOSING_S).abs() < 1e-9);
        assert_eq!(carry.modes.last().unwrap().until_s.to_bits(), path.ends_s().to_bits());
        assert!(path.times_s.windows(2).all(|pair| pair[0] < pair[1]));
        // The hand is open at both ends and closed between them.
        let middle_s = 0.5 * (carry.closes_s()[1] + opens_s);
        let closing = [0.0, middle_s, path.ends_s()].map(|time_s| carry.closing_at(time_s));
        assert!(closing[1] > 0.1 && closing[0].abs() < 1e-12 && closing[2].abs() < 1e-12, "{closing:?}");

        let scene = Scene::of_task(&scenario, Some(&path), &SceneSettings { grasps: 0 }).unwrap();
        let target = scene.nodes.iter().position(|node| node.role == Role::Target).unwrap();
        let along = plan.states(&problem).unwrap().unwrap();
        let there = *along.end.let_go().unwrap().1;
        for (frame, time_s) in path.times_s.iter().enumerate().filter(|(_, time_s)| **time_s >= opens_s) {
            let off: Pose = scene.world_from_nodes(Some(frame))[target].inv_mul(&there);
            assert!(off.translation.vector.norm() < 1e-9 && off.rotation.angle() < 1e-6, "at {time_s} s");
        }
        // The whole path has a clearance; the object is an obstacle after the set-down.
        let cell = problem.cell().unwrap();
        let profile = ClearanceProfile::along(&path, cell, &along.states, 200).unwrap();
        let last_s = profile.times_s.last().unwrap();
        assert_eq!(last_s.to_bits(), path.ends_s().to_bits());
        let free = profile.times_s.iter().zip(&profile.closest);
        let mut retreats = free.filter(|(time_s, _)| **time_s > has_opened_s);
        assert!(retreats.all(|(_, closest)| closest.distance_m > 0.0));
    }
}

#[test]
fn several_steps_are_one_motion() {
    let scenario = Scenario::open("213", &OpenOptions::default()).unwrap();
    let problem = scenario.problem(Margins::default()).unwrap();
    let stages = scenario.task(STEPS).unwrap().stages.clone();
    let request = Request { stages, timing: Some(Timing::default()), ..Request::default() };
    let answer = solve(&problem, &request, &mut Unobserved).unwrap();
    let plan = PlanFile::of(&answer, &source("213"));
    let timed = plan.trajectory(&scenario.robot).unwrap();
    let path = SampledPath::of_plan(&scenario.robot, &plan, timed.as_ref(), 5.0).unwrap().unwrap();
    assert_eq!(path.carries.len(), 3);
    assert!((path.ends_s() - plan.timing.unwrap().duration_s).abs() < 1e-9);
    assert!(path.times_s.windows(2).all(|pair| pair[0] < pair[1]));
    let scene = Scene::of_task(&scenario, Some(&path), &SceneSettings { grasps: 0 }).unwrap();
    let [before, after] = [Some(0), scene.last_frame()].map(|frame| scene.world_from_nodes(frame));
    for name in ["column 1", "column 2", "screwdriver"] {
        let node = scene.nodes.iter().position(|node| node.name == name).unwrap();
        let moved_m = (after[node].translation.vector - before[node].translation.vector).norm();
        assert!(moved_m > 0.5, "{name}: {moved_m} m");
    }
}
