use std::sync::Arc;

use cranny_robot::{LinkFrames, Robot};
use cranny_shape::{Range, Separation, Solid, overlap};
use cranny_spatial::{CONTACT_M, Pose};

use crate::body::cell_parts::{CellParts, Surroundings};
use crate::body::held_body::HeldBody;
use crate::body::link_body::{LinkBody, group_reaches, group_separation_in};
use crate::body::part_tree::FEW;
use crate::body::robot_body::RobotBody;
use crate::body::tool_bound::CellBound;
use crate::body::world::{Part, World};
use crate::lane::lane_scratch::{LaneScratch, as_index};
use crate::lane::lanes::Lanes;
use crate::pair::exempt_pair::ExemptPair;
use crate::pair::pairs::{Held, Other, Pair, Pairs, PartPairs};
use crate::proof::joint_curve::Rates;
use crate::proof::travel::Travel;
use crate::proof::work_list::WorkList;
use crate::touch::contact::{Collider, Contact};
use crate::{CollisionError, Margins, ToolBound};

/// First reach of a search for the nearest pair, and the reach after which all pairs are searched, in metres.
const NEAR_M: f64 = 0.1;
const FAR_M: f64 = 10.0;

/// A robot in a world: immutable and shared between threads, each of which uses its own [`Scratch`].
#[derive(Clone, Debug)]
pub struct Cell {
    pub(crate) robot: Arc<Robot>,
    pub(crate) body: Arc<RobotBody>,
    pub(crate) around: Arc<Surroundings>,
    pub(crate) margins: Margins,
    /// The body to be grasped, and its supports, by index.
    pub(crate) grasp_bodies: Arc<[usize]>,
    /// The held object; `None` for an empty hand.
    pub(crate) held: Option<HeldBody>,
    pub(crate) bodies: Arc<[LinkBody]>,
    pub(crate) pairs: Arc<Pairs>,
    pub(crate) unchecked: Arc<[ExemptPair]>,
    /// Pairs of links that are checked on request, although they are exempt.
    pub(crate) asked_for: Arc<[(usize, usize)]>,
    pub(crate) lanes: Arc<Lanes>,
    /// Bounds on the tool in addition to those of the world.
    pub(crate) further_bounds: Arc<[ToolBound]>,
    /// All bounds on the tool; the bound on the tilt of the held object, if there is one, comes last.
    pub(crate) bounds: Arc<[CellBound]>,
}

/// Buffers for the computations of one thread; created by [`Cell::scratch`].
#[derive(Clone, Debug)]
pub struct Scratch {
    pub(crate) frames: LinkFrames,
    pub(crate) travel: Travel,
    pub(crate) q: Vec<f64>,
    pub(crate) rates: Rates,
    /// Distance that each link has moved, in metres.
    pub(crate) moved_m: Vec<f64>,
    pub(crate) work: WorkList,
    pub(crate) next_work: WorkList,
    pub(crate) rest: WorkList,
    pub(crate) lanes: LaneScratch,
}

impl Cell {
    /// Creates a cell of `robot` in `world`; all checks and proofs demand `margins`.
    ///
    /// # Errors
    /// [`CollisionError::Margin`] for a negative or infinite margin, [`CollisionError::UnknownLink`] for a bound of a link that
    /// the robot does not have.
    pub fn new(robot: Arc<Robot>, world: World, margins: Margins) -> Result<Self, CollisionError> {
        Ok(Self::of(CellParts::new(robot, world, margins)?))
    }

    /// Creates a cell as [`Self::new`] does, in which the body of index `target` will be grasped: the grasp margin is demanded
    /// between the hand ([`Robot::hand_links`]) and this body or its supports.
    ///
    /// # Errors
    /// As [`Self::new`].
    ///
    /// # Panics
    /// If the world has no body of that index.
    pub fn for_grasp(
        robot: Arc<Robot>,
        world: World,
        target: usize,
        margins: Margins,
    ) -> Result<Self, CollisionError> {
        let parts = CellParts::new(robot, world, margins)?;
        let grasp_bodies = parts.around.grasp_bodies(target, margins);
        Ok(Self::of(CellParts { grasp_bodies, ..parts }))
    }

