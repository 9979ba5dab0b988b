//! Mesh files, good and bad.

use std::path::PathBuf;

use cranny_shape::{PaintedMesh, Solid, TriangleSoup};
use cranny_spatial::Vector;

use crate::collada_files::{FACES, NODE, collada};

const TETRAHEDRON_OBJ: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";

pub(crate) fn write(name: &str, text: &str) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, text).unwrap();
    (folder, path)
}

pub(crate) fn fault(name: &str, text: &str) -> String {
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
    assert!(fault("thing.xyz", "0 0 0").contains("names no mesh format"));
    assert!(fault("cut.ply", "ply\nformat ascii 1.0\nelement vertex 4\n").len() > 10);
    let missing = TriangleSoup::load(std::path::Path::new("nowhere.obj"), Vector::repeat(1.0)).unwrap_err();
    assert!(missing.to_string().contains("nowhere.obj"));
}

/// Error message of a reader for invalid bytes.
fn fault_of_bytes(name: &str, bytes: &[u8]) -> String {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    let fault = TriangleSoup::load(&path, Vector::repeat(1.0)).unwrap_err().to_string();
    assert!(fault.contains(name), "{fault}");
    fault
}

fn binary_stl(soup: &TriangleSoup, count: u32) -> Vec<u8> {
    let mut bytes = [b"solid of bytes".to_vec(), vec![0; 66], count.to_le_bytes().to_vec()].concat();
    for triangle in 0..soup.triangles.len() {
        bytes.extend([0; 12]);
        for corner in soup.corners(triangle) {
            #[allow(clippy::cast_possible_truncation, reason = "small whole numbers")]
            bytes.extend(corner.iter().flat_map(|x| (*x as f32).to_le_bytes()));
        }
        bytes.extend([0; 2]);
    }
    bytes
}

fn tetrahedron() -> TriangleSoup {
    let (_folder, path) = write("tetrahedron.obj", TETRAHEDRON_OBJ);
    TriangleSoup::load(&path, Vector::repeat(1.0)).unwrap()
}

#[test]
fn a_binary_stl_that_is_cut_off_at_a_triangle_is_refused() {
    let whole = binary_stl(&tetrahedron(), 4);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("whole.stl");
    std::fs::write(&path, &whole).unwrap();
    assert_eq!(TriangleSoup::load(&path, Vector::repeat(1.0)).unwrap(), tetrahedron());
    // Some programs end the file like a text or pad it, and some write no count.
    let uncounted = binary_stl(&tetrahedron(), 0);
    for rest in [&b"\n"[..], b"\0", &[0; 100]] {
        for start in [&whole, &uncounted] {
            std::fs::write(&path, [start, rest].concat()).unwrap();
            let read = TriangleSoup::load(&path, Vector::repeat(1.0)).unwrap();
            assert!(read == tetrahedron() || start == &uncounted && rest.len() == 100, "{rest:?}");
        }
    }

    // Bytes that are no padding may be triangles, which would be lost.
    let triangle = &whole[84..134];
    for rest in [&b"made by a program"[..], &triangle[..49], triangle, &[triangle, b"x"].concat(), &whole] {
        let fault = fault_of_bytes("more.stl", &[&whole, rest].concat());
        let expected = format!("{} bytes that are no zeros follow the binary STL file of 4 tri", rest.len());
        assert!(fault.contains(&expected), "{fault}");
    }
    assert!(fault_of_bytes("more.stl", &[&uncounted, &triangle[..49]].concat()).contains("49 bytes"));

    for cut in [1, 50, 100, 201, 270] {
        let fault = fault_of_bytes("cut.stl", &whole[..whole.len() - cut]);
        assert!(fault.contains("cut off"), "{cut}: {fault}");
    }
    for count in [1, 3, 5, u32::MAX] {
        let fault = fault_of_bytes("lie.stl", &binary_stl(&tetrahedron(), count));
        assert!(fault.contains(&format!("of {count} triangles")), "{fault}");
    }
}

