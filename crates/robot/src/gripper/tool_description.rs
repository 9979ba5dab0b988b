use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Tool without pads that close along an axis, such as a suction cup or a hand with more than two fingers: `tool` in the
/// `robot.yaml` of a robot. It is a body with a gripper frame. Its grasps come from files, and it carries nothing.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ToolDescription {
    /// Name of the tool.
    pub name: String,
    /// Gripper frame, to which grasps refer: z along the approach direction. Default: the tip that the robot has without this
    /// file.
    #[serde(default)]
    pub tip: Option<String>,
}

#[cfg(test)]
mod tests {
    use crate::{FingerRange, HandDescription, Robot, RobotError, RobotOptions, TextSource};

    const URDF: &str = r#"<robot name="arm"><link name="base"/><link name="cup"/><link name="frame"/><link name="side"/>
        <joint name="slide" type="prismatic"><parent link="base"/><child link="cup"/><axis xyz="1 0 0"/>
          <limit lower="0" upper="1" velocity="1" effort="1"/></joint>
        <joint name="mount" type="fixed"><parent link="cup"/><child link="frame"/></joint>
        <joint name="finger" type="prismatic"><parent link="cup"/><child link="side"/><axis xyz="0 1 0"/>
          <limit lower="0" upper="1" velocity="1" effort="1"/></joint></robot>"#;

    fn robot(description: &str) -> Result<Robot, RobotError> {
        let text = |text: &str| TextSource::Text { name: "robot.yaml".to_owned(), text: text.to_owned() };
        let known = HandDescription {
            name: "known".to_owned(),
            tip: Some("side".to_owned()),
            fingers: [("finger".to_owned(), FingerRange { open: 1.0, closed: 0.0 })].into(),
            opening_m: 0.1,
            finger_depth_m: 0.1,
            closing_force_n: 1.0,
            pads: None,
        };
        let options = RobotOptions {
            description: Some(text(description)),
            known_hands: vec![known],
            ..RobotOptions::default()
        };
        Robot::from_urdf_text(URDF, "arm.urdf", None, &options)
    }

    #[test]
    fn a_tool_is_no_hand_and_names_itself_where_one_is_needed() {
        let robot = robot("tool: {name: cup, tip: frame}").unwrap();
        assert!(robot.hand().is_none());
        assert_eq!(robot.links()[robot.tip()].name, "frame");
        assert_eq!(robot.tool().map(|tool| tool.name.as_str()), Some("cup"));
        let fault = robot.hand_with_pads().unwrap_err().to_string();
        assert!(fault.contains("tool 'cup'") && fault.contains("from a file"), "{fault}");
    }

    #[test]
    fn without_a_tool_the_hand_is_the_known_one() {
        let robot = robot("floor_m: 0").unwrap();
        assert_eq!(robot.hand_with_pads().unwrap().description.name, "known");
    }

    #[test]
    fn what_is_wrong_with_a_tool_is_refused_with_its_line() {
        let hand = "hand: {name: h, opening_m: 0.1, finger_depth_m: 0.1, closing_force_n: 1}";
        let fault = |text: &str| robot(text).unwrap_err().to_string();
        let both = fault(&format!("{hand}\ntool: {{name: cup}}"));
        assert!(both.starts_with("robot.yaml:2: ") && both.contains("not both"), "{both}");
        let unknown = fault("tool:\n  name: cup\n  tip: none");
        assert!(unknown.contains("robot.yaml:3") && unknown.contains("none"), "{unknown}");
        for text in ["tool: {tip: frame}", "tool: {name: cup, opening_m: 0.1}", "tool: cup"] {
            assert!(fault(text).contains("robot.yaml:1"), "{text}");
        }
    }
}
