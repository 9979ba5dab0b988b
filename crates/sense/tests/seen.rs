use cranny_collision::{Body, World};
use cranny_sense::{
    Camera, DepthImage, KnownBody, Noise, SeenMap, SeenSettings, SenseError, SensedScene, SensorModel,
    Unseen, View,
};
use cranny_shape::{Aabb, Solid, separation};
use cranny_spatial::{Point, Pose, Stream, Vector};

/// A table with a shelf, a ball, a tilted board and a post on it.
pub fn bodies() -> Vec<Body> {
    let cuboid = |x: f64, y: f64, z: f64| Solid::cuboid(Vector::new(x, y, z)).unwrap();
    let tilted = Pose::new(Vector::new(0.1, -0.35, 0.2), Vector::new(0.5, 0.3, 0.2));
    vec![
        Body::new("table", Pose::translation(0.0, 0.0, -0.05), cuboid(0.6, 0.8, 0.05)),
        Body::new("side", Pose::translation(0.1, 0.25, 0.2), cuboid(0.2, 0.015, 0.2)),
        Body::new("other side", Pose::translation(0.1, -0.15, 0.2), cuboid(0.2, 0.015, 0.2)),
        Body::new("top", Pose::translation(0.1, 0.05, 0.415), cuboid(0.2, 0.215, 0.015)),
        Body::new("ball", Pose::translation(0.1, 0.05, 0.06), Solid::sphere(0.06).unwrap()),
        Body::new("board", tilted, cuboid(0.15, 0.01, 0.1)),
        Body::new("post", Pose::translation(-0.3, 0.4, 0.15), Solid::cylinder(0.15, 0.02).unwrap()),
    ]
}

pub fn region() -> Aabb {
    Aabb { center: Point::new(0.0, 0.0, 0.25), half_extents: Vector::new(0.6, 0.6, 0.4) }
}

pub fn cameras(count: usize) -> Vec<Camera> {
    let eyes = [[-1.0, 0.1, 0.7], [-0.6, -0.9, 0.9], [-0.7, 0.9, 0.3], [0.9, 0.1, 1.1]];
    let camera = |[x, y, z]: &[f64; 3]| {
        let pose = Camera::looking_at(&Point::new(*x, *y, *z), &Point::new(0.05, 0.0, 0.1), &Vector::z());
        Camera::with_field_of_view([320, 240], 1.2, pose.unwrap()).unwrap()
    };
    eyes[..count].iter().map(camera).collect()
}

pub fn views(scene: &SensedScene, cameras: &[Camera], sensor: &SensorModel, noise: &Noise) -> Vec<View> {
    let view = |(index, camera): (usize, &Camera)| {
        let noise = Noise { seed: noise.seed + index as u64, ..*noise };
        scene.view(format!("view {index}"), camera, sensor, &noise).unwrap()
    };
    cameras.iter().enumerate().map(view).collect()
}

/// All obstacles of a map as solids at their poses.
pub fn obstacles(map: &SeenMap) -> Vec<(Pose, Solid)> {
    let of_body = |body: Body| body.parts.into_iter().map(|part| (part.world_from_solid, part.solid));
    map.bodies().unwrap().into_iter().flat_map(of_body).collect()
}

/// Number of points of true solids, of `count` drawn in the region, that the map takes for free.
fn wrongly_free(map: &SeenMap, bodies: &[Body], count: usize) -> usize {
    wrongly_free_of(map, bodies, count, &|_| true)
}

/// The same of the points that `counts` accepts.
pub fn wrongly_free_of(
    map: &SeenMap,
    bodies: &[Body],
    count: usize,
    counts: &dyn Fn(&Point) -> bool,
) -> usize {
    let obstacles = obstacles(map);
    let point_solid = Solid::sphere(1e-6).unwrap();
    let mut random = Stream::new(3, 0);
    let mut wrong = 0;
    for index in 0..count {
        // A point of a solid, mostly near its surface, where mistakes are.
        let part = &bodies[index % bodies.len()].parts[0];
        let half = part.solid.aabb().half_extents;
        let mut local = Vector::from_fn(|axis, _| random.uniform_between(-half[axis], half[axis]));
        if index % 3 > 0 {
            let axis = random.index(3);
            local[axis] = half[axis].copysign(local[axis]) * (1.0 - 1e-3 * random.uniform());
        }
        let point = part.world_from_solid * Point::from(local);
        let at = Pose::translation(point.x, point.y, point.z);
        let gap_m = |(pose, solid): (&Pose, &Solid)| separation(&point_solid, &at, solid, pose, 1.0).lower_m;
        let is_inside = gap_m((&part.world_from_solid, &part.solid)) <= 0.0;
        if is_inside
            && counts(&point)
            && region().contains(&point)
            && obstacles.iter().all(|(pose, solid)| gap_m((pose, solid)) > 0.0)
        {
            wrong += 1;
        }
    }
    wrong
}

