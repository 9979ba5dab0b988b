//! Joint forces against Lagrange's equations by finite differences, and bounds on their change.

use cranny_robot::{Dynamics, Inertial, PathForces, Robot, RobotOptions};
use cranny_spatial::nalgebra::Matrix3;
use cranny_spatial::{Point, Stream, Vector};

/// A slide, three revolute joints, one of which mimics another at half its rate, and a bare frame between them.
const ARM: &str = r#"<robot name="arm">
<link name="base"/>
<link name="a"><inertial><origin xyz="0.1 0 0.05" rpy="0.3 0 0"/><mass value="3"/><inertia ixx="0.03" iyy="0.02" izz="0.04" ixy="0.002" ixz="0" iyz="0"/></inertial></link>
<link name="b"><inertial><origin xyz="0.2 0.05 0"/><mass value="2"/><inertia ixx="0.01" iyy="0.05" izz="0.05" ixy="0" ixz="0.001" iyz="0"/></inertial></link>
<link name="frame"/>
<link name="c"><inertial><origin xyz="0 0.1 0.1"/><mass value="1"/><inertia ixx="0.01" iyy="0.01" izz="0.005" ixy="0" ixz="0" iyz="0.001"/></inertial></link>
<link name="d"><inertial><origin xyz="0.1 0 0"/><mass value="0.5"/><inertia ixx="0.001" iyy="0.002" izz="0.002" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="turn" type="revolute"><parent link="base"/><child link="a"/><axis xyz="0 0 1"/><limit lower="-3" upper="3" velocity="2" effort="50"/></joint>
<joint name="lift" type="prismatic"><parent link="a"/><child link="b"/><origin xyz="0.1 0 0.3" rpy="0 0.4 0"/><axis xyz="0 0.6 0.8"/><limit lower="-0.5" upper="0.5" velocity="1" effort="90"/></joint>
<joint name="fixed" type="fixed"><parent link="b"/><child link="frame"/><origin xyz="0.4 0 0" rpy="0.5 0 0"/></joint>
<joint name="bend" type="revolute"><parent link="frame"/><child link="c"/><axis xyz="0 1 0"/><limit lower="-2" upper="2" velocity="2" effort="20"/></joint>
<joint name="follow" type="revolute"><parent link="c"/><child link="d"/><origin xyz="0 0 0.3"/><axis xyz="1 0 0"/><mimic joint="bend" multiplier="-0.5" offset="0.2"/><limit lower="-2" upper="2" velocity="2" effort="20"/></joint>
</robot>"#;

const UP: [f64; 3] = [0.6, 0.0, 0.8];

fn robot_of(urdf: &str) -> Robot {
    Robot::from_urdf_text(urdf, "arm.urdf", None, &RobotOptions::default()).unwrap()
}

fn arm() -> Robot {
    robot_of(ARM)
}

fn held() -> Inertial {
    Inertial {
        mass_kg: 0.7,
        center: Point::new(0.05, 0.02, 0.1),
        inertia_kg_m2: Matrix3::new(0.004, 0.0005, 0.0, 0.0005, 0.003, 0.0, 0.0, 0.0, 0.002),
    }
}

/// Centre, rotation, mass and inertia of each link with mass.
fn bodies(robot: &Robot, q: &[f64]) -> Vec<(Vector, Matrix3<f64>, Inertial)> {
    let frames = robot.frames_at(q);
    let of_links = robot.links().iter().enumerate().filter_map(|(link, of)| Some((link, of.inertial?)));
    let all = of_links.chain([(robot.tip(), held())]);
    let placed = all.map(|(link, inertial)| {
        let pose = frames.link(link);
        ((pose * inertial.center).coords, pose.rotation.to_rotation_matrix().into_inner(), inertial)
    });
    placed.collect()
}

const STEP: f64 = 1e-4;

fn moved(q: &[f64], rate: &[f64], by: f64) -> Vec<f64> {
    q.iter().zip(rate).map(|(q, rate)| q + by * rate).collect()
}

/// Returns kinetic minus potential energy, from finite differences of positions and rotations.
fn lagrangian(robot: &Robot, q: &[f64], rate: &[f64]) -> f64 {
    let [before, now, after] = [-STEP, 0.0, STEP].map(|by| bodies(robot, &moved(q, rate, by)));
    let up = Vector::from(UP);
    let of_body = |index: usize| {
        let (center, turn, inertial) = &now[index];
        let velocity = (after[index].0 - before[index].0) / (2.0 * STEP);
        let spin = (after[index].1 - before[index].1) / (2.0 * STEP) * turn.transpose();
        let omega = Vector::new(
            spin[(2, 1)] - spin[(1, 2)],
            spin[(0, 2)] - spin[(2, 0)],
            spin[(1, 0)] - spin[(0, 1)],
        ) * 0.5;
        let inertia = turn * inertial.inertia_kg_m2 * turn.transpose();
        0.5 * inertial.mass_kg * velocity.norm_squared() + 0.5 * omega.dot(&(inertia * omega))
            - inertial.mass_kg * 9.81 * up.dot(center)
    };
    (0..now.len()).map(of_body).sum()
}

