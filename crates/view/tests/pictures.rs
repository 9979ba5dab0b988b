//! Tests of the content of pictures, and regression tests against golden pictures.

use std::path::{Path, PathBuf};

use cranny_scenario::{OpenOptions, Scenario, builtin_object};
use cranny_solve::Timing;
use cranny_view::{
    Animation, Picture, PictureSettings, SampledPath, Scene, SceneSettings, SeeThrough, StandardView,
    ViewError,
};
use strum::VariantArray as _;

const SMALL: (usize, usize) = (320, 240);

fn scenario(id: &str) -> Scenario {
    Scenario::open(id, &OpenOptions::default()).expect("a built-in scenario")
}

/// Path without a planner: from the start over a bend, sampled at four instants per second.
fn bent_path(scenario: &Scenario) -> SampledPath {
    let mut middle = scenario.start.clone();
    (middle[0], middle[1], middle[3]) = (0.3, 0.2, -0.2);
    let mut end = middle.clone();
    (end[2], end[5], end[7]) = (0.6, -1.6, 2.2);
    let waypoints = [scenario.start.clone(), middle, end];
    let trajectory = Timing::default().along(&scenario.robot, &waypoints).expect("a path");
    let path = SampledPath::of(&scenario.robot, &waypoints, trajectory.as_ref(), 4.0);
    path.expect("a path").expect("with way points")
}

fn scene(id: &str) -> Scene {
    let scenario = scenario(id);
    let path = bent_path(&scenario);
    Scene::of_task(&scenario, Some(&path), &SceneSettings::default()).expect("a scene")
}

fn small() -> PictureSettings {
    PictureSettings { width: SMALL.0, height: SMALL.1, ..PictureSettings::default() }
}

fn golden(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden").join(name)
}

fn read_png(path: &Path) -> (usize, usize, Vec<u8>) {
    let file = std::fs::File::open(path).expect("a golden picture; CRANNY_WRITE=1 writes it");
    let mut reader = png::Decoder::new(std::io::BufReader::new(file)).read_info().expect("a PNG file");
    let mut bytes = vec![0; reader.output_buffer_size().expect("a size")];
    let info = reader.next_frame(&mut bytes).expect("a picture");
    assert_eq!((info.color_type, info.bit_depth), (png::ColorType::Rgb, png::BitDepth::Eight));
    (info.width as usize, info.height as usize, bytes)
}

/// Visible difference of two pictures over blocks of 4 × 4 pixels, which appear as one at arm's length: mean and maximum of the
/// differences of the mean screen values of the blocks.
fn difference(width: usize, a: &[u8], b: &[u8]) -> (f64, f64) {
    const BLOCK: usize = 4;
    let height = a.len() / (3 * width);
    let mean = |bytes: &[u8], column: usize, row: usize, channel: usize| -> f64 {
        let points = (0..BLOCK * BLOCK).map(|i| (row + i / BLOCK) * width + column + i % BLOCK);
        points.map(|point| f64::from(bytes[3 * point + channel])).sum::<f64>() / (BLOCK * BLOCK) as f64
    };
    let (mut sum, mut worst, mut count) = (0.0, 0.0_f64, 0.0);
    for row in (0..height).step_by(BLOCK) {
        for column in (0..width).step_by(BLOCK) {
            let of_channel = |channel| (mean(a, column, row, channel) - mean(b, column, row, channel)).abs();
            let block = (0..3).map(of_channel).fold(0.0, f64::max);
            sum += block;
            worst = worst.max(block);
            count += 1.0;
        }
    }
    (sum / count, worst)
}

/// Compares a picture with a golden one, or writes it if `CRANNY_WRITE` is set.
fn holds(picture: &Picture, name: &str) {
    let path = golden(name);
    if std::env::var_os("CRANNY_WRITE").is_some() {
        picture.write_png(&path).expect("written");
    }
    let (width, height, expected) = read_png(&path);
    assert_eq!((picture.width(), picture.height()), (width, height));
    let (mean, worst) = difference(width, &picture.pixels().concat(), &expected);
    // The mean tolerance is half a screen value; no block may differ as much as a moved edge would.
    assert!(mean < 0.5 && worst < 24.0, "{name}: mean {mean:.3}, worst {worst:.1}");
}

#[test]
fn pictures_of_the_environments_look_as_they_did() {
    for id in ["011", "043"] {
        let picture = Picture::of(&scene(id), StandardView::ThreeQuarter, &small()).expect("a picture");
        holds(&picture, &format!("{id}.png"));
    }
}

#[test]
fn the_golden_measure_sees_a_moved_arm() {
    let scene = scene("011");
    let end = Picture::of(&scene, StandardView::ThreeQuarter, &small()).expect("a picture");
    let settings = PictureSettings { frame: Some(scene.last_frame().expect("a motion") - 1), ..small() };
    let before = Picture::of(&scene, StandardView::ThreeQuarter, &settings).expect("a picture");
    let (mean, worst) = difference(SMALL.0, &end.pixels().concat(), &before.pixels().concat());
    assert!(mean > 0.5 || worst > 24.0, "mean {mean:.3}, worst {worst:.1}");
}

