use cranny_shape::Aabb;
use cranny_spatial::{Point, Vector};

use crate::SeenMap;

/// Content of a cell of a map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Content {
    /// It is seen to be free.
    Free,
    /// No camera has seen into it.
    Unseen,
    /// A surface may have been measured in it.
    Occupied,
}

/// Cells of a map as an array, for rays and pictures: equally wide, so that smaller cells of the map are rounded to them.
#[derive(Clone, Debug)]
pub struct OccupancyGrid {
    low: Point,
    side_m: f64,
    counts: [usize; 3],
    content: Vec<Content>,
}

/// Maximum number of cells; a grid of more has larger cells.
const MOST: f64 = 64e6;

impl OccupancyGrid {
    /// Returns the cells of a map.
    pub fn new(map: &SeenMap) -> Self {
        let region = map.settings().region;
        let mut side_m = map.settings().cell_m;
        // A region is a whole number of cells, up to rounding.
        let count = |half: f64, side_m: f64| (2.0 * half / side_m - 1e-6).ceil().max(1.0);
        let counts_at = |side_m: f64| region.half_extents.map(|half| count(half, side_m));
        while counts_at(side_m).product() > MOST {
            side_m *= 2.0;
        }
        let counts = counts_at(side_m);
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "small whole numbers")]
        let counts = [0, 1, 2].map(|axis| counts[axis] as usize);
        let content = vec![Content::Free; counts.iter().product()];
        let mut grid = Self { low: region.low(), side_m, counts, content };
        for aabb in map.unseen() {
            grid.fill(aabb, Content::Unseen);
        }
        for aabb in map.occupied() {
            grid.fill(aabb, Content::Occupied);
        }
        grid
    }

    /// Sets the cells whose centres lie in a box, or the cell of its centre if it is smaller.
    pub fn fill(&mut self, aabb: &Aabb, content: Content) {
        let [low, high] = [aabb.low() - self.low, aabb.high() - self.low].map(|corner| corner / self.side_m);
        let middle = (aabb.center - self.low) / self.side_m;
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped to the grid")]
        let range = |axis: usize| {
            let last = self.counts[axis] as f64;
            let (mut first, mut end) = ((low[axis] - 0.5).ceil(), (high[axis] - 0.5).ceil());
            if end <= first {
                (first, end) = (middle[axis].floor(), middle[axis].floor() + 1.0);
            }
            first.clamp(0.0, last) as usize..end.clamp(0.0, last) as usize
        };
        let [x, y, z] = [range(0), range(1), range(2)];
        for i in x {
            for j in y.clone() {
                let row = (i * self.counts[1] + j) * self.counts[2];
                self.content[row + z.start..row + z.end].fill(content);
            }
        }
    }

    /// Returns the number of cells along each axis.
    pub fn counts(&self) -> [usize; 3] {
        self.counts
    }

    /// Returns the corner of least coordinates, in the planning frame.
    pub fn low(&self) -> Point {
        self.low
    }

    /// Returns the content of a cell by its place along each axis.
    ///
    /// # Panics
    /// If there is no such cell.
    pub fn cell(&self, [x, y, z]: [usize; 3]) -> Content {
        self.content[(x * self.counts[1] + y) * self.counts[2] + z]
    }

    /// Returns the content at a point; `None` outside of the region.
    pub fn at(&self, point: &Point) -> Option<Content> {
        let place = (point - self.low) / self.side_m;
        let mut index = 0;
        for axis in 0..3 {
            let along = place[axis].floor();
            if !(0.0..self.counts[axis] as f64).contains(&along) {
                return None;
            }
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "within the grid")]
            let along = along as usize;
            index = index * self.counts[axis] + along;
        }
        Some(self.content[index])
    }

    /// Returns true if an occupied cell lies between two distances (m) along a ray from a point; `direction` is a unit vector.
    /// Outside of the region nothing is known.
    pub fn is_blocked(&self, from: &Point, direction: &Vector, [begin_m, end_m]: [f64; 2]) -> bool {
        self.along(from, direction, [begin_m, end_m]).any(|content| content == Some(Content::Occupied))
    }

    /// Returns the content at points along a ray, less than a cell apart.
    pub fn along<'a>(
        &'a self,
        from: &'a Point,
        direction: &'a Vector,
        [begin_m, end_m]: [f64; 2],
    ) -> impl Iterator<Item = Option<Content>> + 'a {
        /// Distance between two points, in cells.
        const STEP: f64 = 0.7;
        let step_m = STEP * self.side_m;
        let places = (0..).map(move |index: u32| begin_m + f64::from(index) * step_m);
        places.take_while(move |at_m| *at_m < end_m).map(move |at_m| self.at(&(from + direction * at_m)))
    }

    /// Returns the side of a cell, in metres.
    pub fn side_m(&self) -> f64 {
        self.side_m
    }
}
