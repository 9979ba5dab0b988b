//! Proofs that the base cannot come near enough to any grasp.

use std::collections::VecDeque;

use cranny_collision::Margins;
use cranny_path::base_enclosure;
use cranny_plan::{Budget, NoGrasp, Outcome, Unobserved};
use cranny_scenario::{
    CatalogueEntry, Family, FamilyMaker, GraspChoice, OpenOptions, Placement, RecipeRobot, Scenario,
    SceneScale, catalogue,
};
use cranny_solve::{Request, solve};
use cranny_task::{Problem, Stage};

/// Depth of the box behind the wall of a deep gap, in metres: more than the arm reaches from before the wall.
const DEEPER_M: f64 = 0.55;

fn maker(family: Family) -> FamilyMaker {
    let robot = RecipeRobot::of_the_paper().unwrap();
    FamilyMaker::new(family, robot, SceneScale::PAPER, CatalogueEntry::GRASP_SEED).unwrap()
}

/// Returns the problem of a gap whose box lies deeper by `deeper_m` (m).
fn gap(maker: &FamilyMaker, width_m: f64, deeper_m: f64) -> Problem {
    let paper = maker.paper_placement(width_m);
    let placement = Placement { y_m: paper.y_m + deeper_m, ..paper };
    let recipe = maker.scenario(width_m, &placement, Vec::new(), GraspChoice::Few).unwrap();
    let scenario = recipe.scenario("gap", &OpenOptions::default()).unwrap();
    scenario.problem(Margins::default()).unwrap()
}

fn request(iterations: u64) -> Request {
    Request { budget: Budget { iterations, ..Budget::default() }, ..Request::default() }
}

#[test]
fn a_gap_is_proven_too_narrow_a_centimetre_below_one_that_is_solved() {
    let maker = maker(Family::Gap);
    let wide = solve(&gap(&maker, 0.41, DEEPER_M), &request(1_000_000), &mut Unobserved).unwrap();
    assert_eq!(wide.outcome, Outcome::Solved);
    let narrow = solve(&gap(&maker, 0.40, DEEPER_M), &request(100), &mut Unobserved).unwrap();
    assert_eq!(narrow.outcome, Outcome::NoReachableGrasp);
    let Some(NoGrasp::BaseEnclosed(enclosure)) = narrow.no_grasp else { panic!("{:?}", narrow.no_grasp) };
    assert_eq!(enclosure.joints, ["base_joint_y", "base_joint_x"]);
    assert!(enclosure.beyond_m > 0.0 && enclosure.beyond_m < 0.5, "{enclosure:?}");
    let walls: Vec<&str> = enclosure.blocked_by.iter().map(|[_, body]| &**body).collect();
    assert_eq!(walls, ["left wall", "right wall"]);
}

#[test]
fn no_base_is_enclosed_in_a_built_in_scenario() {
    for entry in catalogue() {
        let scenario = Scenario::open(entry.id, &OpenOptions::default()).unwrap();
        let problem = scenario.problem(Margins::default()).unwrap();
        assert_eq!(base_enclosure(&problem), None, "{}", entry.id);
    }
}

/// Searches a grid of base positions with the arm as at the start for a way to where a grasp is in reach.
fn a_way_is_found(problem: &Problem) -> bool {
    const LINES: usize = 161;
    let cell = problem.cell().unwrap();
    let robot = cell.robot();
    let mut scratch = cell.scratch();
    let limits = &robot.limits()[..2];
    let at = |line: usize, joint: usize| {
        let share = line as f64 / (LINES - 1) as f64;
        limits[joint].lower + share * (limits[joint].upper - limits[joint].lower)
    };
    let mut q = problem.start().to_vec();
    let (reach, tip) = (robot.reach_bound(), robot.tip());
    let at_start = robot.frames_at(&q).link(tip).translation.vector;
    let middle = reach.middle().coords;
    let mut seen = vec![false; LINES * LINES];
    let begin = (LINES / 2, LINES / 2);
    seen[begin.0 * LINES + begin.1] = true;
    let mut open = VecDeque::from([begin]);
    while let Some((column, row)) = open.pop_front() {
        (q[0], q[1]) = (at(column, 0), at(row, 1));
        let way = robot.frames_at(&q).link(tip).translation.vector - at_start;
        let is_near = problem.grasps().unwrap().grasps().iter().any(|grasp| {
            (grasp.world_from_gripper.translation.vector - middle - way).norm() <= reach.radius_m()
        });
        if is_near {
            return true;
        }
        for (across, along) in [(0, 1), (2, 1), (1, 0), (1, 2)] {
            let next = ((column + across).wrapping_sub(1), (row + along).wrapping_sub(1));
            if next.0 < LINES && next.1 < LINES && !seen[next.0 * LINES + next.1] {
                (q[0], q[1]) = (at(next.0, 0), at(next.1, 1));
                seen[next.0 * LINES + next.1] = true;
                if cell.is_clear(&q, &mut scratch) {
                    open.push_back(next);
                }
            }
        }
    }
    false
}

#[test]
fn where_a_grid_finds_a_way_nothing_is_proven_and_the_converse_holds_away_from_the_limit() {
    let maker = maker(Family::Gap);
    let (mut proven, mut ways) = (0, 0);
    for (index, width_m) in [0.30, 0.34, 0.38, 0.398, 0.4, 0.43, 0.47, 0.52, 0.6].into_iter().enumerate() {
        let problem = gap(&maker, width_m, DEEPER_M + 0.02 * index as f64);
        let is_proven = base_enclosure(&problem).is_some();
        let is_open = a_way_is_found(&problem);
        assert!(!(is_proven && is_open), "{width_m}");
        assert_eq!(is_proven, width_m <= 0.4, "{width_m}");
        proven += usize::from(is_proven);
        ways += usize::from(is_open);
    }
    assert!(proven == 5 && ways > 0, "{proven} proven, {ways} ways");
}

#[test]
fn a_box_in_reach_from_before_the_wall_proves_nothing() {
    assert_eq!(base_enclosure(&gap(&maker(Family::Gap), 0.30, 0.0)), None);
}

#[test]
fn the_outcome_of_a_task_of_several_stages_is_that_of_the_proof_too() {
    let problem = gap(&maker(Family::Gap), 0.40, DEEPER_M);
    let stages = vec![Stage::pick(), Stage::home()];
    let answer = solve(&problem, &Request { stages, ..request(100) }, &mut Unobserved).unwrap();
    assert_eq!(answer.outcome, Outcome::NoReachableGrasp);
    assert!(matches!(answer.no_grasp, Some(NoGrasp::BaseEnclosed(_))), "{:?}", answer.no_grasp);
}
