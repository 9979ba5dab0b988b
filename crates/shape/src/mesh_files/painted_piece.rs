use cranny_spatial::{Point, Vector};

use crate::error::usable;
use crate::{ShapeError, TriangleSoup};

/// Triangles of one material.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PaintedPiece {
    /// Corner points, in metres.
    pub vertices: Vec<[f32; 3]>,
    /// Unit normal of each vertex; empty if the file gives none.
    pub normals: Vec<[f32; 3]>,
    /// Red, green, blue and opacity of each vertex, 0 to 1, sRGB; empty if the file gives none.
    pub vertex_colours: Vec<[f32; 4]>,
    /// Three indices into `vertices` each, counterclockwise from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Red, green, blue and opacity of the material, 0 to 1, sRGB; `None` if it has none.
    pub colour: Option<[f32; 4]>,
}

impl PaintedPiece {
    /// Makes a piece of triangles without colours or normals.
    pub fn of_soup(soup: &TriangleSoup) -> Self {
        #[allow(clippy::cast_possible_truncation, reason = "the precision of graphics")]
        let vertices = soup.vertices.iter().map(|v| [v.x as f32, v.y as f32, v.z as f32]).collect();
        Self { vertices, triangles: soup.triangles.clone(), ..Self::default() }
    }

    /// Scales the piece, mirrors its triangles if the scale does, and drops normals and colours that not each vertex has.
    pub(crate) fn scaled(mut self, scale: &Vector) -> Result<Self, ShapeError> {
        #[allow(clippy::cast_possible_truncation, reason = "single precision is what is meant")]
        let factors = [scale.x as f32, scale.y as f32, scale.z as f32];
        for (index, vertex) in self.vertices.iter_mut().enumerate() {
            *vertex = std::array::from_fn(|axis| vertex[axis] * factors[axis]);
            usable(index, &Point::from(vertex.map(f64::from)))?;
        }
        if factors.iter().product::<f32>() < 0.0 {
            self.triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
        }
        // Normals scale by the inverse of the factors of points.
        for normal in &mut self.normals {
            let n: [f32; 3] = std::array::from_fn(|axis| normal[axis] / factors[axis]);
            let length = (n[0] * n[0] + n[1] * n[1] + n[2] * n[2]).sqrt();
            *normal = n.map(|x| x / length);
        }
        if self.normals.len() != self.vertices.len() || self.normals.iter().flatten().any(|x| !x.is_finite())
        {
            self.normals.clear();
        }
        if self.vertex_colours.len() != self.vertices.len() {
            self.vertex_colours.clear();
        }
        Ok(self)
    }
}
