use std::borrow::Cow;

use cranny_spatial::Point;

use crate::mesh_files::mesh_size::{check_corners, check_vertices};
use crate::mesh_files::polygon::triangulate;

/// Corners of the triangles of a Wavefront OBJ file (version 3.0), three at a time, rounded to the single precision of
/// the format. Lines may begin with blanks, have any line ending and be continued by a backslash.
///
/// # Errors
/// A message with the line: an invalid number or index, a face of fewer than three corners or one that crosses itself,
/// geometry other than faces, an unknown line.
pub(crate) fn corners(bytes: &[u8]) -> Result<Vec<Point>, String> {
    let text = text_of(bytes);
    let mut vertices = Vec::new();
    let mut corners = Vec::new();
    for (line, content) in logical_lines(&text) {
        let mut words = content.split_whitespace();
        let Some(keyword) = words.next() else { continue };
        let fault = |message: String| format!("line {line}: {message}");
        match keyword {
            "v" => {
                vertices.push(numbers(words).and_then(|values| point(&values)).map_err(fault)?);
                check_vertices(vertices.len()).map_err(fault)?;
            }
            "f" | "fo" => {
                let face =
                    words.map(|word| place(word, &vertices)).collect::<Result<Vec<_>, _>>().map_err(fault)?;
                if face.len() < 3 {
                    return Err(fault("a face has fewer than three corners".into()));
                }
                let triangles = triangulate(&face)
                    .ok_or_else(|| fault(format!("the face of {} corners crosses itself", face.len())))?;
                corners.extend(triangles.into_iter().flatten().map(|corner| face[corner]));
                check_corners(corners.len()).map_err(fault)?;
            }
            _ if keyword.starts_with('#') || IGNORED.contains(&keyword) => {}
            _ => return Err(fault(format!("'{}' is not read here", cranny_file::excerpt(content.trim())))),
        }
    }
    Ok(corners)
}

/// Ignored keywords: normals, textures, groups, materials, display, and elements without area.
const IGNORED: [&str; 21] = [
    "vt",
    "vn",
    "vp",
    "g",
    "o",
    "s",
    "mg",
    "usemtl",
    "mtllib",
    "usemap",
    "maplib",
    "p",
    "l",
    "lod",
    "bevel",
    "c_interp",
    "d_interp",
    "shadow_obj",
    "trace_obj",
    "cstype",
    "deg",
];

/// Text of an OBJ file or a library of materials, without a byte order mark.
pub(crate) fn text_of(bytes: &[u8]) -> Cow<'_, str> {
    String::from_utf8_lossy(bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes))
}

/// Lines with their numbers, from 1. A line that ends in a backslash includes the next.
pub(crate) fn logical_lines(text: &str) -> impl Iterator<Item = (usize, Cow<'_, str>)> {
    let (mut rest, mut number) = (text, 0);
    let mut physical_line = move || {
        if rest.is_empty() {
            return None;
        }
        number += 1;
        let (line, behind) = rest.split_at(rest.find(['\n', '\r']).unwrap_or(rest.len()));
        rest = behind.strip_prefix("\r\n").or(behind.get(1..)).unwrap_or_default();
        // A backslash has no meaning in a comment.
        let continued = line.trim_end().strip_suffix('\\').filter(|line| !line.trim_start().starts_with('#'));
        Some((number, continued.unwrap_or(line), continued.is_some()))
    };
    std::iter::from_fn(move || {
        let (number, content, mut is_continued) = physical_line()?;
        let mut whole = Cow::Borrowed(content);
        while is_continued && let Some((_, content, goes_on)) = physical_line() {
            whole.to_mut().push(' ');
            whole.to_mut().push_str(content);
            is_continued = goes_on;
        }
        Some((number, whole))
    })
}

/// Parses words as numbers in single precision.
pub(crate) fn numbers<'a>(words: impl Iterator<Item = &'a str>) -> Result<Vec<f32>, String> {
    let number = |word: &str| {
        word.parse::<f32>().map_err(|_| format!("'{}' is no number", cranny_file::excerpt(word)))
    };
    words.map(number).collect()
}

/// Point of a vertex: three numbers, then an optional weight or colour.
pub(crate) fn point(values: &[f32]) -> Result<Point, String> {
    match *values {
        [x, y, z] | [x, y, z, _] | [x, y, z, _, _, _] | [x, y, z, _, _, _, _] => {
            Ok(Point::new(x.into(), y.into(), z.into()))
        }
        _ => Err(format!("a vertex of {} numbers", values.len())),
    }
}

/// Vertex of a corner of a face; texture and normal follow slashes.
fn place(word: &str, vertices: &[Point]) -> Result<Point, String> {
    index(word, vertices.len(), "vertex").map(|vertex| vertices[vertex])
}

/// Index from 0, which is less than `count`, of one that counts from 1, or backwards from the last; text behind a slash is
/// ignored.
pub(crate) fn index(word: &str, count: usize, what: &str) -> Result<usize, String> {
    let index = word.split('/').next().unwrap_or_default();
    let index: i64 = index.parse().map_err(|_| format!("'{}' is no {what}", cranny_file::excerpt(word)))?;
    let total = i64::try_from(count).unwrap_or(i64::MAX);
    let from_zero = if index < 0 { total.saturating_add(index) } else { index - 1 };
    let found = usize::try_from(from_zero).ok().filter(|found| *found < count);
    found.ok_or_else(|| format!("{what} {index} is named, but there are {count} before it"))
}
