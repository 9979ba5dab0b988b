use cranny_robot::Robot;

use crate::Margins;
use crate::body::held_body::Spared;
use crate::body::link_body::LinkBody;
use crate::body::part_tree::PartTree;
use crate::body::world::Part;
use crate::proof::travel::shared_joints;

/// A collision pair.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pair {
    /// Index among the links with geometry.
    pub first: usize,
    pub second: Other,
    /// Least distance that counts as free, in metres.
    pub required_m: f64,
}

/// Required distance of an exempt pair, in metres: any distance satisfies it.
const NOTHING_M: f64 = f64::NEG_INFINITY;

impl Pair {
    /// Returns true if the two may penetrate each other.
    pub fn is_exempt(&self) -> bool {
        self.required_m <= NOTHING_M
    }
}

#[derive(Clone, Copy, Debug)]
pub(crate) enum Other {
    /// Index among the links with geometry, and the number of joints that move both links alike.
    Link { body: usize, shared_joints: usize },
    /// Index among the parts of all bodies of the world.
    Part(usize),
}

/// All collision pairs, by index: every moving link with every part, in the order of the tree; then links with links. Pairs
/// with parts are not stored: ten links among 10⁵ boxes make a million of them.
#[derive(Clone, Debug)]
pub(crate) struct Pairs {
    moving: Vec<Moving>,
    /// Parts in the order of the tree, each with the rule for its distance.
    parts: Vec<(usize, PartRule)>,
    links: Vec<Pair>,
    margins: Margins,
    /// Greatest distances demanded between any part and a link, and between any part and a link of the hand, in metres.
    greatest_m: [f64; 2],
}

/// A link that a joint moves.
#[derive(Clone, Copy, Debug)]
struct Moving {
    /// Index among the links with geometry.
    body: usize,
    is_of_hand: bool,
    is_rigid_with_tip: bool,
    is_held: bool,
}

/// Rule for the distance demanded of a part of the world.
#[derive(Clone, Copy, Debug)]
struct PartRule {
    /// Role in the grasp, if any: the grasp margin of the hand then applies to the part.
    grasped: Option<Grasped>,
    /// True if the part belongs to the held object: it is no obstacle.
    is_held: bool,
    /// True if the held object may touch it.
    is_spared: bool,
}

/// Role of a part of the world in the grasp.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Grasped {
    /// It belongs to the object to be grasped.
    Target,
    /// It supports that object.
    Support,
}

/// The held object, and the parts that it may touch.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Held<'a> {
    /// Index of its link.
    pub link: usize,
    /// Index in the world.
    pub body: usize,
    /// Parts of the world that are not checked against it.
    pub spared: &'a [Spared],
}

/// Pairs of a link with every part.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PartPairs {
    pub body: usize,
    /// Index of the first of these pairs.
    pub begin: usize,
    /// Greatest distance that any of these pairs demands, in metres.
    pub required_m: f64,
    /// True if no joint moves the link against the tip: the hand, and the link that carries it.
    pub is_rigid_with_tip: bool,
}

