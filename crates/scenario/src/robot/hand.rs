use cranny_robot::{JointKind, Mover, Robot};
use cranny_shape::{Solid, overlap};

/// Hand without space between its fingers: the gripper frame, with its origin between the pads, lies inside the hull of a mesh.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error(
    "the gripper frame {tip} lies inside {link}: a link's mesh stands for its convex hull, and this one fills the \
     space between the fingers, so that the hand collides at every grasp (give palm and fingers a mesh each)"
)]
pub struct BlockedGripperFrame {
    /// Name of the link with the mesh.
    pub link: String,
    /// Name of the tip link.
    pub tip: String,
}

impl BlockedGripperFrame {
    /// Returns the fault of a robot's hand, if it has one.
    pub fn of(robot: &Robot) -> Option<Self> {
        // A tiny sphere represents the point.
        let point = Solid::sphere(1e-6).ok()?;
        let mut frames = robot.frames();
        robot.forward_kinematics(&vec![0.0; robot.dof()], &mut frames);
        let root_from_tip = frames.link(robot.tip());
        let is_filled = |&link: &usize| {
            let meshes = robot.links()[link].collisions.iter().filter(|shape| shape.soup.is_some());
            let mut placed = meshes.map(|shape| (&shape.solid, frames.link(link) * shape.link_from_shape));
            placed.any(|(solid, root_from_solid)| {
                overlap(solid, &root_from_solid, &point, root_from_tip).is_some()
            })
        };
        let link = robot.hand_links().iter().copied().find(is_filled)?;
        let name = |link: usize| robot.links()[link].name.clone();
        Some(Self { link: name(link), tip: name(robot.tip()) })
    }
}

/// Returns the link frames whose origins the `paper` criterion keeps above its floor: those in the chain to the tip that at
/// least two joints rotate. For the Panda these are the links from the second on, as in the release.
pub(crate) fn floor_links(robot: &Robot) -> Vec<usize> {
    let turns = |link: &usize| {
        let is_turn = |mover: &&Mover| mover.kind == JointKind::Revolute;
        robot.ancestors(*link).iter().filter(is_turn).count()
    };
    let chain = std::iter::successors(Some(robot.tip()), |&link| robot.links()[link].parent);
    let mut links: Vec<usize> = chain.take_while(|link| turns(link) >= 2).collect();
    links.reverse();
    links
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fmt::Write as _;

    use cranny_robot::RobotOptions;

    fn robot(links: &[(&str, &str, &str)]) -> Robot {
        let mut urdf = String::from("<robot name='r'><link name='base'/>");
        for (link, parent, kind) in links {
            let _ = write!(
                urdf,
                "<link name='{link}'><collision><geometry><sphere radius='0.1'/></geometry></collision></link>\
                 <joint name='to_{link}' type='{kind}'><parent link='{parent}'/><child link='{link}'/>\
                 <axis xyz='0 0 1'/><limit lower='-1' upper='1' velocity='1' effort='1'/></joint>"
            );
        }
        let options = RobotOptions { tip: Some(links[3].0.into()), ..RobotOptions::default() };
        Robot::from_urdf_text(&(urdf + "</robot>"), "r.urdf", None, &options).unwrap()
    }

    fn names(robot: &Robot, links: &[usize]) -> Vec<String> {
        links.iter().map(|&link| robot.links()[link].name.clone()).collect()
    }

    #[test]
    fn the_hand_is_what_moves_with_the_tip_beyond_the_flange() {
        let robot = robot(&[
            ("upper", "base", "revolute"),
            ("lower", "upper", "revolute"),
            ("flange", "lower", "revolute"),
            ("hand", "flange", "fixed"),
            ("finger", "hand", "prismatic"),
        ]);
        assert_eq!(names(&robot, robot.hand_links()), ["hand", "finger"]);
        assert_eq!(names(&robot, &floor_links(&robot)), ["lower", "flange", "hand"]);
    }

    #[test]
    fn a_flange_without_a_hand_is_the_hand() {
        let robot = robot(&[
            ("a", "base", "revolute"),
            ("b", "a", "revolute"),
            ("c", "b", "prismatic"),
            ("tool", "c", "revolute"),
        ]);
        assert_eq!(names(&robot, robot.hand_links()), ["tool"]);
        assert_eq!(names(&robot, &floor_links(&robot)), ["b", "c", "tool"]);
    }

    /// One mesh for palm and fingers makes every grasp collide, which the message must explain.
    #[test]
    fn a_hand_that_fills_the_space_between_its_fingers_is_told() {
        let folder = tempfile::tempdir().unwrap();
        let corners = |x: f64, y: f64, low: f64, high: f64| {
            let mut points = Vec::new();
            for z in [low, high] {
                points.extend([[-x, -y, z], [x, -y, z], [x, y, z], [-x, y, z]]);
            }
            points
        };
        let hand = |points: Vec<[f64; 3]>| {
            let vertices: Vec<_> = points.iter().map(|[x, y, z]| format!("v {x} {y} {z}\n")).collect();
            // Any triangles define the hull.
            let faces: Vec<_> =
                (1..=points.len() - 2).map(|i| format!("f {i} {} {}\n", i + 1, i + 2)).collect();
            std::fs::write(folder.path().join("hand.obj"), vertices.concat() + &faces.concat()).unwrap();
            let urdf = "<robot name='r'><link name='base'/><link name='arm'/><link name='hand'><collision><geometry>\
                        <mesh filename='hand.obj'/></geometry></collision></link><link name='tip'/>\
                        <joint name='turn' type='revolute'><parent link='base'/><child link='arm'/><axis xyz='0 0 1'/>\
                        <limit lower='-1' upper='1' velocity='1' effort='1'/></joint>\
                        <joint name='mount' type='fixed'><parent link='arm'/><child link='hand'/></joint>\
                        <joint name='reach' type='fixed'><parent link='hand'/><child link='tip'/>\
                        <origin xyz='0 0 0.1'/></joint></robot>";
            Robot::from_urdf_text(urdf, "r.urdf", Some(folder.path()), &RobotOptions::default()).unwrap()
        };
        assert_eq!(BlockedGripperFrame::of(&hand(corners(0.1, 0.03, 0.0, 0.06))), None);
        let fingers = [corners(0.1, 0.03, 0.0, 0.06), corners(0.1, 0.01, 0.06, 0.11)].concat();
        let filled = BlockedGripperFrame::of(&hand(fingers)).unwrap();
        assert_eq!((filled.link.as_str(), filled.tip.as_str()), ("hand", "tip"));
        assert!(filled.to_string().contains("fills the space between the fingers"));
    }
}
