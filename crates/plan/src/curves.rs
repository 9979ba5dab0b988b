//! Curves of way points that optimisers improve: their smoothness, their distances from obstacles, their starts, and the proof of
//! what an optimiser claims.

pub(crate) mod refused_claim;
