use std::collections::HashSet;
use std::fmt;
use std::path::Path;

use cranny_file::TEXT;
use cranny_robot::Location;
use cranny_spatial::{Point, Pose, Rotation, Vector, rotation_from_xyzw};
use serde::de::{DeserializeOwned, Error, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};
use serde_saphyr::Spanned;

use crate::{Camera, CameraFrame, SenseError, SensorModel};

/// Camera of a file. Metres, and degrees where the key contains `deg`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct CameraEntry {
    /// Name, which begins the names of files.
    pub name: Spanned<String>,
    /// Width and height of the image, in pixels.
    width: usize,
    height: usize,
    /// Focal length along x and y, or one for both, in pixels.
    focal_px: Option<Focal>,
    /// Horizontal field of view; alternative to the focal length.
    field_of_view_deg: Option<f64>,
    /// Principal point. Default: the middle of the image.
    center_px: Option<[f64; 2]>,
    /// Position of the optical frame, and a point in front of the camera, in the frame.
    position_m: [f64; 3],
    look_at_m: Option<[f64; 3]>,
    /// Direction that is upwards in the image. Default: z of the frame.
    up: Option<[f64; 3]>,
    /// Rotation of the optical frame; alternatives to the point in front.
    rotation_rpy_deg: Option<[f64; 3]>,
    quaternion_xyzw: Option<[f64; 4]>,
    /// Frame of the pose: `world`, or `link NAME` for a camera on a link of the robot. Default: `world`.
    frame: Option<Spanned<String>>,
    /// Configuration of the robot in the image (m, rad), one value per joint. Default: its start.
    configuration: Option<Spanned<Vec<f64>>>,
    /// Bounds of the sensor that differ from those of the file.
    sensor: Option<SensorEntry>,
    /// Files of the depths and of the segments, in a file of views.
    pub depth: Option<Spanned<String>>,
    pub segments: Option<Spanned<String>>,
    /// Unit of the depths. Default: 0.001 for PNG, 1 for NPY.
    pub depth_unit_m: Option<f64>,
}

/// Bounds of a sensor; missing ones are those of the file, or the default.
#[derive(Clone, Copy, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct SensorEntry {
    depth_error_m: Option<f64>,
    depth_error_share: Option<f64>,
    lateral_error_px: Option<f64>,
    position_error_m: Option<f64>,
    turn_error_deg: Option<f64>,
    nearest_m: Option<f64>,
    farthest_m: Option<f64>,
}

impl SensorEntry {
    pub fn or(self, otherwise: SensorModel) -> SensorModel {
        SensorModel {
            depth_error_m: self.depth_error_m.unwrap_or(otherwise.depth_error_m),
            depth_error_share: self.depth_error_share.unwrap_or(otherwise.depth_error_share),
            lateral_error_px: self.lateral_error_px.unwrap_or(otherwise.lateral_error_px),
            position_error_m: self.position_error_m.unwrap_or(otherwise.position_error_m),
            turn_error_rad: self.turn_error_deg.map_or(otherwise.turn_error_rad, f64::to_radians),
            nearest_m: self.nearest_m.unwrap_or(otherwise.nearest_m),
            farthest_m: self.farthest_m.unwrap_or(otherwise.farthest_m),
        }
    }
}

/// Focal lengths along x and y, in pixels.
struct Focal([f64; 2]);

impl<'de> Deserialize<'de> for Focal {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(FocalVisitor)
    }
}

/// Visitor of focal lengths; an untagged enum would lose their line.
struct FocalVisitor;

impl<'de> Visitor<'de> for FocalVisitor {
    type Value = Focal;

    fn expecting(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        formatter.write_str("a number, or a list of two")
    }

    fn visit_f64<E: Error>(self, focal_px: f64) -> Result<Focal, E> {
        Ok(Focal([focal_px; 2]))
    }

    fn visit_u64<E: Error>(self, focal_px: u64) -> Result<Focal, E> {
        Ok(Focal([focal_px as f64; 2]))
    }

    fn visit_i64<E: Error>(self, focal_px: i64) -> Result<Focal, E> {
        Ok(Focal([focal_px as f64; 2]))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut values: A) -> Result<Focal, A::Error> {
        let mut focal_px = Vec::new();
        while let Some(value) = values.next_element::<f64>()? {
            focal_px.push(value);
        }
        match focal_px[..] {
            [both] => Ok(Focal([both; 2])),
            [x, y] => Ok(Focal([x, y])),
            _ => Err(A::Error::invalid_length(focal_px.len(), &self)),
        }
    }
}

/// Text of a file with its path, for errors.
pub(crate) struct Source<'a> {
    pub path: &'a Path,
}

