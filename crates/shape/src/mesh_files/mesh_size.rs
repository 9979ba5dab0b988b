/// Maximum number of triangles. Each takes some 500 bytes in a solid: 4 GB for this many.
const MOST_TRIANGLES: usize = 8_000_000;

/// Checks the number of corners that a reader has found, before they take more memory.
///
/// # Errors
/// A sentence with the limit.
pub(crate) fn check_corners(corners: usize) -> Result<(), String> {
    if corners <= 3 * MOST_TRIANGLES {
        return Ok(());
    }
    Err(format!(
        "the mesh has more than {MOST_TRIANGLES} triangles (reduce it, with Blender's decimate modifier or \
         `simplify_quadric_decimation` of trimesh in Python)"
    ))
}

/// Checks the number of vertices that a reader has found: at most one for each corner.
///
/// # Errors
/// A sentence with the limit.
pub(crate) fn check_vertices(vertices: usize) -> Result<(), String> {
    const MOST: usize = 3 * MOST_TRIANGLES;
    if vertices <= MOST { Ok(()) } else { Err(format!("the mesh has more than {MOST} vertices")) }
}
