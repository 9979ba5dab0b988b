//! Tests of scenes of very many bodies: with work that grows with its square, each would take minutes.

use cranny_shape::TriangleSoup;
use cranny_spatial::{Point, Pose};
use cranny_view::{BodyRecording, MovingBody, PageData, Picture, PictureSettings, Scene, StandardView};

/// Returns a name that no other body has, in letters alone: the colour of an obstacle depends on the words of its name.
fn name(index: usize) -> String {
    let letter =
        |place: u32| char::from(b'a' + u8::try_from(index / 16_usize.pow(place) % 16).expect("below 16"));
    (0..5).map(letter).collect()
}

/// Returns a grasped tile, with tiles of different names around it, half of them between it and the eye.
fn recording(bodies: usize) -> BodyRecording {
    let surface = TriangleSoup {
        vertices: [[0.0; 3], [0.01, 0.0, 0.0], [0.0, 0.0, 0.01], [0.0, 0.001, 0.0]].map(Point::from).to_vec(),
        triangles: vec![[0, 1, 2], [0, 3, 1]],
    };
    let body = |name: String, is_grasped, y: f64| MovingBody {
        name,
        surface: surface.clone(),
        is_grasped,
        world_from_body: vec![Pose::translation(0.0, y, 0.0)],
    };
    let around = (0..bodies).map(|index| body(name(index), false, 0.1 - 0.2 * index as f64 / bodies as f64));
    BodyRecording {
        name: "many tiles".to_owned(),
        times_s: vec![0.0],
        world_from_floor: None,
        bodies: around.chain([body("tile".to_owned(), true, 0.0)]).collect(),
    }
}

#[test]
fn a_scene_has_all_of_very_many_bodies() {
    let bodies = 150_000;
    let scene = Scene::of_moving_bodies(&recording(bodies));
    assert_eq!([scene.nodes.len(), scene.meshes.len(), scene.materials.len()], [bodies + 1; 3]);
}

#[test]
fn pages_gltf_files_and_pictures_have_all_of_many_bodies() {
    let bodies = 10_000;
    let recording = recording(bodies);
    let page = PageData::of_recording(&recording).to_json().expect("finite");
    let page: serde_json::Value = serde_json::from_slice(&page).expect("JSON");
    let count = |key: &str| page[key].as_array().map(Vec::len);
    assert_eq!([count("nodes"), count("meshes"), count("materials")], [Some(bodies + 1); 3]);
    let scene = Scene::of_moving_bodies(&recording);
    assert!(scene.glb().expect("finite").len() > 100 * bodies);
    let settings = PictureSettings { width: 64, height: 64, samples: 1, ..PictureSettings::default() };
    assert!(scene.seen_through(&[StandardView::Side], &settings).len() > bodies / 3);
    let picture = Picture::of(&scene, StandardView::Side, &settings).expect("a picture");
    assert_eq!(picture.pixels().len(), 64 * 64);
}
