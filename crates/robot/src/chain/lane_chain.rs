use cranny_spatial::nalgebra::Matrix3;
use cranny_spatial::{LANES, LaneArray, Pose, Rotation, Vector, sin_cos_lanes};
use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16};

use crate::{JointKind, Robot};

/// Joints from the root to the tip; computes the pose of the tip and its Jacobian at 16 configurations at once, in `f32`.
#[derive(Clone, Debug)]
pub(crate) struct LaneChain {
    joints: Vec<ChainJoint>,
    last_from_tip: Offset,
    /// Axis and origin of every joint in the root frame, from the last call of [`Self::tip`].
    axes: Vec<[LaneArray; 6]>,
}

/// Joint between root and tip, in a frame whose z axis is the joint's.
#[derive(Clone, Debug)]
struct ChainJoint {
    previous_from_joint: Offset,
    joint: usize,
    multiplier: f32,
    kind: JointKind,
}

/// Rigid transform in `f32`.
#[derive(Clone, Debug)]
pub(crate) struct Offset {
    /// Rotation matrix, row by row.
    pub rotation: [[f32; 3]; 3],
    pub translation: [f32; 3],
}

/// Poses of the tips in the root frame: rotation matrices, row by row, and translations.
pub(crate) struct Tip<S: Simd> {
    pub rotation: [[f32x16<S>; 3]; 3],
    pub translation: [f32x16<S>; 3],
}

impl LaneChain {
    /// Returns the chain from the root to the robot's tip.
    pub fn new(robot: &Robot) -> Self {
        let frames = robot.frames();
        let mut root_from_previous = Pose::identity();
        let mut joints = Vec::new();
        for mover in robot.ancestors(robot.tip()) {
            let child_from_joint = Rotation::rotation_between(&Vector::z(), &mover.axis_in_child)
                .unwrap_or_else(|| Rotation::from_axis_angle(&Vector::x_axis(), std::f64::consts::PI));
            let root_from_joint = frames.link(mover.child_link) * child_from_joint;
            joints.push(ChainJoint {
                previous_from_joint: Offset::of(&root_from_previous.inv_mul(&root_from_joint)),
                joint: mover.joint,
                multiplier: narrow(mover.multiplier),
                kind: mover.kind,
            });
            root_from_previous = root_from_joint;
        }
        Self {
            last_from_tip: Offset::of(&root_from_previous.inv_mul(frames.link(robot.tip()))),
            axes: vec![[[0.0; LANES]; 6]; joints.len()],
            joints,
        }
    }

    /// Returns the tip poses at `q`, with one row of lanes per joint.
    #[inline(always)]
    pub fn tip<S: Simd>(&mut self, simd: S, q: &[LaneArray]) -> Tip<S> {
        let (zero, one) = (f32x16::splat(simd, 0.0), f32x16::splat(simd, 1.0));
        let mut tip = Tip {
            rotation: [[one, zero, zero], [zero, one, zero], [zero, zero, one]],
            translation: [zero; 3],
        };
        for (joint, axes) in self.joints.iter().zip(&mut self.axes) {
            tip.follow(simd, &joint.previous_from_joint);
            let value = f32x16::from_slice(simd, &q[joint.joint]) * joint.multiplier;
            match joint.kind {
                JointKind::Prismatic => {
                    for (translation, row) in tip.translation.iter_mut().zip(&tip.rotation) {
                        *translation += row[2] * value;
                    }
                }
                JointKind::Revolute => {
                    let (sine, cosine) = sin_cos_lanes(simd, value);
                    for row in &mut tip.rotation {
                        let [x, y, _] = *row;
                        row[0] = x * cosine + y * sine;
                        row[1] = y * cosine - x * sine;
                    }
                }
            }
            for (row, lanes) in tip.rotation.iter().zip(&mut axes[..3]) {
                row[2].store_slice(lanes);
            }
            for (translation, lanes) in tip.translation.iter().zip(&mut axes[3..]) {
                translation.store_slice(lanes);
            }
        }
        tip.follow(simd, &self.last_from_tip);
        tip
    }

    /// Writes the columns of the geometric Jacobian (see [`Robot::jacobian`]) at the configurations of the last [`Self::tip`].
    #[inline(always)]
    pub fn jacobian<S: Simd>(&self, simd: S, tip: &Tip<S>, jacobian: &mut [[LaneArray; 6]]) {
        let zero = f32x16::splat(simd, 0.0);
        jacobian.as_flattened_mut().fill([0.0; LANES]);
        for (joint, axes) in self.joints.iter().zip(&self.axes) {
            let load = |index: usize| f32x16::from_slice(simd, &axes[index]);
            let axis = [load(0), load(1), load(2)].map(|part| part * joint.multiplier);
            let parts = match joint.kind {
                JointKind::Prismatic => [axis[0], axis[1], axis[2], zero, zero, zero],
                JointKind::Revolute => {
                    let [x, y, z] = tip.translation;
                    let [x, y, z] = cross(axis, [x - load(3), y - load(4), z - load(5)]);
                    [x, y, z, axis[0], axis[1], axis[2]]
                }
            };
            for (part, lanes) in parts.into_iter().zip(&mut jacobian[joint.joint]) {
                (f32x16::from_slice(simd, lanes) + part).store_slice(lanes);
            }
        }
    }
}

