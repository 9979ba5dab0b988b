use cranny_collision::{Body, World};
use cranny_robot::{Robot, RobotOptions};
use cranny_sense::{Camera, DefaultCameras, SegmentKind, SensedScene, default_cameras};
use cranny_shape::{Solid, TriangleSoup, separation};
use cranny_spatial::{Point, Pose, Rotation, Stream, Vector};

fn looking(eye: [f64; 3], target: [f64; 3], size_px: [usize; 2]) -> Camera {
    let pose = Camera::looking_at(&eye.into(), &target.into(), &Vector::z()).unwrap();
    Camera::with_field_of_view(size_px, 1.1, pose).unwrap()
}

fn scene(bodies: Vec<Body>) -> SensedScene {
    SensedScene::of_world(&World::new(bodies).unwrap()).unwrap()
}

fn random_pose(random: &mut Stream) -> Pose {
    let place = Vector::from_fn(|_, _| random.uniform_between(-0.4, 0.4));
    Pose::from_parts(place.into(), random.rotation())
}

#[test]
fn a_floor_a_box_and_a_ball_have_the_depths_of_their_equations() {
    let camera = looking([-2.0, 0.0, 0.7], [0.0, 0.0, 0.0], [65, 49]);
    let ball = Body::new("ball", Pose::translation(0.0, 0.5, 0.2), Solid::sphere(0.2).unwrap());
    let cuboid = Solid::cuboid(Vector::new(0.2, 0.3, 0.4)).unwrap();
    let cuboid = Body::new("box", Pose::translation(0.0, -0.5, 0.4), cuboid);
    let render = scene(vec![ball, cuboid, Body::floor(0.0)]).render(&camera);
    let mut counts = [0; 4];
    let eye = Point::from(camera.world_from_camera.translation.vector);
    for v in 0..49 {
        for u in 0..65 {
            let ray = camera.world_from_camera.rotation * camera.ray(u as f64, v as f64);
            // Depths by the textbook formulas, in world coordinates.
            let floor = if ray.z < 0.0 { -eye.z / ray.z } else { f64::INFINITY };
            let from_center = eye - Point::new(0.0, 0.5, 0.2);
            let (a, b, c) =
                (ray.dot(&ray), 2.0 * ray.dot(&from_center), from_center.dot(&from_center) - 0.04);
            let root = (b * b - 4.0 * a * c).sqrt();
            let ball = if root.is_nan() { f64::INFINITY } else { (-b - root) / (2.0 * a) };
            let faces = [(0, -0.2), (0, 0.2), (1, -0.8), (1, -0.2), (2, 0.0), (2, 0.8)].map(|(axis, at)| {
                let t = (at - eye[axis]) / ray[axis];
                let p = eye + ray * t;
                let is_on = (p.x.abs() <= 0.2 + 1e-9)
                    && (p.y + 0.5).abs() <= 0.3 + 1e-9
                    && (p.z - 0.4).abs() <= 0.4 + 1e-9;
                if is_on && t > 0.0 { t } else { f64::INFINITY }
            });
            let expected = [ball, faces.into_iter().fold(f64::INFINITY, f64::min), floor];
            let nearest = expected.into_iter().fold(f64::INFINITY, f64::min);
            let segment = render.segments[v * 65 + u];
            counts[usize::from(segment)] += 1;
            match render.depth.depth_m(u, v) {
                Some(depth_m) => {
                    assert!((f64::from(depth_m) - nearest).abs() < 1e-6, "{u} {v}: {depth_m} {nearest}");
                    assert!((expected[usize::from(segment) - 1] - nearest).abs() < 1e-6);
                }
                None => assert!(nearest.is_infinite() && segment == 0),
            }
        }
    }
    assert!(counts.iter().all(|count| *count > 50), "{counts:?}");
}

/// Oracle: distances of the collision check. A seen point lies on its body, and the ray before it outside of all.
#[test]
fn each_depth_is_the_first_contact_of_its_ray_with_a_solid() {
    let mut random = Stream::new(3, 0);
    let soup = TriangleSoup::geodesic_sphere(0.15, 2);
    for _ in 0..6 {
        let solids = [
            Solid::cuboid(Vector::new(0.1, 0.2, 0.05)),
            Solid::capsule(0.2, 0.05),
            Solid::cylinder(0.1, 0.1),
            Solid::mesh(&soup),
            Solid::hull(&soup.vertices),
        ];
        let bodies = solids.into_iter().enumerate().map(|(index, solid)| {
            Body::new(format!("body {index}"), random_pose(&mut random), solid.unwrap())
        });
        let world = World::new(bodies.collect()).unwrap();
        let camera = looking([-0.9, 0.3, 0.2], [0.0; 3], [40, 30]);
        let render = SensedScene::of_world(&world).unwrap().render(&camera);
        let probe = Solid::sphere(1e-7).unwrap();
        let distance_m = |body: &Body, point: Point| {
            let part = &body.parts[0];
            let at = Pose::from_parts(point.coords.into(), Rotation::identity());
            separation(&part.solid, &part.world_from_solid, &probe, &at, 5.0).upper_m
        };
        for _ in 0..200 {
            let (u, v) = (random.index(40), random.index(30));
            let depth_m = render.depth.depth_m(u, v).map_or(3.0, f64::from);
            let along = |share: f64| {
                camera.world_from_camera * Point::from(camera.ray(u as f64, v as f64) * (share * depth_m))
            };
            if let Some(body) = usize::from(render.segments[v * 40 + u]).checked_sub(1) {
                assert!(distance_m(&world.bodies()[body], along(1.0)) < 1e-6);
            }
            let before = along(random.uniform_between(0.0, 1.0 - 1e-5));
            assert!(world.bodies().iter().all(|body| distance_m(body, before) > 0.0), "{u} {v}");
        }
    }
}

