use std::sync::Arc;

use crate::cell::{Cell, Scratch};
use crate::link_body::group_separation;
use crate::unchecked::Unchecked;

impl Cell {
    /// What touches and is not checked.
    pub fn unchecked(&self) -> &[Unchecked] {
        &self.unchecked
    }

    /// Those pairs of links of [`Self::unchecked`] that keep their distance at `q`: seen free once, a pair is to be
    /// checked from then on. By link index, the lower first.
    ///
    /// # Panics
    /// If `q` has not one value per joint.
    pub fn unchecked_but_free_at(&self, q: &[f64], scratch: &mut Scratch) -> Vec<(usize, usize)> {
        if self.unchecked.is_empty() {
            return Vec::new();
        }
        self.robot().forward_kinematics(q, &mut scratch.frames);
        let frames = &scratch.frames;
        let body_of = |link: usize| self.bodies.iter().find(|body| body.link == link);
        let is_free = |&(first, second): &(usize, usize)| {
            let (Some(first), Some(second)) = (body_of(first), body_of(second)) else { return false };
            let required_m = self.margins().required_m(false);
            let gap = group_separation(first.placed(frames), &second.placed(frames), required_m);
            gap.lower_m >= required_m
        };
        self.unchecked.iter().filter_map(Unchecked::links).filter(is_free).collect()
    }

    /// The same cell with all pairs of links checked but those that are exempt by declaration.
    #[must_use]
    pub fn with_all_pairs(&self) -> Self {
        self.with_pairs(&self.unchecked.iter().filter_map(Unchecked::links).collect::<Vec<_>>())
    }

    /// This cell, or one in which every pair is checked that is free at one of these configurations.
    ///
    /// # Panics
    /// If a configuration has not one value per joint.
    #[must_use]
    pub fn with_pairs_free_at<'a>(
        self: &Arc<Self>,
        configurations: impl IntoIterator<Item = &'a [f64]>,
    ) -> Arc<Self> {
        let mut cell = self.clone();
        let mut scratch = None;
        for q in configurations {
            if cell.unchecked.iter().all(|unchecked| unchecked.links().is_none()) {
                break;
            }
            let scratch = scratch.get_or_insert_with(|| self.scratch());
            let free = cell.unchecked_but_free_at(q, scratch);
            if !free.is_empty() {
                cell = Arc::new(cell.with_pairs(&free));
            }
        }
        cell
    }
}
