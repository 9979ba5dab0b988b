use std::collections::HashMap;
use std::path::{Path, PathBuf};

use cranny_spatial::Point;

use crate::mesh_files::mesh_size::{check_corners, check_vertices};
use crate::mesh_files::obj::{index, logical_lines, numbers, point, text_of};
use crate::mesh_files::painted_piece::PaintedPiece;
use crate::mesh_files::polygon::triangulate;

/// Maximum number of materials in one mesh: each is a drawing of its own.
const MOST_MATERIALS: usize = 100_000;

/// Maximum number of libraries of materials: each is read as a whole.
const MOST_LIBRARIES: usize = 100;

/// Pieces of a Wavefront OBJ file (version 3.0) for display, one for each material, in the order of their first use, with the
/// diffuse colours of the libraries of materials beside the file. Three vertices for each triangle; normals and vertex colours
/// only if each corner has one. A library that cannot be read leaves its materials without a colour. Lines that do not concern
/// the display are ignored.
///
/// # Errors
/// A message with the line: an invalid number or index, or an exceeded limit.
pub(crate) fn pieces(bytes: &[u8], path: &Path) -> Result<Vec<PaintedPiece>, String> {
    let mut reader = Reader {
        pieces: vec![PaintedPiece::default()],
        piece_of: HashMap::from([(String::new(), 0)]),
        ..Reader::default()
    };
    let text = text_of(bytes);
    for (line, content) in logical_lines(&text) {
        let (keyword, rest) = content.trim().split_once(char::is_whitespace).unwrap_or_default();
        reader.read(keyword, rest.trim_start(), path).map_err(|message| format!("line {line}: {message}"))?;
    }
    drop(text);
    for library in std::mem::take(&mut reader.libraries) {
        reader.paint(&library).map_err(|message| format!("{}, {message}", library.display()))?;
    }
    Ok(reader.pieces)
}

#[derive(Default)]
struct Reader {
    vertices: Vec<Point>,
    /// Colour of each vertex up to the last that has one.
    colours: Vec<Option<[f32; 4]>>,
    normals: Vec<[f32; 3]>,
    pieces: Vec<PaintedPiece>,
    /// Piece of each material, by its name.
    piece_of: HashMap<String, usize>,
    /// Piece of the current material.
    current: usize,
    /// Number of corners of all pieces.
    corners: usize,
    /// Canonical paths of the libraries of materials.
    libraries: Vec<PathBuf>,
}

impl Reader {
    fn read(&mut self, keyword: &str, rest: &str, path: &Path) -> Result<(), String> {
        match keyword {
            "v" => {
                let values = numbers(rest.split_whitespace())?;
                self.vertices.push(point(&values)?);
                if let &[.., red, green, blue] = &values[3..] {
                    self.colours.resize(self.vertices.len() - 1, None);
                    self.colours.push(Some([red, green, blue, 1.0]));
                }
                check_vertices(self.vertices.len())
            }
            "vn" => {
                let normal = numbers(rest.split_whitespace())?;
                self.normals.push(normal[..].try_into().map_err(|_| "a normal has three numbers")?);
                check_vertices(self.normals.len())
            }
            "f" | "fo" => self.face(rest),
            "usemtl" => {
                let next = self.pieces.len();
                self.current = *self.piece_of.entry(rest.to_owned()).or_insert(next);
                if self.current == next {
                    self.pieces.push(PaintedPiece::default());
                }
                // The first piece has no material.
                if self.pieces.len() <= 1 + MOST_MATERIALS {
                    return Ok(());
                }
                Err(format!("more than {MOST_MATERIALS} materials in one mesh"))
            }
            "mtllib" => {
                let named = path.parent().unwrap_or(Path::new("")).join(rest);
                let library = std::fs::canonicalize(named).ok();
                self.libraries.extend(library.filter(|library| !self.libraries.contains(library)));
                if self.libraries.len() <= MOST_LIBRARIES {
                    return Ok(());
                }
                Err(format!("more than {MOST_LIBRARIES} libraries of materials"))
            }
            _ => Ok(()),
        }
    }

