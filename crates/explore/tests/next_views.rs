use cranny_collision::{Collider, Margins};
use cranny_explore::{
    CameraKind, Candidate, ExploreError, ExploreSettings, explore, find_blockage, next_fixed_view,
    next_hand_view, true_contact,
};
use cranny_path::{AuditSettings, audit_task};
use cranny_plan::{Outcome, Unobserved};
use cranny_robot::between;
use cranny_scenario::Scenario;
use cranny_sense::{CameraFrame, Noise, PlacedCamera, View};
use cranny_shape::{Solid, separation};
use cranny_solve::Request;
use cranny_spatial::{Point, Pose};
use cranny_task::Stage;

use crate::scene::{bad_camera, behind_a_wall, options};

/// The scenario behind the wall as the bad camera sees it, with that camera.
fn badly_seen() -> (Scenario, View) {
    let truth = behind_a_wall();
    let PlacedCamera { camera, sensor, .. } = bad_camera();
    let view = truth.sensed().unwrap().view("bad", &camera, &sensor, &Noise::default()).unwrap();
    let views = [view];
    let seen = truth.with_known_bodies_only(&[]).unwrap().with_seen(&views, &options()).unwrap();
    let [view] = views;
    (seen, view)
}

#[test]
fn a_scene_behind_a_wall_is_explored_until_a_plan_is_proven() {
    let truth = behind_a_wall();
    let settings = ExploreSettings {
        cameras: vec![bad_camera()],
        noise_seed: Some(1),
        options: options(),
        ..ExploreSettings::default()
    };
    let explored = explore(&truth, &settings, &mut Unobserved, &mut |_| {}).unwrap();
    let first = &explored.reports[0];
    assert_ne!(first.outcome, Outcome::Solved, "the first view shows too little");
    let blockage = first.blockage.as_ref().expect("unseen space blocks a path");
    assert!(matches!(blockage.candidate, Candidate::Path(_)));
    assert!(blockage.unseen_count() == blockage.cells.len() && blockage.volume_m3() > 1e-3);
    assert!(blockage.around().high().x > 0.1, "what blocks is behind the wall");
    assert!(first.next.as_ref().is_some_and(|next| next.sees > blockage.cells.len() / 4));
    let last = explored.reports.last().unwrap();
    assert_eq!(last.outcome, Outcome::Solved, "{} views", explored.reports.len());
    assert!(last.unseen_m3 < first.unseen_m3 && last.free_m3 > first.free_m3);
    // The plan is valid in the seen space, and in the true scene.
    let seen = explored.seen.problem(Margins::default()).unwrap();
    let audit =
        audit_task(&seen, &Stage::of_goal(&seen), &explored.answer.segments, AuditSettings::default())
            .unwrap();
    assert!(audit.valid, "{:?}", audit.violations.first());
    let problem = truth.problem(Margins::default()).unwrap();
    assert_eq!(true_contact(&problem, &explored.answer).unwrap(), None);
    // The views alone give the same map.
    let views: Vec<View> = explored.views.views.iter().map(|stored| stored.view.clone()).collect();
    let again = truth.with_known_bodies_only(&[]).unwrap().with_seen(&views, &options()).unwrap();
    let unseen = |scenario: &Scenario| scenario.seen.as_ref().unwrap().map.unseen().to_vec();
    assert_eq!(unseen(&again), unseen(&explored.seen));
}