impl Pairs {
    /// Creates the pairs; `link_pairs` are the checked pairs of links, `grasp_bodies` the bodies with the grasp margin.
    pub fn new(
        robot: &Robot,
        bodies: &[LinkBody],
        link_pairs: impl IntoIterator<Item = (usize, usize)>,
        (parts, tree): (&[(usize, Part)], &PartTree),
        grasp_bodies: &[usize],
        held: Option<Held<'_>>,
        margins: Margins,
    ) -> Self {
        // Hand and wrist come first: they are the likeliest to touch.
        let moving = (0..bodies.len()).rev().filter(|&body| !robot.ancestors(bodies[body].link).is_empty());
        let is_of_hand = |body: usize| robot.hand_links().contains(&bodies[body].link);
        let is_rigid = |body: usize| robot.ancestors(bodies[body].link) == robot.ancestors(robot.tip());
        let is_held = |body: usize| held.is_some_and(|held| held.link == bodies[body].link);
        let rule = |part: usize| {
            let body = parts[part].0;
            PartRule {
                grasped: match grasp_bodies.iter().rposition(|grasped| *grasped == body) {
                    Some(last) if last + 1 == grasp_bodies.len() => Some(Grasped::Target),
                    other => other.map(|_| Grasped::Support),
                },
                is_held: held.is_some_and(|held| held.body == body),
                is_spared: held.is_some_and(|held| held.spared.iter().any(|spared| spared.part == part)),
            }
        };
        let link_pair = |(first, second): (usize, usize)| {
            let shared_joints = shared_joints(robot, bodies[first].link, bodies[second].link);
            let second = Other::Link { body: second, shared_joints };
            let is_of_held = |index: usize| held.is_some_and(|held| held.link == bodies[index].link);
            let is_object =
                is_of_held(first) || matches!(second, Other::Link { body, .. } if is_of_held(body));
            let required_m = if is_object { margins.of_held_m() } else { margins.required_m(false) };
            Pair { first, second, required_m }
        };
        let mut pairs = Self {
            moving: moving
                .map(|body| Moving {
                    body,
                    is_of_hand: is_of_hand(body),
                    is_rigid_with_tip: is_of_hand(body) || (!is_held(body) && is_rigid(body)),
                    is_held: is_held(body),
                })
                .collect(),
            parts: tree.parts().iter().map(|&part| (part, rule(part))).collect(),
            links: link_pairs.into_iter().map(link_pair).collect(),
            margins,
            greatest_m: [0.0; 2],
        };
        pairs.greatest_m = [false, true].map(|is_of_hand| {
            let required =
                pairs.parts.iter().map(|(_, rule)| margins.required_m(is_of_hand && rule.grasped.is_some()));
            required.fold(0.0, f64::max) + margins.object_margin_m
        });
        pairs
    }

    pub fn len(&self) -> usize {
        self.first_of_links() + self.links.len()
    }

    /// # Panics
    /// If there is no pair of that index.
    pub fn get(&self, index: u32) -> Pair {
        let index = index as usize;
        match index.checked_sub(self.first_of_links()) {
            Some(index) => self.links[index],
            None => self.with_part(self.moving[index / self.parts.len()], index % self.parts.len()),
        }
    }

    pub fn iter(&self) -> impl Iterator<Item = Pair> {
        let places = 0..self.parts.len();
        let with_parts = move |moving: &Moving| {
            let moving = *moving;
            places.clone().map(move |place| self.with_part(moving, place))
        };
        self.moving.iter().flat_map(with_parts).chain(self.links.iter().copied())
    }

    /// Returns the pairs of links, and the index of the first.
    pub fn of_links(&self) -> (&[Pair], usize) {
        (&self.links, self.first_of_links())
    }

    /// Returns the pairs with parts of each moving link, in order.
    pub fn with_parts(&self) -> impl Iterator<Item = PartPairs> {
        self.moving.iter().enumerate().map(|(index, &Moving { body, is_of_hand, is_rigid_with_tip, .. })| {
            let required_m = self.greatest_m[usize::from(is_of_hand)];
            PartPairs { body, begin: index * self.parts.len(), required_m, is_rigid_with_tip }
        })
    }

    fn first_of_links(&self) -> usize {
        self.moving.len() * self.parts.len()
    }

    fn with_part(&self, Moving { body, is_of_hand, is_held, .. }: Moving, place: usize) -> Pair {
        let (part, rule) = self.parts[place];
        let required_m = if rule.is_held || (rule.is_spared && is_held) {
            NOTHING_M
        } else {
            let object_m = if rule.grasped == Some(Grasped::Target) || is_held {
                self.margins.object_margin_m
            } else {
                0.0
            };
            self.margins.required_m(is_of_hand && rule.grasped.is_some()) + object_m
        };
        Pair { first: body, second: Other::Part(part), required_m }
    }
}
