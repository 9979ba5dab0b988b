//! Moving pictures: files of several frames, and folders of them.

use std::path::Path;

use cranny_scenario::ScenarioError;
use cranny_view::{Animation, Film, Picture, PictureSettings, Scene, StandardView};

use crate::arguments::Output;
use crate::failure::Failure;
use crate::file_kind::FileKind;
use crate::output_file::{self, NamedFile};
use crate::pictures::render_format::Format;
use crate::progress;

/// Maximum number of frames of a motion: some minutes at the highest rate.
const MOST_PICTURES: usize = 10_000;

/// Maximum total number of pixels of an animation in one file, all in memory: 1.5 GB.
const MOST_MOVING_POINTS: usize = 500_000_000;

/// Checks, before anything is drawn, that a format can be written in a size of pictures.
pub fn check(format: Format, (width, height): (usize, usize)) -> Result<(), Failure> {
    if format != Format::Mp4 {
        return Ok(());
    }
    if !width.is_multiple_of(2) || !height.is_multiple_of(2) {
        let even = [width, height].map(|side| side.next_multiple_of(2));
        let problem = format!(
            "the sides of an .mp4 must be even numbers of pixels, such as {}x{}",
            even[0].min(*Picture::SIDES.end()),
            even[1].min(*Picture::SIDES.end())
        );
        return Err(Failure::Flag { flag: "size", problem });
    }
    Ok(Film::check_encoder()?)
}

/// Moving picture of a scene.
pub struct MovingPicture<'a> {
    pub scene: &'a Scene,
    pub settings: &'a PictureSettings,
    /// Requested views: one.
    pub views: Vec<StandardView>,
    pub rate_hz: u16,
    /// Time of the motion between two pictures, in seconds.
    pub step_s: f64,
    pub format: Format,
}

/// Refuses a folder with other files than pictures that are written again: those of a longer film would stay among them.
fn check_folder(folder: &Path, pictures: usize) -> Result<(), Failure> {
    let Ok(known) = std::fs::read_dir(folder) else { return Ok(()) };
    let names = known.flatten().map(|entry| entry.file_name().to_string_lossy().into_owned());
    let written: Vec<String> = (0..pictures).map(picture_name).collect();
    match names.into_iter().find(|name| !written.contains(name)) {
        Some(name) => Err(ScenarioError::Exists { path: folder.join(name) }.into()),
        None => Ok(()),
    }
}

fn picture_name(place: usize) -> String {
    format!("{place:04}.png")
}

/// Renders the motion to a file or folder and returns the number of frames.
pub fn write(moving: &MovingPicture, file: &Path, output: Output) -> Result<usize, Failure> {
    let MovingPicture { scene, settings, rate_hz, format, .. } = *moving;
    let refused = |flag, problem: &str| Failure::Flag { flag, problem: problem.to_owned() };
    let [view] = moving.views[..] else {
        return Err(refused("view", "a moving picture has one view; 'all' is for .png"));
    };
    let times_s = scene.motion.as_ref().map_or(&[][..], |motion| &motion.times_s);
    let Some(&last_s) = times_s.last() else {
        let problem = "nothing moves without a plan: name a plan file, or write .png or .glb";
        return Err(refused("output", problem));
    };
    // At equal steps of time up to the first one at or after the end; the end itself is shown last.
    let nearest = |instant_s: f64| {
        let after = times_s.partition_point(|time_s| *time_s < instant_s).min(times_s.len() - 1);
        let before = after.saturating_sub(1);
        if instant_s - times_s[before] < times_s[after] - instant_s { before } else { after }
    };
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "saturates, and is refused then"
    )]
    let steps = (last_s / moving.step_s - 1e-9).ceil().max(0.0) as usize;
    check_length(steps.saturating_add(1), format, settings)?;
    let frames: Vec<usize> = (0..=steps).map(|step| nearest(step as f64 * moving.step_s)).collect();
    if format == Format::Folder {
        check_folder(file, frames.len())?;
    }
    let bar = progress::bar(frames.len() as u64, output.quiet);
    bar.set_message("pictures");
    let counted = |picture| {
        bar.inc(1);
        Ok(picture)
    };
    if format == Format::Mp4 {
        let film = Film { scene, view, settings, rate_hz };
        // A signal that ends this program ends the encoder too, whose failure is then not reported.
        film.write(&frames, file, || bar.inc(1)).inspect_err(|_| progress::await_end())?;
    } else if format == Format::Folder {
        let pictures = Animation::draw(scene, view, settings, &frames, |place, picture| {
            bar.inc(1);
            let name = picture_name(place);
            let content = picture.png(&file.join(&name))?;
            Ok(NamedFile { name, kind: FileKind::Png, content })
        })?;
        output_file::write_all(file, &pictures, output)?;
    } else {
        let pictures = Animation::draw(scene, view, settings, &frames, |_, picture| counted(picture))?;
        let animation = Animation { pictures, rate_hz };
        if format == Format::Gif { animation.write_gif(file) } else { animation.write_apng(file) }?;
    }
    bar.finish_and_clear();
    Ok(frames.len())
}

/// Refuses a motion with more frames than can be drawn, or kept in memory until they are written.
fn check_length(count: usize, format: Format, settings: &PictureSettings) -> Result<(), Failure> {
    let points = count.saturating_mul(settings.width * settings.height);
    if count > MOST_PICTURES {
        let problem = format!(
            "the motion has {count} pictures, but at most {MOST_PICTURES} are drawn: lower it, or raise --speed"
        );
        return Err(Failure::Flag { flag: "rate", problem });
    }
    let is_in_memory = matches!(format, Format::Gif | Format::Apng);
    if is_in_memory && points > MOST_MOVING_POINTS {
        let problem = format!(
            "{count} pictures of {} × {} pixels are too large for one file, which holds {MOST_MOVING_POINTS} \
             pixels at most: lower it or --rate, or write an .mp4 or a folder",
            settings.width, settings.height
        );
        return Err(Failure::Flag { flag: "size", problem });
    }
    Ok(())
}