    pub(crate) fn of(question: CellParts) -> Self {
        let CellParts { robot, body, around, margins, grasp_bodies, asked_for, held, further_bounds } =
            question;
        let bodies = body.links.clone();
        let Surroundings { parts, tree, lanes, .. } = &*around;
        let (checked, left_out) = body.self_pairs.split(&bodies, &asked_for);
        let held_link = held.as_ref().zip(robot.held_link());
        let of_held = held_link.map(|(held, link)| Held { link, body: held.body, spared: &held.spared });
        let pairs = Pairs::new(&robot, &bodies, checked, (parts, tree), &grasp_bodies, of_held, margins);
        let lanes = Lanes::new(&robot, &body, lanes.clone(), tree, &pairs);
        let mut unchecked = ExemptPair::of_links(&bodies, &left_out);
        unchecked.extend(ExemptPair::still_in_contact(&robot, &bodies, parts));
        if let Some(held) = of_held {
            unchecked.extend(ExemptPair::resting(held.link, held.spared, parts));
        }
        let mut cell = Self {
            robot,
            body,
            around,
            margins,
            grasp_bodies,
            held,
            bodies,
            pairs: Arc::new(pairs),
            unchecked: unchecked.into(),
            asked_for,
            lanes: Arc::new(lanes),
            further_bounds,
            bounds: Arc::default(),
        };
        cell.bounds = cell.all_bounds().into();
        cell
    }

    /// Returns the constituents of the cell, to create a variant of it.
    pub(crate) fn parts_of(&self) -> CellParts {
        CellParts {
            robot: self.robot.clone(),
            body: self.body.clone(),
            around: self.around.clone(),
            margins: self.margins,
            grasp_bodies: self.grasp_bodies.clone(),
            asked_for: self.asked_for.clone(),
            held: self.held.clone(),
            further_bounds: self.further_bounds.clone(),
        }
    }

    /// Returns this cell with these additional pairs of links checked, by index, the lower first.
    #[must_use]
    pub(crate) fn with_pairs(&self, pairs: &[(usize, usize)]) -> Self {
        let asked_for = [&self.asked_for[..], pairs].concat().into();
        Self::of(CellParts { asked_for, ..self.parts_of() })
    }

    /// Returns this cell with other margins.
    ///
    /// # Errors
    /// [`CollisionError::Margin`] for a negative or infinite margin.
    pub fn with_margins(&self, margins: Margins) -> Result<Self, CollisionError> {
        margins.check()?;
        let parts = self.parts_of();
        let grasp_bodies = self.grasp_body().map(|body| self.around.grasp_bodies(body, margins));
        let grasp_bodies = grasp_bodies.unwrap_or_else(|| parts.grasp_bodies.clone());
        Ok(Self::of(CellParts { margins, grasp_bodies, ..parts }))
    }

    /// Returns the robot.
    pub fn robot(&self) -> &Arc<Robot> {
        &self.robot
    }

    /// Returns the world, in the planning frame.
    pub fn world(&self) -> &World {
        &self.around.world
    }

    /// Returns the parts of all bodies, each with the index of its body.
    pub fn parts(&self) -> &[(usize, Part)] {
        &self.around.parts
    }

    /// Returns the demanded clearances.
    pub fn margins(&self) -> Margins {
        self.margins
    }

    /// Returns the name of a link or body.
    pub fn name(&self, collider: Collider) -> &str {
        match collider {
            Collider::Link(link) => &self.robot.links()[link].name,
            Collider::Body(body) => &self.world().bodies()[body].name,
        }
    }

