use std::collections::{BTreeMap, HashMap};

use cranny_collision::{CONTACT_ALLOWANCE_M, Cell, Collider, DemandedOther, UncheckedReason};
use cranny_robot::LinkMotion;

use crate::link_bound::LinkBound;
use crate::span::Object;
use crate::word::object_words;

/// Robot and world as a certificate has them: links, then bodies.
pub(crate) struct Model {
    pub objects: Vec<Object>,
    /// Distance that most pairs must keep, in metres.
    pub margin_m: f64,
    /// Pairs that are proven, in order, with their distances in metres.
    pub pairs: Vec<((usize, usize), f64)>,
    /// Bounds of links along the whole path.
    pub bounds: Vec<LinkBound>,
    /// Pairs that are not compared, with the reason.
    pub skipped: Vec<((usize, usize), &'static str)>,
}

impl Model {
    /// Describes a cell: links with their poses in it, bodies without what is in the hand, and the distances of pairs. A body
    /// whose parts must keep different distances is several objects.
    pub fn of(cell: &Cell) -> Self {
        let robot = cell.robot();
        let links = robot.links().len();
        // Links first, then parts.
        let number = |other: DemandedOther| match other {
            DemandedOther::Link(link) => link,
            DemandedOther::Part(part) => links + part,
        };
        let known = cell.demanded_pairs().into_iter();
        let demands: HashMap<(usize, usize), Option<f64>> =
            known.map(|pair| ((pair.link, number(pair.other)), pair.required_m)).collect();
        let of_part = |part: usize| {
            (0..links).map(|link| demands.get(&(link, links + part)).copied()).collect::<Vec<_>>()
        };
        let parts: Vec<Vec<Option<Option<f64>>>> = (0..cell.parts().len()).map(of_part).collect();
        // No link is compared with a part of the body in the hand.
        let is_present = |part: &usize| parts[*part].iter().flatten().any(Option::is_some);
        // All bodies are named, also those that this scene lacks, so that they have the same names in each scene of a motion.
        let link_names = robot.links().iter().map(|link| link.name.as_str());
        let all = link_names.chain(cell.world().bodies().iter().map(|body| body.name.as_str()));
        let mut names = object_words(all);
        let body_names = names.split_off(links);
        let motions = in_order(robot.link_motions(&cell.frames())).into_iter().enumerate().zip(names);
        let mut objects: Vec<Object> =
            motions.map(|((link, motion), name)| Object::link(cell, name, link, motion)).collect();
        // Parts of each object beyond the links.
        let mut bodies: Vec<usize> = Vec::new();
        for (body, name) in body_names.iter().enumerate() {
            let own = (0..parts.len()).filter(|part| cell.parts()[*part].0 == body).filter(is_present);
            let own: Vec<usize> = own.collect();
            let is_alike = own.windows(2).all(|pair| parts[pair[0]] == parts[pair[1]]);
            let groups: Vec<&[usize]> = if is_alike { vec![&own[..]] } else { own.chunks(1).collect() };
            for (number, group) in groups.iter().enumerate().filter(|(_, group)| !group.is_empty()) {
                let name = if is_alike { name.clone() } else { format!("{name}/{number}") };
                objects.push(Object::body(cell, name, group));
                bodies.push(group[0]);
            }
        }
        let bounds = LinkBound::all(cell);
        let mut model = Self { objects, margin_m: 0.0, pairs: Vec::new(), bounds, skipped: Vec::new() };
        let solid = |index: &usize| !model.objects[*index].solids.is_empty();
        let (mut pairs, mut skipped) = (Vec::new(), Vec::new());
        for a in (0..links).filter(solid) {
            for b in (a + 1..model.objects.len()).filter(solid).filter(|b| model.moves(a, *b)) {
                let demand = if let Some(body) = b.checked_sub(links) {
                    parts[bodies[body]][a]
                } else {
                    let pair = |a, b| demands.get(&(a, b)).copied();
                    pair(a, b).or(pair(b, a))
                };
                match demand {
                    Some(required_m) => pairs.push(((a, b), required_m.unwrap_or(-CONTACT_ALLOWANCE_M))),
                    None => skipped.push(((a, b), reason(cell, (a, b)))),
                }
            }
        }
        let mut counts: BTreeMap<u64, usize> = BTreeMap::new();
        for (_, required_m) in &pairs {
            *counts.entry(required_m.to_bits()).or_default() += 1;
        }
        let most = counts.into_iter().max_by_key(|(_, count)| *count);
        model.margin_m = most.map_or(0.0, |(bits, _)| f64::from_bits(bits));
        (model.pairs, model.skipped) = (pairs, skipped);
        model
    }

    /// Returns true if each link comes after the one to which it is attached, as a certificate demands.
    pub fn is_in_order(&self) -> bool {
        let parent = |object: &Object| object.motion.as_ref().and_then(|motion| motion.parent);
        self.objects
            .iter()
            .enumerate()
            .all(|(index, object)| parent(object).is_none_or(|parent| parent < index))
    }

    /// Returns the links from the one below `top` (from the root for `None`) down to `of`, the topmost first.
    pub fn chain(&self, top: Option<usize>, of: usize) -> Vec<usize> {
        let mut chain = Vec::new();
        let mut next = self.objects[of].motion.is_some().then_some(of);
        while let Some(index) = next.filter(|_| next != top) {
            chain.push(index);
            next = self.objects[index].motion.as_ref().and_then(|motion| motion.parent);
        }
        chain.reverse();
        chain
    }

    /// Returns the lowest link above both or equal to one of them; `None` for the world.
    pub fn common(&self, a: usize, b: usize) -> Option<usize> {
        let (a, b) = (self.chain(None, a), self.chain(None, b));
        a.iter().zip(&b).take_while(|(x, y)| x == y).last().map(|(x, _)| *x)
    }

    /// Returns true if a joint moves one of the two against the other.
    fn moves(&self, a: usize, b: usize) -> bool {
        let top = self.common(a, b);
        let is_moving =
            |index: &usize| self.objects[*index].motion.as_ref().is_some_and(|motion| motion.joint.is_some());
        [a, b].iter().any(|end| self.chain(top, *end).iter().any(is_moving))
    }
}

/// Relates links to ones that precede them: a finger of a hand that has closed is attached to the tip, which may come after it,
/// and thus to the link to which the tip is rigidly connected.
fn in_order(mut motions: Vec<LinkMotion>) -> Vec<LinkMotion> {
    for link in 0..motions.len() {
        while let Some(later) = motions[link].parent.filter(|parent| *parent > link)
            && motions[later].joint.is_none()
        {
            let of_later = motions[later].clone();
            motions[link].parent = of_later.parent;
            motions[link].parent_from_link = of_later.parent_from_link * motions[link].parent_from_link;
        }
    }
    motions
}

/// Returns the reason why a pair of links is not compared.
fn reason(cell: &Cell, (a, b): (usize, usize)) -> &'static str {
    let is_pair = |first, second| matches!((first, second), (Collider::Link(x), Collider::Link(y)) if (x.min(y), x.max(y)) == (a, b));
    let known = cell.unchecked().iter().find(|pair| is_pair(pair.first, pair.second));
    match known.map(|pair| pair.reason) {
        Some(UncheckedReason::AlwaysTouching) => "always-touching",
        Some(UncheckedReason::AdjacentTouching) => "adjacent-touching",
        Some(UncheckedReason::AdjacentUnproven) => "adjacent-unproven",
        Some(UncheckedReason::AdjacentAtJoint) => "adjacent-at-joint",
        Some(UncheckedReason::AdjacentFree) => "adjacent-free",
        _ => "declared",
    }
}
