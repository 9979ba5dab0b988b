/// Disjoint sets of the numbers below a count, each number at first in a set of its own (union by the least number, with
/// path halving).
#[derive(Clone, Debug)]
pub(crate) struct DisjointSets {
    parent: Vec<u32>,
}

impl DisjointSets {
    /// # Panics
    /// If the count does not fit into 32 bits; the readers of meshes reject such large ones.
    pub fn new(count: usize) -> Self {
        let count = u32::try_from(count).expect("a mesh has fewer than 2³² sides");
        Self { parent: (0..count).collect() }
    }

    pub fn len(&self) -> u32 {
        u32::try_from(self.parent.len()).unwrap_or(u32::MAX)
    }

    /// Least number of the set of `number`.
    pub fn root(&mut self, mut number: u32) -> u32 {
        while self.parent[number as usize] != number {
            let above = self.parent[self.parent[number as usize] as usize];
            self.parent[number as usize] = above;
            number = above;
        }
        number
    }

    pub fn join(&mut self, one: u32, other: u32) {
        let [one, other] = [one, other].map(|number| self.root(number));
        self.parent[one.max(other) as usize] = one.min(other);
    }
}
