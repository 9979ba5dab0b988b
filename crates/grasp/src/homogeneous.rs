use cranny_spatial::nalgebra::{Matrix3, Rotation3};
use cranny_spatial::{Pose, Rotation, Vector};

use crate::GraspError;

/// Pose `target_from_source` of the homogeneous 4 × 4 matrix `rows`, row by row, translation in metres. A rotation that is off
/// by rounding (`f32` files) becomes a unit quaternion.
///
/// # Errors
/// [`GraspError::NotANumber`], [`GraspError::LastRow`], [`GraspError::NotARotation`] beyond 1e-4, [`GraspError::LeftHanded`].
pub fn pose_of_rows(rows: &[f64; 16]) -> Result<Pose, GraspError> {
    if let Some(index) = rows.iter().position(|x| !x.is_finite()) {
        return Err(GraspError::NotANumber { column: index + 1, text: rows[index].to_string() });
    }
    let row = [rows[12], rows[13], rows[14], rows[15]];
    let from_last_row = row.iter().zip([0.0, 0.0, 0.0, 1.0]).map(|(a, b)| (a - b).abs());
    if from_last_row.fold(0.0, f64::max) > LAST_ROW_TOLERANCE {
        return Err(GraspError::LastRow { row });
    }
    let matrix = Matrix3::from_fn(|i, j| rows[4 * i + j]);
    let deviation = (matrix.transpose() * matrix - Matrix3::identity()).amax();
    if deviation > ROTATION_TOLERANCE {
        return Err(GraspError::NotARotation { deviation, tolerance: ROTATION_TOLERANCE });
    }
    if matrix.determinant() < 0.0 {
        return Err(GraspError::LeftHanded);
    }
    let nearly = Rotation::from_rotation_matrix(&Rotation3::from_matrix_unchecked(matrix));
    let rotation = Rotation::new_normalize(nearly.into_inner());
    Ok(Pose::from_parts(Vector::new(rows[3], rows[7], rows[11]).into(), rotation))
}

/// Homogeneous matrix of a pose `target_from_source`, row by row.
pub fn rows_of_pose(pose: &Pose) -> [f64; 16] {
    let matrix = pose.to_homogeneous();
    std::array::from_fn(|index| matrix[(index / 4, index % 4)])
}

/// Maximum deviation of an element of `RᵀR` from the identity: the rounding of an `f32` file is 1e-6, that of one printed
/// with four digits 1e-4.
const ROTATION_TOLERANCE: f64 = 1e-4;

/// Maximum deviation of the last row from 0 0 0 1, which every format can write exactly.
const LAST_ROW_TOLERANCE: f64 = 1e-9;

#[cfg(test)]
mod tests {
    use super::*;
    use cranny_spatial::{PoseDifference, Stream};

    #[test]
    fn a_pose_survives_its_matrix_in_single_precision() {
        let mut random = Stream::new(5, 0);
        for _ in 0..1000 {
            let shift = Vector::new(random.normal(), random.normal(), random.normal());
            let pose = Pose::from_parts(shift.into(), random.rotation());
            let rows = rows_of_pose(&pose);
            let exact = PoseDifference::between(&pose, &pose_of_rows(&rows).unwrap());
            assert!(exact.translation_m == 0.0 && exact.rotation_rad < 1e-14, "{exact:?}");
            #[allow(clippy::cast_possible_truncation, reason = "single precision is what is meant")]
            let rounded = rows.map(|x| f64::from(x as f32));
            let read = pose_of_rows(&rounded).unwrap();
            assert!((read.rotation.norm() - 1.0).abs() < 1e-15);
            assert!(PoseDifference::between(&pose, &read).rotation_rad < 1e-6);
        }
    }

    #[test]
    fn what_is_no_rigid_transform_is_refused() {
        let identity = rows_of_pose(&Pose::identity());
        let with = |index: usize, value: f64| {
            let mut rows = identity;
            rows[index] = value;
            pose_of_rows(&rows)
        };
        assert!(with(3, 0.5).is_ok());
        assert!(matches!(with(7, f64::NAN), Err(GraspError::NotANumber { column: 8, .. })));
        assert!(matches!(with(0, f64::INFINITY), Err(GraspError::NotANumber { column: 1, .. })));
        assert!(matches!(with(15, 0.0), Err(GraspError::LastRow { .. })));
        assert!(matches!(with(0, 1.001), Err(GraspError::NotARotation { .. })));
        assert!(matches!(with(1, 0.01), Err(GraspError::NotARotation { .. })));
        assert!(matches!(with(5, -1.0), Err(GraspError::LeftHanded)));
    }
}