impl Source<'_> {
    /// Reads the file as YAML.
    pub fn read<T: DeserializeOwned>(&self) -> Result<T, SenseError> {
        let path = self.path;
        let text =
            TEXT.text(path).map_err(|reason| SenseError::Unreadable { path: path.to_owned(), reason })?;
        if text.trim().is_empty() {
            return Err(SenseError::content(path, "the file is empty"));
        }
        cranny_file::yaml(&text).map_err(|reason| SenseError::Yaml { at: self.line(reason.line), reason })
    }

    fn line(&self, line: usize) -> Location {
        Location { file: self.path.display().to_string(), line: u32::try_from(line).unwrap_or(u32::MAX) }
    }

    /// Returns an error at the place of an entry.
    pub fn fault<T>(&self, entry: &Spanned<T>, problem: impl Into<String>) -> SenseError {
        let line = usize::try_from(entry.referenced.line()).unwrap_or(0).max(1);
        SenseError::Entry { at: self.line(line), problem: problem.into() }
    }

    /// Checks that the names of all cameras are file names and differ.
    pub fn check_names(&self, entries: &[Spanned<CameraEntry>]) -> Result<(), SenseError> {
        /// Maximum length of a name, in bytes.
        const LONGEST: usize = 64;
        let mut taken = HashSet::new();
        for entry in entries {
            let name = &entry.value.name;
            let is_plain = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
            if name.value.is_empty() || name.value.len() > LONGEST || !name.value.chars().all(is_plain) {
                let problem = "the name of a camera begins the names of files: give up to 64 letters, digits, '_' and '-'";
                return Err(self.fault(name, problem));
            }
            // Some file systems do not distinguish small letters from capitals.
            if !taken.insert(name.value.to_ascii_lowercase()) {
                return Err(
                    self.fault(name, format!("the name '{}' is taken by a camera before", name.value))
                );
            }
        }
        Ok(())
    }
}

impl CameraEntry {
    /// Returns the camera with its pose in its frame, and its sensor; `source` and `entry` locate errors.
    pub fn camera(
        entry: &Spanned<Self>,
        source: &Source,
        of_file: SensorModel,
    ) -> Result<(Camera, CameraFrame, SensorModel), SenseError> {
        let own = &entry.value;
        let fault = |problem: String| source.fault(entry, format!("camera '{}': {problem}", own.name.value));
        let size_px = [own.width, own.height];
        let focal_px = match (&own.focal_px, own.field_of_view_deg) {
            (Some(Focal(focal_px)), None) => *focal_px,
            (None, Some(degrees)) => {
                let focal_px = Camera::focal_of_field_px(own.width, degrees.to_radians());
                [focal_px.map_err(|problem| fault(problem.to_string()))?; 2]
            }
            _ => return Err(fault("give either focal_px or field_of_view_deg".to_owned())),
        };
        let center_px = own.center_px.unwrap_or_else(|| Camera::middle_px(size_px));
        let frame_from_camera = own.pose().map_err(fault)?;
        let camera = Camera::new(size_px, focal_px, center_px, frame_from_camera)
            .map_err(|problem| fault(problem.to_string()))?;
        let sensor = own.sensor.unwrap_or_default().or(of_file);
        sensor.check().map_err(|problem| fault(problem.to_string()))?;
        let frame = match &own.frame {
            None => CameraFrame::World,
            Some(frame) => CameraFrame::parse(&frame.value)
                .ok_or_else(|| source.fault(frame, "the frame of a camera is `world` or `link NAME`"))?,
        };
        Ok((camera, frame, sensor))
    }

    /// Returns the configuration of the robot in the image (m, rad; one value per joint); `None`: its start.
    pub fn configuration(&self, source: &Source) -> Result<Option<Vec<f64>>, SenseError> {
        let Some(own) = &self.configuration else { return Ok(None) };
        if own.value.iter().all(|value| value.is_finite()) {
            return Ok(Some(own.value.clone()));
        }
        Err(source.fault(own, "a configuration has only finite numbers"))
    }

    fn pose(&self) -> Result<Pose, String> {
        let position = Point::from(self.position_m);
        let numbers = self.position_m.iter().chain(self.look_at_m.iter().flatten());
        let rotations = self.rotation_rpy_deg.iter().flatten().chain(self.quaternion_xyzw.iter().flatten());
        if numbers.chain(self.up.iter().flatten()).chain(rotations).any(|number| !number.is_finite()) {
            return Err("a pose has only finite numbers".to_owned());
        }
        let rotation = match (self.look_at_m, self.rotation_rpy_deg, self.quaternion_xyzw) {
            (Some(point), None, None) => {
                let up = self.up.map_or_else(Vector::z, Vector::from);
                let pose = Camera::looking_at(&position, &point.into(), &up);
                return pose.ok_or_else(|| "look_at_m must differ from position_m".to_owned());
            }
            (None, ..) if self.up.is_some() => return Err("up needs look_at_m".to_owned()),
            (None, Some([roll, pitch, yaw]), None) => {
                Rotation::from_euler_angles(roll.to_radians(), pitch.to_radians(), yaw.to_radians())
            }
            (None, None, Some(quaternion)) => rotation_from_xyzw(quaternion)
                .map_err(|norm| format!("the quaternion has length {norm} instead of 1"))?,
            _ => return Err("give exactly one of look_at_m, rotation_rpy_deg and quaternion_xyzw".to_owned()),
        };
        Ok(Pose::from_parts(position.coords.into(), rotation))
    }
}
