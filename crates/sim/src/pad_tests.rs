//! Pads that yield against statics: where an object slips on them, turns on them, and is squeezed out.

use cranny_grasp::{BoxHand, PadRectangle, limit_factor};
use cranny_shape::{Solid, Surface, TriangleSoup};
use cranny_spatial::nalgebra::{Matrix3, Vector3};
use cranny_spatial::{Point, Pose, Vector};
use rapier3d_f64::prelude::{PhysicsWorld, RigidBodyBuilder, RigidBodyHandle};

use crate::compliant_pads::{CompliantPads, spring_tips};
use crate::grasping::grasp_test::whole_steps;
use crate::gripper::{Gripper, HandModel};
use crate::{Physics, Piece, PieceShape, engine};

const MASS_KG: f64 = 0.3;

/// A hand that closes on a cuboid, without gravity.
struct Setup {
    hand: HandModel,
    physics: Physics,
    surface: Surface,
    half_m: [f64; 3],
    friction: f64,
}

impl Setup {
    fn new(soup: &TriangleSoup, half_m: [f64; 3], friction: f64, closing_force_n: f64) -> Self {
        let open = BoxHand { closing_force_n, ..BoxHand::default() };
        let mut hand = open.hand().unwrap();
        hand.pads =
            Some(PadRectangle { middle_m: [0.0, open.tip_ahead_m - 0.01], half_m: [0.00875, 0.00925] });
        let hand = HandModel::new(&hand).unwrap();
        Self { hand, physics: Physics::default(), surface: Surface::new(soup).unwrap(), half_m, friction }
    }

    fn cuboid(half_m: [f64; 3], friction: f64, closing_force_n: f64) -> Self {
        Self::new(&Surface::cuboid_soup(&half_m.into()), half_m, friction, closing_force_n)
    }

    fn inertia(&self) -> Matrix3<f64> {
        let square = |axis: usize| 4.0 * self.half_m[axis] * self.half_m[axis];
        let about = |a: usize, b: usize| MASS_KG * (square(a) + square(b)) / 12.0;
        Matrix3::from_diagonal(&Vector::new(about(1, 2), about(0, 2), about(0, 1)))
    }

    /// Closes for one second on the object with its frame at a pose in the gripper's; then a wrench acts on its centre of
    /// mass, which may grow in time. Returns the poses in the hand after each step since then.
    fn run(
        &self,
        gripper_from_object: Pose,
        seconds: f64,
        wrench: impl Fn(f64) -> (Vector, Vector),
    ) -> Vec<Pose> {
        let mut world = engine::world(&self.physics);
        world.gravity = engine::vector(&Vector::zeros());
        let force_n = self.hand.closing_force_n;
        let gripper = Gripper::insert(&self.hand, &self.physics, force_n, &Pose::identity(), &mut world);
        let object = self.insert(&gripper_from_object, &mut world);
        let pads = self.hand.pads.unwrap();
        let inertial = (MASS_KG, self.inertia(), Point::origin());
        let mut pads_of = CompliantPads::new(&pads, (&self.surface, self.friction), inertial);
        let steps = |seconds: f64| whole_steps(seconds, self.physics.step_s);
        let mut poses = Vec::new();
        for step in 0..steps(1.0 + seconds) {
            let time_s = f64::from(step) * self.physics.step_s;
            gripper.drive(&mut world, 0.1 * time_s);
            let body = &mut world.bodies[object];
            body.reset_forces(true);
            body.reset_torques(true);
            if time_s >= 1.0 {
                let (force, torque) = wrench(time_s - 1.0);
                body.add_force(engine::vector(&force), true);
                body.add_torque(engine::vector(&torque), true);
                poses.push(engine::to_pose(body.position()));
            }
            pads_of.press(&mut world, &gripper, object);
            engine::step(&mut world, false);
        }
        poses
    }

    fn insert(&self, pose: &Pose, world: &mut PhysicsWorld) -> RigidBodyHandle {
        let pieces = [Piece { body_from_piece: Pose::identity(), shape: PieceShape::Cuboid(self.half_m) }];
        let body = RigidBodyBuilder::dynamic().can_sleep(false).pose(engine::pose(pose));
        let mass = engine::mass_properties(MASS_KG, &Point::origin(), &self.inertia());
        let body = world.insert_body(body.additional_mass_properties(mass));
        for collider in engine::colliders("object", &pieces, self.friction, engine::OBJECT).unwrap() {
            world.insert_collider(collider, Some(body));
        }
        body
    }