    fn face(&mut self, words: &str) -> Result<(), String> {
        let corner = |word: &str| -> Result<(usize, Option<usize>), String> {
            let normal = word.split('/').nth(2).filter(|normal| !normal.is_empty());
            let normal = normal.map(|normal| index(normal, self.normals.len(), "normal")).transpose()?;
            Ok((index(word, self.vertices.len(), "vertex")?, normal))
        };
        let face: Vec<_> = words.split_whitespace().map(corner).collect::<Result<_, _>>()?;
        let places: Vec<Point> = face.iter().map(|(vertex, _)| self.vertices[*vertex]).collect();
        // The inside of a face that crosses itself is undefined, but it can be shown.
        let fan = || (2..face.len()).map(|corner| [0, corner - 1, corner]).collect();
        let triangles = triangulate(&places).unwrap_or_else(fan);
        self.corners += 3 * triangles.len();
        check_corners(self.corners)?;
        let piece = &mut self.pieces[self.current];
        for triangle in triangles {
            let first = u32::try_from(piece.vertices.len()).unwrap_or(u32::MAX);
            piece.triangles.push([first, first + 1, first + 2]);
            for (vertex, normal) in triangle.map(|corner| face[corner]) {
                #[allow(clippy::cast_possible_truncation, reason = "they were read in single precision")]
                piece.vertices.push(self.vertices[vertex].coords.map(|x| x as f32).into());
                piece.vertex_colours.extend(self.colours.get(vertex).copied().flatten());
                piece.normals.extend(normal.map(|normal| self.normals[normal]));
            }
        }
        Ok(())
    }