#[test]
fn a_text_stl_that_is_cut_off_is_refused() {
    let facet =
        "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n";
    let text = format!("solid s\n{facet}{facet}endsolid s\n");
    let whole = text.find("endsolid").unwrap();
    for end in 6..whole {
        let fault = fault("cut.stl", &text[..end]);
        assert!(fault.contains("no 'endsolid'"), "{fault}");
    }
}

/// Cuboid of 0.1 m by 0.02 m by 0.03 m with quads as faces, in the forms that other programs write and read.
#[test]
fn an_obj_is_read_in_all_its_forms() {
    let plain = "v 0 0 0\nv 0.1 0 0\nv 0 0.02 0\nv 0.1 0.02 0\nv 0 0 0.03\nv 0.1 0 0.03\nv 0 0.02 0.03\n\
                 v 0.1 0.02 0.03\nf 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";
    let indented: String = plain.lines().flat_map(|line| ["  ", line, "\n"]).collect();
    let weighted = plain.lines().map(|line| match line.strip_prefix("v ") {
        Some(numbers) => format!("v {numbers} 2.0\n"),
        None => format!("{line}\n"),
    });
    let forms = [
        plain.to_owned(),
        indented,
        weighted.collect(),
        plain.replace('\n', "\r"),
        plain.replace('\n', "\r\n"),
        plain.replace(' ', "\t"),
        plain.replace("f 1 3 4 2", "f 1 3 \\\n 4 2"),
        plain.replace("f 1 3 4 2", "f -8/1/1 -6//2 -5/3 -7"),
        plain.replace("0.02", "2.0E-2"),
        format!("\u{feff}# a remark \\\no box\ng one\nusemtl red\ns off\nvn 0 0 1\nvt 0 0\n{plain}l 1 2\n"),
        plain.trim_end().to_owned(),
    ];
    for form in forms {
        let (_folder, path) = write("box.obj", &form);
        let soup = TriangleSoup::load(&path, Vector::repeat(1.0)).expect(&form);
        assert_eq!(soup.triangles.len(), 12, "{form}");
        assert!((soup.signed_volume_m3() - 6e-5).abs() < 1e-11, "{form}");
    }
    for (old, new, message) in [
        ("v 0.1 0 0", "v 0,1 0 0", "line 2: '0,1' is no number"),
        ("v 0.1 0 0", "v 0.1 0", "line 2: a vertex of 2 numbers"),
        ("f 1 3 4 2", "surf 0 1 0 1 1 2 3 4", "line 9: 'surf 0 1 0 1 1 2 3 4' is not read here"),
        ("f 1 3 4 2", "f 1 4 3 2", "line 9: the face of 4 corners crosses itself"),
    ] {
        let fault = fault("box.obj", &plain.replacen(old, new, 1));
        assert!(fault.contains(message), "{fault}");
    }
}

#[test]
fn a_text_stl_is_read_in_all_its_forms() {
    let facet = |x: u32| {
        format!(
            "facet normal 0 0 1\n outer loop\n  vertex {x} 0 0\n  vertex {} 0 0\n  vertex {x} 1 0\n endloop\nendfacet\n",
            x + 1
        )
    };
    let plain = format!("solid a b\n{}{}endsolid a b\n", facet(0), facet(2));
    let several = format!("solid\n{}endsolid\n\nsolid two\n{}endsolid two", facet(0), facet(2));
    // Lines may end anywhere except after a name.
    let on_one_line = format!("solid\n{}\nendsolid", [facet(0), facet(2)].concat().replace('\n', " "));
    let forms = [
        plain.clone(),
        several,
        plain.to_uppercase(),
        plain.replace('\n', "\r\n"),
        plain.replace(' ', "\t"),
        plain.replace("normal 0 0 1", "normal -nan(ind) nan 1.#QNAN"),
        plain.replace("normal 0 0 1\n", "normal 0 0 1"),
        plain.replace("solid a b", "solid vertex 1 2 3"),
        plain.replace("solid a b", "solid facet normal vertex"),
        on_one_line,
        format!("\u{feff}{plain}"),
    ];
    for form in forms {
        let (_folder, path) = write("facets.STL", &form);
        let soup = TriangleSoup::load(&path, Vector::repeat(1.0)).expect(&form);
        assert_eq!((soup.vertices.len(), soup.triangles.len()), (6, 2), "{form}");
    }
    let second_cut = format!("{plain}solid b\n{}", facet(4));
    assert!(fault("cut.stl", &second_cut).contains("the last solid has no 'endsolid'"));
    assert!(
        fault("odd.stl", &plain.replacen(" outer loop", " inner loop", 1)).contains("line 3: 'inner loop'")
    );
}

