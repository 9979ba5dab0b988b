//! Curves of way points that optimisers improve: their smoothness, their distances from obstacles, their starts, and the proof of
//! what an optimiser claims.

pub(crate) mod curve;
pub(crate) mod curve_settings;
pub(crate) mod obstacle_cost;
pub(crate) mod refused_claim;
pub(crate) mod smoothness;
pub(crate) mod starts;
