use std::collections::HashMap;

use cranny_spatial::Point;

/// Distance below which vertices are merged, in metres: well below the noise of any export, above the rounding of single
/// precision at a metre.
pub const VERTEX_MERGE_M: f64 = 1e-6;

/// Vertices without those that coincide with an earlier one, and the new index of each.
pub(crate) fn merged(vertices: &[Point]) -> (Vec<Point>, Vec<u32>) {
    let mut kept: Vec<Point> = Vec::new();
    let mut cells: HashMap<[i64; 3], Vec<u32>> = HashMap::new();
    #[allow(
        clippy::cast_possible_truncation,
        reason = "coordinates are at most 1000 m, so a cell number stays far below the limits of i64"
    )]
    let cell = |p: &Point| [p.x, p.y, p.z].map(|x| (x / VERTEX_MERGE_M).floor() as i64);
    let mut place = Vec::with_capacity(vertices.len());
    for vertex in vertices {
        let [x, y, z] = cell(vertex);
        let around =
            (-1..=1).flat_map(|i| (-1..=1).flat_map(move |j| (-1..=1).map(move |k| [x + i, y + j, z + k])));
        let near = around.filter_map(|key| cells.get(&key)).flatten();
        let same = near.copied().filter(|i| (kept[*i as usize] - vertex).norm() <= VERTEX_MERGE_M).min();
        place.push(same.unwrap_or_else(|| {
            kept.push(*vertex);
            let index = u32::try_from(kept.len() - 1).unwrap_or(u32::MAX);
            cells.entry([x, y, z]).or_default().push(index);
            index
        }));
    }
    (kept, place)
}
