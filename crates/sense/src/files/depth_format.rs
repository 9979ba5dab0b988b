use cranny_file::npy_header;

use crate::{DepthImage, SenseError};

/// Formats in which depths are written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum DepthFormat {
    /// PNG of one channel of 16 bits: millimetres, 0 for no valid depth, as `16UC1` of ROS.
    #[default]
    Png,
    /// `NumPy` array of `f32` (rows, columns): metres, NaN for no valid depth, as `32FC1` of ROS.
    Npy,
}

/// Unit of depths in a PNG, in metres.
pub(crate) const PNG_UNIT_M: f64 = 0.001;

impl DepthFormat {
    /// Returns the ending of file names.
    pub fn ending(self) -> &'static str {
        match self {
            Self::Png => "png",
            Self::Npy => "npy",
        }
    }

    /// Returns the greatest error that writing adds to a depth, in metres.
    pub fn rounding_m(self) -> f64 {
        match self {
            Self::Png => 0.5 * PNG_UNIT_M,
            Self::Npy => 0.0,
        }
    }

    /// Returns the unit of the written depths, in metres.
    pub fn unit_m(self) -> f64 {
        match self {
            Self::Png => PNG_UNIT_M,
            Self::Npy => 1.0,
        }
    }

    /// Returns the bytes of a file of depths; `name` names it in errors. A depth beyond 65.535 m is not valid in a PNG.
    pub(crate) fn bytes(self, image: &DepthImage, name: &str) -> Result<Vec<u8>, SenseError> {
        match self {
            Self::Png => {
                let depths_m = image.depths_m().iter().map(|depth_m| f64::from(*depth_m));
                #[allow(
                    clippy::cast_possible_truncation,
                    clippy::cast_sign_loss,
                    reason = "within the range of u16, and NaN becomes 0"
                )]
                let units = depths_m.map(|depth_m| match (depth_m / PNG_UNIT_M).round() {
                    units if units <= f64::from(u16::MAX) => units as u16,
                    _ => 0,
                });
                png_bytes([image.width(), image.height()], units, name)
            }
            Self::Npy => {
                let mut bytes = npy_header("<f4", &[image.height() as u64, image.width() as u64]);
                bytes.extend(image.depths_m().iter().flat_map(|depth_m| depth_m.to_le_bytes()));
                Ok(bytes)
            }
        }
    }
}

/// Returns a PNG of one channel of 16 bits, of this width and height (px).
pub(crate) fn png_bytes(
    size_px: [usize; 2],
    values: impl Iterator<Item = u16>,
    name: &str,
) -> Result<Vec<u8>, SenseError> {
    let [width, height] = size_px.map(|side| u32::try_from(side).unwrap_or(u32::MAX));
    let data: Vec<u8> = values.flat_map(u16::to_be_bytes).collect();
    let mut bytes = Vec::new();
    let encoded = (|| {
        let mut encoder = png::Encoder::new(&mut bytes, width, height);
        encoder.set_color(png::ColorType::Grayscale);
        encoder.set_depth(png::BitDepth::Sixteen);
        encoder.set_compression(png::Compression::Balanced);
        let mut writer = encoder.write_header()?;
        writer.write_image_data(&data)?;
        writer.finish()
    })();
    encoded.map_err(|reason: png::EncodingError| SenseError::Encoding {
        name: name.to_owned(),
        reason: reason.to_string(),
    })?;
    Ok(bytes)
}