impl Offset {
    /// Converts a pose to `f32`.
    pub fn of(target_from_source: &Pose) -> Self {
        let rotation: Matrix3<f64> = target_from_source.rotation.to_rotation_matrix().into_inner();
        let entry = |row: usize, column: usize| narrow(rotation[(row, column)]);
        Self {
            rotation: std::array::from_fn(|row| std::array::from_fn(|column| entry(row, column))),
            translation: std::array::from_fn(|row| narrow(target_from_source.translation.vector[row])),
        }
    }
}

impl<S: Simd> Tip<S> {
    /// Moves on to a frame that is fixed to this one.
    #[inline(always)]
    fn follow(&mut self, simd: S, offset: &Offset) {
        let zero = f32x16::splat(simd, 0.0);
        for (translation, row) in self.translation.iter_mut().zip(&mut self.rotation) {
            let mut turned = [zero; 3];
            for (k, from) in row.iter().enumerate() {
                *translation += *from * offset.translation[k];
                for (to, factor) in turned.iter_mut().zip(offset.rotation[k]) {
                    *to += *from * factor;
                }
            }
            *row = turned;
        }
    }
}

#[inline(always)]
pub(crate) fn cross<S: Simd>(a: [f32x16<S>; 3], b: [f32x16<S>; 3]) -> [f32x16<S>; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Converts `x` to single precision.
#[allow(clippy::cast_possible_truncation, reason = "single precision is what is meant")]
pub(crate) fn narrow(x: f64) -> f32 {
    x as f32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::RobotOptions;
    use cranny_spatial::Stream;
    use fearless_simd::{Level, dispatch};

    fn robot(file: &str) -> Robot {
        let file = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures").join(file);
        Robot::load(&file, &RobotOptions::default()).expect("the fixture is a robot")
    }

    #[inline(always)]
    fn measure<S: Simd>(
        simd: S,
        chain: &mut LaneChain,
        q: &[LaneArray],
        jacobian: &mut [[LaneArray; 6]],
    ) -> [LaneArray; 12] {
        let tip = chain.tip(simd, q);
        chain.jacobian(simd, &tip, jacobian);
        let mut numbers = [[0.0; LANES]; 12];
        let parts = tip.rotation.into_iter().flatten().chain(tip.translation);
        parts.zip(&mut numbers).for_each(|(part, lanes)| part.store_slice(lanes));
        numbers
    }

    #[test]
    fn tip_and_jacobian_are_those_of_double_precision() {
        /// Rounding error of a chain of a dozen frames within 2 m, in m and rad.
        const BOUND: f64 = 5e-6;
        for file in ["mobile_arm/mobile_arm.urdf", "mimic.urdf"] {
            let robot = robot(file);
            let mut random = Stream::new(3, 0);
            let mut chain = LaneChain::new(&robot);
            let (mut frames, mut expected) = (robot.frames(), robot.empty_jacobian());
            let mut jacobian = vec![[[0.0; LANES]; 6]; robot.dof()];
            for _ in 0..50 {
                let draw = |lane: usize, random: &mut Stream| {
                    let limits = robot.limits()[lane];
                    std::array::from_fn(|_| narrow(random.uniform_between(limits.lower, limits.upper)))
                };
                let q: Vec<LaneArray> = (0..robot.dof()).map(|joint| draw(joint, &mut random)).collect();
                let tip = dispatch!(Level::new(), simd => measure(simd, &mut chain, &q, &mut jacobian));
                for lane in 0..LANES {
                    let q: Vec<f64> = q.iter().map(|lanes| f64::from(lanes[lane])).collect();
                    robot.forward_kinematics(&q, &mut frames);
                    robot.jacobian(&frames, robot.tip(), &mut expected);
                    let pose = frames.link(robot.tip()).to_homogeneous();
                    for (index, lanes) in tip.iter().enumerate() {
                        let (row, column) = if index < 9 { (index / 3, index % 3) } else { (index - 9, 3) };
                        assert!((f64::from(lanes[lane]) - pose[(row, column)]).abs() < BOUND);
                    }
                    for (joint, column) in jacobian.iter().enumerate() {
                        for (row, lanes) in column.iter().enumerate() {
                            assert!((f64::from(lanes[lane]) - expected[(row, joint)]).abs() < BOUND);
                        }
                    }
                }
            }
        }
    }
}
