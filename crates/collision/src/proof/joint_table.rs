use std::sync::Arc;

use cranny_robot::{JointLimits, LinkFrames, Robot};
use cranny_shape::{Solid, overlap, quick_lower_bound, reaches};
use cranny_spatial::{ROUNDING_M, Vector};

use crate::body::link_body::LinkBody;
use crate::lane::single_frame::Verdict;
use crate::pair::pairs::{Other, Pair};
use crate::proof::joint_curve::Rates;
use crate::proof::travel::Travel;

/// Table of pairs of links whose relative pose depends on the same one or two joints, as on either side of an elbow or a wrist.
/// They are always near each other, so balls seldom decide; the verdicts are precomputed on a grid over the two joints.
#[derive(Clone, Debug)]
pub(crate) struct JointTable {
    /// Indices in `q`; one index twice for a single joint.
    pub joints: [usize; 2],
    /// Indices of the pairs in the list of all pairs.
    pub pairs: Vec<u32>,
    /// Least value of each joint (m, rad), and number of cells per unit.
    pub lower: [f32; 2],
    pub per_unit: [f32; 2],
    /// For each cell one bit for each pair that is in doubt there, or all of these bits and [`CONTACT`].
    cells: Arc<[u8]>,
    /// Bits of the pairs that are checked with this table, and [`CONTACT`] if all of its pairs are.
    asked: u8,
}

/// Bit of a cell in which some pair is certainly in contact everywhere.
pub(crate) const CONTACT: u8 = 1 << MOST_PAIRS;

/// Maximum number of pairs: the bits of a byte besides [`CONTACT`].
const MOST_PAIRS: usize = 7;

/// Number of cells along each joint. Half a cell is about 1.3° of a joint with a range of 5.8 rad: less than 4 mm at the size
/// of a hand.
const SIDE: usize = 128;

/// Maximum overhang, in cells, for a table to be useful.
const MOST_OVERHANG: f64 = 0.25;

/// Returns the maximum rounding of a joint value, in cells; the certificate of a cell extends beyond the cell by this amount.
///
/// With the unit roundoff u of `f32`: the value and the joint's least value are off by u of the greatest value, their
/// difference and the added travel by u of the range each. The product with the cells per unit, itself off by u, is off by 2 u
/// of all cells.
fn overhang(limits: &JointLimits) -> f64 {
    const UNIT: f64 = 0.5 * f32::EPSILON as f64;
    let greatest = limits.lower.abs().max(limits.upper.abs());
    SIDE as f64 * UNIT * (2.0 * greatest / (limits.upper - limits.lower) + 4.0)
}

impl JointTable {
    /// Returns this table restricted to the pairs that `is_asked` selects.
    pub fn asked_about(&self, is_asked: impl Fn(u32) -> bool) -> Self {
        let asked = (0..).zip(&self.pairs).filter(|(_, pair)| is_asked(**pair));
        let asked = asked.fold(0, |bits, (bit, _)| bits | 1 << bit);
        Self { asked: if asked == self.all_pairs() { asked | CONTACT } else { asked }, ..self.clone() }
    }

    /// Returns this table for a list in which `first` other pairs precede its own.
    pub fn counted_from(&self, first: u32) -> Self {
        Self { pairs: self.pairs.iter().map(|pair| first + pair).collect(), ..self.clone() }
    }

    /// Returns the pairs that are checked with this table, each with its bit.
    #[inline(always)]
    pub fn asked_pairs(&self) -> impl Iterator<Item = (u8, u32)> {
        let bits = (0..MOST_PAIRS).map(|bit| 1 << bit);
        bits.zip(&self.pairs).filter(|(bit, _)| self.asked & bit != 0).map(|(bit, pair)| (bit, *pair))
    }

    /// Computes the tables of all such pairs.
    pub fn all(robot: &Robot, bodies: &[LinkBody], pairs: &[Pair]) -> Vec<Self> {
        let mut tables: Vec<Self> = Vec::new();
        for (index, pair) in pairs.iter().enumerate() {
            let Some(joints) = joints_between(robot, bodies, pair) else { continue };
            let index = u32::try_from(index).unwrap_or(u32::MAX);
            match tables.iter_mut().find(|table| table.joints == joints && table.pairs.len() < MOST_PAIRS) {
                Some(table) => table.pairs.push(index),
                None => tables.push(Self::empty(robot, joints, index)),
            }
        }
        let mut builder = Builder {
            robot,
            bodies,
            pairs,
            frames: robot.frames(),
            travel: Travel::new(robot, bodies),
            q: robot.limits().iter().map(|limits| 0.5 * (limits.lower + limits.upper)).collect(),
            rates: Rates::still(robot.dof()),
            doubts: Vec::new(),
        };
        for table in &mut tables {
            builder.robot.forward_kinematics(&builder.q, &mut builder.frames);
            let mut cells = vec![!CONTACT; SIDE * SIDE];
            builder.doubt_all(table);
            builder.fill(table, &mut cells, [0, 0], SIDE, 0);
            table.cells = cells.into();
            table.asked = table.all_pairs() | CONTACT;
        }
        tables
    }