    /// Time at which an object that is loaded ever more begins to move by 1 mm/s or to turn by 0.1 rad/s, in seconds.
    fn slips_at(&self, gripper_from_object: Pose, wrench: impl Fn(f64) -> (Vector, Vector)) -> f64 {
        let poses = self.run(gripper_from_object, 3.0, wrench);
        let moved = |pair: &[Pose]| {
            let by = pair[0].inverse() * pair[1];
            // Springs yield by less in a step.
            by.translation.vector.norm() > 2e-6 || by.rotation.angle() > 2e-4
        };
        let step = poses.windows(2).position(moved).expect("it slips");
        step as f64 * self.physics.step_s
    }
}

/// Force of 24 cells that a pad bears at most under a pull and a turn about its middle, as a factor on these.
fn factor(setup: &Setup, pull: Vector3<f64>) -> f64 {
    let pads = setup.hand.pads.unwrap();
    let tips = spring_tips(&pads, 0.0);
    let load = setup.hand.closing_force_n / tips.len() as f64;
    let points: Vec<_> =
        tips.iter().map(|tip| ([tip.x - pads.middle_m[0], tip.z - pads.middle_m[1]], load)).collect();
    setup.friction * limit_factor(&points, pull, Vector3::zeros(), 0.0)
}

#[test]
fn a_block_slips_where_the_limit_surface_ends() {
    for (friction, force_n) in [(0.3, 20.0), (0.6, 40.0), (0.35, 70.0)] {
        let setup = Setup::cuboid([0.05, 0.02, 0.015], friction, force_n);
        let middle = setup.hand.pads.unwrap().middle_m;
        let at = Pose::translation(middle[0], 0.0, middle[1]);
        for (pull_n, turn_nm) in [(1.0, 0.0), (0.0, 0.01), (1.0, 0.003), (0.3, 0.01)] {
            // Each pad bears half; a turn from x to z is opposite to the turn about y.
            let expected = factor(&setup, Vector3::new(0.5 * pull_n, 0.0, 0.5 * turn_nm));
            let rate = 0.5 * expected;
            let slips_s = setup.slips_at(at, |time_s| {
                (Vector::x() * (rate * time_s * pull_n), -Vector::y() * (rate * time_s * turn_nm))
            });
            let ratio = rate * slips_s / expected;
            assert!((ratio - 1.0).abs() < 0.04, "{friction} {force_n} N, {pull_n} {turn_nm}: {ratio:.3}");
        }
    }
}

/// A cuboid, and a cylinder along z as a prism.
fn shapes() -> Vec<(&'static str, TriangleSoup)> {
    let cylinder = Solid::cylinder(0.015, 0.02).unwrap().tessellation().unwrap();
    vec![("cuboid", Surface::cuboid_soup(&Vector::new(0.05, 0.02, 0.015))), ("cylinder", cylinder)]
}

/// Coulomb's law for an object that slides: the friction is that at the onset.
#[test]
fn what_slides_is_slowed_by_friction() {
    let (friction, force_n) = (0.35, 40.0);
    for (name, soup) in shapes() {
        let setup = Setup::new(&soup, [0.05, 0.02, 0.015], friction, force_n);
        let middle = setup.hand.pads.unwrap().middle_m;
        let at = Pose::translation(middle[0], 0.0, middle[1]);
        let most_n = 2.0 * friction * force_n;
        for share in [1.1, 1.5, 3.0] {
            let poses = setup.run(at, 0.2, |_| (Vector::z() * (share * most_n), Vector::zeros()));
            let z = |step: usize| poses[step].translation.vector.z;
            // While the whole pad is on the object.
            let steps = (0..poses.len()).find(|step| z(*step) - z(0) > 0.004).unwrap();
            let time_s = steps as f64 * setup.physics.step_s;
            let found = 2.0 * (z(steps) - z(0)) / (time_s * time_s);
            let expected = (share - 1.0) * most_n / MASS_KG;
            assert!(
                (found / expected - 1.0).abs() < 0.07,
                "{name} {share}: {found:.2} of {expected:.2} m/s²"
            );
        }
    }
}

/// A wedge whose sides are steeper than friction holds is squeezed out, a flatter one stays.
#[test]
fn a_wedge_is_squeezed_out_where_its_slope_exceeds_friction() {
    for (slope, stays) in [(0.25, true), (0.45, false)] {
        let mut soup = Surface::cuboid_soup(&Vector::new(0.05, 0.02, 0.015));
        for corner in &mut soup.vertices {
            corner.y *= 1.0 - slope * corner.z / 0.02;
        }
        let setup = Setup::new(&soup, [0.05, 0.02, 0.015], 0.35, 40.0);
        let middle = setup.hand.pads.unwrap().middle_m;
        let poses = setup
            .run(Pose::translation(middle[0], 0.0, middle[1]), 0.5, |_| (Vector::zeros(), Vector::zeros()));
        let moved_m = (poses[0].translation.vector.z - middle[1]).abs();
        assert_eq!(moved_m < 2e-3, stays, "slope {slope}: moved by {moved_m} m while the hand closed");
    }
}
