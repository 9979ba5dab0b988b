//! Coulomb's law: slip begins where the pull exceeds μ times the normal force, on a plane and between rigid fingers.

use cranny_grasp::BoxHand;
use cranny_spatial::nalgebra::Matrix3;
use cranny_spatial::{Point, Pose, Rotation, Vector};
use rapier3d_f64::prelude::{PhysicsWorld, RigidBodyBuilder, RigidBodyHandle};

use crate::gripper::{Gripper, HandModel};
use crate::rolling::Rolling;
use crate::{Physics, Piece, PieceShape, engine};

/// Inserts a cuboid of 4 cm and 200 g with this friction as the object.
fn cube(world: &mut PhysicsWorld, friction: f64) -> RigidBodyHandle {
    let pieces = [Piece { body_from_piece: Pose::identity(), shape: PieceShape::Cuboid([0.02; 3]) }];
    let body = world.insert_body(RigidBodyBuilder::dynamic().can_sleep(false).additional_mass(0.2));
    for mut collider in engine::colliders("cube", &pieces, friction, engine::OBJECT).unwrap() {
        collider.set_mass(0.0);
        world.insert_collider(collider, Some(body));
    }
    body
}

/// Simulates until the cube has moved at 1 mm/s for 0.1 s, and returns the time at which that began (s).
fn slip_begins(
    world: &mut PhysicsWorld,
    cube: RigidBodyHandle,
    physics: &Physics,
    limit_s: f64,
    mut before_step: impl FnMut(&mut PhysicsWorld, f64),
) -> Option<f64> {
    let (mut time_s, mut slow_s) = (0.0, 0.0);
    while time_s < limit_s {
        before_step(world, time_s);
        engine::step(world, false);
        time_s += physics.step_s;
        let moves = world.bodies[cube].linvel().length() > 1e-3 && time_s > 0.5;
        slow_s = if moves { slow_s + physics.step_s } else { 0.0 };
        if slow_s > 0.1 {
            return Some(time_s - slow_s);
        }
    }
    None
}

#[test]
fn on_a_plane_that_tilts_slip_begins_at_the_angle_of_friction() {
    let physics = Physics::default();
    for friction in [0.1, 0.24, 0.5, 0.9] {
        let mut world = engine::world(&physics);
        let floor =
            Piece { body_from_piece: Pose::translation(0.0, 0.0, -0.02), shape: PieceShape::HalfSpace };
        for collider in engine::colliders("floor", &[floor], 0.0, engine::SURROUNDINGS).unwrap() {
            world.insert_collider(collider, None);
        }
        let cube = cube(&mut world, friction);
        // The tilt is slow, because it continues until the slip is detected.
        let expected = f64::atan(friction);
        let angle = |time_s: f64| expected * (0.9 + 0.05 * time_s);
        let begun_s = slip_begins(&mut world, cube, &physics, 30.0, |world, time_s| {
            let tilt = Rotation::from_axis_angle(&Vector::y_axis(), angle(time_s));
            world.gravity = engine::vector(&(tilt.inverse() * Vector::new(0.0, 0.0, -physics.gravity)));
        });
        let ratio = angle(begun_s.expect("it slips")).tan() / friction;
        assert!((ratio - 1.0).abs() < 0.02, "friction {friction}: slip at {ratio:.4} of it");
    }
}

#[test]
fn in_a_hand_slip_begins_at_twice_the_friction_times_the_closing_force() {
    let physics = Physics::default();
    for (friction, closing_force_n) in [(0.24, 5.0), (0.24, 70.0), (0.5, 20.0), (0.9, 40.0)] {
        let hand = BoxHand { closing_force_n, ..BoxHand::default() }.hand().unwrap();
        let model = HandModel::with_pads(&hand, None).unwrap();
        let mut world = engine::world(&physics);
        world.gravity = engine::vector(&Vector::zeros());
        let gripper = Gripper::insert(&model, &physics, closing_force_n, &Pose::identity(), &mut world);
        let cube = cube(&mut world, friction);
        let limit_n = 2.0 * friction * closing_force_n;
        // The hand closes for one second; then the pull grows to 1.5 times the limit within two seconds.
        let pull_n = |time_s: f64| 0.75 * limit_n * (time_s - 1.0).max(0.0);
        let mut pressed_n = 0.0;
        let begun_s = slip_begins(&mut world, cube, &physics, 3.0, |world, time_s| {
            gripper.drive(world, 0.1 * time_s);
            if (time_s - 1.0).abs() < physics.step_s {
                let pressures = gripper.pressures(world, cube);
                pressed_n = 0.5 * pressures.iter().map(|pressure| pressure.expect("it touches")).sum::<f64>();
            }
            let body = &mut world.bodies[cube];
            body.reset_forces(true);
            body.add_force(engine::vector(&Vector::new(0.0, 0.0, pull_n(time_s))), true);
        });
        let ratio = pull_n(begun_s.expect("it slips")) / limit_n;
        assert!(
            (ratio - 1.0).abs() < 0.02,
            "{friction}, {closing_force_n} N: slip at {ratio:.4} of the limit"
        );
        let ratio = pressed_n / closing_force_n;
        assert!((ratio - 1.0).abs() < 0.02, "{closing_force_n} N: pressed with {pressed_n} N");
    }
}

