use std::collections::BTreeMap;

use cranny_spatial::Stream;

/// Cells of a grid with the nodes in them, rated for the next growth (Şucan & Kavraki 2009, "Kinodynamic motion planning by
/// interior-exterior cell exploration", whole, with one level of cells and the constants of OMPL's `KPIECE1`).
#[derive(Default)]
pub(crate) struct CellGrid {
    cells: Vec<Cell>,
    /// Index of the cell of these coordinates.
    index: BTreeMap<[i64; 3], usize>,
    /// Number of cells at the border.
    at_border: usize,
}

struct Cell {
    nodes: Vec<usize>,
    /// Number of cells beside it along an axis.
    neighbours: usize,
    selections: u64,
    score: f64,
    /// Number of motions before it was created.
    since: u64,
}

impl Cell {
    fn is_at_border(&self) -> bool {
        self.neighbours < 6
    }

    fn importance(&self) -> f64 {
        let shared = self.selections as f64 * (1 + self.neighbours) as f64 * self.nodes.len() as f64;
        (1.0 + libm::log(self.since.max(1) as f64)) * self.score / shared
    }
}

impl CellGrid {
    /// Adds a node to the cell of these coordinates, after `since` motions.
    pub fn add(&mut self, coordinates: [i64; 3], node: usize, since: u64) {
        if let Some(&cell) = self.index.get(&coordinates) {
            self.cells[cell].nodes.push(node);
            return;
        }
        let mut neighbours = 0;
        for (axis, by) in (0..3).flat_map(|axis| [(axis, -1), (axis, 1)]) {
            let mut beside = coordinates;
            beside[axis] = beside[axis].saturating_add(by);
            if let Some(&other) = self.index.get(&beside) {
                neighbours += 1;
                self.cells[other].neighbours += 1;
                self.at_border -= usize::from(!self.cells[other].is_at_border());
            }
        }
        let cell = Cell { nodes: vec![node], neighbours, selections: 1, score: 1.0, since };
        self.at_border += usize::from(cell.is_at_border());
        self.index.insert(coordinates, self.cells.len());
        self.cells.push(cell);
    }

    /// Chooses the most important cell: with probability `border`, or with the share of cells at the border if that is greater,
    /// among those at the border, otherwise among the others.
    pub fn choose(&mut self, border: f64, random: &mut Stream) -> Option<usize> {
        let share = self.at_border as f64 / self.cells.len() as f64;
        let wants_border = random.uniform() < border.max(share);
        let greatest = |is_at_border: bool| {
            let cells = self.cells.iter().enumerate().filter(|(_, cell)| cell.is_at_border() == is_at_border);
            let rated = cells.map(|(index, cell)| (cell.importance(), index));
            rated.max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, index)| index)
        };
        let chosen = greatest(wants_border).or_else(|| greatest(!wants_border))?;
        self.cells[chosen].selections += 1;
        Some(chosen)
    }

    /// Draws a node of a cell, rather a recent one: half of a normal distribution over a third of them.
    pub fn node_of(&self, cell: usize, random: &mut Stream) -> usize {
        let nodes = &self.cells[cell].nodes;
        let back = random.normal().abs() * nodes.len() as f64 / 3.0;
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "it is not negative")]
        let back = (back as usize).min(nodes.len() - 1);
        nodes[nodes.len() - 1 - back]
    }

    /// Multiplies the score of a cell by `factor`, since a growth from it failed.
    pub fn lower(&mut self, cell: usize, factor: f64) {
        /// Score below which no cell falls, so that their order remains.
        const LEAST: f64 = 1e-12;
        let score = &mut self.cells[cell].score;
        *score = (*score * factor).max(LEAST);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_count_their_neighbours_and_those_at_the_border() {
        let mut grid = CellGrid::default();
        let block = (0..4_i64).flat_map(|x| (0..4).flat_map(move |y| (0..4).map(move |z| [x, y, z])));
        for (node, coordinates) in block.chain([[i64::MAX; 3], [1, 1, 1]]).enumerate() {
            grid.add(coordinates, node, node as u64);
        }
        for (coordinates, &cell) in &grid.index {
            let beside = |other: &&[i64; 3]| {
                coordinates.iter().zip(**other).map(|(a, b)| a.abs_diff(b)).fold(0, u64::saturating_add) == 1
            };
            assert_eq!(grid.cells[cell].neighbours, grid.index.keys().filter(beside).count());
        }
        // A block of 4³ cells has 2³ inside.
        assert_eq!((grid.cells.len(), grid.at_border), (65, 57));
        assert_eq!(grid.cells.iter().filter(|cell| cell.is_at_border()).count(), grid.at_border);
        assert_eq!(grid.cells.iter().map(|cell| cell.nodes.len()).sum::<usize>(), 66);
    }

    #[test]
    fn a_cell_is_less_important_for_each_node_neighbour_selection_and_failure() {
        let cell = || Cell { nodes: vec![0], neighbours: 1, selections: 1, score: 1.0, since: 9 };
        let mut grid = CellGrid { cells: vec![cell()], ..CellGrid::default() };
        grid.lower(0, 0.5);
        let failed = grid.cells.remove(0);
        let others = [
            Cell { nodes: vec![0, 1], ..cell() },
            Cell { neighbours: 3, ..cell() },
            Cell { selections: 2, ..cell() },
            failed,
        ];
        for other in others {
            assert!((other.importance() - cell().importance() / 2.0).abs() < 1e-12);
        }
        assert!(Cell { since: 10, ..cell() }.importance() > cell().importance());
    }
}