    /// Returns the pairs of links that are checked against each other, by link index.
    pub fn self_pairs(&self) -> Vec<(usize, usize)> {
        let link = |collider: Collider| match collider {
            Collider::Link(link) => Some(link),
            Collider::Body(_) => None,
        };
        let links = |pair: &Pair| Some((self.bodies[pair.first].link, link(self.other(pair))?));
        self.pairs.of_links().0.iter().filter_map(links).collect()
    }

    /// Creates a scratch, to be reused between calls.
    pub fn scratch(&self) -> Scratch {
        let hold = self.held.as_ref().map(|held| &held.hold);
        let mut frames = self.robot.frames();
        if let Some(hold) = hold {
            self.robot.place_held(hold, &mut frames);
        }
        Scratch {
            frames,
            travel: Travel::new(&self.robot, &self.bodies),
            q: vec![0.0; self.robot.dof()],
            rates: Rates::still(self.robot.dof()),
            moved_m: Vec::new(),
            work: WorkList::default(),
            next_work: WorkList::default(),
            rest: WorkList::default(),
            lanes: self.lanes.scratch(&self.robot, hold),
        }
    }

    /// Returns true if every pair keeps its distance at `q` (m, rad; one per joint), and the tool its bounds, by exact
    /// distances alone: the reference of [`Self::is_free`]. Joint limits are not checked.
    ///
    /// # Panics
    /// If `q` has not one value per joint.
    pub fn is_clear(&self, q: &[f64], scratch: &mut Scratch) -> bool {
        self.robot.forward_kinematics(q, &mut scratch.frames);
        self.first_close_pair(&scratch.frames).is_none() && self.keeps_bounds(q, scratch)
    }

    /// Returns the first pair that does not keep its distance.
    pub(crate) fn first_close_pair(&self, frames: &LinkFrames) -> Option<u32> {
        self.near_pairs(frames, |_| 0.0).find(|&pair| !self.keeps_distance(&self.pairs.get(pair), frames))
    }

