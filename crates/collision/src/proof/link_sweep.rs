use cranny_robot::{JointKind, Robot};
use cranny_shape::Ball;

use crate::body::link_body::LinkBody;

/// Returns a ball in the root frame that contains a link in every configuration, even beyond the joint limits; `None` if a
/// prismatic joint moves the link.
///
/// A revolute joint keeps the distance of a point from every point of its axis, so the ball around the whole rotation is
/// centred on the axis, at the projection of the previous centre. The joints are visited from the link to the root.
pub(crate) fn swept_ball(robot: &Robot, body: &LinkBody) -> Option<Ball> {
    let mut rest = robot.frames();
    robot.forward_kinematics(&vec![0.0; robot.dof()], &mut rest);
    let mut ball = Ball { center: rest.link(body.link) * body.bounds.ball.center, ..body.bounds.ball };
    for mover in robot.ancestors(body.link).iter().rev() {
        if mover.kind == JointKind::Prismatic {
            return None;
        }
        let joint = rest.link(mover.child_link);
        let axis = joint.rotation * mover.axis_in_child;
        let from_joint = ball.center.coords - joint.translation.vector;
        let along = axis * axis.dot(&from_joint);
        ball.radius_m += (from_joint - along).norm();
        ball.center = (joint.translation.vector + along).into();
    }
    Some(ball)
}

#[cfg(test)]
mod tests {
    use super::*;
    use cranny_robot::RobotOptions;
    use cranny_spatial::Stream;

    const ARM: &str = r#"<robot name="arm">
  <link name="root"/>
  <link name="upper"><collision><origin xyz="0.1 0 0.2"/><geometry><sphere radius="0.03"/></geometry></collision></link>
  <link name="lower"><collision><origin xyz="0 0.05 0.3"/><geometry><sphere radius="0.03"/></geometry></collision></link>
  <joint name="turn" type="revolute"><parent link="root"/><child link="upper"/><origin xyz="0.2 0 0.1"/>
    <axis xyz="0 0.6 0.8"/><limit lower="-1" upper="1" velocity="1" effort="1"/></joint>
  <joint name="elbow" type="revolute"><parent link="upper"/><child link="lower"/><origin xyz="0 0.1 0.45" rpy="0.3 0 0"/>
    <axis xyz="1 0 0"/><limit lower="-1" upper="1" velocity="1" effort="1"/></joint>
</robot>"#;

    #[test]
    fn no_turn_takes_a_link_out_of_its_ball() {
        let robot =
            Robot::from_urdf_text(ARM, "arm.urdf", None, &RobotOptions::default()).expect("a good URDF");
        let (mut random, mut frames) = (Stream::new(5, 0), robot.frames());
        let bodies = LinkBody::all(&robot);
        let mut farthest = 0.0_f64;
        for _ in 0..2000 {
            let q: Vec<f64> = (0..robot.dof()).map(|_| random.uniform_between(-4.0, 4.0)).collect();
            robot.forward_kinematics(&q, &mut frames);
            for body in &bodies {
                let sweep = swept_ball(&robot, body).expect("no slide");
                let center = frames.link(body.link) * body.bounds.ball.center;
                let reach = (center - sweep.center).norm() + body.bounds.ball.radius_m;
                assert!(reach <= sweep.radius_m + 1e-9);
                farthest = farthest.max(reach / sweep.radius_m);
            }
        }
        assert!(farthest > 0.9, "a ball much too large says little: {farthest}");
    }

    #[test]
    fn what_slides_has_no_ball() {
        let slide = ARM.replacen("revolute", "prismatic", 1);
        let robot =
            Robot::from_urdf_text(&slide, "arm.urdf", None, &RobotOptions::default()).expect("a good URDF");
        assert!(LinkBody::all(&robot).iter().all(|body| swept_ball(&robot, body).is_none()));
    }
}