/// Two equally loaded ends of an edge, pulled sideways by a share of the friction limit: the remaining friction of the ends
/// resists turning. The ends bear all load, as in every point-based engine; a line of even pressure would turn at half that
/// moment. The unmodified engine resists more than 1.5 times that moment, with and without a pull.
#[test]
fn pads_on_their_edges_turn_at_what_the_ends_of_the_edges_hold() {
    let physics = Physics::default();
    let (friction, closing_force_n) = (0.5, 40.0);
    for (pulled_share, most) in [(0.0, 1.06), (0.5, 1.25)] {
        let open = BoxHand { closing_force_n, ..BoxHand::default() };
        let mut hand = open.hand().unwrap();
        // The tips are inclined by one degree, so that the pads are 0.5 mm off the cube at its end.
        for finger in hand.fingers.clone() {
            let tip =
                Pose::translation(0.0, -0.5 * open.opening_m * finger.stroke_m.y.signum(), open.tip_ahead_m);
            let tilt = Rotation::from_axis_angle(
                &Vector::x_axis(),
                -finger.stroke_m.y.signum() * 1_f64.to_radians(),
            );
            for part in finger.parts {
                hand.parts[part].0 =
                    tip * Pose::from_parts(Vector::zeros().into(), tilt) * tip.inverse() * hand.parts[part].0;
            }
        }
        let model = HandModel::with_pads(&hand, None).unwrap();
        let mut world = engine::world(&physics);
        world.gravity = engine::vector(&Vector::zeros());
        let gripper = Gripper::insert(&model, &physics, closing_force_n, &Pose::identity(), &mut world);
        let cube = cube(&mut world, friction);
        let pull_n = pulled_share * 2.0 * friction * closing_force_n;
        let limit_nm = (1.0 - pulled_share) * 2.0 * friction * closing_force_n * 0.5 * open.finger_width_m;
        let turn_nm = |time_s: f64| 0.75 * limit_nm * (time_s - 1.0).max(0.0);
        let edge = engine::vector(&Vector::new(0.0, 0.0, open.tip_ahead_m));
        let turn_begins_s = (0..1500).map(|step| f64::from(step) * physics.step_s).find(|&time_s| {
            gripper.drive(&mut world, 0.1 * time_s);
            let body = &mut world.bodies[cube];
            body.reset_forces(true);
            body.reset_torques(true);
            let ramp = (2.0 * (time_s - 0.5)).clamp(0.0, 1.0);
            body.add_force_at_point(engine::vector(&Vector::new(0.0, 0.0, ramp * pull_n)), edge, true);
            body.add_torque(engine::vector(&Vector::new(0.0, turn_nm(time_s), 0.0)), true);
            let are_faces = gripper.bears_on_faces(&world, cube);
            engine::step(&mut world, are_faces);
            time_s > 1.0 && world.bodies[cube].angvel().y > 0.05
        });
        let ratio = turn_nm(turn_begins_s.expect("it turns")) / limit_nm;
        assert!(
            (0.95..most).contains(&ratio),
            "pulled by {pulled_share} of the limit: turns at {ratio:.3} of what is left"
        );
    }
}

#[test]
fn what_falls_comes_to_rest_without_gaining_energy() {
    let physics = Physics::default();
    for (shape, rest_m) in [
        (PieceShape::Ball(0.03), 0.03),
        (PieceShape::Cuboid([0.02, 0.03, 0.025]), 0.025),
        (PieceShape::Cylinder(0.04, 0.02), 0.04),
        (PieceShape::Capsule(0.03, 0.02), 0.05),
    ] {
        let mut world = engine::world(&physics);
        let floor = Piece { body_from_piece: Pose::identity(), shape: PieceShape::HalfSpace };
        for collider in engine::colliders("floor", &[floor], 0.0, engine::SURROUNDINGS).unwrap() {
            world.insert_collider(collider, None);
        }
        let place = engine::pose(&Pose::translation(0.0, 0.0, rest_m + 0.02));
        let body = RigidBodyBuilder::dynamic().pose(place).can_sleep(false).additional_mass(0.2);
        let body = world.insert_body(body);
        let piece = Piece { body_from_piece: Pose::identity(), shape: shape.clone() };
        for collider in engine::colliders("object", &[piece], 0.5, engine::OBJECT).unwrap() {
            world.insert_collider(collider, Some(body));
        }
        let energy = |world: &PhysicsWorld| {
            let body = &world.bodies[body];
            0.2 * (physics.gravity * body.translation().z + 0.5 * body.linvel().length_squared())
        };
        let mut before = energy(&world);
        for _ in 0..1000 {
            engine::step(&mut world, false);
            let now = energy(&world);
            // Tolerance: elastic energy of the weight in a contact that yields by 0.01 mm.
            assert!(now <= before + 2e-5, "{shape:?}: {before} J, then {now} J");
            before = now;
        }
        let height_m = world.bodies[body].translation().z;
        assert!((height_m - rest_m).abs() < 5e-4, "{shape:?}: rests at {height_m} m");
    }
}