#[test]
fn a_camera_is_expected_to_see_the_cells_that_rays_reach() {
    let (seen, view) = badly_seen();
    let request = Request::default();
    let blockage =
        find_blockage(&seen, Margins::default(), &request, None, &mut Unobserved).unwrap().unwrap();
    // The stated link touches something at the stated place, and nothing does before.
    let first = blockage.first.expect("a contact");
    let problem = seen.problem(Margins::default()).unwrap();
    let cell = problem.cell().unwrap();
    let mut scratch = cell.scratch();
    let mut links_at = |at: f64| {
        let path = blockage.candidate.waypoints();
        let q: Vec<f64> = between(&path[first.edge], &path[first.edge + 1], at).collect();
        cell.contacts(&q, &mut scratch).into_iter().map(|contact| contact.first).collect::<Vec<_>>()
    };
    assert!(links_at(first.at).contains(&Collider::Link(first.link)));
    assert!((0..100).all(|step| links_at((first.at - 2e-4) * f64::from(step) / 99.0).is_empty()));
    let next =
        next_fixed_view(&seen, &blockage, &bad_camera(), &[view], &mut |_| true).unwrap().expect("a view");
    // An independent count: points along each ray in all occupied boxes and known solids.
    let map = &seen.seen.as_ref().unwrap().map;
    let known = seen.without_map().unwrap();
    let parts: Vec<_> = known.world.bodies().iter().flat_map(|body| &body.parts).collect();
    let (eye, point_solid) =
        (Point::from(next.camera.world_from_camera.translation.vector), Solid::sphere(1e-6).unwrap());
    let is_blocking = |point: &Point| blockage.cells.iter().any(|cell| cell.aabb.contains(point));
    let is_opaque = |point: &Point| {
        let at = Pose::translation(point.x, point.y, point.z);
        let in_part = parts.iter().any(|part| {
            separation(&point_solid, &at, &part.solid, &part.world_from_solid, 0.1).upper_m <= 0.0
        });
        in_part || (map.occupied().iter().any(|aabb| aabb.contains(point)) && !is_blocking(point))
    };
    let sees = |center: &Point| {
        let in_camera = next.camera.world_from_camera.inverse_transform_point(center);
        let Some([u, v]) = next.camera.project(&in_camera) else { return false };
        let is_inside = u >= 0.0 && v >= 0.0 && u < 160.0 && v < 120.0;
        let steps = 60;
        is_inside
            && (0..steps).all(|step| {
                let share = f64::from(step) / f64::from(steps);
                !is_opaque(&(eye + (center - eye) * (1.0 - share)))
            })
    };
    let stride = (blockage.cells.len() / 300).max(1);
    let sampled: Vec<_> = blockage.cells.iter().step_by(stride).collect();
    let counted = sampled.iter().filter(|cell| sees(&cell.aabb.center)).count();
    let [expected, found] =
        [counted as f64 / sampled.len() as f64, next.sees as f64 / blockage.cells.len() as f64];
    assert!((expected - found).abs() < 0.1, "rays reach {expected} of the cells, stated are {found}");
    assert!(next.frees.is_some_and(|frees| frees > 0 && frees <= blockage.cells.len()));
    // A refused pose is not chosen.
    let chosen = next.camera.world_from_camera;
    let other = next_fixed_view(&seen, &blockage, &bad_camera(), &[], &mut |camera| {
        camera.world_from_camera != chosen
    });
    assert_ne!(other.unwrap().expect("another view").camera.world_from_camera, chosen);
}

#[test]
fn exploration_refuses_what_it_cannot_use() {
    let truth = behind_a_wall();
    let fault = |truth: &Scenario, settings: &ExploreSettings| {
        explore(truth, settings, &mut Unobserved, &mut |_| {}).unwrap_err().to_string()
    };
    let settings = ExploreSettings { cameras: vec![bad_camera()], ..ExploreSettings::default() };
    let hand = ExploreSettings { kind: CameraKind::Hand, ..settings.clone() };
    assert!(fault(&truth, &hand).contains("frame: link NAME"));
    let (seen, _) = badly_seen();
    assert!(fault(&seen, &settings).contains("has `seen` space already"));
    // A camera on a slide below moves relative to the tip.
    let loose = PlacedCamera { frame: CameraFrame::Link("bridge".to_owned()), ..bad_camera() };
    let request = Request::default();
    let blockage =
        find_blockage(&seen, Margins::default(), &request, None, &mut Unobserved).unwrap().unwrap();
    let next = next_hand_view(&seen, Margins::default(), &blockage, &loose, &[], 0, &mut Unobserved);
    assert!(matches!(next, Err(ExploreError::LooseCamera { .. })));
}
