use std::path::Path;

use cranny_spatial::Vector;

use crate::PaintedMesh;

/// Returns the colour of the material of most triangles of a mesh file (OBJ with its MTL, DAE): red, green and blue, 0 to 1, sRGB.
///
/// `None` for a file without colours or that cannot be read, and for plain white, which files state beside a texture: textures are
/// not read.
pub fn mesh_colour(path: &Path) -> Option<[f64; 3]> {
    let extension = path.extension()?.to_str()?;
    let is_painted = if extension.eq_ignore_ascii_case("obj") {
        names_materials(path)
    } else {
        extension.eq_ignore_ascii_case("dae")
    };
    if !is_painted {
        return None;
    }
    let mesh = PaintedMesh::load(path, Vector::repeat(1.0)).ok()?;
    let mut colours: Vec<([f32; 4], usize)> = Vec::new();
    for (colour, count) in mesh.pieces.iter().filter_map(|p| Some((p.colour?, p.triangles.len()))) {
        match colours.iter_mut().find(|(known, _)| known.map(f32::to_bits) == colour.map(f32::to_bits)) {
            Some((_, known)) => *known += count,
            None => colours.push((colour, count)),
        }
    }
    // Of equal counts, the first.
    let ([red, green, blue, _], _) = colours.into_iter().rev().max_by_key(|(_, count)| *count)?;
    let colour = [red, green, blue].map(f64::from);
    let is_white = colour.iter().all(|channel| *channel >= 1.0);
    (!is_white && colour.iter().all(|channel| (0.0..=1.0).contains(channel))).then_some(colour)
}

/// Returns true if an OBJ names a library of materials, so that only such a file is read again.
fn names_materials(path: &Path) -> bool {
    let bytes = cranny_file::MESH.bytes(path).unwrap_or_default();
    bytes.split(|byte| *byte == b'\n').any(|line| line.trim_ascii_start().starts_with(b"mtllib"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_colour_is_that_of_most_triangles() {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
        let colour = |name: &str| mesh_colour(&folder.path().join(name));
        write(
            "a.mtl",
            "newmtl red\nKd 1 0 0\nnewmtl blue\nKd 0 0 0.5\nnewmtl white\nKd 1 1 1\nnewmtl odd\nKd 2 0 0\n",
        );
        let corners = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\n";
        let faces =
            |material: &str, count: usize| format!("usemtl {material}\n{}", "f 1 2 3\n".repeat(count));
        write("a.obj", &format!("{corners}{}{}{}", faces("red", 2), faces("blue", 2), faces("red", 1)));
        assert_eq!(colour("a.obj"), Some([1.0, 0.0, 0.0]));
        write("b.obj", &format!("{corners}{}{}", faces("red", 2), faces("blue", 3)));
        assert_eq!(colour("b.obj"), Some([0.0, 0.0, 0.5]));
        for (name, material) in [("white.obj", "white"), ("odd.obj", "odd"), ("none.obj", "unknown")] {
            write(name, &format!("{corners}{}", faces(material, 1)));
            assert_eq!(colour(name), None, "{name}");
        }
        write("plain.obj", &corners.replace("mtllib a.mtl\n", ""));
        write("broken.obj", "mtllib a.mtl\nv x\n");
        write("a.stl", "solid");
        for name in ["plain.obj", "broken.obj", "a.stl", "gone.obj", "gone.dae"] {
            assert_eq!(colour(name), None, "{name}");
        }
    }
}
