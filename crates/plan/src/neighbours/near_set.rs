/// Configurations for queries of the k nearest (L2) and of those in a box, answered by a scan: if every neighbour costs a proof, tens of thousands of
/// distances are cheap.
#[derive(Clone, Debug)]
pub(crate) struct NearSet {
    dof: usize,
    rows: Vec<f64>,
}

impl NearSet {
    pub fn new(dof: usize) -> Self {
        Self { dof, rows: Vec::new() }
    }

    /// Adds a configuration (m, rad; one per joint) and returns its index: 0, 1, 2, …
    pub fn add(&mut self, q: &[f64]) -> usize {
        self.rows.extend_from_slice(q);
        self.rows.len() / self.dof - 1
    }

    /// Removes the configuration of this index; the others keep theirs.
    pub fn remove(&mut self, index: usize) {
        self.rows[index * self.dof..(index + 1) * self.dof].fill(f64::INFINITY);
    }

    /// Returns those in the box about `q` (m, rad; one per joint) of which no joint is farther than `half_width`, in the order in
    /// which they were added.
    pub fn in_box(&self, q: &[f64], half_width: f64) -> Vec<usize> {
        let is_in = |row: &[f64]| row.iter().zip(q).all(|(a, b)| (a - b).abs() <= half_width);
        let rows = self.rows.chunks_exact(self.dof).enumerate();
        rows.filter(|(_, row)| is_in(row)).map(|(index, _)| index).collect()
    }

    /// Returns the `k` nearest to `q` (m, rad; one per joint), or all, the nearest first; ties go to the one added first.
    pub fn nearest(&self, q: &[f64], k: usize) -> Vec<usize> {
        let squared = |row: &[f64]| row.iter().zip(q).map(|(a, b)| (a - b) * (a - b)).sum::<f64>();
        let mut all: Vec<(f64, usize)> =
            self.rows.chunks_exact(self.dof).map(squared).enumerate().map(|(index, d)| (d, index)).collect();
        let order = |a: &(f64, usize), b: &(f64, usize)| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1));
        all.retain(|(squared, _)| squared.is_finite());
        if all.len() > k {
            all.select_nth_unstable_by(k, order);
            all.truncate(k);
        }
        all.sort_unstable_by(order);
        all.into_iter().map(|(_, index)| index).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_removed_is_neither_near_nor_in_a_box() {
        let mut set = NearSet::new(2);
        for q in [[0.0, 0.0], [1.0, 0.5], [0.2, -0.3], [4.0, 0.0]] {
            set.add(&q);
        }
        assert_eq!((set.nearest(&[0.1, 0.0], 2), set.in_box(&[0.0; 2], 1.0)), (vec![0, 2], vec![0, 1, 2]));
        set.remove(0);
        assert_eq!((set.nearest(&[0.1, 0.0], 9), set.in_box(&[0.0; 2], 1.0)), (vec![2, 1, 3], vec![1, 2]));
    }
}
