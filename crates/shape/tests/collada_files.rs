//! COLLADA files, good and bad.

use cranny_shape::{Solid, TriangleSoup};
use cranny_spatial::Vector;

use crate::mesh_files::{fault, write};

/// COLLADA file of four corners at 0 and 1; `primitive` makes faces of them, `nodes` position them.
pub(crate) fn collada(primitive: &str, nodes: &str) -> String {
    format!(
        "<COLLADA xmlns='http://www.collada.org/2005/11/COLLADASchema' version='1.4.1'>
<asset><unit meter='0.5'/></asset>
<library_geometries><geometry id='g'><mesh>
<source id='s'><float_array id='a' count='13'>9 0 0 0 1 0 0 0 1 0 0 0 1</float_array>
<technique_common><accessor source='#a' count='4' stride='3' offset='1'>
<param name='X' type='float'/><param name='Y' type='float'/><param name='Z' type='float'/>
</accessor></technique_common></source>
<vertices id='v'><input semantic='POSITION' source='#s'/></vertices>
{primitive}</mesh></geometry></library_geometries>
<library_nodes><node id='loop'><instance_node url='#loop'/></node></library_nodes>
<library_visual_scenes><visual_scene id='c'>{nodes}</visual_scene></library_visual_scenes>
<scene><instance_visual_scene url='#c'/></scene></COLLADA>"
    )
}

pub(crate) const FACES: &str = "<triangles count='4'><input semantic='VERTEX' source='#v' offset='0'/>\
                     <input semantic='NORMAL' source='#none' offset='1'/>\
                     <p>0 9 2 9 1 9 0 9 1 9 3 9 0 9 3 9 2 9 1 9 2 9 3 9</p></triangles>";

pub(crate) const NODE: &str = "<node><instance_geometry url='#g'/></node>";

#[test]
fn a_collada_file_is_read_with_its_unit_where_its_nodes_place_it() {
    let load = |primitive: &str, nodes: &str| {
        let (_folder, path) = write("corner.dae", &collada(primitive, nodes));
        TriangleSoup::load(&path, Vector::repeat(1.0)).unwrap()
    };
    let plain = load(FACES, NODE);
    assert_eq!((plain.vertices.len(), plain.triangles.len()), (4, 4));
    assert!((Solid::mesh(&plain).unwrap().aabb().half_extents - Vector::repeat(0.25)).norm() < 1e-12);
    // The same faces as counted polygons, and as a strip with one face reversed.
    let input = "<input semantic='VERTEX' source='#v' offset='0'/>";
    let list = format!(
        "<polylist count='4'>{input}<vcount>3 3 3 3</vcount><p>0 2 1 0 1 3 0 3 2 1 2 3</p></polylist>"
    );
    assert_eq!(load(&list, NODE), plain);
    let strip = load(&format!("<tristrips count='1'>{input}<p>0 1 2 3</p></tristrips>"), NODE);
    assert_eq!(strip.triangles, [[0, 1, 2], [2, 1, 3]]);
    // The node is rotated by 90° about z, scaled before, moved after, inside a node that is moved again; twice.
    let nodes = "<node><translate>0 0 2</translate><node><translate>10 0 0</translate><rotate>0 0 1 90</rotate>\
                 <scale>3 1 1</scale><instance_geometry url='#g'/></node></node><node><matrix>1 0 0 -8 0 1 0 0 \
                 0 0 1 0 0 0 0 1</matrix><instance_geometry url='#g'/></node>";
    let placed = load(FACES, nodes);
    assert_eq!(placed.triangles.len(), 8);
    let x_axis = placed.vertices[2] - placed.vertices[0];
    assert!(
        (placed.vertices[0].coords - Vector::new(5.0, 0.0, 1.0)).norm() < 1e-12,
        "{}",
        placed.vertices[0]
    );
    assert!((x_axis - Vector::new(0.0, 1.5, 0.0)).norm() < 1e-12, "{x_axis}");
    assert!((placed.vertices[4].coords - Vector::new(-4.0, 0.0, 0.0)).norm() < 1e-12);
}

