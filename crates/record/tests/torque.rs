//! Trajectories within the efforts of the drives, and within speed limits of the hand.

use cranny_collision::Margins;
use cranny_path::TimingMethod;
use cranny_plan::Unobserved;
use cranny_record::{CarryGoal, PlanFile, PlanOptions, PlanSource, SpeedOption, SpeedOptions};
use cranny_robot::{Dynamics, Robot};
use cranny_scenario::{OpenOptions, Scenario};
use cranny_solve::{Answer, solve};
use cranny_spatial::{Pose, Vector};
use cranny_task::{Payload, Problem, Weight, legs};

const RATE_HZ: f64 = 1000.0;

/// Opens a scenario whose target has the mass `mass_kg`.
fn open(id: &str, robot: Option<&str>, mass_kg: f64) -> Problem {
    let options = OpenOptions { robot: robot.map(Into::into), ..OpenOptions::default() };
    let scenario = Scenario::open(id, &options).unwrap();
    let problem = scenario.problem(Margins::default()).unwrap();
    let bodies = problem.cell().unwrap().world().bodies().len();
    let weights: Vec<Weight> = (0..bodies)
        .map(|body| Weight {
            mass_kg: (problem.target() == Some(body)).then_some(mass_kg),
            ..Weight::default()
        })
        .collect();
    problem.with_weights(&weights)
}

fn carried(problem: &Problem, torque: bool, timing: TimingMethod) -> Answer {
    let ask = PlanOptions {
        carry: Some(CarryGoal::Home),
        hold: 0.0,
        torque,
        timing: Some(timing),
        ..PlanOptions::default()
    };
    let (request, _) = ask.request(problem, None).unwrap();
    let answer = solve(problem, &request, &mut Unobserved).unwrap();
    assert!(answer.is_solved(), "{:?}", answer.outcome);
    answer
}

/// Returns the greatest sampled force of each joint along an answer with this payload, as a share of its effort.
fn greatest_shares(robot: &Robot, answer: &Answer, payload: Option<&Payload>) -> Vec<f64> {
    let trajectory = &answer.timed.as_ref().unwrap().trajectory;
    let mut shares = vec![0.0_f64; robot.dof()];
    let mut frames = robot.frames();
    for (leg, segments) in trajectory.legs().iter().zip(legs(&answer.segments)) {
        let held = payload.filter(|_| segments[0].mode.holds).map(Payload::inertial);
        let dynamics = Dynamics::new(robot, &Vector::z(), held).unwrap();
        for sample in leg.samples(RATE_HZ).unwrap() {
            let motion = [&sample.position[..], &sample.velocity, &sample.acceleration];
            let forces = robot.path_forces(&dynamics, motion, &mut frames);
            for (joint, share) in shares.iter_mut().enumerate() {
                let effort = robot.joints()[joint].effort.unwrap();
                *share = share.max((forces.bend[joint] + forces.weight[joint]).abs() / effort);
            }
        }
    }
    shares
}

#[test]
fn a_heavy_load_is_moved_within_the_efforts() {
    for (id, robot, mass_kg, is_slower) in
        [("012", None, 0.1, false), ("012", None, 4.3, true), ("031", Some("fr3"), 3.5, true)]
    {
        for timing in [TimingMethod::TimeOptimal, TimingMethod::JerkLimited] {
            let problem = open(id, robot, mass_kg);
            let (free, kept) = (carried(&problem, false, timing), carried(&problem, true, timing));
            let payload = kept.segments.iter().find_map(|segment| segment.payload).unwrap();
            assert!((payload.mass_kg - mass_kg).abs() < 1e-12 && !payload.mass_assumed);
            let [before, after] =
                [&free, &kept].map(|answer| greatest_shares(problem.robot(), answer, Some(&payload)));
            let most = |shares: &[f64]| shares.iter().copied().fold(0.0, f64::max);
            assert!(most(&after) <= 1.0, "{id} {timing:?}: {after:?}");
            assert_eq!(most(&before) > 1.0, is_slower, "{id} {timing:?}: {before:?}");
            let duration_s = |answer: &Answer| answer.timed.as_ref().unwrap().trajectory.duration_s();
            let slower = duration_s(&kept) / duration_s(&free);
            assert!(slower < 3.0, "{id} {timing:?}: {slower}");
        }
    }
}