#[test]
fn forces_are_those_of_lagrange_s_equations() {
    let robot = arm();
    let dynamics = Dynamics::new(&robot, &Vector::from(UP), Some(held())).unwrap();
    let (mut random, mut frames) = (Stream::new(5, 0), robot.frames());
    let dof = robot.dof();
    for _ in 0..20 {
        let mut draw =
            |most: f64| (0..dof).map(|_| random.uniform_between(-most, most)).collect::<Vec<f64>>();
        let (q, rate, acceleration) = (draw(0.4), draw(1.5), draw(2.0));
        let forces = robot.path_forces(&dynamics, [&q, &rate, &acceleration], &mut frames);
        // Lagrange's equations along q(t) with these derivatives: d/dt ∂L/∂q' − ∂L/∂q.
        let h = 1e-3;
        for joint in 0..dof {
            let momentum = |time: f64| {
                let at: Vec<f64> =
                    (0..dof).map(|j| q[j] + time * rate[j] + 0.5 * time * time * acceleration[j]).collect();
                let with = |change: f64| {
                    let mut rate = moved(&rate, &acceleration, time);
                    rate[joint] += change;
                    lagrangian(&robot, &at, &rate)
                };
                (with(h) - with(-h)) / (2.0 * h)
            };
            let placed = |change: f64| {
                let mut q = q.clone();
                q[joint] += change;
                lagrangian(&robot, &q, &rate)
            };
            let expected = (momentum(h) - momentum(-h)) / (2.0 * h) - (placed(h) - placed(-h)) / (2.0 * h);
            let found = forces.bend[joint] + forces.weight[joint];
            assert!((found - expected).abs() < 2e-3 * (1.0 + expected.abs()), "{joint}: {found} {expected}");
        }
        // The coefficient of the acceleration is the term that is linear in it.
        let twice: Vec<f64> = acceleration.iter().zip(&rate).map(|(a, r)| a + 2.0 * r).collect();
        let faster = robot.path_forces(&dynamics, [&q, &rate, &twice], &mut frames);
        for joint in 0..dof {
            let linear = faster.bend[joint] - forces.bend[joint];
            assert!((linear - 2.0 * forces.inertia[joint]).abs() < 1e-9);
        }
    }
}

#[test]
fn bounds_on_their_change_hold_and_are_not_idle() {
    let robot = arm();
    let dynamics = Dynamics::new(&robot, &Vector::from(UP), Some(held())).unwrap();
    let (mut random, mut frames) = (Stream::new(6, 0), robot.frames());
    let dof = robot.dof();
    let mut nearest = 0.0_f64;
    for draw in 0..300 {
        let mut of = |most: f64| (0..dof).map(|_| random.uniform_between(-most, most)).collect::<Vec<f64>>();
        let most = if draw % 3 == 0 { 0.0 } else { 1.0 };
        let (q, first, second, third) = (of(0.4), of(1.5), of(most), of(most));
        let at = |s: f64| -> [Vec<f64>; 3] {
            let value = |j: usize| q[j] + s * first[j] + 0.5 * s * s * second[j] + s.powi(3) / 6.0 * third[j];
            let rate = |j: usize| first[j] + s * second[j] + 0.5 * s * s * third[j];
            let bend = |j: usize| second[j] + s * third[j];
            [(0..dof).map(value).collect(), (0..dof).map(rate).collect(), (0..dof).map(bend).collect()]
        };
        let step = 1e-5;
        let mut forces = |s: f64| -> PathForces {
            let [q, first, second] = at(s);
            robot.path_forces(&dynamics, [&q, &first, &second], &mut frames)
        };
        let [before, after] = [-step, step].map(&mut forces);
        let bounds = dynamics.changes(&robot, [&first, &second, &third]);
        let pairs = [
            (&before.inertia, &after.inertia, &bounds.inertia),
            (&before.bend, &after.bend, &bounds.bend),
            (&before.weight, &after.weight, &bounds.weight),
        ];
        for (before, after, bound) in pairs {
            for joint in 0..dof {
                let change = (after[joint] - before[joint]).abs() / (2.0 * step);
                assert!(change <= bound[joint] * (1.0 + 1e-3) + 1e-3, "{joint}: {change} {}", bound[joint]);
                nearest = nearest.max(change / bound[joint]);
            }
        }
    }
    assert!(nearest > 0.1, "the nearest comes to {nearest} of its bound");
}

#[test]
fn a_link_without_mass_is_named() {
    let shape = r#"<link name="c"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>"#;
    let begin = ARM.find(r#"<link name="c">"#).unwrap();
    let end = begin + ARM[begin..].find("</link>").unwrap() + "</link>".len();
    let text = format!("{}{shape}{}", &ARM[..begin], &ARM[end..]);
    let robot = robot_of(&text);
    assert_eq!(Dynamics::new(&robot, &Vector::z(), None).unwrap_err(), "c");
}
