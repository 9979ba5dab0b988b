//! `DepthView`: a depth image with its camera.

use std::path::PathBuf;

use cranny_sense::{Camera, DepthImage, SensorModel, StoredView, View, Views};
use numpy::PyArrayDyn;
use pyo3::prelude::*;
use pyo3::types::{IntoPyDict as _, PyDict};

use crate::handover::array::{Numbers, copied, matrices, poses, shaped};
use crate::handover::fault::{bad_value, fault};
use crate::handover::json::python_of;
use crate::handover::pickled::{Made, Reduced, partial};
use crate::sensing::image::{DepthArray, DroppedDepths};

/// Depth image of a camera at its pose, with the bounds of its errors. Immutable.
///
/// `image`: (H, W), depths along the optical axis: uint16 in millimetres, float32 or float64 in metres, or in units of `scale` metres.
/// 0, NaN, infinite and negative depths, masked pixels, and depths beyond the range of the sensor are no valid ones; `dropped` counts
/// them. `intrinsics`: (fx, fy, cx, cy) or a camera matrix (3, 3), in pixels, without distortion; the centre of the first pixel is at
/// (0, 0). `pose`: `world_from_camera`, (4, 4), of the optical frame: z forward, x to the right of the image, y down.
///
/// `q`: configuration of the robot in the image, one value per joint (m, rad); None: that at the start of the motion.
///
/// The other keywords bound the errors, as `sensor` in a `views.yaml`; None: the default there. The bounds include the rounding of
/// the image.
#[pyclass(name = "DepthView", module = "cranny", frozen)]
pub struct PyDepthView {
    pub view: View,
    dropped: DroppedDepths,
    made: Made,
}