#[test]
fn what_a_plan_states_of_its_load_is_measured() {
    let problem = open("012", None, 1.0);
    let plan = PlanFile::of(&carried(&problem, true, TimingMethod::TimeOptimal), &PlanSource::default());
    assert!(plan.timing.as_ref().unwrap().torque_up.is_some());
    let source = PlanSource { margins: problem.cell().unwrap().margins(), ..PlanSource::default() };
    let faults = |plan: &PlanFile| {
        let judgement =
            plan.judge(&source, &problem, cranny_path::AuditSettings::default()).unwrap().unwrap();
        judgement.audit.violations.iter().map(ToString::to_string).collect::<Vec<_>>()
    };
    let known = faults(&plan);
    let mut lighter = plan.clone();
    for payload in lighter.segments.iter_mut().filter_map(|segment| segment.payload.as_mut()) {
        payload.mass_kg = 0.2;
    }
    let new: Vec<String> = faults(&lighter).into_iter().filter(|fault| !known.contains(fault)).collect();
    assert!(new.iter().any(|fault| fault.contains("payload")), "{new:?}");
    for of in 0..plan.segments.len() {
        let mut without = plan.clone();
        if without.segments[of].payload.take().is_some() {
            let new: Vec<String> =
                faults(&without).into_iter().filter(|fault| !known.contains(fault)).collect();
            assert!(new.iter().any(|fault| fault.contains("payload")), "{of}: {new:?}");
        }
    }
    let mut tilted = plan;
    tilted.timing.as_mut().unwrap().torque_up = Some([0.0, 1.0, 0.0]);
    let new: Vec<String> = faults(&tilted).into_iter().filter(|fault| !known.contains(fault)).collect();
    assert!(new.iter().any(|fault| fault.contains("torque_up")), "{new:?}");
}

#[test]
fn a_load_that_the_arm_may_not_hold_is_an_error_with_its_joint() {
    let problem = open("012", None, 40.0);
    let ask = PlanOptions { carry: Some(CarryGoal::Home), hold: 0.0, torque: true, ..PlanOptions::default() };
    let (request, _) = ask.request(&problem, None).unwrap();
    let fault = solve(&problem, &request, &mut Unobserved).unwrap_err().to_string();
    assert!(fault.contains("may be too weak to hold the arm on edge"), "{fault}");
}

#[test]
fn the_hand_neither_goes_nor_turns_faster_than_is_asked() {
    let problem =
        Scenario::open("043", &OpenOptions::default()).unwrap().problem(Margins::default()).unwrap();
    let robot = problem.robot();
    for method in [TimingMethod::TimeOptimal, TimingMethod::JerkLimited] {
        let words = |value| vec![SpeedOption { mode: None, value }];
        let paces =
            SpeedOptions { tool_speed: words(0.3), turn_speed: words(40.0), ..SpeedOptions::default() };
        let ask = PlanOptions { paces, timing: Some(method), ..PlanOptions::default() };
        let (request, _) = ask.request(&problem, None).unwrap();
        let answer = solve(&problem, &request, &mut Unobserved).unwrap();
        let timed = answer.timed.unwrap();
        let poses: Vec<Pose> = timed
            .trajectory
            .samples(RATE_HZ)
            .unwrap()
            .map(|sample| *robot.frames_at(&sample.position).link(robot.tip()))
            .collect();
        let (mut fastest, mut turned) = (0.0_f64, 0.0_f64);
        for pair in poses[..poses.len() - 1].windows(2) {
            let between = pair[0].inverse() * pair[1];
            fastest = fastest.max(between.translation.vector.norm() * RATE_HZ);
            turned = turned.max(between.rotation.angle().to_degrees() * RATE_HZ);
        }
        assert!(fastest <= 0.3 && turned <= 40.0, "{method:?}: {fastest} m/s, {turned} °/s");
        assert!(fastest > 0.29 || turned > 39.0, "{method:?}: {fastest} m/s, {turned} °/s");
    }
}
