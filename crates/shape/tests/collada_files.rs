//! COLLADA files, good and bad.

use cranny_shape::{Solid, TriangleSoup};
use cranny_spatial::Vector;

use crate::mesh_files::{fault, write};

/// A COLLADA file of four corners at 0 and 1; `primitive` makes faces of them, `nodes` place them.
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
    // The same faces as polygons that are counted, and as a strip with one turned round.
    let input = "<input semantic='VERTEX' source='#v' offset='0'/>";
    let list = format!(
        "<polylist count='4'>{input}<vcount>3 3 3 3</vcount><p>0 2 1 0 1 3 0 3 2 1 2 3</p></polylist>"
    );
    assert_eq!(load(&list, NODE), plain);
    let strip = load(&format!("<tristrips count='1'>{input}<p>0 1 2 3</p></tristrips>"), NODE);
    assert_eq!(strip.triangles, [[0, 1, 2], [2, 1, 3]]);
    // Turned by a right angle about z, stretched before, moved after, in a node that is moved again; twice.
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
    assert!(bad(FACES, "<node><matrix>1 2 3</matrix></node>").contains("16 numbers are needed"));
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
