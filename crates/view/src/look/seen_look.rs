use std::collections::HashMap;

use cranny_sense::SeenMap;
use cranny_shape::{Aabb, TriangleSoup};
use cranny_spatial::Point;

/// Surfaces of the space that cameras have seen: of cells with measured surfaces, and of cells that no camera has seen into, where they
/// border on free ones. Free space is what is left of the region.
///
/// Cells are drawn as wide as the smallest ones of the map outside its fine boxes.
pub(crate) fn surfaces(map: &SeenMap) -> [TriangleSoup; 2] {
    let grid = Grid::of(map);
    [Kind::Occupied, Kind::Unseen].map(|kind| grid.surface(kind))
}

/// Kind of a cell.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    Free,
    Unseen,
    Occupied,
}

/// Kinds of all cells of a region, z fastest.
struct Grid {
    low: Point,
    cell_m: f64,
    size: [usize; 3],
    cells: Vec<Kind>,
}

impl Grid {
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a map has a whole number of cells, at most 10⁹"
    )]
    fn of(map: &SeenMap) -> Self {
        let settings = map.settings();
        let (region, cell_m) = (settings.region, settings.cell_m);
        let size = [0, 1, 2].map(|axis| (2.0 * region.half_extents[axis] / cell_m).round().max(1.0) as usize);
        let mut grid =
            Self { low: region.low(), cell_m, size, cells: vec![Kind::Free; size.iter().product()] };
        // An occupied cell hides an unseen one of the same place.
        for (kind, boxes) in [(Kind::Unseen, map.unseen()), (Kind::Occupied, map.occupied())] {
            for aabb in boxes {
                grid.fill(aabb, kind);
            }
        }
        grid
    }

    /// Fills the cells whose centres a box contains, or the one that contains a smaller box.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped to the grid")]
    fn fill(&mut self, aabb: &Aabb, kind: Kind) {
        let range = [0, 1, 2].map(|axis| {
            let place = |value: f64| (value - self.low[axis]) / self.cell_m;
            let (first, end) = (place(aabb.low()[axis]), place(aabb.high()[axis]));
            let last = self.size[axis] - 1;
            let first = (first + 1e-6).floor().max(0.0) as usize;
            let end = ((end - 1e-6).ceil().max(1.0) as usize).min(last + 1);
            first.min(last)..end
        });
        let [x, y, z] = range;
        for x in x {
            for y in y.clone() {
                let row = (x * self.size[1] + y) * self.size[2];
                self.cells[row + z.start..row + z.end.max(z.start)].fill(kind);
            }
        }
    }

    fn kind(&self, [x, y, z]: [usize; 3]) -> Kind {
        self.cells[(x * self.size[1] + y) * self.size[2] + z]
    }

    /// Returns the faces between cells of a kind and free ones; faces of a row are one rectangle.
    fn surface(&self, kind: Kind) -> TriangleSoup {
        let mut corners = Corners { grid: self, soup: TriangleSoup::default(), known: HashMap::new() };
        for axis in 0..3 {
            let (across, along) = ((axis + 1) % 3, (axis + 2) % 3);
            for is_upper in [false, true] {
                for layer in 0..self.size[axis] {
                    let Some(next) = (if is_upper { layer.checked_add(1) } else { layer.checked_sub(1) })
                        .filter(|next| *next < self.size[axis])
                    else {
                        continue;
                    };
                    for row in 0..self.size[across] {
                        let is_face = |place: usize| {
                            let mut cell = [0; 3];
                            (cell[axis], cell[across], cell[along]) = (layer, row, place);
                            let own = self.kind(cell);
                            cell[axis] = next;
                            own == kind && self.kind(cell) == Kind::Free
                        };
                        let mut place = 0;
                        while place < self.size[along] {
                            let first = place;
                            while place < self.size[along] && is_face(place) {
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
}

/// Surface whose corners are those of cells.
struct Corners<'a> {
    grid: &'a Grid,
    soup: TriangleSoup,
    known: HashMap<[usize; 3], u32>,
}

impl Corners<'_> {
    fn index(&mut self, corner: [usize; 3]) -> u32 {
        let vertices = &mut self.soup.vertices;
        *self.known.entry(corner).or_insert_with(|| {
            let place = corner.map(|count| count as f64 * self.grid.cell_m);
            vertices.push(self.grid.low + cranny_spatial::Vector::from(place));
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
    use cranny_shape::Solid;
    use cranny_spatial::{Pose, Vector};

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
        let grid = Grid::of(&map);
        let cell_m3 = grid.cell_m.powi(3);
        let free_m3 = grid.cells.iter().filter(|kind| **kind == Kind::Free).count() as f64 * cell_m3;
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
                let kind_at = |shift: f64| {
                    let middle = a + (b - a) * 0.26 + (c - a) * 0.26 + normal * shift * grid.cell_m;
                    #[allow(
                        clippy::cast_possible_truncation,
                        clippy::cast_sign_loss,
                        reason = "within the grid"
                    )]
                    grid.kind([0, 1, 2].map(|axis| ((middle[axis] - grid.low[axis]) / grid.cell_m) as usize))
                };
                assert!(kind_at(0.5) == Kind::Free && kind_at(-0.5) != Kind::Free);
            }
        }
    }
}
