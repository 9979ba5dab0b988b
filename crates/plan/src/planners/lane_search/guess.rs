//! Beginning of a search along a guessed path ([`Reach::guess`](crate::Reach::guess)).

use super::{EdgeRelation, LaneSearch};
use crate::Observer;
use crate::search::connector::Path;

impl LaneSearch<'_> {
    /// Grows the tree from the start along the guess, as far as it is free.
    pub(super) fn follow_guess(&mut self, observer: &mut dyn Observer) {
        let guess = std::mem::take(&mut self.settings.guess);
        self.follow(0, 0, guess.iter(), observer);
        self.settings.guess = guess;
    }

    /// Grows a goal back along the guess, as far as it is free; returns a path if both sides meet.
    pub(super) fn follow_back(&mut self, root: usize, observer: &mut dyn Observer) -> Option<Path> {
        let guess = std::mem::take(&mut self.settings.guess);
        let last = self.follow(1, root, guess.iter().rev(), observer);
        self.settings.guess = guess;
        if last == root { None } else { self.meet(1, last, observer) }
    }

    /// Grows one side from a node to each way point in turn, up to the first that is not reached; returns the last node.
    fn follow<'q>(
        &mut self,
        side: usize,
        from: usize,
        way_points: impl Iterator<Item = &'q Vec<f64>>,
        observer: &mut dyn Observer,
    ) -> usize {
        let mut node = from;
        for q in way_points {
            // A guess that begins at the start has nothing to grow there.
            if self.sides[side].q(node) == &q[..] {
                continue;
            }
            let mut growth = self.grow(side, (node, EdgeRelation::Turns), q, observer);
            while growth.is_open && !growth.is_target {
                growth = self.grow(side, (growth.node, EdgeRelation::GoesOn), q, observer);
            }
            node = growth.node;
            if !growth.is_target {
                break;
            }
        }
        node
    }
}
