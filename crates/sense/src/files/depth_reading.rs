use std::io::Cursor;
use std::path::Path;

use cranny_file::{NpyArray, TABLE};

use crate::files::depth_format::DepthFormat;
use crate::{Camera, DepthImage, SenseError};

/// Reads a depth image of the size of its camera. `unit_m` is the unit of the depths, in metres; without one it is that of the
/// format.
pub(crate) fn read_depths(
    path: &Path,
    camera: &Camera,
    unit_m: Option<f64>,
) -> Result<DepthImage, SenseError> {
    let bytes = bytes(path)?;
    let size_px = [camera.width_px, camera.height_px];
    let (values, format) = if is_png(&bytes) {
        (png_values(path, &bytes, size_px)?.into_iter().map(f64::from).collect(), DepthFormat::Png)
    } else {
        (npy_values(path, &bytes, size_px)?, DepthFormat::Npy)
    };
    let unit_m = unit_m.unwrap_or_else(|| format.unit_m());
    #[allow(clippy::cast_possible_truncation, reason = "depths are stored as f32")]
    let depths_m = values.into_iter().map(|value| (value * unit_m) as f32).collect();
    Ok(DepthImage::of_camera(camera, depths_m))
}

/// Reads an image of segments of the size of its camera.
pub(crate) fn read_segments(path: &Path, camera: &Camera) -> Result<Vec<u16>, SenseError> {
    let bytes = bytes(path)?;
    if !is_png(&bytes) {
        return Err(SenseError::content(path, "segments are a PNG of one channel of 16 bits"));
    }
    png_values(path, &bytes, [camera.width_px, camera.height_px])
}

fn bytes(path: &Path) -> Result<Vec<u8>, SenseError> {
    TABLE.bytes(path).map_err(|reason| SenseError::Unreadable { path: path.to_owned(), reason })
}

fn is_png(bytes: &[u8]) -> bool {
    bytes.starts_with(b"\x89PNG\r\n\x1a\n")
}

/// Returns the values of a PNG of one channel of 16 bits, whose size is checked before anything is allocated.
fn png_values(path: &Path, bytes: &[u8], size_px: [usize; 2]) -> Result<Vec<u16>, SenseError> {
    let broken = |reason: png::DecodingError| SenseError::content(path, format!("no valid PNG: {reason}"));
    let pixels = size_px[0] * size_px[1];
    // The decoder also buffers rows.
    let limits = png::Limits { bytes: 4 * pixels + (1 << 20) };
    let decoder = png::Decoder::new_with_limits(Cursor::new(bytes), limits);
    let mut reader = decoder.read_info().map_err(broken)?;
    let info = reader.info();
    let actual_px = [info.width, info.height].map(|side| usize::try_from(side).unwrap_or(usize::MAX));
    check_size(path, actual_px, size_px)?;
    if (info.color_type, info.bit_depth) != (png::ColorType::Grayscale, png::BitDepth::Sixteen) {
        let problem = format!(
            "one channel of 16 bits is read, but this PNG is {:?} of {} bits",
            info.color_type, info.bit_depth as u8
        );
        return Err(SenseError::content(path, problem));
    }
    let mut data = vec![0; 2 * pixels];
    reader.next_frame(&mut data).map_err(broken)?;
    Ok(data.chunks_exact(2).map(|pair| u16::from_be_bytes([pair[0], pair[1]])).collect())
}

fn check_size(path: &Path, actual_px: [usize; 2], size_px: [usize; 2]) -> Result<(), SenseError> {
    if actual_px == size_px {
        return Ok(());
    }
    let [[width, height], [camera_width, camera_height]] = [actual_px, size_px];
    let problem =
        format!("the image has {width} × {height} pixels, but its camera {camera_width} × {camera_height}");
    Err(SenseError::content(path, problem))
}

/// Returns the numbers of a `NumPy` array of (rows, columns).
fn npy_values(path: &Path, bytes: &[u8], [width, height]: [usize; 2]) -> Result<Vec<f64>, SenseError> {
    let broken = |problem: String| SenseError::content(path, problem);
    let expected = "depths are a PNG of one channel of 16 bits or a NumPy array";
    let mut array = NpyArray::of(bytes).map_err(|problem| broken(format!("{problem} ({expected})")))?;
    if !array.is_numeric() {
        return Err(broken(format!("an array of {} is not read ({expected} of numbers)", array.kind)));
    }
    let [rows, columns] = array.shape[..] else {
        return Err(broken(format!("an array of shape {:?} is no image of (rows, columns)", array.shape)));
    };
    let side = |side: u64| usize::try_from(side).unwrap_or(usize::MAX);
    check_size(path, [side(columns), side(rows)], [width, height])?;
    let is_column_major = array.is_column_major;
    let mut values = Vec::with_capacity(width * height);
    for value in array.by_ref() {
        values.push(value.map_err(|reason| broken(format!("{reason} (was the file cut short?)")))?);
    }
    if !array.is_at_end().map_err(|reason| broken(reason.to_string()))? {
        return Err(broken("bytes follow the last number".to_owned()));
    }
    if is_column_major {
        values = (0..width * height).map(|at| values[(at % width) * height + at / width]).collect();
    }
    Ok(values)
}