/// Each pixel meets a triangle, also where its ray runs exactly through an edge or a corner.
#[test]
fn a_mesh_has_no_gaps_along_its_edges() {
    let cuboid = Solid::cuboid(Vector::repeat(0.25)).unwrap();
    let mesh = Solid::mesh(&cuboid.tessellation().unwrap()).unwrap();
    for (eye, up) in [(Point::new(-1.0, 0.0, 0.0), Vector::z()), (Point::new(0.0, 0.0, 2.0), Vector::x())] {
        let pose = Camera::looking_at(&eye, &Point::origin(), &up).unwrap();
        let camera = Camera::new([129, 129], [128.0; 2], [64.0; 2], pose).unwrap();
        let render =
            |solid: &Solid| scene(vec![Body::new("box", Pose::identity(), solid.clone())]).render(&camera);
        let (exact, found) = (render(&cuboid), render(&mesh));
        assert_eq!(exact.segments, found.segments);
        let pairs = exact.depth.depths_m().iter().zip(found.depth.depths_m());
        assert!(pairs.clone().all(|(a, b)| (a.is_nan() && b.is_nan()) || (a - b).abs() < 1e-6));
    }
}

#[test]
fn a_camera_within_a_body_or_before_a_large_one_is_rendered_too() {
    let camera = looking([0.0; 3], [1.0, 0.0, 0.0], [20, 16]);
    let inside =
        scene(vec![Body::new("ball", Pose::identity(), Solid::sphere(0.5).unwrap())]).render(&camera);
    assert!(inside.depth.valid_count() == 0 && inside.segments.iter().all(|segment| *segment == 1));
    // Its corners lie in front of the camera and behind it.
    let soup = Solid::cuboid(Vector::new(0.1, 5.0, 5.0)).unwrap().tessellation().unwrap();
    let turned = Pose::new(Vector::new(0.6, 0.0, 0.0), Vector::new(0.0, 0.0, 1.0));
    let wall = scene(vec![Body::new("wall", turned, Solid::mesh(&soup).unwrap())]).render(&camera);
    assert_eq!(wall.depth.valid_count(), 320);
}

#[test]
fn the_robot_is_the_last_segment() {
    let urdf = cranny_test_robots::plane_arm();
    let robot = Robot::from_urdf_text(&urdf, "arm.urdf", None, &RobotOptions::default()).unwrap();
    let world = World::new(vec![Body::floor(-0.5)]).unwrap();
    let scene = SensedScene::of_world(&world).unwrap().with_robot(&robot, &vec![0.0; robot.dof()]).unwrap();
    assert_eq!(scene.segments().len(), 2);
    assert_eq!((&*scene.segments()[1].name, scene.segments()[1].kind), ("robot", SegmentKind::Robot));
    let render = scene.render(&looking([0.5, -2.0, 1.0], [0.5, 0.0, 0.0], [64, 48]));
    assert!([1, 2].iter().all(|number| render.segments.contains(number)));
}

/// A target in a box that is open towards the tool is seen through the opening.
#[test]
fn default_cameras_look_through_the_opening() {
    let wall = |x: f64, y: f64, z: f64, half: [f64; 3]| (Pose::translation(x, y, z), Vector::from(half));
    let walls = [
        wall(0.25, 0.0, 0.2, [0.01, 0.25, 0.2]),
        wall(0.0, 0.25, 0.2, [0.25, 0.01, 0.2]),
        wall(0.0, -0.25, 0.2, [0.25, 0.01, 0.2]),
        wall(0.0, 0.0, 0.41, [0.26, 0.26, 0.01]),
    ];
    let mut bodies: Vec<Body> = walls
        .into_iter()
        .enumerate()
        .map(|(index, (pose, half))| Body::new(format!("wall {index}"), pose, Solid::cuboid(half).unwrap()))
        .collect();
    bodies.push(Body::new("target", Pose::translation(0.0, 0.0, 0.05), Solid::sphere(0.05).unwrap()));
    bodies.push(Body::floor(0.0));
    let scene = scene(bodies);
    let number = scene.number_of_body("target").unwrap();
    let tool = Point::new(-1.0, 0.0, 0.8);
    let request = |count| {
        DefaultCameras::new(count, number, [Point::new(0.0, 0.0, 0.05), tool], Vec::new(), Vector::z())
    };
    let one = default_cameras(&scene, &request(1)).unwrap();
    let four = default_cameras(&scene, &request(4)).unwrap();
    assert_eq!((four.len(), &four[0]), (4, &one[0]));
    let seen =
        |camera: &Camera| scene.render(camera).segments.iter().filter(|segment| **segment == number).count();
    assert!(seen(&one[0]) > 100, "{}", seen(&one[0]));
    for (index, camera) in four.iter().enumerate() {
        let others = &four[..index];
        assert!(others.iter().all(|other| other.world_from_camera != camera.world_from_camera));
    }
}