/// Guards against a solid read as the name on its line, and corners of two facets read as one polygon.
#[test]
fn what_is_out_of_place_in_a_text_stl_is_refused() {
    let facet =
        "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n";
    let plain = format!("solid a\n{facet}{facet}endsolid a\n");
    let second = format!("solid b {facet}").replace('\n', " ");
    for (text, message) in [
        (format!("{plain}{second}\nendsolid b\n"), "line 17: facets follow 'solid' on its line"),
        (
            plain.replace("endsolid a\n", &format!("endsolid a {second}\n")),
            "line 16: facets follow 'endsolid'",
        ),
        (plain.replacen("endfacet\n", "", 1), "line 8: a facet begins, but the one before has no 'endfacet'"),
        (plain.replace("endfacet\nendsolid", "endsolid"), "line 15: 'endsolid' before the 'endfacet'"),
        (plain.replacen("endloop\n", "endloop\nouter loop\n", 1), "line 8: a facet has a second loop"),
        (plain.replace("endsolid", "vertex 9 9 9\nendsolid"), "line 16: a vertex outside of a facet"),
        (plain.replacen("vertex 1 0 0", "vertex 1 0 0 7", 1), "line 5: 'vertex 1 0 0 7' is no line"),
        (plain.replacen("vertex 1 0 0", "vertex 1 0 0abc", 1), "line 5: a vertex has three numbers"),
        (plain.replace('\n', "\r\n").replacen("outer", "inner", 1), "line 3: 'inner loop' is no line"),
    ] {
        let fault = fault("place.stl", &text);
        assert!(fault.contains(message), "{message}: {fault}");
    }
}

/// U of 3 m by 3 m with a slot of 1 m by 2 m, as one polygon: a fan from its first corner would fill the slot.
#[test]
fn no_format_fills_a_concave_polygon() {
    let outline = [(2, 3), (2, 1), (1, 1), (1, 3), (0, 3), (0, 0), (3, 0), (3, 3)];
    let lines = |begin: &str| outline.map(|(x, y)| format!("{begin}{x} {y} 0\n")).concat();
    let obj = format!("{}f 1 2 3 4 5 6 7 8\n", lines("v "));
    let ply = format!(
        "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\nelement face 1\n\
         property list uchar int vertex_indices\nend_header\n{}8 0 1 2 3 4 5 6 7\n",
        lines("")
    );
    let dae = collada(
        "<polylist count='1'><input semantic='VERTEX' source='#v' offset='0'/><vcount>8</vcount><p>0 1 2 3 4 5 6 7</p></polylist>",
        NODE,
    )
    .replace("9 0 0 0 1 0 0 0 1 0 0 0 1", &format!("9 {}", lines("")))
    .replace("count='13'", "count='25'")
    .replace("count='4' stride", "count='8' stride")
    .replace("0.5", "1");
    for (name, text) in [("u.obj", obj), ("u.ply", ply), ("u.dae", dae)] {
        let (_folder, path) = write(name, &text);
        let soup = TriangleSoup::load(&path, Vector::repeat(1.0)).expect(name);
        let doubled_areas = (0..soup.triangles.len()).map(|index| {
            let [a, b, c] = soup.corners(index);
            (b - a).cross(&(c - a)).norm()
        });
        let area = 0.5 * doubled_areas.sum::<f64>();
        assert!((area - 7.0).abs() < 1e-9, "{name}: {area}");
    }
}

