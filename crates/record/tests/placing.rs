//! Tasks that put the target down, in the built-in scenarios, and the errors that plans tolerate.

use cranny_collision::{Body, Cell, Collider, Margins, Part, World};
use cranny_path::{Audit, AuditSettings, Clearances, Violation, audit_task};
use cranny_plan::{Outcome, PlanError, Unobserved};
use cranny_record::{PlanFile, PlanSource};
use cranny_robot::{RobotOptions, between};
use cranny_scenario::{BUILTIN_ROBOTS, OpenOptions, Scenario};
use cranny_solve::{Answer, Request, Robustness, SolveError, Timing, solve};
use cranny_spatial::nalgebra::UnitQuaternion;
use cranny_spatial::{Pose, Rotation, Stream, Vector};
use cranny_task::{AfterPlacing, CLEAR_M, Mode, PlaceAt, PlaceGoal, PlaceRegion, Problem, Stage, TaskError};

fn open(id: &str) -> (Scenario, Problem) {
    let scenario = Scenario::open(id, &OpenOptions::default()).unwrap();
    let problem = scenario.problem(Margins::default()).unwrap();
    (scenario, problem)
}

fn then(then: AfterPlacing) -> Vec<Stage> {
    Stage::put_down(PlaceAt::named("outside"), then)
}

fn asked(problem: &Problem, stages: Vec<Stage>, seed: u64) -> Result<Answer, SolveError> {
    let timing = Some(Timing::default());
    let request = Request { stages, timing, seed, robustness: true, ..Request::default() };
    solve(problem, &request, &mut Unobserved)
}

fn placed(problem: &Problem, stages: Vec<Stage>) -> Answer {
    asked(problem, stages, 0).unwrap()
}

/// Returns this problem with a goal at which the target is put down.
fn at(problem: &Problem, goal: PlaceGoal) -> Problem {
    problem.clone().with_places(&[PlaceGoal { name: "outside".to_owned(), ..goal }])
}

fn audit_of(plan: &PlanFile, problem: &Problem) -> Audit {
    let settings = AuditSettings { clearances: Clearances::None, ..AuditSettings::default() };
    plan.audit(problem, settings).unwrap().unwrap()
}

/// Returns the motion of the target from its start pose, once the hand has opened.
fn moved(answer: &Answer, problem: &Problem) -> Pose {
    let tip = |q: &[f64]| *problem.robot().frames_at(q).link(problem.robot().tip());
    let last = |mode: Mode| {
        let segment = answer.segments.iter().find(|segment| segment.mode == mode).unwrap();
        tip(segment.waypoints.last().unwrap())
    };
    last(Mode::SET_DOWN) * last(Mode::REACH).inverse()
}

/// Checks by the corners of its triangles alone that the target lies on the rectangle, and nowhere beyond its edges.
fn lies_on(scenario: &Scenario, moved: &Pose, place: &PlaceGoal) -> bool {
    let PlaceRegion::Surface { pose, size_m, .. } = &place.spot else { return false };
    let mesh = scenario.target_mesh().unwrap().unwrap();
    let on_surface: Vec<_> = mesh.vertices.iter().map(|vertex| pose.inverse() * (moved * vertex)).collect();
    let lowest_m = on_surface.iter().map(|point| point.z).fold(f64::INFINITY, f64::min);
    // The tessellation of a sphere lies within it.
    let within = |value: f64, size_m: f64| value.abs() <= 0.5 * size_m + 1e-6;
    (-1e-4..2e-3).contains(&lowest_m)
        && on_surface.iter().all(|point| within(point.x, size_m[0]) && within(point.y, size_m[1]))
}

