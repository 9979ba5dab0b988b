use cranny_spatial::nalgebra::Matrix3;
use cranny_spatial::{Point, Pose, Vector};

use crate::inside::closed_mesh::{check_closed, check_indices};
use crate::{ShapeError, TriangleSoup};

/// Volume, centre of mass and inertia of the space that a closed mesh encloses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VolumeMoments {
    /// Volume, in cubic metres; positive for normals outwards.
    pub volume_m3: f64,
    /// Centre of mass under uniform density.
    pub center: Point,
    /// Inertia about the centre, along the axes of the mesh, per unit of mass: in square metres; multiply it by the mass.
    pub inertia_per_mass_m2: Matrix3<f64>,
}

impl VolumeMoments {
    /// Returns these moments in another frame.
    #[must_use]
    pub fn moved(&self, other_from_own: &Pose) -> Self {
        let turn = other_from_own.rotation.to_rotation_matrix();
        Self {
            center: other_from_own * self.center,
            inertia_per_mass_m2: turn.matrix() * self.inertia_per_mass_m2 * turn.matrix().transpose(),
            ..*self
        }
    }

    /// Moments of the volume that `soup` encloses: signed sums over the tetrahedra between each triangle and one point
    /// (Blow & Binstock 2004, "How to find the inertia tensor (or other mass properties) of a 3D solid body represented
    /// by a triangle mesh", whole).
    ///
    /// # Errors
    /// [`ShapeError::Empty`], [`ShapeError::VertexIndex`], [`ShapeError::Open`] for a mesh with a hole,
    /// [`ShapeError::NoVolume`] for one that encloses nothing.
    pub fn of_mesh(soup: &TriangleSoup) -> Result<Self, ShapeError> {
        check_indices(soup)?;
        check_closed(soup)?;
        // The reference point is near the mesh, so that the sum does not cancel far from the origin.
        let eye = soup.corners(0)[0];
        let (mut volume_m3, mut first, mut second) = (0.0, Vector::zeros(), Matrix3::zeros());
        for index in 0..soup.triangles.len() {
            let [a, b, c] = soup.corners(index).map(|corner| corner - eye);
            let determinant = a.dot(&b.cross(&c));
            let sum = a + b + c;
            volume_m3 += determinant / 6.0;
            first += sum * (determinant / 24.0);
            let squares = a * a.transpose() + b * b.transpose() + c * c.transpose();
            second += (squares + sum * sum.transpose()) * (determinant / 120.0);
        }
        if volume_m3.is_nan() || volume_m3 <= 0.0 {
            return Err(ShapeError::NoVolume { volume_m3 });
        }
        let middle = first / volume_m3;
        let covariance = second / volume_m3 - middle * middle.transpose();
        let inertia_per_mass_m2 = Matrix3::identity() * covariance.trace() - covariance;
        Ok(Self { volume_m3, center: eye + middle, inertia_per_mass_m2 })
    }
}
