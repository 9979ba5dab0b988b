//! Tests of recordings as pages: moving bodies without a robot.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use cranny_shape::TriangleSoup;
use cranny_spatial::{Point, Pose, Vector};
use cranny_view::{BodyRecording, MovingBody, PageData};
use serde_json::{Value, json};

fn floats64(row: &Value) -> Vec<f64> {
    let bytes = STANDARD.decode(row.as_str().expect("a row")).expect("base64");
    bytes.chunks_exact(8).map(|b| f64::from_le_bytes(b.try_into().expect("8 bytes"))).collect()
}

/// Recording of a tile that rises beside a static one, with `instants` instants in two seconds.
fn recording(instants: usize) -> BodyRecording {
    let surface = TriangleSoup {
        vertices: [[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.0, 0.1, 0.0]].map(Point::from).to_vec(),
        triangles: vec![[0, 1, 2]],
    };
    let times_s: Vec<f64> = (0..instants).map(|i| 2.0 * i as f64 / (instants - 1) as f64).collect();
    let rising =
        |time_s: &f64| Pose::new(Vector::new(0.0, 0.0, 0.1 * time_s), Vector::new(0.0, 0.0, *time_s));
    let body = |name: &str, is_grasped, world_from_body| MovingBody {
        name: name.to_owned(),
        surface: surface.clone(),
        is_grasped,
        world_from_body,
    };
    BodyRecording {
        name: "a tile rises".to_owned(),
        world_from_floor: Some(Pose::identity()),
        bodies: vec![
            body("tile", true, times_s.iter().map(rising).collect()),
            body("finger", false, times_s.iter().map(rising).collect()),
            body("shelf", false, vec![Pose::translation(0.3, 0.0, 0.0)]),
        ],
        times_s,
    }
}

fn page(recording: &BodyRecording) -> Value {
    serde_json::from_slice(&PageData::of_recording(recording).to_json().expect("finite")).expect("JSON")
}

#[test]
fn a_page_has_the_bodies_and_their_poses_at_every_instant() {
    let recording = recording(41);
    let page = page(&recording);
    assert_eq!((&page["format"], &page["name"]), (&"cranny-page/1".into(), &"a tile rises".into()));
    for empty in ["plans", "grasps", "collision_shapes", "link_spheres"] {
        assert_eq!(page[empty], json!([]), "{empty}");
    }
    assert_eq!((&page["robot"]["links"], &page["robot"]["start"]), (&json!([]), &json!([])));
    assert_eq!(floats64(&page["recording"]["times_s"]), recording.times_s);
    let tracks = page["recording"]["tracks"].as_array().expect("tracks");
    assert_eq!(tracks.len(), 2, "what stands has none");
    for track in tracks {
        let node = usize::try_from(track["node"].as_u64().expect("an index")).expect("small");
        let body =
            recording.bodies.iter().find(|body| page["nodes"][node]["name"] == body.name[..]).expect("it");
        let rows = floats64(&track["poses"]);
        assert_eq!(rows.len(), 7 * recording.times_s.len());
        for (row, pose) in rows.chunks_exact(7).zip(&body.world_from_body) {
            assert_eq!(row[..3], *pose.translation.vector.as_slice());
            assert_eq!(row[3..], *pose.rotation.coords.as_slice());
        }
    }
    let role = |name: &str| {
        let nodes = page["nodes"].as_array().expect("nodes");
        nodes.iter().find(|node| node["name"] == name).expect("a node")["role"].clone()
    };
    assert_eq!([role("tile"), role("finger"), role("shelf")], ["target", "link", "obstacle"]);
}

#[test]
fn a_page_has_no_more_instants_than_a_screen_shows() {
    let times_s = floats64(&page(&recording(2001))["recording"]["times_s"]);
    assert!((110..=122).contains(&times_s.len()), "{} instants of 2 s", times_s.len());
}