    /// Returns one bit for each pair that is not free in all cells from `low` to `high`, and [`CONTACT`] if all of them are in
    /// contact. A cell out of range counts as the nearest one in range.
    #[inline(always)]
    pub fn look_up(&self, low: [i32; 2], high: [i32; 2]) -> u8 {
        let [low_x, low_y] = low.map(in_range);
        if low == high {
            return self.cells[low_x * SIDE + low_y] & self.asked;
        }
        // A pose that depends on one joint is tabulated on the diagonal only.
        let is_single = self.joints[0] == self.joints[1];
        let [high_x, high_y] = high.map(in_range);
        let (mut any, mut all) = (0, CONTACT);
        for x in low_x..=high_x {
            for y in if is_single { x..=x } else { low_y..=high_y } {
                let cell = self.cells[x * SIDE + y];
                any |= cell;
                all &= cell;
            }
        }
        ((any & !CONTACT) | all) & self.asked
    }

    /// Returns the fraction of the straight edge between two values of its joints (rad or m) that is certified free for all
    /// checked pairs, counted from the start, in whole intervals along which no joint moves farther than a cell.
    pub fn free_share(&self, limits: [&JointLimits; 2], [from, to]: [[f64; 2]; 2]) -> f64 {
        let in_cells = |place: [f64; 2]| {
            let cell = |axis: usize| {
                let JointLimits { lower, upper, .. } = limits[axis];
                (place[axis] - lower) / (upper - lower) * SIDE as f64
            };
            [cell(0), cell(1)]
        };
        let (from, to) = (in_cells(from), in_cells(to));
        let farthest = (to[0] - from[0]).abs().max((to[1] - from[1]).abs());
        let pieces = farthest.ceil().clamp(1.0, (2 * SIDE) as f64);
        let cell_at = |piece: f64| {
            #[allow(
                clippy::cast_possible_truncation,
                reason = "at most `SIDE` within the limits; beyond them it is cut off"
            )]
            [0, 1].map(|axis| (from[axis] + (to[axis] - from[axis]) * piece / pieces).floor() as i32)
        };
        let (mut done, mut begin) = (0.0, cell_at(0.0));
        while done < pieces {
            let end = cell_at(done + 1.0);
            let [low, high] = [i32::min, i32::max].map(|of| [of(begin[0], end[0]), of(begin[1], end[1])]);
            if self.look_up(low, high) != 0 {
                break;
            }
            (done, begin) = (done + 1.0, end);
        }
        done / pieces
    }

    fn all_pairs(&self) -> u8 {
        u8::try_from((1 << self.pairs.len()) - 1).unwrap_or(!CONTACT)
    }

    #[allow(
        clippy::cast_possible_truncation,
        reason = "lanes are `f32` by design; the overhang of the cells covers it"
    )]
    fn empty(robot: &Robot, joints: [usize; 2], pair: u32) -> Self {
        let limits = joints.map(|joint| robot.limits()[joint]);
        Self {
            joints,
            pairs: vec![pair],
            lower: limits.map(|limits| limits.lower as f32),
            per_unit: limits.map(|limits| (SIDE as f64 / (limits.upper - limits.lower)) as f32),
            cells: Arc::default(),
            asked: 0,
        }
    }
}

fn in_range(cell: i32) -> usize {
    usize::try_from(cell).unwrap_or(0).min(SIDE - 1)
}

/// Returns the joints on which the relative pose of the pair depends, if they are one or two with a range.
fn joints_between(robot: &Robot, bodies: &[LinkBody], pair: &Pair) -> Option<[usize; 2]> {
    let Other::Link { body, shared_joints } = pair.second else { return None };
    let chain = |body: usize| robot.ancestors(bodies[body].link).iter().skip(shared_joints).map(|m| m.joint);
    let mut joints: Vec<usize> = chain(pair.first).chain(chain(body)).collect();
    joints.sort_unstable();
    joints.dedup();
    let has_range = |joint: &usize| {
        let limits = &robot.limits()[*joint];
        let range = limits.upper - limits.lower;
        range > 0.0 && range.is_finite() && overhang(limits) <= MOST_OVERHANG
    };
    let (first, last) = (*joints.first()?, *joints.last()?);
    (joints.len() <= 2 && joints.iter().all(has_range)).then_some([first, last])
}

struct Builder<'a> {
    robot: &'a Robot,
    bodies: &'a [LinkBody],
    pairs: &'a [Pair],
    frames: LinkFrames,
    travel: Travel,
    q: Vec<f64>,
    rates: Rates,
    /// Doubts in the nested squares around the current one, from the outermost in; in each square the doubts of a pair are
    /// adjacent.
    doubts: Vec<Doubt>,
}

/// Two solids of a pair of links that may come too close.
#[derive(Clone, Copy, Debug)]
struct Doubt {
    bit: usize,
    /// Indices of the solids among those of each link.
    solids: [usize; 2],
}

