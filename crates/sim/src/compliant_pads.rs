//! Pads that yield: each is a bed of springs, as the load of a grasp assumes it.
//!
//! The contacts of the engine are rigid, so that a pad bears on a few corners, which differ from engine to engine. Here each
//! cell of a pad is a spring whose tip sticks to the object or slides on it within the cone of friction. The forces of a step
//! are those at its end (linearly implicit), because the springs are stiffer than the step could follow otherwise.

use cranny_grasp::{PAD_CELLS, Pads, SOFT_PAD};
use cranny_shape::Surface;
use cranny_spatial::nalgebra::{Matrix3, SMatrix, SVector, Vector2};
use cranny_spatial::{Point, Pose, Rotation, Vector};
use rapier3d_f64::prelude::{PhysicsWorld, RigidBodyHandle};

use crate::engine;
use crate::gripper::{Gripper, PalmMotion};
use crate::spring_tip::{DEEPEST_M, Grip, Law, grip};

/// Distance ahead of a pad at which it may touch the object within a step, in metres.
const AHEAD_M: f64 = 1e-3;
/// Ratio of the stiffness of a spring along the pad to that across it. With that of rubber, a third, a long object would swing
/// on its pads at the frequency of the shake test.
const SHEAR_SHARE: f64 = 3.0;
/// Maximum number of Newton steps.
const MOST_STEPS: usize = 12;
/// Error of a velocity at which a step is solved, in m/s: the object creeps less.
const ACCURACY: f64 = 1e-6;
/// Number of halvings of a Newton step.
const SHORTER: i32 = 6;

/// Velocities: of the object's centre of mass, of its rotation, and of both fingers along their strokes.
type Velocities = SVector<f64, 8>;
type Square = SMatrix<f64, 8, 8>;

/// Two pads with the state of their springs.
#[derive(Clone, Debug)]
pub(crate) struct CompliantPads<'a> {
    surface: &'a Surface,
    friction: f64,
    mass_kg: f64,
    inertia_kg_m2: Matrix3<f64>,
    /// Centre of mass in the frame of the object.
    center: Point,
    /// Stiffness of a spring, in N/m.
    stiffness: f64,
    sides: [Side; 2],
    /// Forces of both pads on the object in the last step, in newtons.
    pub forces: [Vector; 2],
}

/// Springs of one pad.
#[derive(Clone, Debug)]
struct Side {
    /// Direction towards the other pad along y: 1 or −1.
    inward: f64,
    springs: Vec<Spring>,
}

/// A cell of a pad.
#[derive(Clone, Copy, Debug)]
struct Spring {
    /// Tip at rest, in the frame of the finger.
    rest: Point,
    /// Point and outward normal of the object at which the tip sticks, in the frame of the object.
    held: Option<(Point, Vector)>,
}

/// Springs in contact, prepared for a step.
struct Touches {
    springs: Vec<Touch>,
    frames: [PadFrame; 2],
}

/// A spring in contact, in the frame of its pad (along, along, inward).
struct Touch {
    side: usize,
    /// Tip relative to the object's centre of mass, in metres.
    arm: Vector,
    /// Velocity of the object relative to the pad from the prescribed motion of the palm alone, in m/s.
    of_palm: Vector,
    /// Deflection at the beginning of the step: along the pad, and depth.
    along: Vector2<f64>,
    depth_m: f64,
    /// Outward normal of the object.
    normal: Vector,
}

/// Frame of a pad.
#[derive(Clone, Copy)]
struct PadFrame {
    /// Its directions in the world, as rows: along, along, inward; right-handed.
    axes: Matrix3<f64>,
    /// Stroke of the finger in this frame, a unit vector.
    slide: Vector,
}

/// Velocities at the end of a step, the forces that they cause, and the error of the equations of motion (N s, N m s).
struct Balance {
    velocities: Velocities,
    grips: Vec<Grip>,
    error: Velocities,
    /// Square of the error, by the inertia that it moves.
    size: f64,
}

