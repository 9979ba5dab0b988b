use cranny_collision::{Body, World};
use cranny_sense::{Camera, DepthImage, Noise, SensedScene, SensorModel, noisy};
use cranny_shape::Solid;
use cranny_spatial::{Point, Pose, Vector};

fn camera(size_px: [usize; 2]) -> Camera {
    let pose = Camera::looking_at(&Point::new(-1.2, 0.1, 0.5), &Point::origin(), &Vector::z()).unwrap();
    Camera::with_field_of_view(size_px, 1.0, pose).unwrap()
}

fn scene() -> SensedScene {
    let post = Solid::cylinder(0.3, 0.05).unwrap();
    let bodies = vec![
        Body::new("post", Pose::translation(-0.2, 0.0, 0.3), post),
        Body::new("ball", Pose::translation(0.2, -0.2, 0.1), Solid::sphere(0.1).unwrap()),
        Body::floor(0.0),
    ];
    SensedScene::of_world(&World::new(bodies).unwrap()).unwrap()
}

/// Least and greatest true depth around a pixel, from rays on a grid within the lateral bound.
fn true_range_m(scene: &SensedScene, camera: &Camera, [u, v]: [usize; 2], lateral_px: f64) -> [f64; 2] {
    /// Rays along each axis.
    const FINE: usize = 41;
    let step = 2.0 * lateral_px / (FINE - 1) as f64;
    // A camera whose pixels are these rays.
    let close = Camera::new(
        [FINE, FINE],
        [camera.focal_x_px / step, camera.focal_y_px / step],
        [
            (camera.center_x_px - u as f64 + lateral_px) / step,
            (camera.center_y_px - v as f64 + lateral_px) / step,
        ],
        camera.world_from_camera,
    )
    .unwrap();
    let render = scene.render(&close);
    let mut range = [f64::INFINITY, 0.0_f64];
    for depth_m in render.depth.depths_m() {
        let depth_m = if depth_m.is_nan() { f64::INFINITY } else { f64::from(*depth_m) };
        range = [range[0].min(depth_m), range[1].max(depth_m)];
    }
    range
}

#[test]
fn measurements_obey_the_law_of_the_sensor() {
    let (scene, camera) = (scene(), camera([80, 60]));
    let sensor = SensorModel { lateral_error_px: 0.7, ..SensorModel::default() };
    let noise = Noise { seed: 5, ..Noise::default() };
    let image = scene.measure(&camera, &sensor, &noise).unwrap();
    let doubled = scene.measure(&camera, &sensor, &Noise { factor: 2.0, ..noise }).unwrap();
    let (mut mixed, mut outside) = (0, 0);
    for v in 0..60 {
        for u in 0..80 {
            let [least, greatest] = true_range_m(&scene, &camera, [u, v], 0.7);
            // The grid of rays misses the extremes between its rays.
            let slack = 0.02 * (greatest - least).min(1.0) + 1e-6;
            let low = least - sensor.depth_bound_m(least) - slack;
            let high = greatest + sensor.depth_bound_m(greatest) + slack;
            if let Some(measured_m) = image.depth_m(u, v).map(f64::from) {
                assert!(low <= measured_m && measured_m <= high, "{u} {v}: {low} {measured_m} {high}");
                let is_between = measured_m > least * 1.05 && measured_m < greatest * 0.95;
                mixed += usize::from(is_between);
            }
            if let Some(measured_m) = doubled.depth_m(u, v).map(f64::from) {
                outside += usize::from(measured_m < low || measured_m > high);
            }
        }
    }
    assert!(mixed > 10, "{mixed} mixed pixels");
    assert!(outside > 500, "{outside} pixels of a sensor with twice the noise violate the law");
}

