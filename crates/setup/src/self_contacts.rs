use std::sync::Arc;

use cranny_collision::{Cell, Collider, CollisionError, Margins, UncheckedReason, World};
use cranny_robot::{LinkFrames, Robot};
use cranny_spatial::Stream;
use rayon::prelude::*;

use crate::contact_search::PairSearch;

/// Contact statistics of two links of a robot over the motion of the joints between them.
#[derive(Clone, Debug, PartialEq)]
pub struct SelfContact {
    /// Indices of the links.
    pub links: (usize, usize),
    /// Number of configurations, of [`SELF_CONTACT_SAMPLES`], in which they touched.
    pub touching: usize,
    /// True if one joint and no third link with geometry is between them.
    pub is_adjacent: bool,
    /// True if the robot's SRDF, or the caller, exempts them from checks.
    pub is_declared: bool,
    /// Minimum penetration depth among configurations in contact, in metres.
    pub least_depth_m: f64,
    /// Reason why no check compares them, though no file exempts them.
    pub unchecked: Option<UncheckedReason>,
    /// Configuration in which they do not touch (m, rad; one per joint), for pairs that touched in at least 90 % of samples.
    pub free_at: Option<Vec<f64>>,
    /// Description of the maximum size of a window that the search for it may have missed.
    pub missed: &'static str,
}

/// Number of configurations drawn.
pub const SELF_CONTACT_SAMPLES: usize = 1000;

/// Maximum number of contacts of a pair whose depth is computed.
const DEPTH_SAMPLES: usize = 10;

impl SelfContact {
    /// Returns true if they touched in every sample, which is no proof, and no file declares them.
    pub fn is_always(&self) -> bool {
        let is_known = self.is_declared || self.is_proven();
        self.touching == SELF_CONTACT_SAMPLES && self.free_at.is_none() && !is_known
    }

    /// Returns true if a proof shows that checking them is unnecessary.
    pub fn is_proven(&self) -> bool {
        use UncheckedReason::{AdjacentFree, AdjacentTouching, AlwaysTouching};
        matches!(self.unchecked, Some(AlwaysTouching | AdjacentTouching | AdjacentFree))
    }

    /// Returns true if they touch so often that configurations without contact are rarely drawn.
    fn is_often(&self) -> bool {
        self.touching * 10 >= 9 * SELF_CONTACT_SAMPLES
    }

    /// Samples all pairs of links with geometry that move relative to each other, in [`SELF_CONTACT_SAMPLES`] drawn
    /// configurations. For pairs that touched in all of them and are neither declared nor proven, a free configuration is
    /// searched for among [`SEARCH_SAMPLES`](crate::SEARCH_SAMPLES) others.
    ///
    /// # Errors
    /// [`CollisionError`] for a link that cannot be checked.
    pub fn sample(robot: &Arc<Robot>) -> Result<Vec<Self>, CollisionError> {
        let cell = Cell::new(robot.clone(), World::new(Vec::new())?, Margins::default())?;
        let unchecked = |links: (usize, usize)| {
            let is_of = |pair: &&cranny_collision::ExemptPair| match (pair.first, pair.second) {
                (Collider::Link(a), Collider::Link(b)) => (a.min(b), a.max(b)) == links,
                _ => false,
            };
            cell.unchecked().iter().find(is_of).map(|pair| pair.reason)
        };
        let links: Vec<usize> =
            (0..robot.links().len()).filter(|&link| !robot.links()[link].collisions.is_empty()).collect();
        let pairs = links.iter().flat_map(|&a| links.iter().filter(move |b| a < **b).map(move |&b| (a, b)));
        let moves = |&(a, b): &(usize, usize)| robot.ancestors(a) != robot.ancestors(b);
        let mut contacts: Vec<Self> = pairs
            .filter(moves)
            .map(|links| Self {
                links,
                touching: 0,
                is_adjacent: robot.adjacent_pairs().binary_search(&links).is_ok(),
                is_declared: robot.disabled_pairs().binary_search(&links).is_ok(),
                least_depth_m: f64::INFINITY,
                unchecked: unchecked(links),
                free_at: None,
                missed: "",
            })
            .collect();
        let mut random = Stream::new(0, 0);
        let drawn: Vec<Vec<f64>> =
            (0..SELF_CONTACT_SAMPLES).map(|_| robot.random_configuration(&mut random)).collect();
        let frames: Vec<LinkFrames> = drawn.iter().map(|q| robot.frames_at(q)).collect();
        contacts.par_iter_mut().for_each(|contact| {
            let mut search = PairSearch::new(robot, contact.links);
            contact.missed = search.missed();
            for (q, frames) in drawn.iter().zip(&frames) {
                if search.is_free_in(frames) {
                    contact.free_at.get_or_insert_with(|| q.clone());
                    continue;
                }
                contact.touching += 1;
                if contact.touching <= DEPTH_SAMPLES {
                    contact.least_depth_m = contact.least_depth_m.min(search.depth_m(q));
                }
            }
            if contact.is_always() {
                contact.free_at = search.free_configuration();
            }
            if !contact.is_often() {
                contact.free_at = None;
            }
        });
        Ok(contacts)
    }
}
