//! Obstacles, start and grasps of a scenario, read from the released files by an independent reader.

use std::fs;
use std::path::Path;

use cranny_spatial::Point;
use cranny_spatial::nalgebra::Matrix4;
use serde::Deserialize;

use crate::mesh::Mesh;

/// One body of the scene in the root frame: its parts are closed meshes.
#[derive(Clone, Debug)]
pub struct Obstacle {
    pub name: String,
    pub parts: Vec<Mesh>,
}

#[derive(Deserialize)]
struct SceneFile {
    bg_objects: Vec<PlacedObject>,
    objects: Vec<PlacedObject>,
}

#[derive(Deserialize)]
struct PlacedObject {
    object_type: String,
    pose: [[f64; 4]; 4],
}

#[derive(Deserialize)]
struct LibraryFile {
    objects: Vec<LibraryEntry>,
}

#[derive(Deserialize)]
struct LibraryEntry {
    identifier: String,
    mesh_fn: String,
    vhacd_fn: String,
    scale: f64,
}

/// Reads all obstacles of the released scenario in `folder`, the target last.
pub fn obstacles(folder: &Path) -> Vec<Obstacle> {
    let scene: SceneFile = yaml(&folder.join("scene.yaml"));
    let library_folder = folder.join("../../object_library");
    let library: LibraryFile = yaml(&library_folder.join("object_library.yaml"));
    let entry = |object: &PlacedObject| {
        let is_it = |entry: &&LibraryEntry| entry.identifier == object.object_type;
        library.objects.iter().find(is_it).expect("the library knows every object of the scene")
    };
    // Obstacles are runs of twelve faces, one for each cuboid, which share vertices.
    let background = scene.bg_objects.iter().map(|object| {
        let entry = entry(object);
        let (vertices, triangles) = placed(&library_folder.join(&entry.mesh_fn), entry.scale, object);
        let cuboid =
            |faces: &[[usize; 3]]| Mesh::new(vertices.clone(), faces.to_vec()).without_unused_vertices();
        Obstacle { name: entry.identifier.clone(), parts: triangles.chunks(12).map(cuboid).collect() }
    });
    let targets = scene.objects.iter().map(|object| {
        let entry = entry(object);
        let (vertices, triangles) = placed(&library_folder.join(&entry.vhacd_fn), entry.scale, object);
        Obstacle { name: "target".to_owned(), parts: Mesh::new(vertices, triangles).pieces() }
    });
    background.chain(targets).collect()
}

/// Reads the start configuration: one number per line.
pub fn start(folder: &Path) -> Vec<f64> {
    let text = fs::read_to_string(folder.join("export/robot_start_conf.csv")).unwrap();
    text.split_whitespace().map(|number| number.parse().unwrap()).collect()
}

/// Reads the grasps: poses of the gripper frame in the root frame.
pub fn grasps(folder: &Path) -> Vec<Matrix4<f64>> {
    let text = fs::read_to_string(folder.join("export/grasps.csv")).unwrap();
    let numbers = |line: &str| line.split(',').map(|number| number.trim().parse().unwrap()).collect();
    text.lines().map(numbers).map(|row: Vec<f64>| Matrix4::from_row_slice(&row)).collect()
}

/// Reads the vertices of an object of the scene in the root frame, and its triangles.
fn placed(mesh_file: &Path, scale: f64, object: &PlacedObject) -> (Vec<Point>, Vec<[usize; 3]>) {
    let (mut vertices, triangles) = obj(&fs::read_to_string(mesh_file).unwrap());
    for vertex in &mut vertices {
        let [x, y, z] = [0, 1, 2].map(|row| {
            let [a, b, c, d] = object.pose[row];
            (a * vertex.x + b * vertex.y + c * vertex.z) * scale + d
        });
        *vertex = root_from_scene(x, y, z);
    }
    (vertices, triangles)
}

/// Converts a point: the root stands at (1, 0, 0.05) m in the scene, its x axis along the scene's y.
fn root_from_scene(x: f64, y: f64, z: f64) -> Point {
    Point::new(y, 1.0 - x, z - 0.05)
}

/// Parses vertices and triangles of an OBJ text whose faces are triangles.
fn obj(text: &str) -> (Vec<Point>, Vec<[usize; 3]>) {
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    for line in text.lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        match words[..] {
            ["v", x, y, z] => {
                let number = |word: &str| word.parse::<f64>().unwrap();
                vertices.push(Point::new(number(x), number(y), number(z)));
            }
            ["f", a, b, c] => {
                let index = |word: &str| word.split('/').next().unwrap().parse::<usize>().unwrap() - 1;
                triangles.push([index(a), index(b), index(c)]);
            }
            ["v" | "f", ..] => panic!("{line}: neither a point nor a triangle"),
            _ => {}
        }
    }
    (vertices, triangles)
}

fn yaml<T: for<'de> Deserialize<'de>>(path: &Path) -> T {
    serde_saphyr::from_str(&fs::read_to_string(path).unwrap()).unwrap()
}
