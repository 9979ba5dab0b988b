use crate::Pose;

/// Difference of two poses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseDifference {
    /// Distance of the two origins, in metres.
    pub translation_m: f64,
    /// Angle of the rotation that takes one to the other, in radians, in [0, π].
    pub rotation_rad: f64,
}

impl PoseDifference {
    /// Returns the difference of two poses in one frame: `between(a, b) = between(b, a)`.
    pub fn between(a: &Pose, b: &Pose) -> Self {
        let translation_m = (a.translation.vector - b.translation.vector).norm();
        // sin| and |cos| of half the angle are accurate both near 0 and near π.
        let relative = a.rotation.conjugate() * b.rotation;
        let (sine, cosine) = (relative.imag().norm(), relative.w.abs());
        Self { translation_m, rotation_rad: 2.0 * libm::atan2(sine, cosine) }
    }

    /// Returns true if both components are within the `exact` criterion: 1 mm and 1°.
    pub fn is_exact(&self) -> bool {
        self.translation_m <= crate::EXACT_TRANSLATION_M && self.rotation_rad <= crate::EXACT_ROTATION_RAD
    }

    /// Returns the released metric `d = ½·millimetres + ½·degrees` (the paper's §V; unit-less).
    pub fn paper_metric(&self) -> f64 {
        0.5 * self.translation_m * 1000.0 + 0.5 * self.rotation_rad.to_degrees()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Vector;

    #[test]
    fn a_difference_reads_back_what_was_built() {
        let a = Pose::new(Vector::new(0.1, 0.2, 0.3), Vector::new(0.3, -0.2, 0.5));
        for angle in [0.0, 1e-9, 0.01, 1.5, 3.1] {
            let b = a * Pose::new(Vector::new(0.0, 3e-3, 4e-3), Vector::new(0.0, angle, 0.0));
            let difference = PoseDifference::between(&a, &b);
            assert!((difference.translation_m - 5e-3).abs() < 1e-12);
            assert!((difference.rotation_rad - angle).abs() < 1e-12, "{difference:?}");
        }
    }

    #[test]
    fn ten_centimetres_make_the_papers_threshold() {
        let difference = PoseDifference { translation_m: 0.1, rotation_rad: 0.0 };
        assert!((difference.paper_metric() - 50.0).abs() < 1e-12);
    }
}
