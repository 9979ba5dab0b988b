use cranny_spatial::Point;

use crate::polygon::triangulate;

/// The corners of the triangles of an STL file, three at a time.
///
/// Some programs leave the count of a binary file at zero, which then is read to its end; bytes behind the triangles that
/// cannot be triangles are passed over. A text may have several solids, and letters of either case.
///
/// # Errors
/// In words: a binary file that has fewer or more triangles than it counts, a text without an end or with a line that
/// is none of the format's.
pub(crate) fn corners(bytes: &[u8]) -> Result<Vec<Point>, String> {
    if let Some(triangles) = counted_triangles(bytes) {
        return Ok(triangles.chunks_exact(TRIANGLE_BYTES).flat_map(binary_corners).collect());
    }
    if bytes.contains(&0) {
        let count = bytes.get(HEADER_BYTES - 4..HEADER_BYTES).map_or(0, little_endian);
        let needed = HEADER_BYTES as u64 + u64::from(count) * TRIANGLE_BYTES as u64;
        return Err(format!(
            "a binary STL file of {count} triangles has {needed} bytes, but this one has {} (is it cut off, or its \
             count wrong?)",
            bytes.len()
        ));
    }
    let has_end = bytes.windows(END.len()).any(|word| word.eq_ignore_ascii_case(END));
    if !has_end {
        return Err("the text has no 'endsolid' (is the file cut off, or no STL file?)".into());
    }
    text_corners(&String::from_utf8_lossy(bytes))
}

/// A comment of 80 bytes, and the count of the triangles.
const HEADER_BYTES: usize = 84;

/// A normal and three corners in single precision, and two bytes that mean nothing.
const TRIANGLE_BYTES: usize = 50;

const END: &[u8] = b"endsolid";

/// The triangles of a binary file. No text is taken for one: its count would be that of half a gigabyte of triangles.
/// `None` also where more triangles seem to follow than are counted.
fn counted_triangles(bytes: &[u8]) -> Option<&[u8]> {
    let (header, triangles) = bytes.split_at_checked(HEADER_BYTES)?;
    let count = match usize::try_from(little_endian(&header[HEADER_BYTES - 4..])).ok()? {
        0 => triangles.len() / TRIANGLE_BYTES,
        count => count,
    };
    let (triangles, rest) = triangles.split_at_checked(count.checked_mul(TRIANGLE_BYTES)?)?;
    let may_be_triangles = !rest.is_empty()
        && rest.len().is_multiple_of(TRIANGLE_BYTES)
        && rest.iter().any(|byte| *byte != 0 && !byte.is_ascii_whitespace());
    (!may_be_triangles).then_some(triangles)
}

fn binary_corners(triangle: &[u8]) -> [Point; 3] {
    let number = |index: usize| f64::from(f32::from_bits(little_endian(&triangle[4 * index..4 * index + 4])));
    [3, 6, 9].map(|first| Point::new(number(first), number(first + 1), number(first + 2)))
}

fn little_endian(bytes: &[u8]) -> u32 {
    bytes.iter().rev().fold(0, |number, byte| number << 8 | u32::from(*byte))
}

fn text_corners(text: &str) -> Result<Vec<Point>, String> {
    let mut corners = Vec::new();
    let mut facet = Vec::new();
    let mut is_open = true;
    for (index, line) in text.split(['\n', '\r']).enumerate() {
        let fault = |message: String| format!("line {}: {message}", index + 1);
        let mut words = line.split_whitespace();
        let Some(keyword) = words.next() else { continue };
        match keyword.to_ascii_lowercase().as_str() {
            "solid" | "facet" | "outer" => is_open = true,
            "endsolid" => is_open = false,
            "endloop" => {}
            "vertex" => {
                let numbers: Vec<f32> = words.map_while(|word| word.parse().ok()).collect();
                let [x, y, z] = numbers[..] else {
                    return Err(fault("a vertex has three numbers".into()));
                };
                facet.push(Point::new(x.into(), y.into(), z.into()));
            }
            "endfacet" => {
                if facet.len() < 3 {
                    return Err(fault("a facet has fewer than three corners".into()));
                }
                let triangles =
                    triangulate(&facet).ok_or_else(|| fault("the facet crosses itself".into()))?;
                corners.extend(triangles.into_iter().flatten().map(|corner| facet[corner]));
                facet.clear();
            }
            _ => {
                return Err(fault(format!(
                    "'{}' is no line of an STL file",
                    cranny_file::excerpt(line.trim())
                )));
            }
        }
    }
    if is_open || !facet.is_empty() {
        return Err("the last solid has no 'endsolid' (is the file cut off?)".into());
    }
    Ok(corners)
}
