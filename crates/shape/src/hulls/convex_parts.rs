use cranny_spatial::{Point, Vector};
use parry3d_f64::transformation::vhacd::{VHACD, VHACDParameters};
use serde::{Deserialize, Serialize};

use crate::inside::closed_mesh::{check_closed, check_indices};
use crate::{ShapeError, Surface, TriangleSoup, distance::parry};

/// Settings of the convex decomposition of a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DecompositionSettings {
    /// Number of voxels along the longest side of the mesh, 8 to 400. Default 64: 3 mm for a hand-sized object.
    pub resolution: u32,
    /// Maximum concavity of a piece, as a share of the mesh's volume, in (0, 1). Default 0.005: a banana gets about ten pieces.
    pub concavity: f64,
    /// Maximum number of pieces. Default 32: more pieces cost more in every collision check than they gain.
    pub most_parts: u32,
}

impl Default for DecompositionSettings {
    fn default() -> Self {
        Self { resolution: 64, concavity: 0.005, most_parts: 32 }
    }
}

/// Convex solids that together approximate a mesh.
#[derive(Clone, Debug)]
pub struct ConvexParts {
    /// The pieces, each a closed convex mesh.
    pub parts: Vec<TriangleSoup>,
    /// Error of the approximation.
    pub error: VolumeError,
}

/// Difference between a union of convex pieces and the volume of a mesh, as shares of the mesh's volume.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct VolumeError {
    /// Volume of the pieces outside the mesh.
    pub excess: f64,
    /// Volume of the mesh outside all pieces.
    pub missing: f64,
}

impl ConvexParts {
    /// Decomposes the volume that `soup` encloses into convex pieces (V-HACD as `parry` implements it; Mamou 2016, "Volumetric
    /// hierarchical approximate convex decomposition", whole) and measures the error.
    ///
    /// # Errors
    /// [`ShapeError::Open`] and similar errors for a mesh that encloses no volume; [`ShapeError::NoVolume`] if no piece is
    /// found.
    pub fn of_mesh(soup: &TriangleSoup, settings: &DecompositionSettings) -> Result<Self, ShapeError> {
        check_indices(soup)?;
        check_closed(soup)?;
        // The voxels of V-HACD would cut even a box.
        let hull = TriangleSoup::convex_hull(&soup.vertices)?;
        let hollow = 1.0 - soup.signed_volume_m3() / hull.signed_volume_m3();
        if hollow <= settings.concavity {
            return Self::measured(soup, vec![hull]);
        }
        let parameters = VHACDParameters {
            resolution: settings.resolution.clamp(8, 400),
            concavity: settings.concavity,
            max_convex_hulls: settings.most_parts.max(1),
            ..VHACDParameters::default()
        };
        let vertices: Vec<_> = soup.vertices.iter().map(parry::point).collect();
        let decomposition = VHACD::decompose(&parameters, &vertices, &soup.triangles, true);
        let hulls = decomposition.compute_exact_convex_hulls(&vertices, &soup.triangles);
        let parts: Vec<TriangleSoup> = hulls
            .into_iter()
            .filter_map(|(points, _)| {
                let points: Vec<Point> = points.into_iter().map(|p| parry::to_vector(p).into()).collect();
                TriangleSoup::convex_hull(&points).ok()
            })
            .collect();
        Self::measured(soup, parts)
    }

    /// Takes given pieces, and measures their error against the volume that `soup` encloses.
    ///
    /// # Errors
    /// [`ShapeError::NoVolume`] if there is no piece, or the mesh encloses nothing.
    pub fn measured(soup: &TriangleSoup, parts: Vec<TriangleSoup>) -> Result<Self, ShapeError> {
        let error = volume_error(soup, &parts)?;
        Ok(Self { parts, error })
    }
}

/// Number of lines along which volumes are compared; a share of the volume is then off by some 0.003.
const LINES: u32 = 4096;

/// Compares the lengths of vertical lines inside the mesh and inside any piece. The lines are spread evenly but not on a grid
/// (R₂ of Roberts 2018, "The unreasonable effectiveness of quasirandom sequences", whole), so that none runs along the edges of
/// a symmetric mesh.
fn volume_error(soup: &TriangleSoup, parts: &[TriangleSoup]) -> Result<VolumeError, ShapeError> {
    let mesh = Surface::new(soup)?;
    let parts: Vec<Surface> = parts.iter().map(Surface::new).collect::<Result<_, _>>()?;
    let low = parts.iter().map(|part| part.aabb().low()).fold(mesh.aabb().low(), |a, b| a.inf(&b));
    let high = parts.iter().map(|part| part.aabb().high()).fold(mesh.aabb().high(), |a, b| a.sup(&b));
    let height_m = high.z - low.z + 2.0 * ROOM_M;
    let (mut of_mesh, mut excess, mut missing) = (0.0, 0.0, 0.0);
    // Powers of the inverse of the root of x³ = x + 1.
    const STEP: [f64; 2] = [0.754877666246693, 0.569840290998053];
    for line in 0..LINES {
        let share = STEP.map(|step| (0.5 + f64::from(line) * step).fract());
        let x = low.x + (high.x - low.x) * share[0];
        let y = low.y + (high.y - low.y) * share[1];
        let foot = Point::new(x, y, low.z - ROOM_M);
        let inside = intervals(&mesh, &foot, height_m);
        let mut covered: Vec<[f64; 2]> =
            parts.iter().flat_map(|part| intervals(part, &foot, height_m)).collect();
        covered.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let covered = united(&covered);
        let (length, common) = (length_of(&inside), overlap_of(&inside, &covered));
        of_mesh += length;
        missing += length - common;
        excess += length_of(&covered) - common;
    }
    if of_mesh > 0.0 && !parts.is_empty() {
        Ok(VolumeError { excess: excess / of_mesh, missing: missing / of_mesh })
    } else {
        Err(ShapeError::NoVolume { volume_m3: of_mesh })
    }
}

/// Distance of the start of the lines below all meshes, in metres; no rounding moves a face below it.
const ROOM_M: f64 = 1e-3;

/// Intervals of a vertical line inside a closed surface: those preceded by more entries than exits.
fn intervals(surface: &Surface, foot: &Point, height_m: f64) -> Vec<[f64; 2]> {
    let (mut depth, mut begin, mut found) = (0_i32, 0.0, Vec::new());
    for hit in surface.ray_hits(foot, &Vector::z(), height_m) {
        let before = depth;
        depth += if hit.normal.z < 0.0 { 1 } else { -1 };
        if before <= 0 && depth > 0 {
            begin = hit.distance_m;
        } else if before > 0 && depth <= 0 {
            found.push([begin, hit.distance_m]);
        }
    }
    found
}

/// Merges those of the sorted intervals that overlap.
fn united(sorted: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let mut united: Vec<[f64; 2]> = Vec::new();
    for &[begin, end] in sorted {
        match united.last_mut() {
            Some(last) if begin <= last[1] => last[1] = last[1].max(end),
            _ => united.push([begin, end]),
        }
    }
    united
}

fn length_of(intervals: &[[f64; 2]]) -> f64 {
    intervals.iter().map(|[begin, end]| end - begin).sum()
}

fn overlap_of(first: &[[f64; 2]], second: &[[f64; 2]]) -> f64 {
    let pairs = first.iter().flat_map(|a| second.iter().map(move |b| (a, b)));
    pairs.map(|(a, b)| (a[1].min(b[1]) - a[0].max(b[0])).max(0.0)).sum()
}