#[test]
fn the_same_scene_gives_the_same_bytes() {
    let draw = || {
        let picture = Picture::of(&scene("021"), StandardView::Front, &small()).expect("a picture");
        picture.png(Path::new("021.png")).expect("a PNG")
    };
    assert!(draw() == draw());
}

#[test]
fn every_standard_view_shows_something_and_keeps_it_off_its_edges() {
    let scene = scene("031");
    for &view in StandardView::VARIANTS {
        let picture = Picture::of(&scene, view, &small()).expect("a picture");
        let page = picture.pixels()[0];
        let differs = |point: &&[u8; 3]| (0..3).any(|i| point[i].abs_diff(page[i]) > 12);
        let shown = picture.pixels().iter().filter(differs).count();
        assert!(shown > SMALL.0 * SMALL.1 / 12, "{view:?}: {shown} points");
    }
}

#[test]
fn ghosts_and_glass_change_the_picture_and_can_be_left_out() {
    let scene = scene("011");
    let draw = |settings: PictureSettings| {
        Picture::of(&scene, StandardView::ThreeQuarter, &settings).expect("a picture")
    };
    let usual = draw(small());
    assert!(usual != draw(PictureSettings { ghosts: 0, ..small() }));
    assert!(usual != draw(PictureSettings { see_through: SeeThrough::Nothing, ..small() }));
}

#[test]
fn moving_pictures_are_written_whole() {
    let scene = scene("021");
    let settings =
        PictureSettings { width: 64, height: 48, samples: 1, ghosts: 0, ..PictureSettings::default() };
    let frames: Vec<usize> = (0..=scene.last_frame().expect("a motion")).collect();
    let pictures = Animation::draw(&scene, StandardView::Side, &settings, &frames, |_, picture| Ok(picture))
        .expect("drawn");
    assert!(pictures[0] != pictures[frames.len() - 1], "nothing moves");
    let folder = tempfile::tempdir().expect("a folder");
    let (apng, gif) = (folder.path().join("a.png"), folder.path().join("a.gif"));
    let animation = Animation { pictures, rate_hz: 20 };
    animation.write_apng(&apng).expect("written");
    animation.write_gif(&gif).expect("written");
    // The first picture of the APNG is the PNG for other programs; both files contain all pictures.
    let (width, height, bytes) = read_png(&apng);
    assert_eq!((width, height), (64, 48));
    assert!(bytes == animation.pictures[0].pixels().concat());
    let file = std::fs::File::open(&apng).expect("a file");
    let reader = png::Decoder::new(std::io::BufReader::new(file)).read_info().expect("a PNG");
    let control = reader.info().animation_control().expect("an animation");
    assert_eq!(control.num_frames as usize, frames.len());
    let file = std::fs::File::open(&gif).expect("a file");
    let mut reader = gif::DecodeOptions::new().read_info(file).expect("a GIF");
    let mut count = 0;
    while reader.read_next_frame().expect("a frame").is_some() {
        count += 1;
    }
    assert_eq!(count, frames.len());
}

#[test]
fn objects_have_pictures_in_their_colours() {
    let settings = PictureSettings { width: 96, height: 96, ..PictureSettings::default() };
    // Test of the dominant colour of the object against its background.
    for (name, is_its_colour) in [
        ("banana", (|p: &[u8; 3]| p[0] > 150 && p[2] < 100) as fn(&[u8; 3]) -> bool),
        ("tennis_ball", |p| p[1] > 120 && p[2] < 80),
        ("flat_screwdriver", |p| p[0] > 150 && p[1] < 100),
        ("sugar_box", |p| p[2] > 120 && p[0] < 100),
    ] {
        let scene = Scene::of_object(&builtin_object(name).expect("an object"));
        let picture = Picture::of(&scene, StandardView::ThreeQuarter, &settings).expect("a picture");
        let count = picture.pixels().iter().filter(|point| is_its_colour(point)).count();
        assert!(count > 60, "{name}: {count} points");
    }
}

#[test]
fn impossible_sizes_and_places_are_refused() {
    let scene = scene("021");
    for (width, height) in [(0, 100), (100, 3), (100_000, 100), (usize::MAX, usize::MAX)] {
        let settings = PictureSettings { width, height, ..PictureSettings::default() };
        let refused = Picture::of(&scene, StandardView::Top, &settings);
        assert!(matches!(refused, Err(ViewError::Size { .. })), "{width} × {height}");
    }
    let picture = Picture::blank(16, 16, [0; 3]);
    let folder = tempfile::tempdir().expect("a folder");
    for path in [folder.path().join("no/such/x.png"), folder.path().to_owned()] {
        assert!(matches!(picture.write_png(&path), Err(ViewError::Unwritable { .. })));
        assert!(matches!(scene.write_glb(&path), Err(ViewError::Unwritable { .. })));
    }
    assert_eq!(std::fs::read_dir(folder.path()).expect("a folder").count(), 0);
}
