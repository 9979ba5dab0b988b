#![doc = include_str!("../README.md")]

/// Cart that slides along x, without geometry.
pub const SLIDE: &str = r#"<robot name="slide">
  <link name="rail"/><link name="cart"/>
  <joint name="drive" type="prismatic"><parent link="rail"/><child link="cart"/><axis xyz="1 0 0"/>
    <limit lower="-1" upper="1" velocity="1" effort="1"/></joint>
</robot>"#;

/// Radius of the ball, in metres.
pub const BALL_RADIUS_M: f64 = 0.05;

/// Returns a ball that three slides move anywhere within ±`reach_m`, in metres. It has no self-collisions, and distances
/// from it have closed formulas.
pub fn ball(reach_m: f64) -> String {
    format!(
        r#"<robot name="ball">
  <link name="root"/><link name="bridge"/><link name="trolley"/>
  <link name="ball"><collision><geometry><sphere radius="{BALL_RADIUS_M}"/></geometry></collision></link>
  <joint name="x" type="prismatic"><parent link="root"/><child link="bridge"/><axis xyz="1 0 0"/>
    <limit lower="-{reach_m}" upper="{reach_m}" velocity="1" effort="1"/></joint>
  <joint name="y" type="prismatic"><parent link="bridge"/><child link="trolley"/><axis xyz="0 1 0"/>
    <limit lower="-{reach_m}" upper="{reach_m}" velocity="1" effort="1"/></joint>
  <joint name="z" type="prismatic"><parent link="trolley"/><child link="ball"/><axis xyz="0 0 1"/>
    <limit lower="-{reach_m}" upper="{reach_m}" velocity="1" effort="1"/></joint>
</robot>"#
    )
}

/// Returns a cart on a rail with an arm in the plane z = 0.3 and a hand of a palm and two fingers; the gripper frame lies
/// between the fingers, z forwards. Four joints: slide, turn, elbow, wrist.
pub fn plane_arm() -> String {
    arm(&ArmParts {
        rail: r#"<link name="rail"><collision><geometry><box size="2 0.02 0.02"/></geometry></collision></link>"#,
        lower: r#"<cylinder radius="0.03" length="0.3"/>"#,
        turn_rad: 2.9,
        elbow_rad: 2.9,
        wrist: r#"<joint name="wrist" type="revolute"><parent link="lower"/><child link="flange"/><origin xyz="0.3 0 0"/>
    <axis xyz="0 0 1"/><limit lower="-2" upper="2" velocity="1" effort="1"/></joint>"#,
        fin: "",
    })
}

/// Returns the arm of [`plane_arm`] without the rail's geometry and with a hand that rolls by ±`roll_rad`, in radians, about
/// its approach direction. Five joints: slide, turn, elbow, bend, roll. An optional fin breaks the symmetry of the hand.
pub fn rolling_arm(roll_rad: f64, has_fin: bool) -> String {
    let wrist = format!(
        r#"<link name="wrist"/>
  <joint name="bend" type="revolute"><parent link="lower"/><child link="wrist"/><origin xyz="0.3 0 0"/>
    <axis xyz="0 0 1"/><limit lower="-2" upper="2" velocity="1" effort="1"/></joint>
  <joint name="roll" type="revolute"><parent link="wrist"/><child link="flange"/>
    <axis xyz="1 0 0"/><limit lower="-{roll_rad}" upper="{roll_rad}" velocity="1" effort="1"/></joint>"#
    );
    let fin = r#"<collision><origin xyz="0.06 0 0.1"/><geometry><box size="0.04 0.02 0.15"/></geometry></collision>"#;
    arm(&ArmParts {
        rail: r#"<link name="rail"/>"#,
        lower: r#"<capsule radius="0.03" length="0.3"/>"#,
        turn_rad: 2.8,
        elbow_rad: 2.6,
        wrist: &wrist,
        fin: if has_fin { fin } else { "" },
    })
}

/// Variable elements of the arms.
struct ArmParts<'a> {
    rail: &'a str,
    /// Geometry of the lower arm.
    lower: &'a str,
    turn_rad: f64,
    elbow_rad: f64,
    /// Joints from the lower arm to the flange.
    wrist: &'a str,
    /// Additional geometry of the palm.
    fin: &'a str,
}

fn arm(parts: &ArmParts) -> String {
    let ArmParts { rail, lower, turn_rad, elbow_rad, wrist, fin } = parts;
    format!(
        r#"<robot name="arm">
  {rail}
  <link name="cart"><collision><geometry><box size="0.2 0.2 0.1"/></geometry></collision></link>
  <link name="upper"><collision><origin xyz="0.15 0 0" rpy="0 1.5707963267948966 0"/>
    <geometry><capsule radius="0.03" length="0.3"/></geometry></collision></link>
  <link name="lower"><collision><origin xyz="0.15 0 0" rpy="0 1.5707963267948966 0"/>
    <geometry>{lower}</geometry></collision></link>
  <joint name="slide" type="prismatic"><parent link="rail"/><child link="cart"/><axis xyz="1 0 0"/>
    <limit lower="-1" upper="1" velocity="1" effort="1"/></joint>
  <joint name="turn" type="revolute"><parent link="cart"/><child link="upper"/><origin xyz="0 0 0.3"/>
    <axis xyz="0 0 1"/><limit lower="-{turn_rad}" upper="{turn_rad}" velocity="1" effort="1"/></joint>
  <joint name="elbow" type="revolute"><parent link="upper"/><child link="lower"/><origin xyz="0.3 0 0"/>
    <axis xyz="0 0 1"/><limit lower="-{elbow_rad}" upper="{elbow_rad}" velocity="1" effort="1"/></joint>
  {wrist}
  <link name="flange"/>
  <joint name="mount" type="fixed"><parent link="flange"/><child link="palm"/></joint>
  <link name="palm"><collision><origin xyz="0.06 0 0"/>
    <geometry><box size="0.04 0.12 0.05"/></geometry></collision>{fin}</link>
  <link name="left_finger"><collision><geometry><box size="0.05 0.01 0.02"/></geometry></collision></link>
  <link name="right_finger"><collision><geometry><box size="0.05 0.01 0.02"/></geometry></collision></link>
  <link name="gripper"/>
  <joint name="left" type="fixed"><parent link="palm"/><child link="left_finger"/>
    <origin xyz="0.105 0.045 0"/></joint>
  <joint name="right" type="fixed"><parent link="palm"/><child link="right_finger"/>
    <origin xyz="0.105 -0.045 0"/></joint>
  <joint name="grasp" type="fixed"><parent link="palm"/><child link="gripper"/>
    <origin xyz="0.105 0 0" rpy="0 1.5707963267948966 0"/></joint>
</robot>"#
    )
}