    /// Returns, in order, the pairs of links with parts that may be closer than required plus `beyond_m` (m) of the link's index
    /// among the links with geometry, then all pairs of links.
    pub(crate) fn near_pairs<'a>(
        &'a self,
        frames: &'a LinkFrames,
        beyond_m: impl Fn(usize) -> f64 + 'a,
    ) -> impl Iterator<Item = u32> + 'a {
        let links = self.pairs.of_links().1..self.pairs.len();
        let with_parts = self.pairs.with_parts().flat_map(move |pairs| {
            let world_from_link = frames.link(self.bodies[pairs.body].link);
            self.near_parts(pairs, world_from_link, beyond_m(pairs.body))
        });
        with_parts.chain(links).map(as_index)
    }

    /// Returns the pairs of a link at this pose with parts that may be closer than required plus `beyond_m` (m), in order.
    pub(crate) fn near_parts<'a>(
        &'a self,
        pairs: PartPairs,
        world_from_link: &Pose,
        beyond_m: f64,
    ) -> impl Iterator<Item = usize> + use<'a> {
        let ball = &self.bodies[pairs.body].bounds.ball;
        // Every skipped part is certainly farther away than required.
        let reach_m = ball.radius_m + pairs.required_m + beyond_m + CONTACT_M;
        self.around.tree.near(world_from_link * ball.center, reach_m).map(move |place| pairs.begin + place)
    }

    /// Returns the least distance over all pairs at `q` (m, rad; one per joint), in metres, as a certified lower bound; 0 in
    /// contact. Joint limits are not checked.
    ///
    /// # Panics
    /// If `q` has not one value per joint.
    pub fn clearance(&self, q: &[f64], scratch: &mut Scratch) -> f64 {
        self.nearest_where(q, f64::INFINITY, &|pair| !pair.is_exempt(), scratch).0
    }

    /// Returns the least distance of the pairs that `is_asked` selects, and its pair; `below_m` (m) and `None` if none is less.
    pub(crate) fn nearest_where(
        &self,
        q: &[f64],
        below_m: f64,
        is_asked: &dyn Fn(&Pair) -> bool,
        scratch: &mut Scratch,
    ) -> (f64, Option<Pair>) {
        self.robot.forward_kinematics(q, &mut scratch.frames);
        let frames = &scratch.frames;
        // The tree skips the parts beyond a reach. It grows until a pair is within it, which excludes all others.
        let mut reach_m = if self.around.parts.len() > FEW { NEAR_M } else { f64::INFINITY };
        loop {
            let near = self.near_pairs(frames, |_| reach_m).map(|pair| self.pairs.get(pair)).filter(is_asked);
            let found = self.nearest_of(&near.collect::<Vec<_>>(), below_m, frames);
            if reach_m >= below_m || (found.1.is_some() && found.0 <= reach_m) {
                return found;
            }
            reach_m = if reach_m < FAR_M { 4.0 * reach_m } else { f64::INFINITY };
        }
    }

    /// Returns the least distance of `pairs`, and its pair; `below_m` (m) and `None` if none is less.
    fn nearest_of(&self, pairs: &[Pair], below_m: f64, frames: &LinkFrames) -> (f64, Option<Pair>) {
        // Evaluate the pair that seems nearest first: it excludes most others.
        let (mut least_bound, mut first) = (below_m, None);
        for pair in pairs {
            let bound = self.quick_bound(pair, frames, least_bound);
            if bound < least_bound {
                (least_bound, first) = (bound, Some(pair));
            }
        }
        let (mut least, mut nearest) = (below_m, None);
        for pair in first.into_iter().chain(pairs) {
            let is_farther = self.quick_bound(pair, frames, least) >= least;
            // NaN does not count as farther: the pair is measured, and found in contact.
            if !is_farther {
                let lower_m = self.distance(pair, frames, least).lower_m;
                if lower_m < least {
                    (least, nearest) = (lower_m, Some(*pair));
                }
            }
            if least <= 0.0 {
                break;
            }
        }
        (least, nearest)
    }

    /// Returns a pair that is closer at `q` (m, rad; one per joint) than required: the first in a fixed order, hand and wrist
    /// before the base, the world before other links; `None` if every pair keeps its distance. Joint limits are not checked.
    ///
    /// # Panics
    /// If `q` has not one value per joint.
    pub fn first_contact(&self, q: &[f64], scratch: &mut Scratch) -> Option<Contact> {
        self.robot.forward_kinematics(q, &mut scratch.frames);
        let frames = &scratch.frames;
        self.first_close_pair(frames).map(|pair| self.describe(&self.pairs.get(pair), frames))
    }

    /// Returns the pairs that are closer at `q` (m, rad; one per joint) than required, each pair of colliders once.
    ///
    /// # Panics
    /// If `q` has not one value per joint.
    pub fn contacts(&self, q: &[f64], scratch: &mut Scratch) -> Vec<Contact> {
        self.robot.forward_kinematics(q, &mut scratch.frames);
        let mut contacts: Vec<Contact> = Vec::new();
        for pair in self.near_pairs(&scratch.frames, |_| 0.0) {
            let pair = self.pairs.get(pair);
            if self.keeps_distance(&pair, &scratch.frames) {
                continue;
            }
            let contact = self.describe(&pair, &scratch.frames);
            let known = contacts.iter_mut().find(|c| (c.first, c.second) == (contact.first, contact.second));
            match known {
                Some(known) if known.depth_m >= contact.depth_m => {}
                Some(known) => *known = contact,
                None => contacts.push(contact),
            }
        }
        contacts
    }

    /// Returns the indices of all pairs.
    pub(crate) fn all_pairs(&self) -> std::ops::Range<u32> {
        0..as_index(self.pairs.len())
    }

    pub(crate) fn describe(&self, pair: &Pair, frames: &LinkFrames) -> Contact {
        let first = &self.bodies[pair.first];
        let deepest = self
            .placed(pair.first, frames)
            .flat_map(|(pose_a, a)| {
                self.placed_other(pair, frames).filter_map(move |(pose_b, b)| overlap(a, &pose_a, b, &pose_b))
            })
            .max_by(|a, b| a.depth_m.total_cmp(&b.depth_m));
        let clearance_m = self.distance(pair, frames, f64::MAX).lower_m;
        Contact {
            first: Collider::Link(first.link),
            second: self.other(pair),
            clearance_m,
            required_m: pair.required_m,
            depth_m: deepest.map_or(0.0, |o| o.depth_m),
            point: deepest.map(|o| o.point),
        }
    }

    pub(crate) fn other(&self, pair: &Pair) -> Collider {
        match pair.second {
            Other::Link { body, .. } => Collider::Link(self.bodies[body].link),
            Other::Part(index) => Collider::Body(self.around.parts[index].0),
        }
    }

    pub(crate) fn keeps_distance(&self, pair: &Pair, frames: &LinkFrames) -> bool {
        self.is_beyond(pair, frames, pair.required_m)
    }

    /// Returns true if the pair is certified to be at least `distance_m` (m) apart.
    pub(crate) fn is_beyond(&self, pair: &Pair, frames: &LinkFrames, distance_m: f64) -> bool {
        self.quick_bound(pair, frames, distance_m) > distance_m || self.reaches(pair, frames, distance_m)
    }

    /// Returns true if the exact distance of the pair is certified to reach `distance_m` (m).
    fn reaches(&self, pair: &Pair, frames: &LinkFrames, distance_m: f64) -> bool {
        group_reaches(self.placed(pair.first, frames), &self.placed_other(pair, frames), distance_m)
    }

    /// Returns a lower bound of the pair's distance (m) from its bounding balls; from its boxes if the bound from the balls
    /// does not exceed `enough_m` (m).
    pub(crate) fn quick_bound(&self, pair: &Pair, frames: &LinkFrames, enough_m: f64) -> f64 {
        let first = &self.bodies[pair.first];
        let world_from_first = frames.link(first.link);
        match pair.second {
            Other::Link { body, .. } => {
                let second = &self.bodies[body];
                let world_from_second = frames.link(second.link);
                first.bounds.distance_bound(world_from_first, &second.bounds, world_from_second, enough_m)
            }
            Other::Part(index) => {
                first.quick_bound_to(world_from_first, &self.around.parts[index].1, enough_m)
            }
        }
    }

    pub(crate) fn distance(&self, pair: &Pair, frames: &LinkFrames, beyond_m: f64) -> Separation {
        self.distance_in(pair, frames, Range::to(beyond_m))
    }

    /// Returns the distance of a pair, limited to a range of interest.
    pub(crate) fn distance_in(&self, pair: &Pair, frames: &LinkFrames, range: Range) -> Separation {
        group_separation_in(self.placed(pair.first, frames), &self.placed_other(pair, frames), range)
    }

    /// Returns the solids of the first member of a pair, each with its pose.
    pub(crate) fn placed<'a>(
        &'a self,
        body: usize,
        frames: &LinkFrames,
    ) -> impl Iterator<Item = (Pose, &'a Solid)> + Clone + use<'a> {
        self.bodies[body].placed(frames)
    }

    /// Returns the solids of the second member.
    pub(crate) fn placed_other<'a>(
        &'a self,
        pair: &Pair,
        frames: &LinkFrames,
    ) -> impl Iterator<Item = (Pose, &'a Solid)> + Clone + use<'a> {
        let (link, part) = match pair.second {
            Other::Link { body, .. } => (Some(self.placed(body, frames)), None),
            Other::Part(index) => (None, Some(&self.around.parts[index].1)),
        };
        let part = part.map(|part| (part.world_from_solid, &part.solid));
        link.into_iter().flatten().chain(part)
    }
}

impl Contact {
    /// Returns the names of the two colliders in the cell of the contact.
    pub fn names(&self, cell: &Cell) -> [String; 2] {
        [self.first, self.second].map(|collider| cell.name(collider).to_owned())
    }
}