impl<'a> CompliantPads<'a> {
    /// Pads on an object with this surface, friction, mass (kg), inertia about its centre of mass (kg m²) and centre of mass.
    pub fn new(
        pads: &Pads,
        (surface, friction): (&'a Surface, f64),
        (mass_kg, inertia_kg_m2, center): (f64, Matrix3<f64>, Point),
    ) -> Self {
        let spring = |rest: Point| Spring { rest, held: None };
        let sides = pads.faces_m.map(|face_m| Side {
            inward: -face_m.signum(),
            springs: spring_tips(pads, face_m).into_iter().map(spring).collect(),
        });
        let stiffness = spring_stiffness(pads);
        Self {
            surface,
            friction,
            mass_kg,
            inertia_kg_m2,
            center,
            stiffness,
            sides,
            forces: [Vector::zeros(); 2],
        }
    }

    /// Adds the forces of the pads in the next step, after all other forces on object and fingers.
    pub fn press(&mut self, world: &mut PhysicsWorld, gripper: &Gripper<'_>, object: RigidBodyHandle) {
        let body = &world.bodies[object];
        let world_from_object = engine::to_pose(body.position());
        let dt = world.integration_parameters.dt;
        let palm = gripper.palm_motion(world, dt);
        let center = (world_from_object * self.center).coords;
        let touches = self.touches(world, gripper, &palm, (&world_from_object, &center));
        self.forces = [Vector::zeros(); 2];
        if touches.springs.is_empty() {
            return;
        }
        let turn = world_from_object.rotation.to_rotation_matrix();
        let inertia = turn.matrix() * self.inertia_kg_m2 * turn.matrix().transpose();
        let mut mass = Square::zeros();
        mass.fixed_view_mut::<3, 3>(0, 0).copy_from(&(Matrix3::identity() * self.mass_kg));
        mass.fixed_view_mut::<3, 3>(3, 3).copy_from(&inertia);
        let mut free = Velocities::zeros();
        let pull = world.gravity * self.mass_kg + body.user_force();
        let (linear, angular) = (engine::to_vector(body.linvel()), engine::to_vector(body.angvel()));
        free.fixed_rows_mut::<3>(0).copy_from(&(linear + engine::to_vector(pull) * (dt / self.mass_kg)));
        let torque = engine::to_vector(body.user_torque());
        let turned = inertia.try_inverse().map_or(Vector::zeros(), |inverse| inverse * torque * dt);
        free.fixed_rows_mut::<3>(3).copy_from(&(angular + turned));
        for (side, (rate, force_n, finger_kg)) in gripper.fingers_along(world).into_iter().enumerate().take(2)
        {
            mass[(6 + side, 6 + side)] = finger_kg;
            free[6 + side] = rate + force_n * dt / finger_kg;
        }
        let mut carried = free;
        carried.fixed_rows_mut::<3>(0).copy_from(&palm.at_point(&center));
        carried.fixed_rows_mut::<3>(3).copy_from(&palm.angular);
        carried.fixed_rows_mut::<2>(6).fill(0.0);
        let Balance { velocities, grips, .. } = self.solve(&touches, &mass, [free, carried], dt);
        for (touch, grip) in touches.springs.iter().zip(&grips) {
            self.forces[touch.side] += touches.frames[touch.side].axes.tr_mul(&grip.force);
        }
        // The forces that give these velocities are those of the springs, up to the error of the solution. Applied instead, an
        // error never flings off a light object.
        apply(world, gripper, object, &(mass * (velocities - free) / dt));
    }

    /// Springs that touch the object or may do so within the next step.
    fn touches(
        &mut self,
        world: &PhysicsWorld,
        gripper: &Gripper<'_>,
        palm: &PalmMotion,
        (world_from_object, center): (&Pose, &Vector),
    ) -> Touches {
        let springs = (self.stiffness, SHEAR_SHARE * self.stiffness);
        let world_from_palm = engine::to_pose(world.bodies[gripper.palm].position());
        let closed_m = gripper.closed_m(world);
        let mut touches = Vec::with_capacity(2 * PAD_CELLS[0] * PAD_CELLS[1]);
        let mut frames = [PadFrame { axes: Matrix3::identity(), slide: Vector::zeros() }; 2];
        for (side, pad) in self.sides.iter_mut().enumerate() {
            // The finger exactly on its slide: the engine's joint yields.
            let world_from_finger = world_from_palm
                * Pose::from_parts((gripper.axis(side) * closed_m[side]).into(), Rotation::identity());
            let rotation = world_from_finger.rotation.to_rotation_matrix();
            let [x, y, z] = [0, 1, 2].map(|axis| rotation.matrix().column(axis).into_owned());
            let inward = y * pad.inward;
            // Right-handed, as cross products need it.
            let [along, across] = if pad.inward > 0.0 { [z, x] } else { [x, z] };
            let axes = Matrix3::from_rows(&[along.transpose(), across.transpose(), inward.transpose()]);
            frames[side] = PadFrame { axes, slide: axes * (rotation * gripper.axis(side)) };
            let place = Place { world_from_object, axes: &axes };
            for spring in &mut pad.springs {
                let rest = world_from_finger * spring.rest;
                spring.held = place.held(self.surface, (spring.held, rest), springs, self.friction);
                let Some((point, normal)) = spring.held else { continue };
                let at = world_from_object * point;
                let off = axes * (at - rest);
                let depth_m = -off.z;
                let normal = axes * (world_from_object * normal);
                let arm = axes * (at.coords - center);
                let of_palm = axes * -palm.at_point(&at.coords);
                let along = Vector2::new(off.x, off.y);
                touches.push(Touch { side, arm, of_palm, along, depth_m, normal });
            }
        }
        Touches { springs: touches, frames }
    }

    /// Finds velocities and forces at the end of a step by Newton's method, with steps that shorten until the error falls.
    /// Begins with the better of two guesses: nothing holds the object, or it moves with the hand.
    fn solve(&self, touches: &Touches, mass: &Square, guesses: [Velocities; 2], dt: f64) -> Balance {
        let free = guesses[0];
        let at = |velocities: Velocities, law: Law| {
            let grips = self.grips(touches, &velocities, law, dt);
            let error = mass * (velocities - free) - touches.impulses(&grips, dt);
            let size = error.component_mul(&error).component_div(&mass.diagonal()).sum();
            Balance { velocities, grips, error, size }
        };
        let step_from = |balance: &Balance| {
            let slope = mass + touches.stiffness(&balance.grips) * (dt * dt);
            slope.lu().solve(&balance.error)
        };
        let accepted = ACCURACY * ACCURACY * self.mass_kg;
        let [loose, held] = guesses.map(|guess| at(guess, Law::Tangent));
        let mut best = if held.size < loose.size { held } else { loose };
        for _ in 0..MOST_STEPS {
            if best.size <= accepted {
                break;
            }
            let Some(step) = step_from(&best) else { break };
            let shares = (0..SHORTER).map(|times| 0.5_f64.powi(times));
            let mut shorter = shares.map(|share| at(best.velocities - step * share, Law::Tangent));
            let nearer = shorter.find(|tried| tried.size < best.size);
            best = nearer.unwrap_or_else(|| {
                // A sliding tip that sticks in the step: its secant leads there slowly but surely.
                let step = step_from(&at(best.velocities, Law::Secant)).unwrap_or_default();
                at(best.velocities - step, Law::Tangent)
            });
        }
        best
    }

    /// Forces of the springs after a step with these velocities.
    fn grips(&self, touches: &Touches, velocities: &Velocities, law: Law, dt: f64) -> Vec<Grip> {
        let springs = (self.stiffness, SHEAR_SHARE * self.stiffness);
        let [linear, angular] = [0, 3].map(|row| velocities.fixed_rows::<3>(row).into_owned());
        let of_sides = [0, 1].map(|side| {
            let PadFrame { axes, slide } = &touches.frames[side];
            (axes * linear - slide * velocities[6 + side], axes * angular)
        });
        let grip_of = |touch: &Touch| {
            let (linear, angular) = &of_sides[touch.side];
            let moved = (linear + angular.cross(&touch.arm) + touch.of_palm) * dt;
            let deflection = (touch.depth_m - moved.z, touch.along + moved.xy());
            grip(springs, deflection, (&touch.normal, self.friction), law)
        };
        touches.springs.iter().map(grip_of).collect()
    }
}

impl Touches {
    /// Impulses of the springs in a step of `dt` seconds on object and fingers, in the order of their [`Velocities`].
    fn impulses(&self, grips: &[Grip], dt: f64) -> Velocities {
        let mut sums = [(Vector::zeros(), Vector::zeros()); 2];
        for (touch, grip) in self.springs.iter().zip(grips) {
            let (force, moment) = &mut sums[touch.side];
            *force += grip.force;
            *moment += touch.arm.cross(&grip.force);
        }
        let mut impulses = Velocities::zeros();
        for (side, (frame, (force, moment))) in self.frames.iter().zip(sums).enumerate() {
            let mut linear = impulses.fixed_rows_mut::<3>(0);
            linear += frame.axes.tr_mul(&force);
            let mut angular = impulses.fixed_rows_mut::<3>(3);
            angular += frame.axes.tr_mul(&moment);
            impulses[6 + side] = -frame.slide.dot(&force);
        }
        impulses * dt
    }

