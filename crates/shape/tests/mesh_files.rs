//! Mesh files, good and bad.

use std::path::PathBuf;

use cranny_shape::{Solid, TriangleSoup};
use cranny_spatial::Vector;

const TETRAHEDRON_OBJ: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";

fn write(name: &str, text: &str) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, text).unwrap();
    (folder, path)
}

fn fault(name: &str, text: &str) -> String {
    let (_folder, path) = write(name, text);
    let fault = TriangleSoup::load(&path, Vector::repeat(1.0)).unwrap_err().to_string();
    assert!(fault.contains(name), "{fault}");
    fault
}

#[test]
fn an_obj_is_read_in_order_and_scaled() {
    let (_folder, path) = write("tetrahedron.obj", TETRAHEDRON_OBJ);
    let soup = TriangleSoup::load(&path, Vector::new(2.0, 1.0, 1.0)).unwrap();
    assert_eq!((soup.vertices.len(), soup.triangles.len()), (4, 4));
    assert!((soup.corners(1)[1].x - 2.0).abs() < 1e-12);
    Solid::mesh(&soup).unwrap();
}

#[test]
fn a_ply_is_read() {
    let text = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
                element face 1\nproperty list uchar int vertex_indices\nend_header\n\
                0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n";
    let (_folder, path) = write("square.ply", text);
    let soup = TriangleSoup::load(&path, Vector::repeat(1.0)).unwrap();
    assert_eq!((soup.vertices.len(), soup.triangles.len()), (4, 2));
}

#[test]
fn an_stl_is_read() {
    let facet =
        "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n";
    let (_folder, path) = write("facet.stl", &format!("solid s\n{facet}endsolid s\n"));
    assert_eq!(TriangleSoup::load(&path, Vector::repeat(1.0)).unwrap().triangles.len(), 1);
}

#[test]
fn bad_files_are_named() {
    assert!(fault("empty.obj", "").contains("no triangles"));
    assert!(fault("index.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n").len() > 10);
    assert!(fault("nan.obj", &TETRAHEDRON_OBJ.replace("v 1 0 0", "v nan 0 0")).len() > 10);
    assert!(fault("thing.xyz", "0 0 0").contains("unknown mesh format"));
    assert!(fault("cut.ply", "ply\nformat ascii 1.0\nelement vertex 4\n").len() > 10);
    let missing = TriangleSoup::load(std::path::Path::new("nowhere.obj"), Vector::repeat(1.0)).unwrap_err();
    assert!(missing.to_string().contains("nowhere.obj"));
}
