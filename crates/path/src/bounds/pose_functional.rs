use cranny_spatial::nalgebra::Matrix3;
use cranny_spatial::{EXACT_ROTATION_RAD, EXACT_TRANSLATION_M, Pose, Vector};

use crate::bounds::pose_clusters::Cluster;

/// A linear functional of a pose, `force · p + ⟨V, R⟩`.
pub(crate) struct Functional {
    pub force: Vector,
    /// Gradient of the second term with respect to rotations at the centre of the box.
    pub turn: Vector,
    /// `R Vᵀ` at the centre.
    product: Matrix3<f64>,
    /// Upper bound of the sum of the singular values of V.
    pub torque_norm: f64,
    /// Increase from the centre of the box to any pose of the cluster, minus the tolerance.
    pub rise: f64,
}

impl Functional {
    /// Creates a functional whose V makes the second term grow with a rotation about `torque`, between the pose of the tip and
    /// the cluster, both in the root frame.
    pub fn new(force: Vector, torque: Vector, cluster: &Cluster, root_from_tip: &Pose) -> Self {
        let [here, there] =
            [root_from_tip, &cluster.middle].map(|pose| *pose.rotation.to_rotation_matrix().matrix());
        // The mean of two rotations has no singular value above 1, and half a cross-product matrix has two of half the norm.
        let of_torque = torque.cross_matrix() * (here + there) * 0.25;
        let product = here * of_torque.transpose();
        let turn = Vector::new(
            product[(1, 2)] - product[(2, 1)],
            product[(2, 0)] - product[(0, 2)],
            product[(0, 1)] - product[(1, 0)],
        );
        let rise = force.dot(&(cluster.middle.translation.vector - root_from_tip.translation.vector))
            + of_torque.dot(&(there - here));
        let functional = Self { force, turn, product, torque_norm: torque.norm(), rise };
        let slack =
            functional.slack(cluster.radius_m + EXACT_TRANSLATION_M, cluster.chord + EXACT_ROTATION_RAD);
        Self { rise: rise - slack, ..functional }
    }

    /// Returns an upper bound of the change of the functional if a pose moves by `radius_m` (m) and turns by this chord.
    pub fn slack(&self, radius_m: f64, chord: f64) -> f64 {
        self.force.norm() * radius_m + self.torque_norm * chord
    }

    /// Returns the second derivative of the second term by rotations about two axes, the outer one first.
    pub fn second(&self, outer: &Vector, inner: &Vector) -> f64 {
        outer.dot(&(self.product * inner)) - outer.dot(inner) * self.product.trace()
    }
}
