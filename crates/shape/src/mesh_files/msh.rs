use cranny_spatial::Point;

use crate::mesh_files::mesh_size::check_corners;

/// Corners of the triangles of an MSH file, three at a time; such a file is binary (`MuJoCo`, Modeling, MSH files).
///
/// Four counts (vertices, normals, texture coordinates, triangles) of 32 bits precede the three coordinates of each vertex, in
/// single precision, those of each normal, two texture coordinates each, and three vertex indices for each triangle. All
/// numbers are little-endian.
///
/// # Errors
/// A message: another size than the counts state, no triangle, or an index beyond the vertices.
pub(crate) fn corners(bytes: &[u8]) -> Result<Vec<Point>, String> {
    let word = |index: usize| -> Option<[u8; 4]> { bytes.get(4 * index..4 * index + 4)?.try_into().ok() };
    let count = |index| word(index).and_then(|bytes| usize::try_from(i32::from_le_bytes(bytes)).ok());
    let counts = [0, 1, 2, 3].map(count);
    let [Some(vertices), Some(normals), Some(places), Some(triangles)] = counts else {
        return Err("the file does not begin with four counts, as an MSH file does".into());
    };
    let words = [(vertices, 3), (normals, 3), (places, 2), (triangles, 3)];
    // Each count is below 2^31, so that no sum of these overflows 64 bits.
    let needed = words.iter().map(|(count, each)| *count as u64 * each).sum::<u64>() * 4 + 16;
    if needed != bytes.len() as u64 {
        return Err(format!(
            "an MSH file of these counts has {needed} bytes, but this one has {}",
            bytes.len()
        ));
    }
    if triangles == 0 {
        return Err("the file has no triangles".into());
    }
    check_corners(3 * triangles)?;
    let coordinate = |index| word(index).map_or(f64::NAN, |bytes| f64::from(f32::from_le_bytes(bytes)));
    let first_index = 4 + 3 * vertices + 3 * normals + 2 * places;
    (first_index..first_index + 3 * triangles)
        .map(|place| {
            let vertex = count(place).filter(|vertex| *vertex < vertices);
            let vertex =
                vertex.ok_or_else(|| format!("a triangle names a vertex that is not one of {vertices}"))?;
            Ok(Point::from([0, 1, 2].map(|axis| coordinate(4 + 3 * vertex + axis))))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(counts: [i32; 4], vertices: &[f32], indices: &[i32]) -> Vec<u8> {
        let counts = counts.iter().flat_map(|count| count.to_le_bytes());
        let vertices = vertices.iter().flat_map(|number| number.to_le_bytes());
        counts.chain(vertices).chain(indices.iter().flat_map(|index| index.to_le_bytes())).collect()
    }

    #[test]
    fn a_triangle_is_read() {
        let bytes = file([3, 0, 0, 1], &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 2.0, 0.0], &[0, 1, 2]);
        let corners = corners(&bytes).unwrap();
        assert_eq!(corners, [Point::origin(), Point::new(1.0, 0.0, 0.0), Point::new(0.0, 2.0, 0.0)]);
    }

    #[test]
    fn counts_and_indices_that_do_not_fit_are_refused() {
        for bytes in [
            Vec::new(),
            vec![0; 15],
            file([0; 4], &[], &[]),
            file([-1, 0, 0, 1], &[], &[]),
            file([i32::MAX; 4], &[], &[]),
            file([3, 0, 0, 1], &[0.0; 9], &[0, 1]),
            file([3, 0, 0, 1], &[0.0; 9], &[0, 1, 3]),
            file([3, 0, 0, 1], &[0.0; 9], &[0, 1, -1]),
        ] {
            assert!(corners(&bytes).is_err(), "{bytes:?}");
        }
    }
}
