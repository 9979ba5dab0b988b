//! Maps around bodies whose places are known: nothing else is free there beyond the stated distances.

use cranny_collision::{Body, World};
use cranny_sense::{Camera, KnownBody, Noise, SeenMap, SeenSettings, SensedScene, SensorModel};
use cranny_shape::{Solid, separation};
use cranny_spatial::{Point, Pose, Vector};

use crate::seen::{bodies, cameras, region, settings, views, wrongly_free_of};

fn known(body: &Body, border_m: Option<f64>) -> KnownBody {
    KnownBody {
        name: body.name.clone(),
        solids: body.parts.iter().map(|part| (part.world_from_solid, part.solid.clone())).collect(),
        tolerance_m: 0.002,
        reach_m: 0.002,
        border_m,
        is_transparent: true,
        is_alone: false,
    }
}

/// Distance of a point from a body.
fn distance_m(point: &Point, body: &Body) -> f64 {
    let at = Pose::translation(point.x, point.y, point.z);
    let ball = Solid::sphere(1e-6).unwrap();
    let of_part = body
        .parts
        .iter()
        .map(|part| separation(&ball, &at, &part.solid, &part.world_from_solid, 1.0).lower_m);
    of_part.fold(f64::INFINITY, f64::min)
}

/// No camera sees the inside of a block that stands before a known wall; in cells of any width, none of it is free.
#[test]
fn the_inside_of_what_stands_on_a_known_body_is_not_free() {
    let cuboid = |x: f64, y: f64, z: f64| Solid::cuboid(Vector::new(x, y, z)).unwrap();
    let wall = Body::new("wall", Pose::translation(0.4, 0.0, 0.3), cuboid(0.05, 0.3, 0.3));
    let block = Body::new("block", Pose::translation(0.27, 0.0, 0.3), cuboid(0.08, 0.05, 0.05));
    let scene = SensedScene::of_world(&World::new(vec![wall.clone(), block.clone()]).unwrap()).unwrap();
    let pose = Camera::looking_at(&Point::new(-0.5, 0.0, 0.3), &Point::new(0.4, 0.0, 0.3), &Vector::z());
    let camera = Camera::with_field_of_view([320, 240], 1.2, pose.unwrap()).unwrap();
    let sensor = SensorModel::exact();
    let view = scene.view("view", &camera, &sensor, &Noise::default()).unwrap();
    let is_long = std::env::var_os("CRANNY_LONG").is_some();
    let cells_m: &[f64] = if is_long { &[0.01, 0.02, 0.05, 0.1] } else { &[0.02, 0.1] };
    for &cell_m in cells_m {
        let fine = vec![region()];
        for (border_m, fine) in [(None, Vec::new()), (Some(0.0025), fine)] {
            let settings = SeenSettings { cell_m, fine_m: cell_m, fine, ..settings() };
            let views = std::slice::from_ref(&view);
            let map = SeenMap::new(views, &[known(&wall, border_m)], settings).unwrap();
            let stated_m = map.layer_m()[usize::from(border_m.is_some())].max(0.007);
            let is_beyond = |point: &Point| distance_m(point, &wall) > stated_m;
            let wrong = wrongly_free_of(&map, std::slice::from_ref(&block), 20_000, &is_beyond);
            assert_eq!(wrong, 0, "cells of {cell_m} m, {border_m:?}");
        }
    }
}

/// A camera that stands elsewhere than stated sees known bodies elsewhere, and others where known ones are.
#[test]
fn beyond_the_stated_layer_nothing_is_taken_for_a_known_body_by_a_displaced_camera() {
    let all = bodies();
    let scene = SensedScene::of_world(&World::new(all.clone()).unwrap()).unwrap();
    for (position_error_m, turn_error_rad) in [(0.01, 0.0), (0.0, 0.01), (0.03, 0.02)] {
        let sensor = SensorModel { position_error_m, turn_error_rad, ..SensorModel::default() };
        for seed in 0..2 {
            let noise = Noise { seed: 10 * seed, ..Noise::default() };
            let views = views(&scene, &cameras(4), &sensor, &noise);
            let (table, ball) = (&all[0], &all[4]);
            let known = [known(table, None), known(ball, Some(0.0025))];
            let map = SeenMap::new(&views, &known, settings()).unwrap();
            let is_other = |body: &&Body| body.name != table.name && body.name != ball.name;
            let others: Vec<Body> = all.iter().filter(is_other).cloned().collect();
            let stated_m = map.layer_m()[0];
            let is_beyond =
                |point: &Point| [table, ball].iter().all(|body| distance_m(point, body) > stated_m);
            assert_eq!(wrongly_free_of(&map, &others, 20_000, &is_beyond), 0, "{sensor:?}, seed {seed}");
        }
    }
}

/// A camera within the shape of a known body, as one in the hull of a link, sees what stands before it.
#[test]
fn a_camera_inside_of_a_known_body_sees_what_stands_before_it() {
    let block = bodies().remove(1);
    let scene = SensedScene::of_world(&World::new(vec![block.clone()]).unwrap()).unwrap();
    let camera = &cameras(1)[0];
    let eye = camera.world_from_camera.translation.vector;
    let view = scene.view("view", camera, &SensorModel::default(), &Noise::default()).unwrap();
    let hull = Body::new("hull", Pose::translation(eye.x, eye.y, eye.z), Solid::sphere(0.2).unwrap());
    let robot = KnownBody { is_transparent: false, reach_m: 1.0, ..known(&hull, None) };
    let map = SeenMap::new(&[view], &[robot], settings()).unwrap();
    // Unseen space is free within a metre of the hull, and what was measured is not: the front of the block and the cells behind.
    let front = |point: &Point| block.parts[0].world_from_solid.inverse_transform_point(point).x < -0.19;
    assert_eq!(wrongly_free_of(&map, std::slice::from_ref(&block), 20_000, &front), 0);
}
