use cranny_robot::Robot;
use cranny_sense::{DepthImage, SenseError, SensedScene, View};

/// Maximum distance from a pixel of the robot up to which pixels are dropped.
const MOST_PX: f64 = 32.0;

/// Returns a view without the depths of pixels that may show the robot at `q` (m, rad; one per joint): a map knows the robot only where
/// it stands at its start. A pixel without a depth shows nothing.
pub(crate) fn without_robot(view: View, robot: &Robot, q: &[f64]) -> Result<View, SenseError> {
    let View { camera, depth, sensor, name } = view;
    let render = SensedScene::default().with_robot(robot, q)?.render(&camera);
    let focal_px = camera.focal_x_px.max(camera.focal_y_px);
    let pose_px = focal_px * (sensor.turn_error_rad + sensor.position_error_m / sensor.nearest_m.max(1e-3));
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a few pixels")]
    let around = (sensor.lateral_error_px + pose_px + 1.0).ceil().min(MOST_PX) as usize;
    let (width, height) = (camera.width_px, camera.height_px);
    let mut depths_m = depth.depths_m().to_vec();
    for v in 0..height {
        for u in 0..width {
            if render.segments[v * width + u] == 0 {
                continue;
            }
            for row in v.saturating_sub(around)..(v + around + 1).min(height) {
                let begin = row * width + u.saturating_sub(around);
                let end = row * width + (u + around + 1).min(width);
                depths_m[begin..end].fill(f32::NAN);
            }
        }
    }
    View::new(name, camera, DepthImage::new(width, height, depths_m)?, sensor)
}

#[cfg(test)]
mod tests {
    use cranny_robot::RobotOptions;
    use cranny_sense::{Camera, Noise, SensorModel};
    use cranny_spatial::{Point, Vector};

    use super::*;

    #[test]
    fn no_depth_of_the_robot_is_left() {
        let urdf = cranny_test_robots::ball(0.2);
        let robot =
            Robot::from_urdf_text(&urdf, "ball.urdf", None, &RobotOptions::default()).expect("a robot");
        let q = [0.1, 0.0, 0.0];
        let pose = Camera::looking_at(&Point::new(-1.0, 0.0, 0.1), &Point::origin(), &Vector::z());
        let camera = Camera::with_field_of_view([80, 60], 1.2, pose.expect("two points")).expect("a camera");
        let scene = SensedScene::default().with_robot(&robot, &q).expect("a scene");
        let view = scene.view("left", &camera, &SensorModel::default(), &Noise::default()).expect("a view");
        assert!(view.depth.valid_count() > 10, "the robot is in the image");
        let left = without_robot(view, &robot, &q).expect("a view");
        assert_eq!(left.depth.valid_count(), 0);
        // Elsewhere, the robot hides nothing.
        let view = scene.view("left", &camera, &SensorModel::default(), &Noise::default()).expect("a view");
        let count = view.depth.valid_count();
        assert_eq!(without_robot(view, &robot, &[9.0, 0.0, 0.0]).expect("a view").depth.valid_count(), count);
    }
}