#[pymethods]
impl PyDepthView {
    #[new]
    #[pyo3(signature = (image, intrinsics, pose, *, name="view", scale=None, q=None, depth_error_m=None,
        depth_error_share=None, lateral_error_px=None, position_error_m=None, turn_error_deg=None, nearest_m=None, farthest_m=None))]
    #[allow(clippy::too_many_arguments, reason = "the keywords of the Python class")]
    fn new(
        image: &Bound<'_, PyAny>,
        intrinsics: &Bound<'_, PyAny>,
        pose: &Bound<'_, PyAny>,
        name: &str,
        scale: Option<f64>,
        q: Option<&Bound<'_, PyAny>>,
        depth_error_m: Option<f64>,
        depth_error_share: Option<f64>,
        lateral_error_px: Option<f64>,
        position_error_m: Option<f64>,
        turn_error_deg: Option<f64>,
        nearest_m: Option<f64>,
        farthest_m: Option<f64>,
    ) -> PyResult<Self> {
        let py = image.py();
        let array = DepthArray::read(image, scale)?;
        let [focal_x, focal_y, center_x, center_y] = intrinsics_of(intrinsics)?;
        let (is_single, places) = poses(pose, "pose")?;
        let [world_from_camera] = places[..] else { return Err(one_pose()) };
        if !is_single {
            return Err(one_pose());
        }
        let size_px = [array.width, array.height];
        let camera = Camera::new(size_px, [focal_x, focal_y], [center_x, center_y], world_from_camera);
        let default = SensorModel::default();
        let sensor = SensorModel {
            depth_error_m: depth_error_m.unwrap_or(default.depth_error_m),
            depth_error_share: depth_error_share.unwrap_or(default.depth_error_share),
            lateral_error_px: lateral_error_px.unwrap_or(default.lateral_error_px),
            position_error_m: position_error_m.unwrap_or(default.position_error_m),
            turn_error_rad: turn_error_deg.map_or(default.turn_error_rad, f64::to_radians),
            nearest_m: nearest_m.unwrap_or(default.nearest_m),
            farthest_m: farthest_m.unwrap_or(default.farthest_m),
        };
        let dropped = array.dropped([sensor.nearest_m, sensor.farthest_m]);
        let depth = DepthImage::new(array.width, array.height, array.depths_m).map_err(fault)?;
        let configuration = q.map(configuration_of).transpose()?;
        let view = View::new(name, camera.map_err(fault)?, depth, sensor).map_err(fault)?;
        let view = view.at_configuration(configuration);
        let keywords = PyDict::new(py);
        keywords.set_item("name", name)?;
        keywords.set_item("scale", scale)?;
        keywords.set_item("q", q.map(copied).transpose()?)?;
        for (key, value) in [
            ("depth_error_m", depth_error_m),
            ("depth_error_share", depth_error_share),
            ("lateral_error_px", lateral_error_px),
            ("position_error_m", position_error_m),
            ("turn_error_deg", turn_error_deg),
            ("nearest_m", nearest_m),
            ("farthest_m", farthest_m),
        ] {
            keywords.set_item(key, value)?;
        }
        // A mask is a part of the image.
        let with_mask = [("subok", true)].into_py_dict(py)?;
        let image = py.import("numpy")?.getattr("array")?.call((image,), Some(&with_mask))?;
        let constructor = partial(py.get_type::<Self>().as_any(), &keywords)?;
        let made = Made::by(constructor, (image, copied(intrinsics)?, copied(pose)?))?;
        Ok(Self { view, dropped, made })
    }

    /// Reads a folder of views with a `views.yaml`, as `cranny sense` writes it: a list of DepthView. All depths that are not valid
    /// count as "nan".
    #[staticmethod]
    fn load<'py>(py: Python<'py>, path: PathBuf) -> PyResult<Vec<Bound<'py, Self>>> {
        let views = py.detach(|| Views::read(&path)).map_err(fault)?.views;
        let class = py.get_type::<Self>();
        let made = |StoredView { view, .. }: StoredView| -> PyResult<Bound<'py, Self>> {
            let View { name, camera, depth, sensor, configuration } = view;
            let keywords = PyDict::new(py);
            keywords.set_item("name", name)?;
            keywords.set_item("q", configuration)?;
            for (key, value) in [
                ("depth_error_m", sensor.depth_error_m),
                ("depth_error_share", sensor.depth_error_share),
                ("lateral_error_px", sensor.lateral_error_px),
                ("position_error_m", sensor.position_error_m),
                ("turn_error_deg", sensor.turn_error_rad.to_degrees()),
                ("nearest_m", sensor.nearest_m),
                ("farthest_m", sensor.farthest_m),
            ] {
                keywords.set_item(key, value)?;
            }
            let image = shaped(py, depth.depths_m().to_vec(), &[depth.height(), depth.width()])?;
            let intrinsics = (camera.focal_x_px, camera.focal_y_px, camera.center_x_px, camera.center_y_px);
            let pose = matrices(py, std::iter::once(camera.world_from_camera))?.get_item(0)?;
            Ok(class.call((image, intrinsics, pose), Some(&keywords))?.cast_into::<Self>()?)
        };
        views.into_iter().map(made).collect()
    }

    /// Name in reports.
    #[getter]
    fn name(&self) -> &str {
        &self.view.name
    }

    /// Rows and columns of the image.
    #[getter]
    fn shape(&self) -> (usize, usize) {
        (self.view.camera.height_px, self.view.camera.width_px)
    }

    /// Depths in metres, (H, W), as float32; NaN where the depth is not valid, also beyond the range of the sensor.
    #[getter]
    fn depths<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f32>>> {
        let View { depth, sensor, .. } = &self.view;
        let range_m = sensor.nearest_m..=sensor.farthest_m;
        let valid = |depth_m: &f32| if range_m.contains(&f64::from(*depth_m)) { *depth_m } else { f32::NAN };
        shaped(py, depth.depths_m().iter().map(valid).collect(), &[depth.height(), depth.width()])
    }

    /// Focal lengths and principal point in pixels: (fx, fy, cx, cy).
    #[getter]
    fn intrinsics(&self) -> (f64, f64, f64, f64) {
        let Camera { focal_x_px, focal_y_px, center_x_px, center_y_px, .. } = self.view.camera;
        (focal_x_px, focal_y_px, center_x_px, center_y_px)
    }

    /// Pose of the optical frame, `world_from_camera`, (4, 4).
    #[getter]
    fn pose<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        matrices(py, std::iter::once(self.view.camera.world_from_camera))?.get_item(0)
    }

    /// Configuration of the robot in the image, (D,); None: that at the start of the motion.
    #[getter]
    fn q<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArrayDyn<f64>>>> {
        let q = self.view.configuration.as_ref();
        q.map(|q| shaped(py, q.clone(), &[q.len()])).transpose()
    }

    /// Returns the same view with the robot at `q` in the image (None: at the start of the motion).
    #[pyo3(signature = (q))]
    fn with_q<'py>(slf: &Bound<'py, Self>, q: Option<&Bound<'py, PyAny>>) -> PyResult<Self> {
        let own = slf.get();
        let view = own.view.clone().at_configuration(q.map(configuration_of).transpose()?);
        let made = Made::by_method(slf, ("with_q", q.map(copied).transpose()?), None)?;
        Ok(Self { view, dropped: own.dropped, made })
    }

    /// Number of pixels with a valid depth in the range of the sensor.
    #[getter]
    fn valid(&self) -> usize {
        self.view.camera.pixel_count() - self.dropped.sum()
    }

    /// Numbers of the other pixels: a dictionary of "zero", "nan", "infinite", "negative", "masked" and "out_of_range".
    #[getter]
    fn dropped<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        python_of(py, &self.dropped)
    }

    /// Returns the measured points in the planning frame, (N, 3), in metres, as float32, row by row; also those beyond the range of
    /// the sensor.
    fn points<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArrayDyn<f32>>> {
        let points = self.view.cloud().points;
        shaped(py, points.as_flattened().to_vec(), &[points.len(), 3])
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Reduced<'py>> {
        slf.get().made.reduced(slf, "make it again")
    }

    fn __repr__(&self) -> String {
        let Camera { width_px, height_px, .. } = self.view.camera;
        format!("<cranny.DepthView '{}': {width_px} × {height_px}, {} valid>", self.view.name, self.valid())
    }
}