    /// Derivative of the forces of the springs by displacements of object and fingers, in the order of their [`Velocities`].
    ///
    /// A tip moves relative to its pad by J = [1, −[arm]×, −slide] times the displacement in the frame of the pad.
    fn stiffness(&self, grips: &[Grip]) -> Square {
        let mut sums = [[Matrix3::zeros(); 4]; 2];
        for (touch, Grip { stiffness, .. }) in self.springs.iter().zip(grips) {
            let turning = touch.arm.cross_matrix();
            let by_turn = -(stiffness * turning);
            let sums = &mut sums[touch.side];
            sums[0] += stiffness;
            sums[1] += by_turn;
            sums[2] += turning * stiffness;
            sums[3] += turning * by_turn;
        }
        let mut total = Square::zeros();
        for (side, (PadFrame { axes, slide }, sums)) in self.frames.iter().zip(&sums).enumerate() {
            for (block, sum) in sums.iter().enumerate() {
                let mut place = total.fixed_view_mut::<3, 3>(3 * (block / 2), 3 * (block % 2));
                place += axes.tr_mul(&(sum * axes));
            }
            for (row, [by_motion, by_slide]) in [(0, [0, 0]), (3, [1, 2])] {
                total
                    .fixed_view_mut::<3, 1>(row, 6 + side)
                    .copy_from(&-axes.tr_mul(&(sums[by_slide] * slide)));
                let across = -(slide.transpose() * sums[by_motion] * axes);
                total.fixed_view_mut::<1, 3>(6 + side, row).copy_from(&across);
            }
            total[(6 + side, 6 + side)] = slide.dot(&(sums[0] * slide));
        }
        total
    }
}

/// Adds forces (N, N m) to object and fingers, in the order of their [`Velocities`].
fn apply(world: &mut PhysicsWorld, gripper: &Gripper<'_>, object: RigidBodyHandle, forces: &Velocities) {
    let world_from_palm = engine::to_pose(world.bodies[gripper.palm].position()).rotation;
    let body = &mut world.bodies[object];
    body.add_force(engine::vector(&forces.fixed_rows::<3>(0).into_owned()), true);
    body.add_torque(engine::vector(&forces.fixed_rows::<3>(3).into_owned()), true);
    for side in 0..2 {
        let slide = world_from_palm * gripper.axis(side);
        world.bodies[gripper.fingers[side]].add_force(engine::vector(&(slide * forces[6 + side])), true);
    }
}

/// Tips of the springs of a pad at rest, in the gripper frame; its face is at `face_m` along y.
pub(crate) fn spring_tips(pads: &Pads, face_m: f64) -> Vec<Point> {
    let at = |axis: usize, step: usize| {
        let share = 2.0 * (step as f64 + 0.5) / PAD_CELLS[axis] as f64 - 1.0;
        pads.middle_m[axis] + pads.half_m[axis] * share
    };
    let [columns, rows] = PAD_CELLS;
    (0..columns * rows).map(|cell| Point::new(at(0, cell / rows), face_m, at(1, cell % rows))).collect()
}

/// Stiffness of a spring of a pad, in N/m.
pub(crate) fn spring_stiffness(pads: &Pads) -> f64 {
    let count = (PAD_CELLS[0] * PAD_CELLS[1]) as f64;
    SOFT_PAD * 4.0 * pads.half_m[0] * pads.half_m[1] / count
}

/// Object between the pads.
struct Place<'a> {
    world_from_object: &'a Pose,
    /// Directions of a pad in the world, as rows: along it, along it, inward.
    axes: &'a Matrix3<f64>,
}

