use std::collections::BTreeMap;

use cranny_spatial::{Stream, Vector};

/// Nodes of a tree by the direction of their grippers from an object, so that approaches come evenly from all sides (the
/// `ApproachSphere` of Vahrenkamp, Asfour & Dillmann 2012, whole). The sphere is divided as an octahedron whose faces are split
/// three times into four: 512 triangles.
#[derive(Clone, Debug, Default)]
pub(crate) struct ApproachSphere {
    faces: Vec<Face>,
    /// Index in `faces` of each triangle that has ever had a node.
    places: BTreeMap<Triangle, usize>,
}

/// Octant, cell of its face, and true for the upper half of the cell.
type Triangle = ([bool; 3], [u32; 2], bool);

#[derive(Clone, Debug, Default)]
struct Face {
    /// Number of nodes that were taken from it.
    taken: u32,
    nodes: Vec<usize>,
}

/// Cells along an edge of the octahedron.
const CELLS: u32 = 8;

/// Number of triangles sampled to find one from which few nodes were taken.
const LOOKS: u32 = 30;

impl ApproachSphere {
    /// Adds a node that lies in a direction from the middle; ignores one without a direction.
    pub fn add(&mut self, direction: &Vector, node: usize) {
        let length = direction.iter().map(|x| x.abs()).sum::<f64>();
        if length <= 0.0 || !length.is_finite() {
            return;
        }
        let triangle = triangle(&(direction / length));
        let place = *self.places.entry(triangle).or_insert(self.faces.len());
        if place == self.faces.len() {
            self.faces.push(Face::default());
        }
        self.faces[place].nodes.push(node);
    }

    /// Removes and returns a random node of a triangle from which few were taken; `None` if no sampled triangle has a node.
    pub fn take(&mut self, random: &mut Stream) -> Option<usize> {
        let mut best: Option<usize> = None;
        for _ in 0..LOOKS.min(u32::try_from(self.faces.len()).unwrap_or(LOOKS)) {
            let face = random.index(self.faces.len());
            let is_better = |best: usize| self.faces[face].taken < self.faces[best].taken;
            if !self.faces[face].nodes.is_empty() && best.is_none_or(is_better) {
                best = Some(face);
            }
        }
        let face = &mut self.faces[best?];
        face.taken += 1;
        let node = random.index(face.nodes.len());
        Some(face.nodes.swap_remove(node))
    }
}

/// Returns the triangle of a point of the octahedron |x| + |y| + |z| = 1.
fn triangle(point: &Vector) -> Triangle {
    let scaled = [point.x, point.y].map(|x| x.abs() * f64::from(CELLS));
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "they lie in [0, CELLS]")]
    let cell = scaled.map(|x| x.floor() as u32);
    let is_upper = scaled.iter().map(|x| x.fract()).sum::<f64>() > 1.0;
    ([point.x < 0.0, point.y < 0.0, point.z < 0.0], cell, is_upper)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_are_taken_alike_however_many_nodes_lie_in_them() {
        let (mut sphere, mut random) = (ApproachSphere::default(), Stream::new(3, 0));
        for node in 0..1000 {
            sphere.add(&Vector::new(0.1, 0.2, 0.7), node);
        }
        for node in 1000..1010 {
            sphere.add(&Vector::new(-0.1, 0.2, -0.7), node);
        }
        let taken: Vec<usize> = (0..20).filter_map(|_| sphere.take(&mut random)).collect();
        let rare = taken.iter().filter(|node| **node >= 1000).count();
        assert!((8..=10).contains(&rare), "{rare} of {}", taken.len());
        assert!(taken.iter().enumerate().all(|(index, node)| !taken[..index].contains(node)));
    }

    #[test]
    fn what_has_no_direction_is_left_out() {
        let (mut sphere, mut random) = (ApproachSphere::default(), Stream::new(3, 0));
        sphere.add(&Vector::zeros(), 0);
        sphere.add(&Vector::repeat(f64::NAN), 1);
        assert_eq!(sphere.take(&mut random), None);
    }
}