/// Reads a configuration, (D,).
fn configuration_of(value: &Bound<'_, PyAny>) -> PyResult<Vec<f64>> {
    let numbers = Numbers::read(value, "q")?;
    match numbers.shape() {
        [_] => Ok(numbers.finite()?.to_vec()),
        _ => Err(numbers.wrong_shape("one value per joint, (D,),")),
    }
}

fn one_pose() -> PyErr {
    bad_value("pose: one matrix (4, 4) is expected")
}

/// Reads focal lengths and principal point (px): (fx, fy, cx, cy) or a camera matrix.
fn intrinsics_of(value: &Bound<'_, PyAny>) -> PyResult<[f64; 4]> {
    let expected = "(fx, fy, cx, cy) or a camera matrix (3, 3), in pixels,";
    if value.is_none() {
        return Err(bad_value(format!("intrinsics: there are none, but {expected} is expected")));
    }
    let numbers = Numbers::read(value, "intrinsics")?;
    match (numbers.shape(), numbers.finite()?) {
        ([4], &[focal_x, focal_y, center_x, center_y]) => Ok([focal_x, focal_y, center_x, center_y]),
        ([3, 3], &[focal_x, skew, center_x, below, focal_y, center_y, left, middle, last]) => {
            let is_plain = [skew, below, left, middle, last - 1.0].iter().all(|rest| rest.abs() <= 0.0);
            if is_plain {
                Ok([focal_x, focal_y, center_x, center_y])
            } else {
                Err(bad_value(
                    "intrinsics: a camera matrix is [[fx, 0, cx], [0, fy, cy], [0, 0, 1]]; rectify images of a \
                     camera with skew",
                ))
            }
        }
        _ => Err(numbers.wrong_shape(expected.trim_end_matches(','))),
    }
}
