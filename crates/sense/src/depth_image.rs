use crate::{Camera, SenseError};

/// Image of depths along the optical axis.
#[derive(Clone, Debug, PartialEq)]
pub struct DepthImage {
    width: usize,
    height: usize,
    depths_m: Vec<f32>,
}

impl DepthImage {
    /// Creates an image of `width` × `height` depths (m), row by row from the top left. A depth that is not valid (0, negative,
    /// infinite or NaN) is stored as NaN.
    ///
    /// # Errors
    /// [`SenseError::DepthCount`] for another number of depths.
    pub fn new(width: usize, height: usize, depths_m: Vec<f32>) -> Result<Self, SenseError> {
        if width.checked_mul(height) != Some(depths_m.len()) {
            return Err(SenseError::DepthCount { width, height, actual: depths_m.len() });
        }
        Ok(Self { width, height, depths_m: with_nan(depths_m) })
    }

    /// Returns the image of a camera from one depth (m) per pixel.
    pub(crate) fn of_camera(camera: &Camera, depths_m: Vec<f32>) -> Self {
        debug_assert_eq!(depths_m.len(), camera.pixel_count());
        Self { width: camera.width_px, height: camera.height_px, depths_m: with_nan(depths_m) }
    }

    /// Returns the width, in pixels.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Returns the height, in pixels.
    pub fn height(&self) -> usize {
        self.height
    }

    /// Returns the depths (m), `width` × `height` of them row by row; NaN where the depth is not valid.
    pub fn depths_m(&self) -> &[f32] {
        &self.depths_m
    }

    /// Returns the depth of pixel (u, v), in metres; `None` if it is not valid or outside of the image.
    pub fn depth_m(&self, u: usize, v: usize) -> Option<f32> {
        let is_inside = u < self.width && v < self.height;
        is_inside.then(|| self.depths_m[v * self.width + u]).filter(|depth_m| !depth_m.is_nan())
    }

    /// Returns the number of valid depths.
    pub fn valid_count(&self) -> usize {
        self.depths_m.iter().filter(|depth_m| !depth_m.is_nan()).count()
    }
}

/// Replaces depths that are not valid by NaN.
fn with_nan(mut depths_m: Vec<f32>) -> Vec<f32> {
    for depth_m in &mut depths_m {
        if !(*depth_m > 0.0 && depth_m.is_finite()) {
            *depth_m = f32::NAN;
        }
    }
    depths_m
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn invalid_depths_become_nan_and_sizes_must_match() {
        let depths_m = vec![0.0, -1.0, f32::INFINITY, f32::NEG_INFINITY, f32::NAN, 0.5];
        let image = DepthImage::new(3, 2, depths_m).expect("six depths");
        assert_eq!((image.valid_count(), image.depth_m(2, 1)), (1, Some(0.5)));
        assert!(image.depths_m()[..5].iter().all(|depth_m| depth_m.is_nan()));
        assert!(
            image.depth_m(0, 0).is_none() && image.depth_m(3, 1).is_none() && image.depth_m(0, 2).is_none()
        );
        let fault = DepthImage::new(3, 2, vec![1.0; 5]).unwrap_err().to_string();
        assert!(fault.contains("3 × 2 pixels has 6 depths, but 5 are given"), "{fault}");
    }
}