/// A ball on an incline rolls exactly if the horizontal offset of its weight from the contact point exceeds the resistance arm.
#[test]
fn a_ball_rolls_where_the_slope_exceeds_the_resistance_by_its_radius() {
    let (radius_m, arm_m) = (0.03, 3e-4);
    let physics = Physics::default();
    let rolling = Rolling {
        arm_m,
        mass_kg: 0.1,
        inertia_kg_m2: Matrix3::identity() * (0.4 * 0.1 * radius_m * radius_m),
        center: Point::origin(),
    };
    for (share, stays) in [(0.8, true), (1.25, false)] {
        let mut world = engine::world(&physics);
        let slope = Rotation::from_axis_angle(&Vector::y_axis(), f64::atan(share * arm_m / radius_m));
        world.gravity = engine::vector(&(slope.inverse() * Vector::new(0.0, 0.0, -physics.gravity)));
        let floor = Piece { body_from_piece: Pose::identity(), shape: PieceShape::HalfSpace };
        for collider in engine::colliders("floor", &[floor], 0.0, engine::SURROUNDINGS).unwrap() {
            world.insert_collider(collider, None);
        }
        let inertia = engine::mass_properties(0.1, &Point::origin(), &rolling.inertia_kg_m2);
        let body = RigidBodyBuilder::dynamic()
            .pose(engine::pose(&Pose::translation(0.0, 0.0, radius_m)))
            .can_sleep(false)
            .additional_mass_properties(inertia);
        let body = world.insert_body(body);
        let piece = Piece { body_from_piece: Pose::identity(), shape: PieceShape::Ball(radius_m) };
        for collider in engine::colliders("ball", &[piece], 0.5, engine::OBJECT).unwrap() {
            world.insert_collider(collider, Some(body));
        }
        for _ in 0..1000 {
            rolling.resist(&mut world, body);
            engine::step(&mut world, false);
        }
        let rolled_m = world.bodies[body].translation().x.abs();
        assert_eq!(rolled_m < 5e-4, stays, "{share} of the slope: rolled {rolled_m} m");
    }
}
/// Column of 70 cm, held 18 cm from its middle with its axis up to 15° off the vertical: face contacts prevent creep.
#[test]
fn a_column_stays_where_a_hand_holds_it() {
    let physics = Physics::default();
    let (mass_kg, half, closing_force_n) = (0.15, [0.35, 0.03, 0.035], 40.0);
    let hand = BoxHand { closing_force_n, ..BoxHand::default() }.hand().unwrap();
    let model = HandModel::with_pads(&hand, None).unwrap();
    let square = |axis: usize| 4.0 * half[axis] * half[axis];
    let about = |a: usize, b: usize| mass_kg * (square(a) + square(b)) / 12.0;
    let inertia = Matrix3::from_diagonal(&Vector::new(about(1, 2), about(0, 2), about(0, 1)));
    for tilt_deg in [0.0, 5.0, 15.0] {
        let mut world = engine::world(&physics);
        let gripper = Gripper::insert(&model, &physics, closing_force_n, &Pose::identity(), &mut world);
        let pieces = [Piece { body_from_piece: Pose::identity(), shape: PieceShape::Cuboid(half) }];
        let column = RigidBodyBuilder::dynamic()
            .can_sleep(false)
            .pose(engine::pose(&Pose::translation(0.18, 0.0, 0.0)))
            .additional_mass_properties(engine::mass_properties(mass_kg, &Point::origin(), &inertia));
        let column = world.insert_body(column);
        for mut collider in engine::colliders("column", &pieces, 0.35, engine::OBJECT).unwrap() {
            collider.set_mass(0.0);
            world.insert_collider(collider, Some(column));
        }
        let down = Rotation::from_axis_angle(&Vector::z_axis(), f64::to_radians(tilt_deg)) * Vector::x();
        let mut pose_after = |steps: u32| {
            for step in 0..steps {
                let time_s = f64::from(step) * physics.step_s;
                // The weight acts once the column is held.
                let gravity = if time_s > 0.8 || steps < 1000 { physics.gravity } else { 0.0 };
                world.gravity = engine::vector(&(down * gravity));
                gripper.drive(&mut world, 0.1);
                let are_faces = gripper.bears_on_faces(&world, column);
                engine::step(&mut world, are_faces);
            }
            engine::to_pose(world.bodies[column].position())
        };
        let (held, later) = (pose_after(1000), [(); 4].map(|()| pose_after(500))[3]);
        let crept = held.inverse() * later;
        let (crept_m, turned) = (crept.translation.vector.norm(), crept.rotation.angle().to_degrees());
        assert!(crept_m < 1e-3 && turned < 0.35, "{tilt_deg}°: crept by {crept_m} m and {turned}°");
    }
}