#[test]
fn a_pointer_of_git_lfs_is_named_in_every_format() {
    let pointer = "version https://git-lfs.github.com/spec/v1\noid sha256:3e2f605cf4fb\nsize 11056\n";
    for name in ["table.obj", "table.stl", "table.ply", "table.dae"] {
        assert!(fault(name, pointer).contains("it is a Git LFS pointer"));
    }
}

const PLY_HEADER: &str = "element vertex 4\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\n\
                          element face 4\nproperty list uchar int vertex_indices\nend_header\n";

fn binary_ply(big_endian: bool) -> Vec<u8> {
    let form = if big_endian { "binary_big_endian" } else { "binary_little_endian" };
    let mut bytes = format!("ply\nformat {form} 1.0\ncomment of a test\n{PLY_HEADER}").into_bytes();
    for vertex in [[0.0_f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]] {
        bytes.extend(vertex.iter().flat_map(|x| if big_endian { x.to_be_bytes() } else { x.to_le_bytes() }));
        bytes.push(255);
    }
    for face in [[0_u32, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]] {
        bytes.push(3);
        bytes.extend(face.iter().flat_map(|i| if big_endian { i.to_be_bytes() } else { i.to_le_bytes() }));
    }
    bytes
}

#[test]
fn a_ply_is_read_in_all_its_forms() {
    for big_endian in [false, true] {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("bytes.ply");
        std::fs::write(&path, binary_ply(big_endian)).unwrap();
        assert_eq!(TriangleSoup::load(&path, Vector::repeat(1.0)).unwrap(), tetrahedron());
    }
}

#[test]
fn a_ply_that_counts_more_than_it_holds_is_refused_at_once() {
    let whole = binary_ply(false);
    for cut in 1..150 {
        let fault = fault_of_bytes("cut.ply", &whole[..whole.len() - cut]);
        assert!(fault.contains("cut off") || fault.contains("ends before"), "{cut}: {fault}");
    }
    let text = |elements: &str| {
        fault("bad.ply", &format!("ply\nformat binary_little_endian 1.0\n{elements}end_header\n"))
    };
    // Guards against an allocation of 10^18 empty elements.
    let fault = text("element nothing 1000000000000000000\n");
    assert!(fault.contains("line 3") && fault.contains("have no properties"), "{fault}");
    let fault = text("element vertex 1000000000000000000\nproperty float x\n");
    assert!(fault.contains("only 0 bytes are left"), "{fault}");
    let fault = text("element face 18446744073709551615\nproperty list uchar int vertex_indices\n");
    assert!(fault.contains("only 0 bytes are left"), "{fault}");
    assert!(text("element vertex -1\n").contains("'-1' is no count"));
    assert!(text("element vertex 0\nproperty tensor x\n").contains("line 4"));
    assert!(text("property float x\n").contains("line 3"));
    let ascii = |body: &str| {
        fault_of_bytes("bad.ply", format!("ply\nformat ascii 1.0\n{PLY_HEADER}{body}").as_bytes())
    };
    let vertices = "0 0 0 1\n1 0 0 1\n0 1 0 1\n0 0 1 1\n";
    assert!(ascii(&format!("{vertices}3 0 1 2\n3 0 1 3\n3 0 2 3\n3 1 2\n")).contains("ends before"));
    assert!(ascii(&format!("{vertices}3 0 1 2\n3 0 1 3\n3 0 2 3\n3 1 2 4\n")).contains("only 4"));
    assert!(ascii(&format!("{vertices}3 0 1 2\n3 0 1 3\n3 0 2 3\n3 1 2 -3\n")).contains("-3 is no index"));
    assert!(
        ascii(&format!("{}3 0 1 2\n3 0 1 3\n3 0 2 3\n3 1 2 3\n", vertices.replacen('1', "nan", 2))).len()
            > 10
    );
    let faces = "3 0 1 2\n3 0 1 3\n3 0 2 3\n3 1 2 3\n";
    let fault = ascii(&format!("{}{faces}", vertices.replacen("1 0", "one 0", 1)));
    assert!(fault.contains("line 12: 'one' is no number"), "{fault}");
}