pub fn settings() -> SeenSettings {
    SeenSettings { region: region(), cell_m: 0.01, fine: Vec::new(), fine_m: 0.005, unseen: Unseen::Solid }
}

/// Views whose depths are all too great by `factor` times the bound of the sensor: the worst within its model for 1.
fn too_far(scene: &SensedScene, sensor: &SensorModel, factor: f64) -> Vec<View> {
    let view = |camera: &Camera| {
        let depth = scene.render(camera).depth;
        #[allow(clippy::cast_possible_truncation, reason = "depths are stored as f32")]
        let measured = |true_m: &f32| true_m + (factor * sensor.depth_bound_m(f64::from(*true_m))) as f32;
        let depths = depth.depths_m().iter().map(measured).collect();
        let depth = DepthImage::new(depth.width(), depth.height(), depths).unwrap();
        View::new("too far", camera.clone(), depth, *sensor).unwrap()
    };
    cameras(4).iter().map(view).collect()
}

fn draws() -> usize {
    if std::env::var_os("CRANNY_LONG").is_some() { 2_500_000 } else { 20_000 }
}

#[test]
fn no_point_of_free_space_lies_in_a_solid() {
    let bodies = bodies();
    let scene = SensedScene::of_world(&World::new(bodies.clone()).unwrap()).unwrap();
    let sensor = SensorModel { position_error_m: 0.002, turn_error_rad: 0.003, ..SensorModel::default() };
    for seed in 0..4 {
        let noise = Noise { seed: 10 * seed, ..Noise::default() };
        let map = SeenMap::new(&views(&scene, &cameras(4), &sensor, &noise), &[], settings()).unwrap();
        assert!(map.free_m3() > 0.5, "{}", map.free_m3());
        assert_eq!(wrongly_free(&map, &bodies, draws()), 0);
    }
}

#[test]
fn a_sensor_outside_its_model_is_detected() {
    let bodies = bodies();
    let scene = SensedScene::of_world(&World::new(bodies.clone()).unwrap()).unwrap();
    let sensor = SensorModel { depth_error_m: 0.02, ..SensorModel::default() };
    let wrong = |factor: f64| {
        let map = SeenMap::new(&too_far(&scene, &sensor, factor), &[], settings()).unwrap();
        wrongly_free(&map, &bodies, draws())
    };
    assert_eq!(wrong(1.0), 0);
    assert!(wrong(2.0) > 0, "errors of twice the bound go unnoticed");
}

#[test]
fn known_bodies_are_cut_out_and_nothing_else() {
    let bodies = bodies();
    let scene = SensedScene::of_world(&World::new(bodies.clone()).unwrap()).unwrap();
    let views = views(&scene, &cameras(4), &SensorModel::default(), &Noise::default());
    let known = |index: usize| KnownBody {
        name: bodies[index].name.clone(),
        solids: bodies[index].parts.iter().map(|part| (part.world_from_solid, part.solid.clone())).collect(),
        tolerance_m: 0.002,
        reach_m: 0.002,
        is_transparent: true,
        border_m: Some(0.0025),
        is_alone: false,
    };
    let ball = known(4);
    let whole = SeenMap::new(&views, &[], settings()).unwrap();
    let fine = SeenSettings { fine: vec![region()], ..settings() };
    let map = SeenMap::new(&views, std::slice::from_ref(&ball), fine).unwrap();
    assert!(map.free_m3() > whole.free_m3() + 4e-4, "the volume of the ball is 9e-4 m³");
    let touches = |map: &SeenMap, (pose, solid): &(Pose, Solid)| {
        let gap = |(other, obstacle): &(Pose, Solid)| separation(solid, pose, obstacle, other, 1.0).lower_m;
        obstacles(map).iter().any(|obstacle| gap(obstacle) <= 0.0)
    };
    assert!(touches(&whole, &ball.solids[0]));
    // The table below it was measured, and stays.
    let above = (Pose::translation(0.1, 0.05, 0.08), Solid::sphere(0.035).unwrap());
    assert!(!touches(&map, &above));
    let others: Vec<Body> = bodies.iter().filter(|body| body.name != "ball").cloned().collect();
    assert_eq!(wrongly_free(&map, &others, draws()), 0);
    // A body that is not where it is stated to be is no reason to cut anything out.
    let mut moved = ball.clone();
    moved.solids[0].0.translation.vector.z += 0.2;
    moved.reach_m = 0.0;
    let map = SeenMap::new(&views, &[moved], settings()).unwrap();
    assert!(touches(&map, &ball.solids[0]));
}