#[test]
fn the_target_of_every_scenario_can_be_put_down_outside() {
    for (family, level) in (1..=4).flat_map(|family| (1..=5).map(move |level| (family, level))) {
        let id = format!("0{family}{level}");
        let (scenario, problem) = open(&id);
        let after = if level % 2 == 0 { AfterPlacing::Stay } else { AfterPlacing::Home };
        let answer = placed(&problem, then(after));
        assert!(answer.is_solved(), "{id}: {:?} {:?}", answer.outcome, answer.audit);
        let modes: Vec<Mode> = answer.segments.iter().map(|segment| segment.mode).collect();
        let all = [Mode::REACH, Mode::LIFT_OFF, Mode::CARRY, Mode::SET_DOWN, Mode::RETREAT, Mode::RETURN];
        assert_eq!(modes, all[..if after == AfterPlacing::Home { 6 } else { 5 }], "{id}");
        let moved = moved(&answer, &problem);
        assert!(lies_on(&scenario, &moved, &scenario.places[0]), "{id}: {moved}");
        assert!(moved.translation.vector.norm() > 0.3, "{id}");
        if after == AfterPlacing::Home {
            assert_eq!(answer.waypoints().last().map(Vec::as_slice), Some(problem.start()), "{id}");
        }
        let timed = &answer.timed.as_ref().unwrap().trajectory;
        assert_eq!((timed.legs().len(), timed.hand_motions().len()), (3, 2));
        assert_eq!(timed.waypoint_times_s().len(), answer.waypoints().len());
        let [closes, opens] = timed.hand_motions()[..] else { panic!("{id}") };
        let bits = |openings_m: [f64; 2]| openings_m.map(f64::to_bits);
        assert_eq!(bits(closes.openings_m), bits([opens.openings_m[1], opens.openings_m[0]]));
        assert_eq!(timed.opening_m(opens.until_s), Some(opens.openings_m[1]));
        if level == 1 {
            let again = placed(&problem, then(after));
            assert_eq!(again.waypoints(), answer.waypoints(), "{id}");
        }
    }
}

#[test]
fn the_target_is_brought_to_a_pose() {
    let (scenario, problem) = open("031");
    let now = problem.cell().unwrap().world().bodies()[problem.target().unwrap()].parts[0].world_from_solid;
    // Beside its present pose, turned by 20°.
    let there = Pose::translation(-0.1, -0.15, 0.0) * now * Pose::rotation(Vector::x() * 0.35);
    let goal = PlaceGoal { name: "there".to_owned(), spot: PlaceRegion::Target(there) };
    let answer = placed(&at(&problem, goal), then(AfterPlacing::Home));
    // A tilted object may be released but does not stand: a goal pose does not require that.
    assert!(matches!(answer.outcome, Outcome::Solved | Outcome::BudgetExhausted | Outcome::NoReachableGrasp));
    let upright = Pose::translation(-0.1, -0.15, 0.0) * now;
    let goal = PlaceGoal { name: "there".to_owned(), spot: PlaceRegion::Target(upright) };
    let answer = placed(&at(&problem, goal), then(AfterPlacing::Home));
    assert!(answer.is_solved(), "{:?} {:?}", answer.outcome, answer.audit);
    // In the air, or in the floor, no object can be released.
    for off_m in [0.02, -0.005] {
        let spot = PlaceRegion::Target(Pose::translation(-0.1, -0.15, off_m) * now);
        let goal = PlaceGoal { name: "there".to_owned(), spot };
        assert_ne!(placed(&at(&problem, goal), then(AfterPlacing::Home)).outcome, Outcome::Solved, "{off_m}");
    }
    let ended = moved(&answer, &problem) * now;
    assert!((ended.translation.vector - upright.translation.vector).norm() < 1e-4);
    assert!(ended.rotation.angle_to(&upright.rotation) < 1e-3);
    drop(scenario);
}

