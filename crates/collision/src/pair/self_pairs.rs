use cranny_robot::Robot;

use crate::body::link_body::LinkBody;
use crate::pair::exempt_pair::{Exempt, ExemptIndices, UncheckedReason};
use crate::pair::pair_range::{PairRange, PairRanges, Question};

/// Pairs of links with relative motion, as indices among the links with geometry, each with the reason if it is exempt.
///
/// A pair is exempt if the SRDF or the caller declares it, if no joint moves one link against the other, or if the links are
/// proven to touch over the whole range of the joints between them. Adjacent links are also exempt if they are proven to touch
/// never, or only near their joint, or if nothing can be proven of them; every answer names the exempt pairs that are not
/// declared. All others are compared; samples have no influence.
#[derive(Clone, Debug)]
pub(crate) struct SelfPairs(Vec<((usize, usize), Option<Exempt>)>);

impl SelfPairs {
    /// Finds all pairs except those that the SRDF or the options of the robot disable, and those without relative motion.
    pub fn of(robot: &Robot, bodies: &[LinkBody]) -> Self {
        let moves_relatively = |(a, b): (usize, usize)| {
            let joints = |link: usize| robot.ancestors(link).iter().map(|j| j.child_link).collect::<Vec<_>>();
            joints(a) != joints(b)
        };
        let mut ranges = PairRanges::new(robot, bodies);
        let mut pairs = Vec::new();
        for second in 0..bodies.len() {
            for first in 0..second {
                let links = links_of(bodies, (first, second));
                if robot.disabled_pairs().binary_search(&links).is_ok() || !moves_relatively(links) {
                    continue;
                }
                let is_adjacent = robot.adjacent_pairs().binary_search(&links).is_ok();
                pairs.push(((first, second), exempt(&mut ranges, (first, second), is_adjacent)));
            }
        }
        Self(pairs)
    }

    /// Adds pairs of the held object, the last of `bodies`, with all links that move relative to it. A proof for an open hand
    /// is not valid for fingers that have closed.
    pub fn with_held(&self, robot: &Robot, bodies: &[LinkBody]) -> Self {
        let held = bodies.len() - 1;
        let moves = |other: &usize| {
            let joints =
                |body: usize| robot.ancestors(bodies[body].link).iter().map(|mover| mover.child_link);
            !joints(*other).eq(joints(held))
        };
        let own = self.0.iter().map(|&(pair, exempt)| {
            let is_loose = [pair.0, pair.1].iter().any(|&body| robot.is_loose(bodies[body].link));
            let still = exempt.filter(|exempt| !is_loose || exempt.reason != UncheckedReason::AdjacentFree);
            (pair, still)
        });
        let with_held = (0..held).filter(moves).map(|other| ((other, held), None));
        Self(own.chain(with_held).collect())
    }

    /// Splits the pairs into checked and exempt ones; pairs in `asked_for` (by link index, the lower first) are always checked.
    pub fn split(
        &self,
        bodies: &[LinkBody],
        asked_for: &[(usize, usize)],
    ) -> (Vec<(usize, usize)>, Vec<ExemptIndices>) {
        let (mut checked, mut left_out) = (Vec::new(), Vec::new());
        for &(pair, exempt) in &self.0 {
            match exempt.filter(|_| !asked_for.contains(&links_of(bodies, pair))) {
                Some(exempt) => left_out.push((pair, exempt)),
                None => checked.push(pair),
            }
        }
        (checked, left_out)
    }
}

/// Returns the link indices of two links with geometry, the lower first.
fn links_of(bodies: &[LinkBody], (first, second): (usize, usize)) -> (usize, usize) {
    let (a, b) = (bodies[first].link, bodies[second].link);
    (a.min(b), a.max(b))
}

/// Returns the exemption of a pair, with its reason and least depth (m), if there is one.
fn exempt(ranges: &mut PairRanges<'_>, pair: (usize, usize), is_adjacent: bool) -> Option<Exempt> {
    let of = |reason, depth_m| Some(Exempt { reason, depth_m });
    if !is_adjacent {
        return match ranges.of(pair, Question::AlwaysTouching) {
            PairRange::AlwaysTouching { depth_m } => of(UncheckedReason::AlwaysTouching, depth_m),
            _ => None,
        };
    }
    match ranges.of(pair, Question::AlwaysAlike) {
        PairRange::AlwaysTouching { depth_m } => of(UncheckedReason::AdjacentTouching, depth_m),
        PairRange::NeverTouching => of(UncheckedReason::AdjacentFree, 0.0),
        PairRange::Unproven { depth_m } => of(UncheckedReason::AdjacentUnproven, depth_m),
        PairRange::Both { is_at_joint: true, depth_m } => of(UncheckedReason::AdjacentAtJoint, depth_m),
        PairRange::Both { is_at_joint: false, .. } | PairRange::Refuted => None,
    }
}
