use cranny_shape::TriangleSoup;
use cranny_spatial::{Point, Vector};

use crate::{Colour, Material, MeshPiece, Scene};

/// Appearance of a class of objects, recognized by name.
struct Look {
    /// Words, any of which identifies the class in a name.
    words: &'static [&'static str],
    colour: u32,
    /// Region of the mesh in another colour.
    detail: Detail,
}

/// Selection of the triangles with another colour.
#[derive(Clone, Copy)]
enum Detail {
    None,
    /// Thin triangles beyond the handle along the longest axis: bare steel.
    Shaft,
    /// Both ends of the longest axis.
    DarkEnds,
    /// Band around the middle of a box.
    Band,
}

const LOOKS: [Look; 4] = [
    Look { words: &["screwdriver"], colour: 0x00d1_3b2a, detail: Detail::Shaft },
    Look { words: &["banana"], colour: 0x00f5_c518, detail: Detail::DarkEnds },
    Look { words: &["ball"], colour: 0x00c5_e01b, detail: Detail::None },
    Look { words: &["sugar", "box"], colour: 0x00f4_d35e, detail: Detail::Band },
];

/// Colour of all other objects: orange, unique in a scene.
const OTHER: u32 = 0x00ee_7f1b;

const STEEL: u32 = 0x00b9_bec4;
const BROWN: u32 = 0x005a_4321;
const BLUE: u32 = 0x0026_5fb0;

/// Half the width of a band, and start of the ends from the middle, as shares of the whole length.
const BAND_SHARE: f64 = 0.2;
const END_SHARE: f64 = 0.475;

/// Maximum thickness of a shaft, as a share of the whole thickness.
const SHAFT_SHARE: f64 = 0.55;

/// End of the handle from the middle, as a share of the whole length: slightly before the start of the shaft.
const HANDLE_END: f64 = -0.03;

/// Returns the mesh of an object, coloured by its name.
pub(crate) fn painted(name: &str, soup: &TriangleSoup, scene: &mut Scene) -> Vec<MeshPiece> {
    let lower = name.to_lowercase();
    let look = LOOKS.iter().find(|look| look.words.iter().any(|word| lower.contains(word)));
    let (colour, detail) = look.map_or((OTHER, Detail::None), |look| (look.colour, look.detail));
    let colour = Colour::hex(colour);
    let main = scene.material(Material { roughness: 0.45, ..Material::matt(name, colour) });
    let Some(first) = soup.vertices.first() else { return Vec::new() };
    let (low, high) = soup.vertices.iter().fold((*first, *first), |(low, high), p| (low.inf(p), high.sup(p)));
    let (middle, size) = ((low.coords + high.coords) * 0.5, high - low);
    let is_detail = |corner: &Point| -> bool {
        let from_middle = corner.coords - middle;
        match detail {
            Detail::None => false,
            Detail::Shaft => is_shaft(&from_middle, &size),
            Detail::DarkEnds => {
                let long = size.imax();
                from_middle[long].abs() > END_SHARE * size[long]
            }
            Detail::Band => from_middle[size.imax()].abs() < BAND_SHARE * size.max(),
        }
    };
    let other = match detail {
        Detail::None => return vec![MeshPiece::of_soup(soup, main)],
        Detail::Shaft => Material {
            metallic: 0.9,
            roughness: 0.3,
            ..Material::matt(format!("{name} steel"), Colour::hex(STEEL))
        },
        Detail::DarkEnds => Material::matt(format!("{name} ends"), Colour::hex(BROWN)),
        Detail::Band => {
            Material { roughness: 0.45, ..Material::matt(format!("{name} band"), Colour::hex(BLUE)) }
        }
    };
    let other = scene.material(other);
    let cut_at = match detail {
        Detail::Band => Some(BAND_SHARE),
        Detail::DarkEnds => Some(END_SHARE),
        Detail::None | Detail::Shaft => None,
    };
    let long = size.imax();
    let cut = cut_at.map(|share| banded(soup, long, middle[long], share * size[long]));
    let soup = cut.as_ref().unwrap_or(soup);
    let whole = MeshPiece::of_soup(soup, main);
    let mut parts = [whole.clone(), MeshPiece { material: other, ..whole.clone() }];
    for part in &mut parts {
        part.triangles.clear();
    }
    for triangle in &whole.triangles {
        let corner = |index: usize| Vector::from(whole.positions[triangle[index] as usize].map(f64::from));
        let center = (corner(0) + corner(1) + corner(2)) / 3.0;
        parts[usize::from(is_detail(&center.into()))].triangles.push(*triangle);
    }
    parts.into_iter().filter(|part| !part.triangles.is_empty()).map(|part| part.compacted()).collect()
}

/// Returns true if a point is on the shaft of a screwdriver: near its axis and beyond the handle.
fn is_shaft(from_middle: &Vector, size: &Vector) -> bool {
    let long = size.imax();
    let (one, other) = ((long + 1) % 3, (long + 2) % 3);
    let across = (from_middle[one].powi(2) + from_middle[other].powi(2)).sqrt();
    let thickness = size[one].max(size[other]);
    across < 0.5 * thickness * SHAFT_SHARE && from_middle[long] > HANDLE_END * size[long]
}

/// Cuts the triangles at two heights along an axis, so that a band between them has straight edges.
fn banded(soup: &TriangleSoup, axis: usize, middle: f64, half_width: f64) -> TriangleSoup {
    let mut corners: Vec<Vec<Point>> = (0..soup.triangles.len()).map(|t| soup.corners(t).to_vec()).collect();
    for height in [middle - half_width, middle + half_width] {
        corners = corners.iter().flat_map(|polygon| cut(polygon, axis, height)).collect();
    }
    let fans = corners.iter().flat_map(|polygon| {
        (2..polygon.len()).flat_map(|i| [polygon[0], polygon[i - 1], polygon[i]]).collect::<Vec<_>>()
    });
    TriangleSoup::from_corners(fans).unwrap_or_default()
}

/// Splits a convex polygon into the polygons below and above a height.
fn cut(polygon: &[Point], axis: usize, height: f64) -> Vec<Vec<Point>> {
    let mut sides = [Vec::new(), Vec::new()];
    for (index, here) in polygon.iter().enumerate() {
        let next = polygon[(index + 1) % polygon.len()];
        let (a, b) = (here[axis] - height, next[axis] - height);
        if a <= 0.0 {
            sides[0].push(*here);
        }
        if a >= 0.0 {
            sides[1].push(*here);
        }
        if a * b < 0.0 {
            let crossing = here + (next - here) * (a / (a - b));
            sides[0].push(crossing);
            sides[1].push(crossing);
        }
    }
    sides.into_iter().filter(|side| side.len() >= 3).collect()
}