#[test]
fn what_a_plan_file_says_of_a_place_is_judged() {
    let (_, problem) = open("021");
    let answer = placed(&problem, then(AfterPlacing::Home));
    let plan = PlanFile::of(&answer, &PlanSource { scenario: "021".to_owned(), ..PlanSource::default() });
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("021.plan.json");
    plan.write(&file).unwrap();
    let read = PlanFile::read(&file).unwrap();
    assert_eq!(read, plan);
    assert!(audit_of(&read, &problem).valid);
    let again = solve(&problem, &plan.request(), &mut Unobserved).unwrap();
    assert_eq!(again.waypoints(), plan.waypoints);

    let kinds = |plan: &PlanFile, problem: &Problem| -> Vec<&str> {
        audit_of(plan, problem).violations.iter().map(Violation::kind).collect()
    };
    // The same path for a smaller rectangle, one beside it, and one that floats.
    let PlaceGoal { name, spot } = problem.place("outside").unwrap().clone();
    let PlaceRegion::Surface { on, pose, size_m } = spot else { panic!("a surface") };
    let other = |pose: Pose, size_m: [f64; 2], on: &str| {
        let spot = PlaceRegion::Surface { on: on.to_owned(), pose, size_m };
        problem.clone().with_places(&[PlaceGoal { name: name.clone(), spot }])
    };
    let aside = Pose::translation(0.0, 0.7, 0.0) * pose;
    let above = Pose::translation(0.0, 0.0, 0.01) * pose;
    for (what, problem) in [
        ("small", other(pose, [0.02, 0.02], &on)),
        ("aside", other(aside, size_m, &on)),
        ("above", other(above, size_m, &on)),
        ("on another body", other(pose, size_m, "floor")),
    ] {
        assert_eq!(kinds(&plan, &problem), ["goal"], "{what}");
    }
    // Require another end of the retreat, or of the path; along its edges alone.
    let mut plan = plan;
    plan.segments.iter_mut().for_each(|segment| segment.corners.clear());
    let mut far = plan.clone();
    far.task[1] = Stage::Place(PlaceAt { clear_m: 0.2, ..PlaceAt::named("outside") });
    assert_eq!(kinds(&far, &problem), ["retreat"]);
    let mut stays = plan.clone();
    stays.segments.pop();
    let problems: Vec<_> = kinds(&stays, &problem);
    assert_eq!(problems, ["goal"], "the path ends before it goes home");
    stays.task.pop();
    assert!(audit_of(&stays, &problem).valid);
    // Release from higher up, or carry through the table.
    let mut early = plan.clone();
    let above = early.segments[3].waypoints[0].clone();
    early.segments[3].waypoints = vec![above.clone(), above.clone()];
    early.segments[4].waypoints[0] = above;
    assert!(kinds(&early, &problem).contains(&"goal"));
    let mut through = plan.clone();
    let mut deep = through.segments[3].waypoints.last().unwrap().clone();
    deep[2] += 0.3;
    through.segments[3].waypoints.insert(1, deep);
    assert!(!audit_of(&through, &problem).valid);
    // A jump between two segments: no file has one, but a caller may pass one.
    for piece in [1, 2, 3, 4, 5] {
        let mut segments = plan.segments.clone();
        segments[piece].waypoints[0] =
            segments[piece].waypoints[0].iter().map(|value| value + 1e-3).collect();
        let fault = audit_task(&problem, &plan.task, &segments, AuditSettings::default()).unwrap_err();
        assert!(fault.to_string().contains("does not begin where"), "piece {piece}: {fault}");
    }
    // An unknown goal is an error, and not a verdict.
    let mut unknown = plan.clone();
    unknown.task[1] = Stage::place("nowhere");
    assert!(matches!(
        unknown.audit(&problem, AuditSettings::default()),
        Err(PlanError::Task(TaskError::UnknownPlace { known, .. })) if known == "'outside'"
    ));
    // A path to the grasp alone does not put anything down, regardless of the stated task.
    let mut reach = plan.clone();
    reach.segments.truncate(1);
    reach.waypoints = reach.segments[0].waypoints.clone();
    assert_eq!(kinds(&reach, &problem), ["goal"]);
    // Without its task, its segments match no stage.
    let placeless = PlanFile { task: Vec::new(), ..plan };
    assert!(matches!(
        placeless.audit(&problem, AuditSettings::default()),
        Err(PlanError::Task(TaskError::Segments { .. }))
    ));
}

#[test]
fn places_that_are_none_are_refused_and_those_that_hold_nothing_are_told() {
    let (_, problem) = open("021");
    let PlaceRegion::Surface { on, pose, size_m } = problem.place("outside").unwrap().spot.clone() else {
        panic!("a surface")
    };
    let with = |on: &str, pose: Pose, size_m: [f64; 2]| {
        let spot = PlaceRegion::Surface { on: on.to_owned(), pose, size_m };
        at(&problem, PlaceGoal { name: String::new(), spot })
    };
    let clear =
        |clear_m: f64| vec![Stage::pick(), Stage::Place(PlaceAt { clear_m, ..PlaceAt::named("outside") })];
    let tilted = pose * Pose::rotation(Vector::x() * 0.1);
    for (problem, stages, says) in [
        (with("ball", pose, size_m), clear(CLEAR_M), "lies on the object that is to be put down"),
        (with("moon", pose, size_m), clear(CLEAR_M), "moon"),
        (with(&on, tilted, size_m), clear(CLEAR_M), "not level"),
        (with(&on, pose, [0.1, f64::NAN]), clear(CLEAR_M), "no size"),
        (problem.clone().with_weights(&[]), clear(CLEAR_M), "ball rolls away from 'outside'"),
        (problem.clone(), clear(-0.1), "not a valid clearance"),
        (problem.clone(), clear(f64::INFINITY), "not a valid clearance"),
    ] {
        let fault = asked(&problem, stages, 0).unwrap_err().to_string();
        assert!(fault.contains(says), "{fault}");
    }
    // The rectangle is too small: no error, and every grasp has a reason.
    let answer = placed(&with(&on, pose, [0.01, 0.01]), clear(CLEAR_M));
    assert_ne!(answer.outcome, Outcome::Solved);
    assert!(answer.failures.iter().any(|failure| failure.reason.sentence().contains("no place")));
}

