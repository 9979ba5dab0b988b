use std::io::BufWriter;
use std::path::Path;

use cranny_scenario::{ScenarioError, write_whole_file};
use rayon::prelude::*;

use crate::{Picture, PictureSettings, Scene, StandardView, ViewError};

impl Picture {
    /// Writes the picture as a PNG file. An existing file is replaced as a whole or not at all.
    ///
    /// # Errors
    /// [`ViewError::Unwritable`].
    pub fn write_png(&self, path: &Path) -> Result<(), ViewError> {
        write_whole(path, &self.png(path)?)
    }

    /// Encodes the picture as a PNG file; `path` names it in errors.
    ///
    /// # Errors
    /// [`ViewError::Encoding`].
    pub fn png(&self, path: &Path) -> Result<Vec<u8>, ViewError> {
        let mut bytes = Vec::new();
        let encoded = (|| {
            let mut writer = encoder(self, &mut bytes).write_header()?;
            writer.write_image_data(&self.bytes())?;
            writer.finish()
        })();
        encoded.map_err(|reason: png::EncodingError| encoding(path, &reason))?;
        Ok(bytes)
    }
}

/// Sequence of pictures for an animated file or for many files.
pub struct Animation {
    /// Pictures, all of one size.
    pub pictures: Vec<Picture>,
    /// Frame rate, in pictures per second; at most 50, the limit of common GIF players.
    pub rate_hz: u16,
}

impl Animation {
    /// Renders instants of the motion of a scene on all cores. `each` gets every picture, in any order, with its index.
    ///
    /// # Errors
    /// Those of [`Picture::of`] and of `each`.
    ///
    /// # Panics
    /// See [`Picture::of`].
    pub fn draw<T: Send>(
        scene: &Scene,
        view: StandardView,
        settings: &PictureSettings,
        frames: &[usize],
        each: impl Fn(usize, Picture) -> Result<T, ViewError> + Sync,
    ) -> Result<Vec<T>, ViewError> {
        let draw = |(place, &frame): (usize, &usize)| {
            let settings = PictureSettings { frame: Some(frame), ..settings.clone() };
            each(place, Picture::of(scene, view, &settings)?)
        };
        frames.par_iter().enumerate().map(draw).collect()
    }
}

/// Duration of the last picture before the animation repeats, in seconds.
const LAST_STANDS_S: u16 = 1;

impl Animation {
    /// Writes an animated PNG, which browsers show as a picture.
    ///
    /// # Errors
    /// [`ViewError::Encoding`], [`ViewError::Unwritable`].
    pub fn write_apng(&self, path: &Path) -> Result<(), ViewError> {
        let Some(first) = self.pictures.first() else { return Ok(()) };
        let mut bytes = Vec::new();
        let encoded = (|| {
            let mut encoder = encoder(first, &mut bytes);
            let count = u32::try_from(self.pictures.len()).unwrap_or(u32::MAX);
            encoder.set_animated(count, 0)?;
            encoder.set_frame_delay(1, self.rate_hz)?;
            let mut writer = encoder.write_header()?;
            for (index, picture) in self.pictures.iter().enumerate() {
                if index + 1 == self.pictures.len() {
                    writer.set_frame_delay(LAST_STANDS_S, 1)?;
                }
                writer.write_image_data(&picture.bytes())?;
            }
            writer.finish()
        })();
        encoded.map_err(|reason: png::EncodingError| encoding(path, &reason))?;
        write_whole(path, &bytes)
    }

    /// Writes a GIF, with 256 colours per picture, for viewers without support for animated PNG.
    ///
    /// # Errors
    /// [`ViewError::Encoding`], also for sides above 65535 pixels; [`ViewError::Unwritable`].
    pub fn write_gif(&self, path: &Path) -> Result<(), ViewError> {
        let Some(first) = self.pictures.first() else { return Ok(()) };
        let side = |side: usize| u16::try_from(side).map_err(|reason| encoding(path, &reason));
        let (width, height) = (side(first.width())?, side(first.height())?);
        let mut bytes = Vec::new();
        let encoded = (|| {
            let mut encoder = gif::Encoder::new(BufWriter::new(&mut bytes), width, height, &[])?;
            encoder.set_repeat(gif::Repeat::Infinite)?;
            for (index, picture) in self.pictures.iter().enumerate() {
                // This is the fastest setting of the quantiser without visible bands on the floor.
                const SPEED: i32 = 10;
                let mut frame = gif::Frame::from_rgb_speed(width, height, &picture.bytes(), SPEED);
                let is_last = index + 1 == self.pictures.len();
                // The delay is in hundredths of a second, so that delays differ by one at rates that do not divide 100.
                let end = |count: usize| 100 * count / usize::from(self.rate_hz.max(1));
                let delay = u16::try_from(end(index + 1) - end(index)).unwrap_or(1);
                frame.delay = if is_last { 100 * LAST_STANDS_S } else { delay };
                encoder.write_frame(&frame)?;
            }
            Ok(())
        })();
        encoded.map_err(|reason: gif::EncodingError| encoding(path, &reason))?;
        write_whole(path, &bytes)
    }
}

fn encoder<'a>(picture: &Picture, bytes: &'a mut Vec<u8>) -> png::Encoder<'a, &'a mut Vec<u8>> {
    let side = |side: usize| u32::try_from(side).unwrap_or(u32::MAX);
    let mut encoder = png::Encoder::new(bytes, side(picture.width()), side(picture.height()));
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    encoder.set_compression(png::Compression::Balanced);
    encoder
}

fn encoding(path: &Path, reason: &dyn std::fmt::Display) -> ViewError {
    ViewError::Encoding { path: path.to_owned(), reason: reason.to_string() }
}

/// Writes a file as a whole or not at all.
pub(crate) fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), ViewError> {
    write_whole_file(path, bytes).map_err(|fault| match fault {
        ScenarioError::Unwritable { path, reason } => ViewError::Unwritable { path, reason },
        other => other.into(),
    })
}
