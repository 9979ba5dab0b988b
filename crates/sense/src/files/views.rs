use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use cranny_spatial::Pose;
use serde::Deserialize;
use serde_saphyr::Spanned;

use crate::files::camera_entry::{CameraEntry, SensorEntry, Source};
use crate::files::depth_format::{DepthFormat, png_bytes};
use crate::files::depth_reading::{read_depths, read_segments};
use crate::{CameraFrame, Segment, SenseError, SensorModel, View};

/// Name of the file that lists the views of a folder.
pub const VIEWS_FILE: &str = "views.yaml";

/// Format of the file.
const FORMAT: &str = "cranny-views/1";

/// Maximum number of pixels of all views together: four images of 1280 × 720, or 54 of 320 × 240.
const MOST_PIXELS: usize = 1 << 22;

/// Views with the segments that they show, as a folder of files holds them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Views {
    /// Views in order.
    pub views: Vec<StoredView>,
    /// Segments by number, from 1; empty if no view has an image of segments.
    pub segments: Vec<Segment>,
}

/// View, with its image of segments if there is one.
#[derive(Clone, Debug, PartialEq)]
pub struct StoredView {
    /// The view.
    pub view: View,
    /// Number of the segment of each pixel, row by row; 0 for none.
    pub segments: Option<Vec<u16>>,
}

/// Name and content of a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NamedFile {
    /// Name within a folder.
    pub name: String,
    /// Content.
    pub content: Vec<u8>,
}

/// Content of a file of views.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    format: Spanned<String>,
    sensor: Option<SensorEntry>,
    views: Vec<Spanned<CameraEntry>>,
    #[serde(default)]
    segments: Vec<Segment>,
}

impl Views {
    /// Reads a folder with a file `views.yaml`, or such a file by its path.
    ///
    /// # Errors
    /// [`SenseError::Unreadable`], [`SenseError::Yaml`], [`SenseError::Entry`] with the line of the view,
    /// [`SenseError::Content`] with the name of an image.
    pub fn read(path: &Path) -> Result<Self, SenseError> {
        let path: PathBuf = if path.is_dir() { path.join(VIEWS_FILE) } else { path.to_owned() };
        let folder = path.parent().unwrap_or(Path::new(""));
        let source = Source { path: &path };
        let file: File = source.read()?;
        if file.format.value != FORMAT {
            let problem =
                format!("the format is '{FORMAT}', not '{}'", cranny_file::excerpt(&file.format.value));
            return Err(source.fault(&file.format, problem));
        }
        if file.views.is_empty() {
            return Err(SenseError::content(&path, "the list of views is empty"));
        }
        source.check_names(&file.views)?;
        let of_file = file.sensor.unwrap_or_default().or(SensorModel::default());
        let in_folder = |name: &Spanned<String>| {
            let is_plain =
                Path::new(&name.value).components().eq([std::path::Component::Normal(name.value.as_ref())]);
            if is_plain {
                Ok(folder.join(&name.value))
            } else {
                Err(source.fault(name, "give the name of a file in the folder of views.yaml"))
            }
        };
        let mut pixels = 0;
        let view = |entry: &Spanned<CameraEntry>| {
            let own = &entry.value;
            let (camera, frame, sensor) = CameraEntry::camera(entry, &source, of_file)?;
            pixels += camera.width_px.saturating_mul(camera.height_px);
            if pixels > MOST_PIXELS && !cranny_file::are_limits_lifted() {
                let problem = format!(
                    "up to this view there are {pixels} pixels, of which a map keeps some 250 bytes each; the limit is \
                     {MOST_PIXELS} (give fewer or smaller images, or --large-files)"
                );
                return Err(source.fault(entry, problem));
            }
            if frame != CameraFrame::World {
                return Err(source.fault(entry, "the pose of a view is in the frame `world`"));
            }
            let Some(depth) = &own.depth else {
                return Err(source.fault(
                    entry,
                    format!("view '{}' has no file of depths (`depth: NAME`)", own.name.value),
                ));
            };
            if let Some(unit_m) = own.depth_unit_m
                && !(unit_m > 0.0 && unit_m <= 1.0)
            {
                return Err(source.fault(entry, format!("depth_unit_m is above 0, at most 1, not {unit_m}")));
            }
            let depth = read_depths(&in_folder(depth)?, &camera, own.depth_unit_m)?;
            let segments = match &own.segments {
                Some(name) => {
                    let path = in_folder(name)?;
                    let numbers = read_segments(&path, &camera)?;
                    if let Some(beyond) =
                        numbers.iter().find(|number| usize::from(**number) > file.segments.len())
                    {
                        let problem = format!("segment {beyond} is not in the list `segments` of views.yaml");
                        return Err(SenseError::content(&path, problem));
                    }
                    Some(numbers)
                }
                None => None,
            };
            let view = View::new(own.name.value.clone(), camera, depth, sensor)?;
            Ok(StoredView { view: view.at_configuration(own.configuration(&source)?), segments })
        };
        let views = file.views.iter().map(view).collect::<Result<Vec<_>, _>>()?;
        Ok(Self { views, segments: file.segments })
    }

