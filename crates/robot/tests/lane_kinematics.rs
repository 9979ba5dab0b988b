//! Forward kinematics in lanes: within its bound of that in double precision, for any robot.

use std::fmt::Write as _;

use cranny_robot::{LaneFrame, LaneKinematics, Robot, RobotOptions};
use cranny_spatial::{LANES, LaneArray, Point, Stream, Vector, simd_level};
use fearless_simd::dispatch;

/// Returns a chain of random joints: turns of up to a hundred radians, slides, gears, long and short links, distant roots.
fn random_chain(random: &mut Stream) -> Robot {
    let size_m = 10_f64.powf(random.uniform_between(-2.0, 1.5));
    let turn_rad = 10_f64.powf(random.uniform_between(0.0, 2.5));
    let mut urdf = String::from(r#"<robot name="chain"><link name="l0"/>"#);
    let count = 1 + random.index(12);
    for joint in 1..=count {
        let mut draw = |range: f64| random.uniform_between(-range, range);
        let xyz = |v: [f64; 3]| format!("{} {} {}", v[0], v[1], v[2]);
        let origin = xyz([draw(size_m), draw(size_m), draw(size_m)]);
        let turn = xyz([draw(3.0), draw(1.5), draw(3.0)]);
        let axis = xyz([draw(1.0), draw(1.0), draw(1.0)]);
        let kind = random.index(4);
        let (kind, limit, mimic) = match kind {
            0 => ("prismatic", size_m, String::new()),
            1 if joint > 1 => {
                let gear = random.uniform_between(-3.0, 3.0);
                ("revolute", 1e6, format!(r#"<mimic joint="j1" multiplier="{gear}" offset="{gear}"/>"#))
            }
            _ => ("revolute", turn_rad, String::new()),
        };
        let parent = joint - 1;
        let _ = write!(
            urdf,
            r#"<link name="l{joint}"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
<joint name="j{joint}" type="{kind}"><parent link="l{parent}"/><child link="l{joint}"/>
<origin xyz="{origin}" rpy="{turn}"/><axis xyz="{axis}"/>
<limit lower="-{limit}" upper="{limit}" velocity="1" effort="1"/>{mimic}</joint>"#
        );
    }
    urdf += "</robot>";
    Robot::from_urdf_text(&urdf, "chain.urdf", None, &RobotOptions::default()).expect("a good URDF")
}

/// Guards against bounds that are valid only for ordinary angles: the lanes were off by 22 mm for an arm at 10⁶ rad, and by
/// 50 µm for one with a gear ratio of 1000.
#[test]
fn lanes_are_no_farther_off_than_their_bound_says() {
    let mut random = Stream::new(14, 0);
    let (mut tightest, mut bounded) = (f64::INFINITY, 0);
    for _ in 0..300 {
        let robot = random_chain(&mut random);
        let kinematics = LaneKinematics::new(&robot);
        let mut lane_frames = vec![LaneFrame::IDENTITY; kinematics.frame_count()];
        let mut frames = robot.frames();
        let rows: Vec<Vec<f64>> = (0..LANES).map(|_| robot.random_configuration(&mut random)).collect();
        #[allow(clippy::cast_possible_truncation, reason = "single precision is what is meant")]
        let q: Vec<LaneArray> =
            (0..robot.dof()).map(|joint| std::array::from_fn(|lane| rows[lane][joint] as f32)).collect();
        dispatch!(simd_level(), simd => kinematics.forward(simd, &q, &[], &mut lane_frames));
        for (lane, row) in rows.iter().enumerate() {
            robot.forward_kinematics(row, &mut frames);
            for link in 0..robot.links().len() {
                let placement = kinematics.placement(link);
                let from_frame = Vector::new(0.3, -0.2, 0.5);
                let bound_m = kinematics.position_error_m(placement.frame, from_frame.norm());
                if bound_m.is_infinite() {
                    continue;
                }
                bounded += 1;
                let frame = &lane_frames[placement.frame];
                let in_lanes = Vector::from_fn(|row, _| {
                    let axis = |axis: usize| f64::from(frame.axes[axis][row][lane]) * from_frame[axis];
                    axis(0) + axis(1) + axis(2) + f64::from(frame.origin[row][lane])
                });
                let exact =
                    frames.link(link) * (placement.frame_from_link.inverse() * Point::from(from_frame));
                let error_m = (exact.coords - in_lanes).norm();
                assert!(error_m <= bound_m, "{error_m} m off, bound {bound_m} m");
                if error_m > 1e-7 {
                    tightest = tightest.min(bound_m / error_m);
                }
            }
        }
    }
    assert!(bounded > 10_000, "most have a bound: {bounded}");
    assert!(tightest < 10.0, "a bound far from any error says little: {tightest}");
}