#[test]
fn the_same_seed_gives_the_same_image_and_another_one_another() {
    let (scene, camera) = (scene(), camera([40, 30]));
    let sensor = SensorModel { position_error_m: 0.01, turn_error_rad: 0.02, ..SensorModel::default() };
    let view = |seed| scene.view("a", &camera, &sensor, &Noise { seed, ..Noise::default() }).unwrap();
    let bits =
        |image: &DepthImage| image.depths_m().iter().map(|depth_m| depth_m.to_bits()).collect::<Vec<_>>();
    assert_eq!(bits(&view(1).depth), bits(&view(1).depth));
    assert_ne!(bits(&view(1).depth), bits(&view(2).depth));
    let (mut farthest_m, mut most_rad) = (0.0_f64, 0.0_f64);
    for seed in 0..200 {
        let stated = camera.misplaced(&sensor, &Noise { seed, ..Noise::default() });
        let (stated, truth) = (stated.world_from_camera, camera.world_from_camera);
        farthest_m = farthest_m.max((stated.translation.vector - truth.translation.vector).norm());
        most_rad = most_rad.max(stated.rotation.angle_to(&truth.rotation));
    }
    assert!(farthest_m <= 0.01 + 1e-12 && farthest_m > 0.009, "{farthest_m}");
    assert!(most_rad <= 0.02 + 1e-9 && most_rad > 0.018, "{most_rad}");
}

#[test]
fn an_exact_sensor_measures_the_render() {
    let (scene, camera) = (scene(), camera([40, 30]));
    let sensor = SensorModel { farthest_m: 1.3, ..SensorModel::exact() };
    let image = scene.measure(&camera, &sensor, &Noise::default()).unwrap();
    let render = scene.render(&camera);
    let mut cut = 0;
    for (measured_m, true_m) in image.depths_m().iter().zip(render.depth.depths_m()) {
        if f64::from(*true_m) > 1.3 + 1e-6 {
            cut += 1;
            assert!(measured_m.is_nan());
        } else {
            assert!(measured_m.to_bits() == true_m.to_bits(), "{measured_m} {true_m}");
        }
    }
    assert!(cut > 50);
}

#[test]
fn noise_of_an_image_alone_stays_within_its_bounds() {
    let camera = camera([80, 60]);
    let render = scene().render(&camera).depth;
    let true_m = |u: isize, v: isize| {
        let inside = |at: isize, count: isize| usize::try_from(at.clamp(0, count - 1)).unwrap();
        render.depth_m(inside(u, 80), inside(v, 60)).map_or(f64::INFINITY, f64::from)
    };
    for (lateral_px, dropout_share) in [(0.5, 0.0), (1.0, 0.1)] {
        let sensor = SensorModel { lateral_error_px: lateral_px, ..SensorModel::default() };
        let image = noisy(&render, &sensor, &Noise { dropout_share, ..Noise::default() }).unwrap();
        let reach = isize::from(lateral_px >= 1.0);
        for v in 0..60 {
            for u in 0..80 {
                let near = (-reach..=reach)
                    .flat_map(|dv| (-reach..=reach).map(move |du| (u + du, v + dv)))
                    .map(|(u, v)| true_m(u, v));
                let (least, greatest) =
                    near.fold((f64::INFINITY, 0.0_f64), |(low, high), z| (low.min(z), high.max(z)));
                let measured_m = image.depth_m(u.unsigned_abs(), v.unsigned_abs()).map(f64::from);
                if let Some(measured_m) = measured_m {
                    assert!(measured_m >= least - sensor.depth_bound_m(least) - 1e-6);
                    assert!(measured_m <= greatest + sensor.depth_bound_m(greatest) + 1e-6);
                }
            }
        }
        let lost = render.valid_count() - image.valid_count();
        assert!(lost > 0 && lost < render.valid_count() / 3, "{lost}");
    }
    let fault = noisy(&render, &SensorModel::default(), &Noise { factor: -1.0, ..Noise::default() });
    assert!(fault.unwrap_err().to_string().contains("factor of a noise must be 0 to 100, but is -1"));
}
