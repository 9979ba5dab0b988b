//! Depth images as NumPy arrays.

use numpy::{Element, PyArrayDyn, PyArrayMethods as _};
use pyo3::prelude::*;
use serde::Serialize;

use crate::handover::fault::bad_value;

/// Unit of depths in `uint16`, in metres, as in images of ROS.
const MILLIMETRE_M: f64 = 0.001;

/// Array of depths.
pub struct DepthArray {
    pub width: usize,
    pub height: usize,
    /// Depths (m), row by row, valid or not; NaN for masked pixels.
    pub depths_m: Vec<f32>,
    /// Number of masked pixels.
    masked: usize,
}

/// Numbers of pixels without a usable depth, by the reason.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct DroppedDepths {
    pub zero: usize,
    pub nan: usize,
    pub infinite: usize,
    pub negative: usize,
    pub masked: usize,
    pub out_of_range: usize,
}

impl DepthArray {
    /// Reads an array (H, W) of `uint16`, `float32` or `float64`. `scale`: its unit in metres; `None`: 0.001 for `uint16`, 1 for floats.
    /// Masked pixels are not valid.
    ///
    /// # Errors
    /// ValueError for another shape, another type, or a unit that is not above 0 and at most 1.
    pub fn read(image: &Bound<'_, PyAny>, scale: Option<f64>) -> PyResult<Self> {
        let expected = "uint16 (millimetres), float32 or float64 (metres), or units of `scale` metres";
        if image.is_none() {
            return Err(bad_value(format!("image is None, but an array (H, W) of {expected} is expected")));
        }
        let numpy = image.py().import("numpy")?;
        let refused =
            |reason: PyErr| bad_value(format!("image: an array (H, W) of {expected} is expected ({reason})"));
        let array = numpy.call_method1("asanyarray", (image,)).map_err(refused)?;
        let dtype = array.getattr("dtype")?;
        let (kind, bytes): (String, usize) =
            (dtype.getattr("kind")?.extract()?, dtype.getattr("itemsize")?.extract()?);
        let (name, unit_m) = match (kind.as_str(), bytes) {
            ("u", 2) => ("uint16", MILLIMETRE_M),
            ("f", 4) => ("float32", 1.0),
            ("f", 8) => ("float64", 1.0),
            _ => return Err(bad_value(format!("image has dtype {dtype}, but {expected} is expected"))),
        };
        let shape: Vec<usize> = array.getattr("shape")?.extract()?;
        let [height, width] = shape[..] else {
            return Err(bad_value(format!(
                "image has shape {}, but (H, W) is expected",
                array.getattr("shape")?
            )));
        };
        let unit_m = scale.unwrap_or(unit_m);
        if !(unit_m > 0.0 && unit_m <= 1.0) {
            return Err(bad_value(format!(
                "scale is {unit_m}, but a unit in metres above 0 and at most 1 is expected"
            )));
        }
        // Conversions of NumPy drop a mask. Floats contain each uint16, and NaN.
        let (array, name, masked) = if array.hasattr("filled")? {
            let name = if name == "uint16" { "float32" } else { name };
            let masked = numpy.getattr("ma")?.call_method1("count_masked", (&array,))?.extract()?;
            let array = array.call_method1("astype", (name,))?.call_method1("filled", (f64::NAN,))?;
            (array, name, masked)
        } else {
            (array, name, 0)
        };
        let array = numpy.call_method1("ascontiguousarray", (array, name))?;
        #[allow(clippy::cast_possible_truncation, reason = "depths are stored as f32")]
        let depths_m = match name {
            "uint16" => in_metres(&array, |value: u16| (f64::from(value) * unit_m) as f32)?,
            "float32" => in_metres(&array, |value: f32| (f64::from(value) * unit_m) as f32)?,
            _ => in_metres(&array, |value: f64| (value * unit_m) as f32)?,
        };
        Ok(Self { width, height, depths_m, masked })
    }

    /// Returns the numbers of pixels without a depth in the range of a sensor (m).
    pub fn dropped(&self, [nearest_m, farthest_m]: [f64; 2]) -> DroppedDepths {
        let mut dropped = DroppedDepths { masked: self.masked, ..DroppedDepths::default() };
        for depth_m in &self.depths_m {
            if depth_m.is_nan() {
                dropped.nan += 1;
            } else if depth_m.is_infinite() {
                dropped.infinite += 1;
            } else if *depth_m < 0.0 {
                dropped.negative += 1;
            } else if *depth_m <= 0.0 {
                dropped.zero += 1;
            } else if !(nearest_m..=farthest_m).contains(&f64::from(*depth_m)) {
                dropped.out_of_range += 1;
            }
        }
        // A masked pixel is NaN.
        dropped.nan -= self.masked;
        dropped
    }
}

impl DroppedDepths {
    pub fn sum(&self) -> usize {
        let Self { zero, nan, infinite, negative, masked, out_of_range } = self;
        zero + nan + infinite + negative + masked + out_of_range
    }
}

fn in_metres<T: Element + Copy>(array: &Bound<'_, PyAny>, metres: impl Fn(T) -> f32) -> PyResult<Vec<f32>> {
    let array = array.cast::<PyArrayDyn<T>>()?;
    let writing = |_| bad_value("image: the array is being written to elsewhere");
    let array = array.try_readonly().map_err(writing)?;
    let values = array.as_slice().map_err(|_| bad_value("image: the array is not contiguous"))?;
    Ok(values.iter().copied().map(metres).collect())
}
