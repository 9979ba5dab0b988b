//! Films in H.264, which `ffmpeg` encodes while they are drawn.

use std::ffi::OsString;
use std::io::{self, Read as _, Write as _};
use std::path::Path;
use std::process::{Child, ChildStderr, Command, Stdio};
use std::thread::JoinHandle;

use cranny_file::system::{ending, installed_command};
use cranny_scenario::write_whole_file_by;

use crate::{Animation, PictureSettings, Scene, StandardView, ViewError};

/// Name of the encoder's program.
const ENCODER: &str = "ffmpeg";

/// Number of pictures that are drawn before they are encoded, per core: few are in memory, and no core waits for long.
const PICTURES_PER_CORE: usize = 4;

/// Quality of x264, from 0 (lossless) to 51: no visible loss at edges.
const QUALITY: &str = "18";

/// Maximum length of the message that is shown, in characters.
const MOST_SHOWN: usize = 200;

/// Maximum length of the messages of `ffmpeg` that are kept, in bytes.
const MOST_MESSAGES: u64 = 1 << 16;

/// MP4 file in H.264, encoded by the `ffmpeg` on the `PATH`.
pub struct Film<'a> {
    /// Scene with a motion.
    pub scene: &'a Scene,
    /// Direction of the view, unless the settings have a camera.
    pub view: StandardView,
    /// Size and look of each picture; both sides are even numbers of pixels.
    pub settings: &'a PictureSettings,
    /// Frame rate, in pictures per second.
    pub rate_hz: u16,
}

impl Film<'_> {
    /// Checks that `ffmpeg` is on the `PATH`.
    ///
    /// # Errors
    /// [`ViewError::NoFilmEncoder`].
    pub fn check_encoder() -> Result<(), ViewError> {
        encoder().map(drop)
    }

    /// Draws instants of the motion and writes them to a file, which is replaced as a whole or not at all. The same `ffmpeg` writes
    /// the same bytes. `drawn` is called after each picture.
    ///
    /// # Errors
    /// [`ViewError::NoFilmEncoder`], [`ViewError::Encoding`] for odd sides and with the message of `ffmpeg`,
    /// [`ViewError::Unwritable`], those of [`Animation::draw`].
    ///
    /// # Panics
    /// See [`Animation::draw`].
    pub fn write(&self, frames: &[usize], path: &Path, drawn: impl Fn() + Sync) -> Result<(), ViewError> {
        let fault = |reason: String| ViewError::Encoding { path: path.to_owned(), reason };
        let PictureSettings { width, height, .. } = *self.settings;
        if !width.is_multiple_of(2) || !height.is_multiple_of(2) {
            return Err(fault(format!(
                "the sides of a film must be even numbers of pixels, but are {width} × {height}"
            )));
        }
        let mut command = encoder()?;
        write_whole_file_by(path, |partial| {
            let begun = Encoding::begin(command.args(self.arguments(partial)));
            let mut encoding =
                begun.map_err(|reason| fault(format!("{ENCODER} does not start: {reason}")))?;
            for frames in frames.chunks(PICTURES_PER_CORE * rayon::current_num_threads()) {
                let pictures =
                    Animation::draw(self.scene, self.view, self.settings, frames, |_, picture| {
                        drawn();
                        Ok(picture)
                    })?;
                if pictures.iter().any(|picture| encoding.push(&picture.bytes()).is_err()) {
                    break;
                }
            }
            encoding.end().map_err(|reason| fault(format!("{ENCODER} failed: {reason}")))
        })
    }

    fn arguments(&self, file: &Path) -> Vec<OsString> {
        let PictureSettings { width, height, .. } = *self.settings;
        let (size, rate) = (format!("{width}x{height}"), self.rate_hz.to_string());
        let input = ["-f", "rawvideo", "-pixel_format", "rgb24", "-video_size", &size, "-framerate", &rate];
        // Players expect colours of HD video with a colour sample for each four pixels.
        let colours = [
            "-vf",
            "scale=out_color_matrix=bt709:flags=accurate_rnd+bitexact,format=yuv420p",
            "-colorspace",
            "bt709",
        ];
        // One thread, and code that is equal on all processors, so that bytes are equal too.
        let codec =
            ["-c:v", "libx264", "-crf", QUALITY, "-threads", "1", "-x264-params", "cpu-independent=1"];
        let exact = ["-map_metadata", "-1", "-fflags", "+bitexact", "-flags:v", "+bitexact"];
        let output = ["-movflags", "+faststart", "-f", "mp4"];
        let quiet = ["-hide_banner", "-nostdin", "-loglevel", "error"];
        let words = quiet.iter().chain(&input).chain(&["-i", "pipe:0"]).chain(&colours);
        let words = words.chain(&codec).chain(&exact).chain(&output);
        // A path alone could be read as a flag or an address.
        let mut place = OsString::from("file:");
        place.push(file);
        words.map(OsString::from).chain([place]).collect()
    }
}

fn encoder() -> Result<Command, ViewError> {
    let mut command = installed_command(ENCODER).map_err(|_| ViewError::NoFilmEncoder)?;
    // These make it write a report to the current folder, or colours into its messages.
    command.env_remove("FFREPORT").env_remove("AV_LOG_FORCE_COLOR");
    Ok(command)
}

/// Running encoder; ended with this value.
struct Encoding {
    child: Child,
    messages: Option<JoinHandle<String>>,
}

impl Encoding {
    fn begin(command: &mut Command) -> io::Result<Self> {
        let streams = command.stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::piped());
        let mut child = streams.spawn()?;
        let messages = child.stderr.take().map(|stderr| std::thread::spawn(move || all_of(stderr)));
        Ok(Self { child, messages })
    }

    fn push(&mut self, bytes: &[u8]) -> io::Result<()> {
        let input = self.child.stdin.as_mut().ok_or(io::ErrorKind::BrokenPipe)?;
        input.write_all(bytes)
    }

    /// Completes the file. Returns the reason of a failure: the first message of the encoder, or how it ended.
    fn end(mut self) -> Result<(), String> {
        drop(self.child.stdin.take());
        let status = self.child.wait().map_err(|reason| reason.to_string())?;
        let messages = self.messages.take().and_then(|reading| reading.join().ok()).unwrap_or_default();
        if status.success() {
            return Ok(());
        }
        let first = messages.lines().map(without_source).find(|line| !line.is_empty());
        Err(first.map_or_else(|| ending(status), |line| line.chars().take(MOST_SHOWN).collect()))
    }
}

impl Drop for Encoding {
    fn drop(&mut self) {
        // It may have ended already.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Returns a message of `ffmpeg` without the part that it is of, such as `[mp4 @ 0x55d5]`.
fn without_source(line: &str) -> &str {
    let line = line.trim();
    let after = line.strip_prefix('[').and_then(|rest| rest.split_once("] "));
    after.map_or(line, |(_, message)| message.trim())
}

/// Reads messages to their end, and keeps the beginning.
fn all_of(mut stderr: ChildStderr) -> String {
    let mut bytes = Vec::new();
    // Without them, the exit code remains.
    let _ = (&mut stderr).take(MOST_MESSAGES).read_to_end(&mut bytes);
    let _ = io::copy(&mut stderr, &mut io::sink());
    String::from_utf8_lossy(&bytes).into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_message_is_shown_without_its_source() {
        assert_eq!(
            without_source("[vost#0:0 @ 0x55] Unknown encoder 'libx264'"),
            "Unknown encoder 'libx264'"
        );
        assert_eq!(without_source(" Conversion failed!"), "Conversion failed!");
        assert_eq!(without_source("[x"), "[x");
    }
}