#[test]
fn what_is_wrong_in_a_collada_file_is_said_with_its_line() {
    let bad = |primitive: &str, nodes: &str| fault("bad.dae", &collada(primitive, nodes));
    assert!(bad(&FACES.replace("2 9 3 9<", "2 9 4 9<"), NODE).contains("vertex 4 is named, but there are 4"));
    assert!(
        bad(&FACES.replace('#', "#un"), NODE)
            .contains("line 9: <input> refers to '#unv', which is not there")
    );
    assert!(bad(FACES, &NODE.replace("#g", "#h")).contains("'#h', which is not there"));
    assert!(bad(FACES, "<node><instance_node url='#loop'/></node>").contains("without end"));
    assert!(
        bad(FACES, "<node><matrix>1 2 3</matrix></node>")
            .contains("16 numbers are needed for <matrix>, but there are 3")
    );
    let text = collada(FACES, NODE);
    assert!(
        fault("long.dae", &text.replace("count='4' stride", "count='5' stride")).contains("more than the 13")
    );
    assert!(fault("word.dae", &text.replace("9 0 0", "9 zero 0")).contains("line 4: 'zero' is no number"));
    assert!(fault("other.dae", "<robot/>").contains("not <COLLADA>"));
    assert!(fault("cut.dae", &text[..text.len() / 2]).len() > 10);
    // Without a scene all geometries are shown; without geometries nothing is.
    assert!(fault("none.dae", &text.replace("instance_geometry", "instance_light")).contains("no triangles"));
}

fn load(text: &str) -> TriangleSoup {
    let (_folder, path) = write("corner.dae", text);
    TriangleSoup::load(&path, Vector::repeat(1.0)).unwrap()
}

const INPUT: &str = "<input semantic='VERTEX' source='#v' offset='0'/>";

/// Guards against an ignored `<lookat>`. The positions are those of Assimp 6.0 for eye, interest and up.
#[test]
fn a_node_that_looks_at_a_point_is_placed() {
    let node =
        |numbers: &str| format!("<node><lookat>{numbers}</lookat><instance_geometry url='#g'/></node>");
    let placed = load(&collada(FACES, &node("10 2 4  4 10 4  0 0 1")));
    let expected = [[5.0, 1.0, 2.0], [5.0, 1.0, 2.5], [5.4, 1.3, 2.0], [5.3, 0.6, 2.0]].map(Vector::from);
    // In the order of the triangles: the origin, y, x, z.
    for (vertex, expected) in placed.vertices.iter().zip(expected) {
        assert!((vertex.coords - expected).norm() < 1e-12, "{vertex} for {expected}");
    }
    // The upward direction need not be perpendicular to the line of sight.
    let slanting = load(&collada(FACES, &node("10 2 4  4 10 4  -3 4 7")));
    for (one, other) in placed.vertices.iter().zip(&slanting.vertices) {
        assert!((one - other).norm() < 1e-12);
    }
    for nowhere in ["1 2 3  1 2 3  0 0 1", "1 2 3  1 2 5  0 0 1"] {
        assert!(fault("nowhere.dae", &collada(FACES, &node(nowhere))).contains("give no direction"));
    }
}

/// Guards against the loss of text after a comment.
#[test]
fn comments_may_stand_in_numbers() {
    let text = collada(FACES, NODE);
    let remarked = text
        .replace("9 0 0 0 1", "<!-- x -->9 0 0 <!-- y --> 0 <!-- z -->1")
        .replace("<p>0 9 2 9 1 9", "<p><!-- 3 -->0 9 2 9<!-- first --> 1 9");
    assert!(remarked.matches("<!--").count() == 5);
    assert_eq!(load(&remarked), load(&text));
}

/// A `<convex_mesh>` has the faces of a mesh.
#[test]
fn a_convex_mesh_with_faces_is_read() {
    let text = collada(FACES, NODE);
    assert_eq!(load(&text.replace("mesh>", "convex_mesh>")), load(&text));
}

/// Guards against geometry without a node that shows it, if no scene is named.
#[test]
fn the_only_scene_of_a_file_is_shown() {
    let moved = collada(FACES, "<node><translate>2 0 0</translate><instance_geometry url='#g'/></node>");
    let unnamed = moved.replace("<scene><instance_visual_scene url='#c'/></scene>", "");
    assert_eq!(load(&unnamed), load(&moved));
    let two = unnamed.replace("</visual_scene>", "</visual_scene><visual_scene id='d'/>");
    assert!(fault("two.dae", &two).contains("a second <visual_scene>, and no <scene>"));
}

/// Exporters number the elements of each file anew and join files. The last element of an id must not replace all.
#[test]
fn parts_of_two_geometries_may_have_one_id() {
    let both = "<node><instance_geometry url='#g'/><instance_geometry url='#h'/></node>";
    let text = collada(FACES, both);
    let (begin, end) = (text.find("<geometry").unwrap(), text.find("</library_geometries>").unwrap());
    let other = text[begin..end].replace("id='g'", "id='h'").replace("9 0 0 0", "9 4 4 4");
    let text = [&text[..end], &other, &text[end..]].concat();
    let soup = load(&text);
    assert_eq!((soup.vertices.len(), soup.triangles.len()), (5, 8));
    let twice = fault("twice.dae", &text.replace("id='h'", "id='g'"));
    assert!(
        twice.contains("<instance_geometry> refers to '#g', but there are two of it (line 9: the second)"),
        "{twice}"
    );
    assert!(
        fault("kind.dae", &text.replace("url='#h'", "url='#v'")).contains("'#v', which is no <geometry>")
    );
    // No instance refers to the node.
    load(&text.replace("id='loop'><instance_node url='#loop'/>", "id='n'/><node id='n'>"));
}

