use std::collections::HashMap;

use crate::error::{ShapeError, usable};
use crate::mesh_files::mesh_file::TriangleSoup;

pub(crate) fn check_indices(soup: &TriangleSoup) -> Result<(), ShapeError> {
    if soup.triangles.is_empty() {
        return Err(ShapeError::Empty);
    }
    soup.vertices.iter().enumerate().try_for_each(|(vertex, p)| usable(vertex, p))?;
    for (triangle, corners) in soup.triangles.iter().enumerate() {
        for &vertex in corners {
            if vertex as usize >= soup.vertices.len() {
                return Err(ShapeError::VertexIndex { triangle, vertex, vertices: soup.vertices.len() });
            }
        }
    }
    Ok(())
}

/// Checks that every edge is traversed as often in one direction as in the other.
pub(crate) fn check_closed(soup: &TriangleSoup) -> Result<(), ShapeError> {
    let mut balance: HashMap<(u32, u32), i64> = HashMap::new();
    for &[a, b, c] in &soup.triangles {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            let (key, sign) = if from < to { ((from, to), 1) } else { ((to, from), -1) };
            *balance.entry(key).or_default() += sign;
        }
    }
    let edges = balance.values().filter(|&&sum| sum != 0).count();
    if edges == 0 { Ok(()) } else { Err(ShapeError::Open { edges }) }
}
