use crate::inside::disjoint_sets::DisjointSets;

/// A face at one of its edges.
#[derive(Clone, Copy)]
pub(crate) struct EdgeUse {
    /// The edge's two vertices, the lower one in the high bits.
    pub edge: u64,
    /// The side of the face that one meets last when one turns about the edge, from its lower vertex to its
    /// higher one by the right hand. Sides are numbered: twice the triangle for its front, one more for its
    /// back.
    pub ahead: u32,
}

impl EdgeUse {
    pub fn behind(self) -> u32 {
        self.ahead ^ 1
    }
}

/// Joins the sides that look at each other, of faces in their order around an edge.
pub(crate) fn join_around(sides: &mut DisjointSets, ordered: &[EdgeUse]) {
    for (index, at) in ordered.iter().enumerate() {
        let next = ordered[(index + 1) % ordered.len()];
        sides.join(at.ahead, next.behind());
    }
}