/// A plate stands behind the place of an arm, within the distance at which unseen space counts as free. The first view shows it, since
/// the arm is elsewhere in it.
#[test]
fn what_a_view_shows_where_a_known_body_will_be_is_an_obstacle() {
    let plate = Solid::cuboid(Vector::new(0.003, 0.03, 0.04)).unwrap();
    let plate = Body::new("plate", Pose::translation(-0.355, -0.45, 0.1), plate);
    let others = [&bodies()[..], std::slice::from_ref(&plate)].concat();
    let arm = Solid::cuboid(Vector::new(0.03, 0.03, 0.04)).unwrap();
    let [before, now] = [0.3, -0.45].map(|y| Pose::translation(-0.4, y, 0.1));
    let known = |place: Pose| KnownBody {
        name: "arm".to_owned(),
        solids: vec![(place, arm.clone())],
        tolerance_m: 0.005,
        reach_m: 0.03,
        is_transparent: false,
        border_m: None,
        is_alone: false,
    };
    let camera = &cameras(1)[0];
    let seen_with = |place: Pose| {
        let whole = [&others[..], &[Body::new("arm", place, arm.clone())]].concat();
        let scene = SensedScene::of_world(&World::new(whole).unwrap()).unwrap();
        scene.view("view", camera, &SensorModel::default(), &Noise::default()).unwrap()
    };
    let views = [seen_with(before), seen_with(now)];
    let wrong = |shown: &[Option<Vec<KnownBody>>]| {
        let map = SeenMap::of_moving(&views, &[known(now)], shown, settings()).unwrap();
        wrongly_free(&map, std::slice::from_ref(&plate), draws())
    };
    assert_eq!(wrong(&[Some(vec![known(before)]), None]), 0);
    assert_eq!(wrong(&[]), 0, "nor is it the edge of an arm that is believed to be there");
}

#[test]
fn above_a_known_support_there_is_room_where_a_camera_sees_it() {
    let bodies = bodies();
    let scene = SensedScene::of_world(&World::new(bodies.clone()).unwrap()).unwrap();
    let views = views(&scene, &cameras(4), &SensorModel::default(), &Noise::default());
    let table = KnownBody {
        name: "table".to_owned(),
        solids: vec![(bodies[0].parts[0].world_from_solid, bodies[0].parts[0].solid.clone())],
        tolerance_m: 0.002,
        reach_m: 0.002,
        is_transparent: true,
        border_m: None,
        is_alone: false,
    };
    let others: Vec<Body> = bodies.iter().filter(|body| body.name != "table").cloned().collect();
    let finger = |x: f64, y: f64| (Pose::translation(x, y, 0.025), Solid::sphere(0.01).unwrap());
    let meets = |map: &SeenMap, (pose, solid): (Pose, Solid)| {
        let gap_m =
            |(other, obstacle): &(Pose, Solid)| separation(&solid, &pose, obstacle, other, 1.0).lower_m;
        obstacles(map).iter().any(|obstacle| gap_m(obstacle) <= 0.0)
    };
    let without = SeenMap::new(&views, &[], settings()).unwrap();
    let map = SeenMap::new(&views, std::slice::from_ref(&table), settings()).unwrap();
    assert!(meets(&without, finger(-0.3, 0.0)) && !meets(&map, finger(-0.3, 0.0)));
    // Below the post, and in the shadow of the shelf, the map is as before.
    assert!(meets(&map, finger(-0.3, 0.4)));
    assert!(map.layer_m()[0] > 0.01);
    // Surfaces of other bodies farther from the table than the layer in which they cannot be distinguished are never free.
    let high: Vec<Body> =
        others.into_iter().filter(|body| body.name == "top" || body.name == "board").collect();
    assert_eq!(wrongly_free(&map, &high, draws()), 0);
}

#[test]
fn unseen_space_is_solid_and_what_lies_outside_the_region_too() {
    let bodies = bodies();
    let scene = SensedScene::of_world(&World::new(bodies).unwrap()).unwrap();
    let views = views(&scene, &cameras(1), &SensorModel::default(), &Noise::default());
    let names = |unseen: Unseen| {
        let map = SeenMap::new(&views, &[], SeenSettings { unseen, ..settings() }).unwrap();
        map.bodies().unwrap().iter().map(|body| (body.name.clone(), body.parts.len())).collect::<Vec<_>>()
    };
    assert_eq!(names(Unseen::Solid), [("occupied".to_owned(), 1), ("unseen".to_owned(), 7)]);
    assert_eq!(names(Unseen::Free), [("occupied".to_owned(), 1)]);
    let fault = |result: Result<SeenMap, SenseError>| result.unwrap_err().to_string();
    assert!(fault(SeenMap::new(&[], &[], settings())).contains("at least one view"));
    let tiny = SeenSettings { cell_m: 1e-5, ..settings() };
    assert!(fault(SeenMap::new(&views, &[], tiny)).contains("0.001 to 0.2 m"));
    let mut wide = settings();
    wide.region.half_extents *= 100.0;
    assert!(fault(SeenMap::new(&views, &[], wide)).contains("larger cells"));
    let mut odd = settings();
    odd.region.center.x = f64::NAN;
    assert!(fault(SeenMap::new(&views, &[], odd)).contains("positive size"));
}
