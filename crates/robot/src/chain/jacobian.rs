use std::ops::AddAssign;

use cranny_spatial::nalgebra::{Cholesky, Const, Matrix6, Matrix6xX, Vector6};

use crate::{JointKind, LinkFrames, Robot};

/// Geometric Jacobian, 6 × dof: rows 0–2 metres of the link's origin, rows 3–5 radians of its rotation, both in the root
/// frame, per metre or radian of each joint.
pub type Jacobian = Matrix6xX<f64>;

/// Infinitesimal motion of a frame in the root frame: translation of its origin (m), then rotation vector (rad).
pub type Twist = Vector6<f64>;

impl Robot {
    /// Returns a zero Jacobian of the right size.
    pub fn empty_jacobian(&self) -> Jacobian {
        Jacobian::zeros(self.dof())
    }

    /// Writes the geometric Jacobian of `link`, at its origin and in the root frame, for the configuration at which `frames`
    /// were computed. The columns of mimic joints are added to that of the joint they follow.
    ///
    /// Law: `frames(q + δ) ≈ twist(jacobian · δ) applied to frames(q)` (test `jacobian_is_the_derivative_of_the_pose`).
    ///
    /// # Panics
    /// If `jacobian` or `frames` belong to another robot, or `link` does not exist.
    pub fn jacobian(&self, frames: &LinkFrames, link: usize, jacobian: &mut Jacobian) {
        assert_eq!(jacobian.ncols(), self.dof(), "one column for each joint of the group");
        jacobian.fill(0.0);
        let point_in_root = frames.link(link).translation.vector;
        for mover in self.ancestors(link) {
            let root_from_child = frames.link(mover.child_link);
            let axis = (root_from_child.rotation * mover.axis_in_child) * mover.multiplier;
            let mut column = jacobian.column_mut(mover.joint);
            match mover.kind {
                JointKind::Prismatic => column.fixed_rows_mut::<3>(0).add_assign(&axis),
                JointKind::Revolute => {
                    let arm = point_in_root - root_from_child.translation.vector;
                    column.fixed_rows_mut::<3>(0).add_assign(&axis.cross(&arm));
                    column.fixed_rows_mut::<3>(3).add_assign(&axis);
                }
            }
        }
    }
}

/// Writes to `step` the joint motion (m, rad; one per joint) `Jᵀ(JJᵀ + λ²I)⁻¹ v` that best follows the twist `v` in the sense
/// of damped least squares (Wampler 1986, "Manipulator inverse kinematic solutions based on vector formulations and damped
/// least-squares methods", whole; Nakamura & Hanafusa 1986, "Inverse kinematic solutions with singularity robustness for robot
/// manipulator control", whole; as in Siciliano, Sciavicco, Villani & Oriolo 2009, "Robotics", §3.5.2), λ = `damping`: λ = 0
/// gives the motion of the pseudo-inverse. Returns true unless λ = 0 and J is rank-deficient; `step` is then unchanged.
///
/// # Panics
/// If `step` does not have one value per column.
pub fn damped_pseudo_inverse_step(
    jacobian: &Jacobian,
    twist: &Twist,
    damping: f64,
    step: &mut [f64],
) -> bool {
    let Some(inverse) = DampedInverse::new(jacobian, damping) else { return false };
    inverse.step(jacobian, twist, step);
    true
}

/// Factorisation of `JJᵀ + λ²I` of a Jacobian J, reused by several operations. All methods require the same J.
#[derive(Clone, Debug)]
pub struct DampedInverse {
    factors: Cholesky<f64, Const<6>>,
}

impl DampedInverse {
    /// Factorises with λ = `damping`; `None` if `JJᵀ + λ²I` is not numerically positive definite, which never happens for
    /// finite J and λ well above 10⁻⁷ of its entries.
    pub fn new(jacobian: &Jacobian, damping: f64) -> Option<Self> {
        let mut gram = Matrix6::from_diagonal_element(damping * damping);
        // The factorisation reads the lower triangle only.
        for column in jacobian.column_iter() {
            for i in 0..6 {
                let factor = column[i];
                for k in i..6 {
                    gram[(k, i)] += factor * column[k];
                }
            }
        }
        Some(Self { factors: gram.cholesky()? })
    }

    /// Writes `Jᵀ(JJᵀ + λ²I)⁻¹ v` to `step` (m, rad; one per joint).
    ///
    /// # Panics
    /// If `step` does not have one value per column.
    pub fn step(&self, jacobian: &Jacobian, twist: &Twist, step: &mut [f64]) {
        assert_eq!(step.len(), jacobian.ncols(), "one value for each column");
        let weights = self.dual(twist);
        for (value, column) in step.iter_mut().zip(jacobian.column_iter()) {
            *value = column.dot(&weights);
        }
    }

    /// Returns `(JJᵀ + λ²I)⁻¹ v`: the weights with which the rows of J sum to [`Self::step`].
    pub fn dual(&self, twist: &Twist) -> Twist {
        self.factors.solve(twist)
    }

    /// Projects `motion` (m, rad; one per joint) onto the null space of the Jacobian, `(I − J⁺J) motion`. With damping,
    /// J⁺ = `Jᵀ(JJᵀ + λ²I)⁻¹` only approximates the pseudo-inverse, and a residual of the order of λ² remains.
    ///
    /// # Panics
    /// If `motion` does not have one value per column.
    pub fn project_to_null_space(&self, jacobian: &Jacobian, motion: &mut [f64]) {
        assert_eq!(motion.len(), jacobian.ncols(), "one value for each column");
        let mut twist = Twist::zeros();
        for (&value, column) in motion.iter().zip(jacobian.column_iter()) {
            twist.axpy(value, &column, 1.0);
        }
        let weights = self.factors.solve(&twist);
        for (value, column) in motion.iter_mut().zip(jacobian.column_iter()) {
            *value -= column.dot(&weights);
        }
    }
}