/// PLY file of the corners of a tetrahedron, twice, with the elements that `elements` announces.
fn ply_of_two(elements: &str, body: &str) -> String {
    format!(
        "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\n{elements}\
         end_header\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n2 0 0\n3 0 0\n2 1 0\n2 0 1\n{body}"
    )
}

const FACE_ELEMENT: &str = "element face 4\nproperty list uchar int vertex_indices\n";
const PLY_FACES: &str = "3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n";

/// Guards against the loss of strips, and of their triangles.
#[test]
fn strips_of_a_ply_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("strips.ply");
    let load = |elements: &str, body: &str| {
        std::fs::write(&path, ply_of_two(elements, body)).unwrap();
        TriangleSoup::load(&path, Vector::repeat(1.0)).unwrap()
    };
    let strips = "element tristrips 1\nproperty list int int vertex_indices\n";
    // Two triangles side by side, then a single one, then one that a repeated corner reverses.
    let body = "15 4 6 5 7 -1 4 5 7 -1 6 6 4 4 7 -1\n";
    let both = load(&format!("{FACE_ELEMENT}{strips}"), &format!("{PLY_FACES}{body}"));
    assert_eq!(both.triangles.len(), 7);
    let alone = load(strips, body);
    assert_eq!(alone.triangles, [[0, 1, 2], [2, 1, 3], [0, 2, 3]]);
    let closed = load(strips, "13 4 6 5 7 -1 4 5 7 -1 4 7 6 -1\n");
    assert!((closed.signed_volume_m3() - 1.0 / 6.0).abs() < 1e-12);
    Solid::mesh(&closed).unwrap();
    let other =
        load(&format!("element edge 2\nproperty int vertex1\n{FACE_ELEMENT}"), &format!("0\n1\n{PLY_FACES}"));
    assert_eq!(other.triangles.len(), 4);
}

/// Guards against the second element of a name replacing the first, and against dropped faces beyond the count.
#[test]
fn what_a_ply_gives_twice_or_does_not_announce_is_refused() {
    let polygon = FACE_ELEMENT.replace("face", "Face");
    let listed_twice = format!("{FACE_ELEMENT}property list uchar int vertex_index\n");
    let unlisted = FACE_ELEMENT.replace("indices", "colours");
    for (elements, body, message) in [
        (
            &*format!("{FACE_ELEMENT}{FACE_ELEMENT}"),
            &*PLY_FACES.repeat(2),
            "line 9: line 7 has an element 'face' too",
        ),
        ("element vertex 8\n", "", "line 7: line 3 has an element 'vertex' too"),
        ("property float x\n", "", "line 7: a second property 'x' of the element 'vertex'"),
        (FACE_ELEMENT, &PLY_FACES.repeat(2), "line 22: 32 bytes follow what the header announces"),
        (FACE_ELEMENT, &format!("{PLY_FACES}\0"), "line 22: 1 bytes follow"),
        (&polygon, PLY_FACES, "no element 'face' (its elements are 'vertex', 'Face')"),
        ("", "", "no element 'face' (its elements are 'vertex'; is it"),
        (
            &listed_twice,
            "3 0 1 2 0\n3 0 1 2 0\n3 0 1 2 0\n3 0 1 2 0\n",
            "line 7: the element 'face' has more than one",
        ),
        (&unlisted, PLY_FACES, "line 7: the element 'face' has no list 'vertex_indices'"),
    ] {
        let fault = fault("twice.ply", &ply_of_two(elements, body));
        assert!(fault.contains(message), "{message}: {fault}");
    }
    let whole = binary_ply(true);
    assert!(fault_of_bytes("more.ply", &[&whole[..], &[3]].concat()).contains("1 bytes follow"));
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("filled.ply");
    std::fs::write(&path, [&whole[..], b"\0\0\n"].concat()).unwrap();
    assert_eq!(TriangleSoup::load(&path, Vector::repeat(1.0)).unwrap(), tetrahedron());
}

