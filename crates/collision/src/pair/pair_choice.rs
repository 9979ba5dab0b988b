use crate::cell::Cell;
use crate::pair::exempt_pair::ExemptPair;

impl Cell {
    /// Returns the pairs that are not checked.
    pub fn unchecked(&self) -> &[ExemptPair] {
        &self.unchecked
    }

    /// Returns this cell with all pairs of links checked, except those exempt by declaration, and adjacent ones that are free
    /// at no value of their joint.
    #[must_use]
    pub fn with_all_pairs(&self) -> Self {
        let more = self.unchecked.iter().filter(|unchecked| !unchecked.reason.is_never_free());
        self.with_pairs(&more.filter_map(ExemptPair::links).collect::<Vec<_>>())
    }
}