impl Builder<'_> {
    /// Puts all pairs of solids in doubt.
    fn doubt_all(&mut self, table: &JointTable) {
        self.doubts.clear();
        for (bit, &pair) in table.pairs.iter().enumerate() {
            let Pair { first, second: Other::Link { body, .. }, .. } = self.pairs[pair as usize] else {
                unreachable!("tables are of pairs of links");
            };
            let [first, second] = [first, body].map(|body| self.bodies[body].shapes.len());
            for one in 0..first {
                self.doubts.extend((0..second).map(|other| Doubt { bit, solids: [one, other] }));
            }
        }
    }

    /// Decides the square of cells from `corner`: as a whole if possible, otherwise by quarters. The doubts of the enclosing
    /// square start at `first_doubt`.
    fn fill(
        &mut self,
        table: &JointTable,
        cells: &mut [u8],
        corner: [usize; 2],
        side: usize,
        first_doubt: usize,
    ) {
        if table.joints[0] == table.joints[1] && corner[0] != corner[1] {
            return;
        }
        let own_doubt = self.doubts.len();
        let verdict = self.square(table, corner, side, first_doubt);
        if verdict != 0 && verdict & CONTACT == 0 && side > 1 {
            let half = side / 2;
            for (x, y) in [(0, 0), (0, half), (half, 0), (half, half)] {
                self.fill(table, cells, [corner[0] + x, corner[1] + y], half, own_doubt);
            }
        } else {
            for x in corner[0]..corner[0] + side {
                cells[x * SIDE + corner[1]..][..side].fill(verdict);
            }
        }
        self.doubts.truncate(own_doubt);
    }

    /// Returns the verdict on the square, and adds its doubts.
    fn square(&mut self, table: &JointTable, corner: [usize; 2], side: usize, first_doubt: usize) -> u8 {
        self.rates.now.fill(0.0);
        for (joint, corner) in table.joints.into_iter().zip(corner) {
            let limits = &self.robot.limits()[joint];
            let cell = (limits.upper - limits.lower) / SIDE as f64;
            self.q[joint] = limits.lower + cell * (corner as f64 + 0.5 * side as f64);
            self.rates.now[joint] = cell * (0.5 * side as f64 + overhang(limits));
        }
        self.robot.update_kinematics(&self.q, &table.joints, &mut self.frames);
        let (mut left, mut next, end) = (0, first_doubt, self.doubts.len());
        while next < end {
            let bit = self.doubts[next].bit;
            let of_pair = self.doubts[next..end].iter().take_while(|doubt| doubt.bit == bit).count();
            match self.pair(&self.pairs[table.pairs[bit] as usize], next..next + of_pair) {
                Verdict::Contact => return CONTACT | table.all_pairs(),
                Verdict::Doubt => left |= 1 << bit,
                Verdict::Free => {}
            }
            next += of_pair;
        }
        left
    }

    /// Certifies a pair for all configurations that differ from `q` by at most `rates` in each joint, as the points of straight
    /// motions from `q` with at most these rates. Adds the remaining ones of `doubts`.
    fn pair(&mut self, pair: &Pair, doubts: std::ops::Range<usize>) -> Verdict {
        let Other::Link { body, shared_joints } = pair.second else { return Verdict::Doubt };
        self.travel.forget();
        for body in [pair.first, body] {
            self.travel.know(self.robot, self.bodies, body, &self.frames, &self.rates, 1.0);
        }
        let travel_m = self.travel.between(pair.first, body, shared_joints) + ROUNDING_M;
        let links = [pair.first, body].map(|body| &self.bodies[body]);
        let enough_m = pair.required_m + travel_m;
        let frames = links.map(|link| *self.frames.link(link.link));
        let bounds = links.map(|link| &link.bounds);
        if bounds[0].distance_bound(&frames[0], bounds[1], &frames[1], enough_m) > enough_m {
            return Verdict::Free;
        }
        let first_left = self.doubts.len();
        for index in doubts {
            let doubt = self.doubts[index];
            let [(pose_a, a), (pose_b, b)] = [0, 1].map(|side| {
                let (link_from_solid, solid) = &links[side].shapes[doubt.solids[side]];
                (frames[side] * link_from_solid, solid)
            });
            let bound_m = quick_lower_bound(a, &pose_a, b, &pose_b, enough_m);
            if bound_m > enough_m || reaches(a, &pose_a, b, &pose_b, enough_m) {
                continue;
            }
            let is_convex = |solid: &Solid| solid.support_point(&Vector::x()).is_some();
            // The bounding balls and boxes limit the depth, so a small bound needs no exact depth.
            let is_deep = bound_m < -travel_m
                && is_convex(a)
                && is_convex(b)
                && overlap(a, &pose_a, b, &pose_b).is_some_and(|overlap| overlap.depth_m > travel_m);
            if is_deep {
                return Verdict::Contact;
            }
            self.doubts.push(doubt);
        }
        if self.doubts.len() > first_left { Verdict::Doubt } else { Verdict::Free }
    }
}