    /// Returns the files of a folder that [`Self::read`] reads: for each view its depths and segments, and `views.yaml`. The
    /// rounding of the format is part of the depth errors that `views.yaml` states.
    ///
    /// # Errors
    /// [`SenseError::Encoding`].
    pub fn files(&self, format: DepthFormat) -> Result<Vec<NamedFile>, SenseError> {
        let mut files = Vec::new();
        let mut text = format!("format: {FORMAT}\nviews:\n");
        for StoredView { view, segments } in &self.views {
            let depth = format!("{}.depth.{}", view.name, format.ending());
            text.push_str(&entry_text(view, format));
            let _ = writeln!(text, "    depth: {depth}\n    depth_unit_m: {}", format.unit_m());
            files.push(NamedFile { content: format.bytes(&view.depth, &depth)?, name: depth });
            if let Some(numbers) = segments {
                let name = format!("{}.segments.png", view.name);
                let _ = writeln!(text, "    segments: {name}");
                let size_px = [view.camera.width_px, view.camera.height_px];
                files.push(NamedFile { content: png_bytes(size_px, numbers.iter().copied(), &name)?, name });
            }
        }
        if !self.segments.is_empty() {
            text.push_str("segments:\n");
        }
        for segment in &self.segments {
            let row = serde_json::to_string(segment).unwrap_or_default();
            let _ = writeln!(text, "  - {row}");
        }
        files.push(NamedFile { name: VIEWS_FILE.to_owned(), content: text.into_bytes() });
        Ok(files)
    }
}

/// Returns the entry of a view, without its files.
fn entry_text(view: &View, format: DepthFormat) -> String {
    let View { name, camera, sensor, configuration, .. } = view;
    let Pose { translation, rotation } = &camera.world_from_camera;
    let list = |values: &[f64]| {
        let values: Vec<String> = values.iter().map(f64::to_string).collect();
        format!("[{}]", values.join(", "))
    };
    let mut text =
        format!("  - name: {name}\n    width: {}\n    height: {}\n", camera.width_px, camera.height_px);
    for (key, value) in [
        ("focal_px", list(&[camera.focal_x_px, camera.focal_y_px])),
        ("center_px", list(&[camera.center_x_px, camera.center_y_px])),
        ("position_m", list(translation.vector.as_slice())),
        ("quaternion_xyzw", list(rotation.coords.as_slice())),
    ] {
        let _ = writeln!(text, "    {key}: {value}");
    }
    if let Some(configuration) = configuration {
        let _ = writeln!(text, "    configuration: {}", list(configuration));
    }
    text.push_str("    sensor:\n");
    for (key, value) in [
        ("depth_error_m", sensor.depth_error_m + format.rounding_m()),
        ("depth_error_share", sensor.depth_error_share),
        ("lateral_error_px", sensor.lateral_error_px),
        ("position_error_m", sensor.position_error_m),
        ("turn_error_deg", sensor.turn_error_rad.to_degrees()),
        ("nearest_m", sensor.nearest_m),
        ("farthest_m", sensor.farthest_m),
    ] {
        let _ = writeln!(text, "      {key}: {value}");
    }
    text
}