/// Guards against silently skipping these elements, with all that they show.
#[test]
fn what_is_not_read_of_a_collada_file_is_refused() {
    let geometry = |old: &str, new: &str| fault("not.dae", &collada(FACES, NODE).replace(old, new));
    let placed = |what: &str| {
        let (node, text) = (NODE.replace("<node>", &format!("<node>{what}")), FACES);
        fault("not.dae", &collada(text, &node))
    };
    let shown = |faces: &str| fault("not.dae", &collada(faces, NODE));
    let list = |counts: &str| {
        shown(&format!("<polylist>{INPUT}<vcount>{counts}</vcount><p>0 2 1 0 1 3</p></polylist>"))
    };
    let skewed = placed("<skew>45 0 1 0 1 0 0</skew>");
    assert!(skewed.contains("line 11: <skew> is not read (write it as a <matrix>)"), "{skewed}");
    let skinned = placed("<instance_controller url='#skin'/>");
    assert!(
        skinned.contains("<instance_controller>, a mesh with a skin or a morph, is not read (apply"),
        "{skinned}"
    );
    let parts = "<geometry id='g'>";
    for (fault, message) in [
        (placed("<Translate>1 0 0</Translate>"), "<Translate> in <node> is not read"),
        (placed("<translate>1 0 0 0</translate>"), "3 numbers are needed for <translate>, but there are 4"),
        (placed("<matrix>1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 2</matrix>"), "the last row of a <matrix>"),
        (placed("<translate>1 <b>0</b> 0</translate>"), "<b> in <translate> is not read"),
        (geometry(parts, &format!("{parts}<brep/>")), "a geometry of <brep> is not read (export it"),
        (geometry(parts, &format!("{parts}<spline/>")), "a geometry of <spline> is not read"),
        (
            geometry(parts, &format!("{parts}<convex_mesh convex_hull_of='#h'/>")),
            "a <convex_mesh> without faces",
        ),
        (geometry("mesh>", "Mesh>"), "<Mesh> in <geometry> is not read"),
        (geometry("<node><inst", "<Node/><node><inst"), "<Node> in <visual_scene> is not read"),
        (geometry("meter='0.5'", "meter='0'"), "line 2: a unit of '0' metres"),
        (geometry("<source id='s'>", "<source id='s'><asset><unit meter='1'/></asset>"), "another unit"),
        (geometry("count='13'", "count='12'"), "line 4: 12 numbers are announced, but there are 13"),
        (
            geometry("url='#c'/>", "url='#c'/><instance_visual_scene url='#c'/>"),
            "a second <instance_visual_scene>",
        ),
        (shown(&FACES.replace("triangles", "Triangles")), "<Triangles> in <mesh> is not read"),
        (shown(&FACES.replace("9</p>", "9 1</p>")), "25 indices are no whole number of corners of 2 each"),
        (shown(&FACES.replace("9</p>", "9 1 9</p>")), "13 corners are no whole number of triangles"),
        (shown(&FACES.replace("VERTEX", "POSITION")), "there is no <input> of VERTEX"),
        (shown(&FACES.replace("NORMAL", "VERTEX")), "a second <input> of VERTEX"),
        (shown(&FACES.replace("p>", "P>")), "<P> in <triangles> is not read"),
        (
            shown(&format!("<tristrips count='2'>{INPUT}<p>0 1 2</p></tristrips>")),
            "2 tristrips are announced",
        ),
        (list("3"), "it leaves 3 of 6 corners over"),
        (list("3 4"), "it counts more corners than there are"),
        (list("3</vcount><vcount>3"), "there is a <vcount> before this one"),
    ] {
        assert!(fault.contains(message), "{message}: {fault}");
    }
    // Content without a surface, or for other programs, is valid.
    let lines = format!("{FACES}<lines count='1'>{INPUT}<p>0 1</p></lines><extra><skew/></extra>");
    let node = NODE.replace("<node>", "<node><extra><skew/></extra><instance_camera url='#c'/>");
    assert_eq!(load(&collada(&lines, &node)), load(&collada(FACES, NODE)));
}