/// Returns the surroundings as they appear to a robot whose root is displaced.
fn seen_from(cell: &Cell, root_from_planned: &Pose, only: Option<usize>) -> World {
    let planned_from_root = root_from_planned.inverse();
    let bodies = cell.world().bodies().iter().enumerate().map(|(index, body)| {
        let is_moved = only.is_none_or(|only| only == index);
        let part = |part: &Part| Part {
            world_from_solid: if is_moved {
                planned_from_root * part.world_from_solid
            } else {
                part.world_from_solid
            },
            solid: part.solid.clone(),
        };
        Body { parts: body.parts.iter().map(part).collect(), ..body.clone() }
    });
    World::new(bodies.collect()).unwrap()
}

/// Returns a random pose error about a point that uses up a share of a radius (m, rad).
fn error(random: &mut Stream, radius: [f64; 2], share: f64, about: &Vector) -> Pose {
    let direction = random.rotation() * Vector::x();
    let axis = random.rotation() * Vector::x();
    let turned = random.uniform();
    let turn = Rotation::from_scaled_axis(axis * (share * turned * radius[1]));
    let shift = direction * (share * (1.0 - turned) * radius[0]);
    let about = Pose::from_parts((*about).into(), UnitQuaternion::identity());
    Pose::from_parts(shift.into(), Rotation::identity())
        * about
        * Pose::from_parts(Vector::zeros().into(), turn)
        * about.inverse()
}

/// The law of [`Robustness`]: an error within the radius causes no contact, and a much larger error causes some.
#[test]
fn within_the_radius_nothing_is_touched() {
    // Ten thousand executions over both scenarios and the three kinds in the long run.
    let executions = if std::env::var_os("CRANNY_LONG").is_some() { 1700 } else { 30 };
    // Number of executions with contact within the radius, at three times and at thirty times of it, by kind.
    let mut touching = [[0; 3]; 3];
    let shares = [1.0, 3.0, 30.0];
    for id in ["012", "033"] {
        let (_, problem) = open(id);
        let answer = placed(&problem, then(AfterPlacing::Home));
        let plan = PlanFile::of(&answer, &PlanSource { scenario: id.to_owned(), ..PlanSource::default() });
        let along = plan.states(&problem).unwrap().unwrap();
        let Robustness { object, base, joints, .. } = answer.robustness.unwrap();
        let [object, base] = [object, base].map(|radius| {
            let radius = radius.expect("there is something to touch");
            [radius.translation_m, radius.rotation_rad]
        });
        let joints = joints.unwrap();
        let empty = problem.cell().unwrap();
        let target = problem.target().unwrap();
        let middle = empty.world().bodies()[target].ball().unwrap().center.coords;
        let mut random = Stream::new(7, 0);
        for execution in 0..executions {
            // An error of the object, before the hand closes; and of the base, on the path of the empty hand too.
            for (kind, radius, about, only) in
                [(0, object, middle, Some(target)), (1, base, Vector::zeros(), None)]
            {
                let reach = &answer.segments[0];
                for (row, share) in touching.iter_mut().zip(shares) {
                    let off = error(&mut random, radius, share, &about);
                    let world = seen_from(empty, &off, only);
                    let cell =
                        Cell::for_grasp(empty.robot().clone(), world, target, Margins::default()).unwrap();
                    let touches = touches_along(&cell, &reach.waypoints, &[0.0; 9], &mut random);
                    assert!(share > 1.0 || !touches, "{id}: execution {execution} of kind {kind}");
                    row[kind] += usize::from(touches);
                }
            }
            for (row, share) in touching.iter_mut().zip(shares) {
                let segment = &answer.segments[execution % answer.segments.len()];
                let cell = along.states[execution % answer.segments.len()].cell();
                let slides = random.uniform() < 0.5;
                let off: Vec<f64> = (0..9)
                    .map(|joint| {
                        let radius = if joint < 2 { joints.sliding_m } else { joints.turning_rad };
                        let is_off = slides == (joint < 2);
                        let sign = random.uniform_between(-1.0, 1.0).signum();
                        if is_off { sign * share * radius.unwrap() } else { 0.0 }
                    })
                    .collect();
                let touches = touches_along(cell, &segment.waypoints, &off, &mut random);
                assert!(share > 1.0 || !touches, "{id}: execution {execution} of the joints");
                row[2] += usize::from(touches);
            }
        }
    }
    println!("{executions} executions of each kind in each scenario; {touching:?} touch at {shares:?} radii");
    assert!(touching[2].iter().all(|count| *count > 0), "{touching:?}");
}

