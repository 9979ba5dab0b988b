use std::collections::HashMap;

use cranny_sense::{Content, OccupancyGrid, SeenMap};
use cranny_shape::TriangleSoup;
use cranny_spatial::Vector;

/// Surfaces of the space that cameras have seen: of cells with measured surfaces, and of cells that no camera has seen into, where they
/// border on free ones. Free space is what is left of the region.
pub(crate) fn surfaces(map: &SeenMap) -> [TriangleSoup; 2] {
    let grid = OccupancyGrid::new(map);
    [Content::Occupied, Content::Unseen].map(|content| surface(&grid, content))
}

/// Returns the faces between cells of a content and free ones; faces of a row are one rectangle.
fn surface(grid: &OccupancyGrid, content: Content) -> TriangleSoup {
    let size = grid.counts();
    let mut corners = Corners { grid, soup: TriangleSoup::default(), known: HashMap::new() };
    for axis in 0..3 {
        let (across, along) = ((axis + 1) % 3, (axis + 2) % 3);
        for is_upper in [false, true] {
            for layer in 0..size[axis] {
                let Some(next) = (if is_upper { layer.checked_add(1) } else { layer.checked_sub(1) })
                    .filter(|next| *next < size[axis])
                else {
                    continue;
                };
                for row in 0..size[across] {
                    let is_face = |place: usize| {
                        let mut cell = [0; 3];
                        (cell[axis], cell[across], cell[along]) = (layer, row, place);
                        let own = grid.cell(cell);
                        cell[axis] = next;
                        own == content && grid.cell(cell) == Content::Free
                    };
                    let mut place = 0;
                    while place < size[along] {
                        let first = place;
                        while place < size[along] && is_face(place) {
                            place += 1;
                        }
                        if place > first {
                            let at = layer + usize::from(is_upper);
                            let mut corner = |across_at: usize, along_at: usize| {
                                let mut corner = [0; 3];
                                (corner[axis], corner[across], corner[along]) = (at, across_at, along_at);
                                corners.index(corner)
                            };
                            let quad = [
                                corner(row, first),
                                corner(row + 1, first),
                                corner(row + 1, place),
                                corner(row, place),
                            ];
                            corners.add(quad, is_upper);
                        }
                        place += 1;
                    }
                }
            }
        }
    }
    corners.soup
}

/// Surface whose corners are those of cells.
struct Corners<'a> {
    grid: &'a OccupancyGrid,
    soup: TriangleSoup,
    known: HashMap<[usize; 3], u32>,
}

impl Corners<'_> {
    fn index(&mut self, corner: [usize; 3]) -> u32 {
        let vertices = &mut self.soup.vertices;
        *self.known.entry(corner).or_insert_with(|| {
            let place = corner.map(|count| count as f64 * self.grid.side_m());
            vertices.push(self.grid.low() + Vector::from(place));
            // Far fewer than `u32` can count.
            u32::try_from(vertices.len() - 1).unwrap_or_default()
        })
    }

    /// Adds a rectangle; its corners are in order about the axis, which is outwards for the upper side.
    fn add(&mut self, [a, b, c, d]: [u32; 4], is_upper: bool) {
        let triangles = if is_upper { [[a, b, c], [a, c, d]] } else { [[a, c, b], [a, d, c]] };
        self.soup.triangles.extend(triangles);
    }
}

#[cfg(test)]
mod tests {
    use cranny_collision::{Body, World};
    use cranny_sense::{Camera, Noise, SeenSettings, SensedScene, SensorModel, Unseen};
    use cranny_shape::{Aabb, Solid};
    use cranny_spatial::{Point, Pose, Vector};

    use super::*;

    #[test]
    fn surfaces_lie_between_cells_of_a_kind_and_free_ones() {
        let wall = Body::new(
            "wall",
            Pose::translation(1.0, 0.0, 0.0),
            Solid::cuboid(Vector::new(0.05, 0.3, 0.3)).expect("sizes"),
        );
        let scene = SensedScene::of_world(&World::new(vec![wall]).expect("a world")).expect("solids");
        let pose = Camera::looking_at(&Point::new(-1.0, 0.0, 0.0), &Point::origin(), &Vector::z())
            .expect("two points");
        let camera = Camera::with_field_of_view([160, 120], 0.8, pose).expect("a camera");
        let view = scene.view("front", &camera, &SensorModel::default(), &Noise::default()).expect("a view");
        let settings = SeenSettings {
            region: Aabb { center: Point::new(0.8, 0.0, 0.0), half_extents: Vector::new(0.4, 0.2, 0.2) },
            cell_m: 0.02,
            fine: Vec::new(),
            fine_m: 0.01,
            unseen: Unseen::Solid,
        };
        let map = SeenMap::new(&[view], &[], settings).expect("a map");
        let grid = OccupancyGrid::new(&map);
        let cell_m3 = grid.side_m().powi(3);
        let [x, y, z] = grid.counts();
        let cells = (0..x * y * z).map(|index| [index / (y * z), index / z % y, index % z]);
        let free_m3 = cells.filter(|cell| grid.cell(*cell) == Content::Free).count() as f64 * cell_m3;
        assert!((free_m3 - map.free_m3()).abs() < 1e-9, "cells of one size");
        let [occupied, unseen] = surfaces(&map);
        assert!(!occupied.triangles.is_empty());
        // The camera sees the front of the wall, so what lies behind borders on what was measured, and on nothing free there.
        let before =
            |soup: &TriangleSoup| soup.vertices.iter().map(|vertex| vertex.x).fold(f64::INFINITY, f64::min);
        assert!(before(&occupied) > 0.8 && before(&occupied) < 0.95, "{}", before(&occupied));
        for soup in [&occupied, &unseen] {
            for [a, b, c] in &soup.triangles {
                let [a, b, c] = [a, b, c].map(|index| soup.vertices[*index as usize]);
                let normal = (b - a).cross(&(c - a)).normalize();
                let content_at = |shift: f64| {
                    let middle = a + (b - a) * 0.26 + (c - a) * 0.26 + normal * shift * grid.side_m();
                    grid.at(&middle)
                };
                assert!(content_at(0.5) == Some(Content::Free) && content_at(-0.5) != Some(Content::Free));
            }
        }
    }
}