/// Guards against references that multiply the content of a file: of 1 to 3 MB, these took minutes or gigabytes.
#[test]
fn content_that_others_refer_to_is_read_once() {
    let input = "<input semantic='VERTEX' source='#v' offset='0'/>";
    let empty = format!("<triangles count='0'>{input}<p/></triangles>");
    let face = format!("<triangles material='m' count='1'>{input}<p>0 1 2</p></triangles>");
    let numbers = " 0".repeat(300_000);
    let faces = 10_000;
    let shown = |text: &str| load(text).triangles.len();
    // Many primitives and sources of one array; many colours of one effect.
    let sources = (0..faces).fold(String::new(), |all, index| {
        all + &format!(
            "<source id='s{index}'><technique_common><accessor source='#a' count='4' stride='3' offset='1'/>\
             </technique_common></source><vertices id='v{index}'><input semantic='POSITION' source='#s{index}'/>\
             </vertices><triangles material='m{index}' count='1'><input semantic='VERTEX' source='#v{index}'/>\
             <p>0 1 2</p></triangles>"
        )
    });
    let materials = (0..faces).fold(String::new(), |all, index| {
        all + &format!("<material id='m{index}'><instance_effect url='#e'/></material>")
    });
    let text = collada(&sources, NODE)
        .replace("count='13'>", "count='300013'>")
        .replace("0 0 1</float_array>", &format!("0 0 1{numbers}</float_array>"))
        .replace(
            "<library_nodes>",
            &format!("{materials}<effect id='e'>{}</effect><library_nodes>", "<param/>".repeat(100_000)),
        );
    assert_eq!(shown(&text), faces);
    // Many nodes that show a geometry with many elements, through others with many transforms.
    let crowded = collada(
        &format!("{face}{}{}", empty.repeat(3000), "<extra/>".repeat(30_000)),
        &"<node><instance_node url='#n'/></node>".repeat(2000),
    );
    let moves = "<translate>0 0 0</translate>".repeat(400);
    let node = format!("<node id='n'>{moves}<instance_geometry url='#g'/></node>");
    assert_eq!(shown(&crowded.replace("<library_nodes>", &format!("<library_nodes>{node}"))), 2000);
    // Many equal ids, each meant within its own geometry.
    let geometry =
        text_between(&collada(&face, NODE), "<geometry", "</geometry>").replace("id='g'", "id='g#'");
    let several = |each: &str| {
        (0..20_000)
            .fold(String::new(), |all, index| all + &each.replace('#', &index.to_string()).replace('@', "#"))
    };
    let own = several(&geometry.replace("source='#", "source='@"));
    let nodes = several("<node><instance_geometry url='@g#'/></node>");
    let text = collada(&face, &nodes).replace("<library_nodes>", &format!("{own}<library_nodes>"));
    assert_eq!(shown(&text), 20_000);
}

fn text_between(text: &str, begin: &str, end: &str) -> String {
    let (_, rest) = text.split_once(begin).expect("its beginning");
    let (inside, _) = rest.split_once(end).expect("its end");
    format!("{begin}{inside}{end}")
}

/// Guards against references that multiply each other, and content for which the parser needs quadratic time.
#[test]
fn a_collada_file_that_multiplies_is_refused_with_its_limit() {
    let bad = |text: &str| fault("bad.dae", text);
    let doubling = (0..60).fold(String::new(), |all, index| {
        let below = format!("<instance_node url='#d{}'/>", index + 1);
        all + &format!("<node id='d{index}'>{below}{below}</node>")
    });
    let text = collada(FACES, "<node><instance_node url='#d0'/></node>")
        .replace("<library_nodes>", &format!("<library_nodes>{doubling}<node id='d60'/>"));
    assert!(bad(&text).contains("the scene shows more than 1000000 elements of nodes"));
    let deep = |count: usize| format!("{}{}", "<node>".repeat(count), "</node>".repeat(count));
    assert!(bad(&collada(FACES, &deep(70))).contains("more than 64 deep"));
    assert!(bad(&collada(FACES, &deep(100_000))).contains("elements inside each other, but at most 256"));
    let with = |content: &str| bad(&collada(FACES, NODE).replace("<asset>", &format!("<asset>{content}")));
    let attributes = (0..100_000).fold(String::new(), |all, index| all + &format!(" a{index}='0'"));
    assert!(
        with(&format!("<x{attributes}/>"))
            .contains("line 2: 100000 attributes in one element, but at most 64")
    );
    let namespaces = (0..100_000).fold(String::new(), |all, index| all + &format!("<x xmlns:n{index}='u'>"));
    assert!(with(&namespaces).contains("65 namespaces declared for one element, but at most 64"));
    let many = format!("<triangles>{INPUT}<p>{}</p></triangles>", "0 1 2 ".repeat(100_000));
    assert!(bad(&collada(&many, &NODE.repeat(81))).contains("more than 8000000 triangles (reduce it"));
    let zeros = " 0".repeat(100_000);
    let lists = "<p/>".repeat(100_000);
    let polylist = format!("<polylist>{INPUT}<vcount>{zeros}</vcount>{lists}</polylist>");
    assert!(bad(&collada(&polylist, NODE)).contains("there is a <p> before this one"));
}
