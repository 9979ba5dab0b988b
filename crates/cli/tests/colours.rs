//! Colours of files in pictures: of meshes, objects, worlds and scenarios.

use std::fmt::Write as _;
use std::path::Path;
use std::process::Output;

use assert_cmd::Command;
use cranny_scenario::{OpenOptions, Scenario};

fn cranny(folder: &Path, line: &str) -> Output {
    let mut command = Command::cargo_bin("cranny").expect("the program");
    command.current_dir(folder).args(line.split(' ')).output().expect("it runs")
}

fn done(folder: &Path, line: &str) {
    let output = cranny(folder, line);
    assert_eq!(output.status.code(), Some(0), "{line}: {}", String::from_utf8_lossy(&output.stderr));
}

/// Returns the base colour (linear light) of a material of a binary glTF, by its name.
fn gltf_colour(file: &Path, name: &str) -> Vec<f64> {
    let bytes = std::fs::read(file).expect("a file");
    let length = u32::from_le_bytes(bytes[12..16].try_into().expect("four bytes")) as usize;
    let root: serde_json::Value = serde_json::from_slice(&bytes[20..20 + length]).expect("JSON");
    let materials = root["materials"].as_array().expect("materials");
    let material =
        materials.iter().find(|material| material["name"] == name).unwrap_or_else(|| panic!("{materials:?}"));
    let colour = &material["pbrMetallicRoughness"]["baseColorFactor"];
    (0..3).map(|channel| colour[channel].as_f64().expect("a number")).collect()
}

/// A closed box of 60 mm around the origin, with its material.
fn write_box(folder: &Path, name: &str) {
    let mut text = "mtllib paint.mtl\nusemtl paint\n".to_owned();
    for corner in 0..8 {
        let along = |bit: usize| if corner >> bit & 1 == 0 { -0.03 } else { 0.03 };
        let _ = writeln!(text, "v {} {} {}", along(0), along(1), along(2));
    }
    text += "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";
    std::fs::write(folder.join(name), text).expect("written");
    std::fs::write(folder.join("paint.mtl"), "newmtl paint\nKd 0 0 1\n").expect("written");
}

#[test]
fn bodies_have_the_colours_of_scenario_mesh_and_object() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    write_box(folder, "block.obj");
    done(folder, "object add block.obj --mass 0.2 -o block");
    let object = std::fs::read_to_string(folder.join("block/object.yaml")).expect("an object");
    assert!(object.contains("colour:"), "{object}");
    done(folder, "object show block --picture block.png");
    let yaml = |colour: &str| {
        format!(
            "robot: panda_mobile\nframe: {{position: [0, 0, 0.05]}}\nstart: [0, 0, -0.0178, -0.7601, 0.0198, -2.3421, 0.0298, \
             1.5412, 0.7534]\nfloor: 0\nobstacles:\n  - name: stated\n    pose: {{position: [0.8, 0, 0.2]}}\n    shapes:\n      \
             - {{box: {{size: [0.3, 0.3, 0.4]}}, colour: {colour}}}\n  - name: painted\n    pose: {{position: [0.8, 0.5, \
             0.2]}}\n    shapes: [{{mesh: {{file: block.obj}}}}]\n  - name: plain\n    pose: {{position: [0.8, -0.5, 0.2]}}\n    \
             shapes: [{{box: {{size: [0.1, 0.1, 0.4]}}}}]\ntarget:\n  name: ball\n  pose: {{position: [0.8, 0, 0.43]}}\n  \
             shapes: [{{object: block}}]\n"
        )
    };
    std::fs::write(folder.join("scenario.yaml"), yaml("[1, 0, 0]")).expect("written");
    done(folder, "render . -o a.glb");
    let colour = |name: &str| gltf_colour(&folder.join("a.glb"), name);
    assert_eq!(colour("stated"), [1.0, 0.0, 0.0]);
    assert_eq!(colour("painted"), [0.0, 0.0, 1.0]);
    assert_eq!(colour("ball"), [0.0, 0.0, 1.0]);
    let plain = colour("plain");
    assert!(plain.iter().all(|channel| (0.2..0.8).contains(channel)), "{plain:?}");
    done(folder, "scenario pack . -o packed.zip");
    done(folder, "render packed.zip -o b.glb");
    assert_eq!(gltf_colour(&folder.join("b.glb"), "ball"), [0.0, 0.0, 1.0]);
    for wrong in ["[1, 0, 2]", "[1, 0, -0.1]", "[.nan, 0, 0]"] {
        std::fs::write(folder.join("scenario.yaml"), yaml(wrong)).expect("written");
        let refused = cranny(folder, "render . -o c.glb");
        let error = String::from_utf8_lossy(&refused.stderr);
        assert_eq!(refused.status.code(), Some(2), "{error}");
        assert!(error.contains("scenario.yaml:9") && error.contains("each from 0 to 1"), "{error}");
    }
}

#[test]
fn a_world_keeps_its_colours() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let mjcf = r#"<mujoco><asset><material name="green" rgba="0 1 0 1"/></asset><worldbody>
        <geom type="plane" size="2 2 0.1"/>
        <body name="table" pos="0.8 0 0.2"><geom type="box" size="0.2 0.2 0.2" rgba="1 0 0 1"/>
          <geom type="box" size="0.1 0.1 0.01" pos="0 0 0.21" material="green"/></body>
        <body name="ball" pos="0.8 0 0.45"><freejoint/><geom type="sphere" size="0.03"/></body>
        </worldbody></mujoco>"#;
    std::fs::write(folder.join("world.xml"), mjcf).expect("written");
    done(folder, "scenario from world.xml --robot panda_mobile --target ball -o cell");
    let yaml = std::fs::read_to_string(folder.join("cell/scenario.yaml")).expect("a scenario");
    assert!(yaml.contains("colour: [1, 0, 0]") && yaml.contains("colour: [0, 1, 0]"), "{yaml}");
    let path = folder.join("cell").display().to_string();
    let scenario = Scenario::open(&path, &OpenOptions::default()).expect("a scenario");
    assert_eq!(scenario.colours["table"], [Some([1.0, 0.0, 0.0]), Some([0.0, 1.0, 0.0])]);
    assert!(!scenario.colours.contains_key("ball"));
}
