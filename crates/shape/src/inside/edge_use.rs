use crate::inside::disjoint_sets::DisjointSets;

/// Use of an edge by a face.
#[derive(Clone, Copy)]
pub(crate) struct EdgeUse {
    /// The two vertices of the edge, the lower one in the high bits.
    pub edge: u64,
    /// Side of the face that a right-handed turn about the edge, from its lower vertex to its higher one, meets last. Sides are
    /// numbered: twice the triangle for its front, plus one for its back.
    pub ahead: u32,
}

impl EdgeUse {
    pub fn behind(self) -> u32 {
        self.ahead ^ 1
    }
}

/// Joins the sides that face each other; the faces are in their order around an edge.
pub(crate) fn join_around(sides: &mut DisjointSets, ordered: &[EdgeUse]) {
    for (index, at) in ordered.iter().enumerate() {
        let next = ordered[(index + 1) % ordered.len()];
        sides.join(at.ahead, next.behind());
    }
}
