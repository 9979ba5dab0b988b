use std::collections::HashMap;

use cranny_spatial::Point;

use crate::TriangleSoup;

impl TriangleSoup {
    /// A sphere about the origin as a closed mesh of 20 · 4ⁿ nearly equal triangles: an icosahedron whose
    /// triangles are divided n times, all vertices on the sphere.
    pub fn geodesic_sphere(radius_m: f64, divisions: u32) -> Self {
        let golden = 0.5 * (1.0 + 5.0_f64.sqrt());
        let mut vertices = Vec::new();
        for a in [-1.0, 1.0] {
            for b in [-golden, golden] {
                vertices.extend([Point::new(0.0, a, b), Point::new(a, b, 0.0), Point::new(b, 0.0, a)]);
            }
        }
        let mut soup = Self::convex_hull(&vertices).unwrap_or_default();
        for _ in 0..divisions {
            soup = soup.divided();
        }
        for vertex in &mut soup.vertices {
            *vertex = (vertex.coords.normalize() * radius_m).into();
        }
        soup
    }

    /// Returns this surface with each triangle divided into four at the midpoints of its edges.
    fn divided(&self) -> Self {
        let mut vertices = self.vertices.clone();
        let mut middles: HashMap<(u32, u32), u32> = HashMap::new();
        let mut triangles = Vec::with_capacity(4 * self.triangles.len());
        for &[a, b, c] in &self.triangles {
            let [ab, bc, ca] = [(a, b), (b, c), (c, a)].map(|(from, to)| {
                *middles.entry((from.min(to), from.max(to))).or_insert_with(|| {
                    let ends = [from, to].map(|vertex| self.vertices[vertex as usize].coords);
                    // The midpoint is put on the sphere at once, so that later divisions stay even.
                    let middle = (ends[0] + ends[1]).normalize() * ends[0].norm();
                    vertices.push(middle.into());
                    u32::try_from(vertices.len() - 1).unwrap_or(u32::MAX)
                })
            });
            triangles.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
        }
        Self { vertices, triangles }
    }
}