    /// Gives the materials of a library their colours. Those that the mesh does not use take no memory.
    fn paint(&mut self, library: &Path) -> Result<(), String> {
        let bytes = cranny_file::TEXT.bytes(library).unwrap_or_default();
        let mut piece = None;
        for (line, content) in logical_lines(&text_of(&bytes)) {
            let (keyword, rest) = content.trim().split_once(char::is_whitespace).unwrap_or_default();
            let rest = rest.trim_start();
            match keyword {
                "newmtl" => piece = self.piece_of.get(rest).copied(),
                // `Kd spectral` and `Kd xyz` give no colour for a screen.
                "Kd" if !rest.starts_with(char::is_alphabetic) => {
                    let values = numbers(rest.split_whitespace());
                    let values = values.map_err(|message| format!("line {line}: {message}"))?;
                    let colour = match values[..] {
                        [grey] => [grey; 3],
                        [red, green, blue] => [red, green, blue],
                        _ => return Err(format!("line {line}: a colour of {} numbers", values.len())),
                    };
                    if let Some(piece) = piece {
                        self.pieces[piece].colour = Some([colour[0], colour[1], colour[2], 1.0]);
                    }
                }
                _ => {}
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::fmt::Write as _;

    use super::*;

    const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\n";

    fn read(text: &str) -> Result<Vec<PaintedPiece>, String> {
        pieces(text.as_bytes(), Path::new("a.obj"))
    }

    fn triangles(text: &str) -> Vec<usize> {
        read(text).unwrap().iter().map(|piece| piece.triangles.len()).collect()
    }

    /// The material holds until the next `usemtl`, also in another group (specification, "usemtl").
    #[test]
    fn there_is_one_piece_for_each_material() {
        let text = "f 1 2 3\nusemtl b\nf 1 2 3\ng x\nf -3 -2 -1\n  usemtl a\nusemtl b\nf 1 2 \\\n3\nf 1 2\n";
        assert_eq!(triangles(&format!("{TRIANGLE}{text}")), [1, 3, 0]);
    }

    #[test]
    fn normals_and_colours_are_those_of_all_corners() {
        let text = "v 0 0 1 1 0.5 0\nf 1//1 2//1 3//-1\nusemtl a\nf 4/1/1 4 4\n";
        let pieces = read(&format!("{TRIANGLE}{text}")).unwrap();
        assert_eq!(pieces[0].normals, [[0.0, 0.0, 1.0]; 3]);
        assert_eq!(pieces[1].vertex_colours, [[1.0, 0.5, 0.0, 1.0]; 3]);
        assert_eq!((pieces[0].vertex_colours.len(), pieces[1].normals.len()), (0, 1));
    }

    /// The reader of a library copied the name of group and material into each piece: 100 GB for a file of 2 MB.
    #[test]
    fn long_names_and_many_changes_take_no_memory() {
        let name = "n".repeat(1_000_000);
        let changes = format!("usemtl {name}\nf 1 2 3\nusemtl b\nf 1 2 3\n");
        let text =
            format!("{TRIANGLE}g {name}\n{}", "usemtl b\nf 1 2 3\nusemtl a\nf 1 2 3\n".repeat(200_000));
        assert_eq!(triangles(&format!("{text}{changes}")), [0, 200_001, 200_000, 1]);
    }

    #[test]
    fn each_limit_is_named_with_its_line() {
        let materials = (0..=MOST_MATERIALS).map(|material| format!("usemtl {material}\n"));
        let faults = [
            (materials.collect::<String>(), "line 100001: more than 100000 materials in one mesh"),
            (format!("{TRIANGLE}f 1 2 4\n"), "line 5: vertex 4 is named, but there are 3 before it"),
            (format!("{TRIANGLE}f 1//2 2 3\n"), "line 5: normal 2 is named, but there are 1 before it"),
            ("v 0 0\n".to_owned(), "line 1: a vertex of 2 numbers"),
            ("vn 0 0\n".to_owned(), "line 1: a normal has three numbers"),
        ];
        for (text, message) in faults {
            assert_eq!(read(&text).unwrap_err(), message);
        }
        let mut full = Reader {
            vertices: vec![Point::origin()],
            pieces: vec![PaintedPiece::default()],
            corners: 3 * 8_000_000,
            ..Reader::default()
        };
        assert!(full.read("f", "1 1 1", Path::new("")).unwrap_err().contains("more than 8000000 triangles"));
    }

    /// The limits were counted in the bytes of the file, but the text was read as UTF-16.
    #[test]
    fn utf_16_is_no_mesh() {
        let text = "v 0 0 0\nf 1 1 1\n".encode_utf16().flat_map(u16::to_le_bytes);
        let bytes: Vec<u8> = [0xff, 0xfe].into_iter().chain(text).collect();
        let pieces = pieces(&bytes, Path::new("a.obj")).unwrap();
        assert!(pieces.iter().all(|piece| piece.triangles.is_empty()));
    }

    #[test]
    fn a_library_is_read_once_under_all_its_names() {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
        write("a.mtl", "newmtl a\nKd 1 0 0.5\nKd spectral x.rfl\n  newmtl b\n Kd 0.25\nnewmtl c\n");
        let spelled = (0..1000).map(|number| format!("mtllib {}a.mtl\n", "./".repeat(number)));
        let text = format!("{}mtllib none.mtl\nusemtl a\nusemtl b\nusemtl c\n", spelled.collect::<String>());
        let path = folder.path().join("a.obj");
        let colours: Vec<_> =
            pieces(text.as_bytes(), &path).unwrap().iter().map(|piece| piece.colour).collect();
        assert_eq!(colours, [None, Some([1.0, 0.0, 0.5, 1.0]), Some([0.25, 0.25, 0.25, 1.0]), None]);
        let mut text = String::new();
        for number in 0..=MOST_LIBRARIES {
            write(&format!("{number}.mtl"), "");
            let _ = writeln!(text, "mtllib {number}.mtl");
        }
        let fault = pieces(text.as_bytes(), &path).unwrap_err();
        assert_eq!(fault, "line 101: more than 100 libraries of materials");
        write("a.mtl", "newmtl a\nKd x y z\nKd 1 2\n");
        let fault = pieces(b"mtllib a.mtl\n", &path).unwrap_err();
        assert!(fault.ends_with("a.mtl, line 3: a colour of 2 numbers"), "{fault}");
    }
}