/// Guards against corners that all fall on one point and leave no triangles.
#[test]
fn a_scale_of_zero_is_named() {
    let (_folder, path) = write("tetrahedron.obj", TETRAHEDRON_OBJ);
    for (scale, said) in [
        (Vector::zeros(), "cannot be scaled by (0, 0, 0): each factor must be a number other than zero"),
        (Vector::new(1.0, 0.0, 1.0), "cannot be scaled by (1, 0, 1)"),
        (Vector::new(1.0, 1.0, f64::NAN), "cannot be scaled by (1, 1, NaN)"),
    ] {
        let solid = TriangleSoup::load(&path, scale).unwrap_err().to_string();
        let painted = PaintedMesh::load(&path, scale).unwrap_err().to_string();
        assert_eq!(solid, painted);
        assert!(solid.contains("tetrahedron.obj: ") && solid.contains(said), "{solid}");
    }
}

#[test]
fn other_counts_that_lie_are_refused() {
    let faces = FACES.replace("count='4'", "count='5'");
    assert!(fault("lie.dae", &collada(&faces, NODE)).contains("5 triangles are announced, but there are 4"));
    let cut = &TETRAHEDRON_OBJ[..TETRAHEDRON_OBJ.len() - 3];
    assert!(fault("cut.obj", cut).contains("line 8: a face has fewer than three corners"));
    for index in ["99999999999", "-9", "0", "4294967295"] {
        assert!(
            fault("index.obj", &TETRAHEDRON_OBJ.replace("f 3 1 4", &format!("f 3 1 {index}"))).len() > 10
        );
    }
}

#[test]
fn a_mesh_that_a_scale_mirrors_still_faces_outwards() {
    let (_folder, path) = write("tetrahedron.obj", TETRAHEDRON_OBJ);
    let mirrored = TriangleSoup::load(&path, Vector::new(1.0, -2.0, 1.0)).unwrap();
    assert!(mirrored.signed_volume_m3() > 0.3);
    assert_eq!(Solid::mesh(&mirrored).unwrap().mesh_repairs(), None);
}

/// Guards against memory for each line of an OBJ file, and a comparison of all names in the header of a PLY file.
#[test]
fn very_many_lines_and_names_take_little() {
    let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    let (_folder, path) = write("lines.obj", &format!("{}{triangle}", "\n".repeat(20_000_000)));
    assert_eq!(TriangleSoup::load(&path, Vector::repeat(1.0)).unwrap().triangles.len(), 1);
    let groups = (0..200_000).map(|group| format!("g a{group}\nusemtl b\n")).collect::<Vec<_>>().concat();
    let (_folder, path) = write("groups.obj", &format!("{triangle}{groups}"));
    assert_eq!(TriangleSoup::load(&path, Vector::repeat(1.0)).unwrap().triangles.len(), 1);
    assert_eq!(PaintedMesh::load(&path, Vector::repeat(1.0)).unwrap().pieces.len(), 1);
    let libraries = "mtllib a.mtl\n".repeat(50_000);
    let (folder, path) = write("libraries.obj", &format!("{libraries}{triangle}"));
    let colours = format!("newmtl a\nKd 1 0 0\n{}", "\n".repeat(1_000_000));
    std::fs::write(folder.path().join("a.mtl"), colours).unwrap();
    assert_eq!(PaintedMesh::load(&path, Vector::repeat(1.0)).unwrap().pieces.len(), 1);
    for line in ["element", "property float"] {
        let names = (0..300_000)
            .map(|name| format!("{line} a{name}{}\n", &" 0"[..2 * usize::from(line == "element")]))
            .collect::<Vec<_>>()
            .concat();
        let header = format!("ply\nformat ascii 1.0\nelement vertex 0\n{names}end_header\n");
        assert!(fault("names.ply", &header).contains("line 1003: more than 1000 elements and properties"));
    }
    let list =
        "ply\nformat binary_little_endian 1.0\nelement other 1\nproperty list uint uchar a\nend_header\n";
    let bytes = [list.as_bytes(), &[255; 4], &[0; 100]].concat();
    let said = fault_of_bytes("list.ply", &bytes);
    assert!(said.contains("element 0 of 'other' has a list of 4294967295 numbers, but at most"), "{said}");
}
