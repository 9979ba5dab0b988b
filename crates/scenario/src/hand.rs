use cranny_robot::Robot;

/// The links of hand and fingers, by index: those with collision geometry that move as one with the tip,
/// without the link that the last joint moves, which belongs to the arm. A gripper mounted right on the last
/// joint, as one link with its flange, is that link itself.
pub(crate) fn hand_links(robot: &Robot) -> Vec<usize> {
    let tip_movers = robot.ancestors(robot.tip());
    let last_arm_link = tip_movers.last().map(|mover| mover.child_link);
    let moves_with_tip =
        |link: &usize| !robot.links()[*link].collisions.is_empty() && robot.ancestors(*link) == tip_movers;
    let rigid: Vec<usize> = (0..robot.links().len()).filter(moves_with_tip).collect();
    let hand: Vec<usize> = rigid.iter().copied().filter(|&link| Some(link) != last_arm_link).collect();
    if hand.is_empty() { rigid } else { hand }
}

/// The link frames whose origins the `paper` criterion keeps above its floor: those of the chain to the tip
/// from `panda_link2` on; where the chain has no such link, those that at least three joints move.
pub(crate) fn floor_links(robot: &Robot) -> Vec<usize> {
    let mut chain: Vec<usize> =
        std::iter::successors(Some(robot.tip()), |&link| robot.links()[link].parent).collect();
    chain.reverse();
    let named = chain.iter().position(|&link| robot.links()[link].name == "panda_link2");
    let third = chain.iter().position(|&link| robot.ancestors(link).len() >= 3);
    chain.split_off(named.or(third).unwrap_or(chain.len()))
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
        assert_eq!(names(&robot, &hand_links(&robot)), ["hand", "finger"]);
        assert_eq!(names(&robot, &floor_links(&robot)), ["flange", "hand"]);
    }

    #[test]
    fn a_flange_without_a_hand_is_the_hand() {
        let robot = robot(&[
            ("a", "base", "revolute"),
            ("b", "a", "revolute"),
            ("panda_link2", "b", "revolute"),
            ("tool", "panda_link2", "revolute"),
        ]);
        assert_eq!(names(&robot, &hand_links(&robot)), ["tool"]);
        assert_eq!(names(&robot, &floor_links(&robot)), ["panda_link2", "tool"]);
    }
}