/// Returns true if anything touches along a path (m, rad) whose joints are off by `off`, by exact distances at samples.
fn touches_along(cell: &Cell, path: &[Vec<f64>], off: &[f64], random: &mut Stream) -> bool {
    let mut scratch = cell.scratch();
    path.windows(2).any(|edge| {
        (0..8).any(|_| {
            let at = random.uniform();
            let q: Vec<f64> =
                between(&edge[0], &edge[1], at).zip(off).map(|(value, off)| value + off).collect();
            !cell.is_clear(&q, &mut scratch)
        })
    })
}

/// An error slightly beyond the radius, towards the nearest body at the nearest configuration, causes a contact.
#[test]
fn just_beyond_the_radius_the_nearest_is_touched() {
    let looked_at = if std::env::var_os("CRANNY_LONG").is_some() { 4 } else { 1 };
    for id in ["012", "044", "021", "033"].into_iter().take(looked_at) {
        let (_, problem) = open(id);
        let answer =
            solve(&problem, &Request { robustness: true, ..Request::default() }, &mut Unobserved).unwrap();
        let path = &answer.segments[0].waypoints;
        let Robustness { object, base, .. } = answer.robustness.unwrap();
        let (cell, target) = (problem.cell().unwrap(), problem.target().unwrap());
        // Neither error moves a link against another: only the nearest body of the world matters.
        let names: Vec<&str> = cell.robot().links().iter().map(|link| link.name.as_str()).collect();
        let pairs = names.iter().flat_map(|a| names.iter().map(|b| [(*a).to_owned(), (*b).to_owned()]));
        let unchecked_pairs = pairs.filter(|[a, b]| a < b).collect();
        let builtin = BUILTIN_ROBOTS.iter().find(|robot| robot.name == "panda_mobile").unwrap();
        let robot = builtin.robot(&RobotOptions { unchecked_pairs, ..RobotOptions::default() }).unwrap();
        let in_world = |bodies: Vec<Body>, target| {
            Cell::for_grasp(robot.clone(), World::new(bodies).unwrap(), target, Margins::default()).unwrap()
        };
        let alone = in_world(vec![cell.world().bodies()[target].clone()], 0);
        let around = in_world(cell.world().bodies().to_vec(), target);
        for (kind, cell, target, radius) in [("object", &alone, 0, object), ("base", &around, target, base)] {
            let radius_m = radius.unwrap().translation_m;
            let mut scratch = cell.scratch();
            let samples = path.windows(2).flat_map(|edge| {
                (0..=1000).map(|step| between(&edge[0], &edge[1], f64::from(step) / 1000.0).collect())
            });
            let of_bodies = |q: Vec<f64>| {
                let closest = cell.closest(&q, &mut scratch)?;
                let is_body = matches!(closest.second, Collider::Body(_));
                is_body.then_some((q, closest))
            };
            let nearest =
                samples.filter_map(of_bodies).min_by(|a, b| a.1.distance_m.total_cmp(&b.1.distance_m));
            let (q, closest) = nearest.expect("something is near");
            let [on_link, on_body] = closest.points.unwrap();
            // Besides the share of its lower bound, the radius omits some hundredths of a millimetre of the distance.
            let touches = |share: f64| {
                let beyond_m = share * radius_m + if share > 1.0 { 2e-5 } else { 0.0 };
                let shift = (on_link - on_body).normalize() * beyond_m;
                let world = seen_from(cell, &Pose::from_parts((-shift).into(), Rotation::identity()), None);
                let moved = Cell::for_grasp(cell.robot().clone(), world, target, Margins::default()).unwrap();
                !moved.is_clear(&q, &mut moved.scratch())
            };
            println!("{id}, {kind}: {:.3} of {:.3} mm", 1e3 * radius_m, 1e3 * closest.distance_m);
            assert!(!touches(1.0) && touches(1.15), "{id}, {kind}: {radius_m} of {}", closest.distance_m);
        }
    }
}
