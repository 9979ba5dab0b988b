use std::io::{Error, ErrorKind};

use cranny_spatial::Point;

/// The corners of the triangles of an STL file, three at a time.
///
/// # Errors
/// A binary file whose length is not that of the triangles it counts, a text without an end, or what
/// `mesh-loader` says of a text.
pub(crate) fn corners(bytes: &[u8]) -> Result<Vec<Point>, Error> {
    let broken = |message: String| Error::new(ErrorKind::InvalidData, message);
    if let Some(triangles) = counted_triangles(bytes) {
        return Ok(triangles.chunks_exact(TRIANGLE_BYTES).flat_map(binary_corners).collect());
    }
    if bytes.contains(&0) {
        let count = bytes.get(HEADER_BYTES - 4..HEADER_BYTES).map_or(0, little_endian);
        let needed = HEADER_BYTES as u64 + u64::from(count) * TRIANGLE_BYTES as u64;
        return Err(broken(format!(
            "a binary STL file of {count} triangles has {needed} bytes, but this one has {} (is it cut off?)",
            bytes.len()
        )));
    }
    let has_end = bytes.windows(END.len()).any(|word| word.eq_ignore_ascii_case(END));
    if !has_end {
        return Err(broken("the text has no 'endsolid' (is the file cut off, or no STL file?)".into()));
    }
    let read = mesh_loader::stl::from_slice(bytes)?;
    let solids = read.meshes.iter();
    Ok(solids.flat_map(|solid| solid.vertices.iter().map(|&v| Point::from(v.map(f64::from)))).collect())
}

/// A comment of 80 bytes, and the count of the triangles.
const HEADER_BYTES: usize = 84;

/// A normal and three corners in single precision, and two bytes that mean nothing.
const TRIANGLE_BYTES: usize = 50;

const END: &[u8] = b"endsolid";

/// The triangles of a binary file, if it has as many as it counts, and nothing more but white space.
fn counted_triangles(bytes: &[u8]) -> Option<&[u8]> {
    let (header, triangles) = bytes.split_at_checked(HEADER_BYTES)?;
    let count = usize::try_from(little_endian(&header[HEADER_BYTES - 4..])).ok()?;
    let (triangles, rest) = triangles.split_at_checked(count.checked_mul(TRIANGLE_BYTES)?)?;
    rest.iter().all(u8::is_ascii_whitespace).then_some(triangles)
}

fn binary_corners(triangle: &[u8]) -> [Point; 3] {
    let number = |index: usize| f64::from(f32::from_bits(little_endian(&triangle[4 * index..4 * index + 4])));
    [3, 6, 9].map(|first| Point::new(number(first), number(first + 1), number(first + 2)))
}

fn little_endian(bytes: &[u8]) -> u32 {
    bytes.iter().rev().fold(0, |number, byte| number << 8 | u32::from(*byte))
}