impl Place<'_> {
    /// Returns the point and the outward normal of the object, in its frame, at which the tip of a spring sticks: where it has
    /// stuck, or where it has slid to, or where it meets the object in front of its place at rest.
    fn held(
        &self,
        surface: &Surface,
        (held, rest): (Option<(Point, Vector)>, Point),
        springs: (f64, f64),
        friction: f64,
    ) -> Option<(Point, Vector)> {
        let inward = self.axes.row(2).transpose();
        let meet_at = |at: Point| {
            let origin = self.world_from_object.inverse_transform_point(&(at - inward * DEEPEST_M));
            meet(surface, &origin, &self.world_from_object.inverse_transform_vector(&inward))
        };
        let Some((point, normal)) = held else { return meet_at(rest) };
        let off = self.axes * (self.world_from_object * point - rest);
        let normal = self.axes * (self.world_from_object * normal);
        let grip = grip(springs, (-off.z, off.xy()), (&normal, friction), Law::Tangent);
        if grip.force.z <= 0.0 {
            return meet_at(rest);
        }
        let Some(slid_m) = grip.slid_m else { return held };
        let tip = off.xy() + slid_m;
        meet_at(rest + self.axes.tr_mul(&Vector::new(tip.x, tip.y, 0.0)))
    }
}

/// Point at which a ray enters a surface, with its outward normal; the origin, if it lies inside. `None` beyond the reach of a
/// pad.
fn meet(surface: &Surface, origin: &Point, along: &Vector) -> Option<(Point, Vector)> {
    let hit = *surface.ray_hits(origin, along, DEEPEST_M + AHEAD_M).first()?;
    if hit.normal.dot(along) > 0.0 {
        return Some((*origin, -along));
    }
    Some((origin + along * hit.distance_m, hit.normal))
}
