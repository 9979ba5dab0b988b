/// Configurations for queries of the k nearest (L2), answered by a scan: if every neighbour costs a proof, tens of thousands of
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

    /// Returns the `k` nearest to `q` (m, rad; one per joint), or all, the nearest first; ties go to the one added first.
    pub fn nearest(&self, q: &[f64], k: usize) -> Vec<usize> {
        let squared = |row: &[f64]| row.iter().zip(q).map(|(a, b)| (a - b) * (a - b)).sum::<f64>();
        let mut all: Vec<(f64, usize)> =
            self.rows.chunks_exact(self.dof).map(squared).enumerate().map(|(index, d)| (d, index)).collect();
        let order = |a: &(f64, usize), b: &(f64, usize)| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1));
        if all.len() > k {
            all.select_nth_unstable_by(k, order);
            all.truncate(k);
        }
        all.sort_unstable_by(order);
        all.into_iter().map(|(_, index)| index).collect()
    }
}
