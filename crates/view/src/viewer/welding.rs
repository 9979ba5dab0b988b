use std::collections::HashMap;

use crate::MeshPiece;

/// Grid of the corners, in metres (61 µm): below what a page can show, and numbers with few digits compress well.
const POSITION_GRID_M: f32 = 1.0 / 16384.0;

/// Grid of the components of normals: half a degree.
const NORMAL_GRID: f32 = 1.0 / 128.0;

/// Cosine of 8°: coincident corners merge if their normals differ by less, as the faces of a cylinder of 40 faces do not.
const SAME_COSINE: f32 = 0.99;

/// Number of corners in one point with which others are compared: more than any usual mesh has. Further ones stay apart.
const MOST_COMPARED: usize = 64;

impl MeshPiece {
    /// Returns the surface with few corners and few digits, for transmission: many mesh files repeat each corner for each
    /// triangle. Triangles that vanish on the grid are left out.
    #[must_use]
    pub(crate) fn welded(&self) -> Self {
        let mut piece = Self { material: self.material, ..Self::default() };
        let mut known: HashMap<[i64; 3], Vec<u32>> = HashMap::new();
        let mut welded = Vec::with_capacity(self.positions.len());
        for (corner, (position, normal)) in self.positions.iter().zip(&self.normals).enumerate() {
            let colour = self.colours.get(corner);
            let place = position.map(|x| steps(x, POSITION_GRID_M));
            let here = known.entry(place).or_default();
            let is_same = |&other: &u32| {
                let other = other as usize;
                let cosine: f32 = piece.normals[other].iter().zip(normal).map(|(a, b)| a * b).sum();
                cosine > SAME_COSINE && piece.colours.get(other) == colour
            };
            let index = here.iter().copied().find(is_same).unwrap_or_else(|| {
                #[allow(clippy::cast_precision_loss, reason = "few enough digits for `f32`")]
                let index = piece.push(place.map(|step| step as f32 * POSITION_GRID_M), *normal, colour);
                if here.len() < MOST_COMPARED {
                    here.push(index);
                }
                index
            });
            welded.push(index);
        }
        #[allow(clippy::cast_precision_loss, reason = "steps of the grid are few")]
        let on_grid = |x: f32| steps(x, NORMAL_GRID) as f32 * NORMAL_GRID;
        for normal in &mut piece.normals {
            *normal = normal.map(on_grid);
        }
        let triangles = self.triangles.iter().map(|triangle| triangle.map(|corner| welded[corner as usize]));
        piece.triangles = triangles.filter(|[a, b, c]| a != b && b != c && c != a).collect();
        piece
    }
}

/// Returns the index of the nearest line of a grid.
#[allow(clippy::cast_possible_truncation, reason = "what is drawn is far smaller than the range")]
fn steps(value: f32, grid: f32) -> i64 {
    (value / grid).round() as i64
}

#[cfg(test)]
mod tests {
    use cranny_shape::TriangleSoup;

    use super::*;

    #[test]
    fn a_surface_keeps_its_shape_and_its_edges() {
        let ball = MeshPiece::of_soup(&TriangleSoup::geodesic_sphere(0.3, 3), 4);
        // Many files have this form: three separate corners for each triangle.
        let corners: Vec<usize> = ball.triangles.iter().flatten().map(|&corner| corner as usize).collect();
        let loose = MeshPiece {
            positions: corners.iter().map(|&corner| ball.positions[corner]).collect(),
            normals: corners.iter().map(|&corner| ball.normals[corner]).collect(),
            triangles: (0..1280).map(|triangle| [0, 1, 2].map(|corner| 3 * triangle + corner)).collect(),
            ..ball.clone()
        };
        let welded = loose.welded();
        assert_eq!((welded.positions.len(), welded.triangles.len(), welded.material), (642, 1280, 4));
        for (one, other) in loose.triangles.iter().zip(&welded.triangles) {
            for (a, b) in one.iter().zip(other) {
                for axis in 0..3 {
                    let moved = loose.positions[*a as usize][axis] - welded.positions[*b as usize][axis];
                    assert!(moved.abs() <= 0.51 * POSITION_GRID_M);
                }
            }
        }
        let half_extents = cranny_spatial::Vector::new(0.1, 0.2, 0.3);
        let cuboid = MeshPiece::of_soup(&cranny_shape::Surface::cuboid_soup(&half_extents), 0);
        assert_eq!(cuboid.welded().positions.len(), 24, "each side keeps its own corners");
    }

    #[test]
    fn what_vanishes_is_left_out() {
        let piece = MeshPiece {
            positions: vec![[0.0; 3], [1e-6, 0.0, 0.0], [0.0, 1e-6, 0.0]],
            normals: vec![[0.0, 0.0, 1.0]; 3],
            triangles: vec![[0, 1, 2]],
            ..MeshPiece::default()
        };
        assert!(piece.welded().triangles.is_empty());
    }
}
