use std::collections::{BTreeMap, BTreeSet, HashMap, VecDeque};

use cranny_grasp::Grasp;
use cranny_spatial::{EXACT_TRANSLATION_M, Point};
use cranny_task::{Goal, Problem, Region};
use serde::{Deserialize, Serialize};

use crate::audit_limits::START_TOLERANCE;
use crate::bounds::sliding_base::{ROUNDING_M, SlidingBase};

/// Proof that the base of a robot cannot leave a region from which no goal is in reach.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BaseEnclosure {
    /// Names of the slides of the base.
    pub joints: Vec<String>,
    /// Bounds of the region in each slide, in metres.
    pub region_m: Vec<[f64; 2]>,
    /// Names of the links and bodies whose contact bounds the region.
    pub blocked_by: Vec<[String; 2]>,
    /// Lower bound of the distance of every goal from everything within reach from the region, in metres; greater than zero.
    pub beyond_m: f64,
    /// Number of squares that the proof compares.
    pub squares: usize,
}

/// Edge length below which a square is not split further, in metres: a passage narrower than the base by less is not found.
const FINEST_M: f64 = 5e-4;

/// Maximum number of squares.
const MOST_SQUARES: usize = 200_000;

/// Proves that no path leads from the start of a problem to any of its goals, because the base cannot come near enough. Returns
/// `None` if that is not so or remains undecided, for a robot whose arm does not stand on one or two slides, and under criteria other
/// than `exact`.
///
/// The links that only these slides move keep their orientation. The distance of two convex solids is a convex function of their
/// relative translation, so that a pair that is too near at all corners of a square of slide values is too near in the whole square,
/// whatever the arm does. The remaining squares that are connected with that of the start by common edges contain the base along
/// every path. If no goal is in reach from them, no path exists. Squares are split in four where this is undecided.
///
/// The reach of the arm is that of [`reach_bound`](cranny_robot::Robot::reach_bound). Parts of the base and of the world that are not convex are ignored, which
/// only enlarges the region.
pub fn base_enclosure(problem: &Problem) -> Option<BaseEnclosure> {
    let cell = problem.cell()?;
    let base = SlidingBase::new(cell, problem.start())?;
    let goals = Goals::new(problem, &base).filter(|goals| !goals.is_empty())?;
    Squares::new(base, goals, problem.start()).proof()
}

/// Goals of a problem: balls (radius in m) that contain the positions of the tip, or values of the slides.
enum Goals {
    Tips(Vec<(Point, f64)>),
    Slides(Vec<[f64; 2]>),
}

impl Goals {
    fn new(problem: &Problem, base: &SlidingBase) -> Option<Self> {
        match problem.goal() {
            Goal::Configurations(ends) => {
                Some(Self::Slides(ends.iter().map(|end| base.slides_of(end)).collect()))
            }
            Goal::Grasps(grasps) if problem.grasp_measure().is_none() => {
                let tip = |grasp: &Grasp| (Point::from(grasp.world_from_gripper.translation.vector), 0.0);
                Some(Self::Tips(grasps.grasps().iter().map(tip).collect()))
            }
            Goal::Regions(regions) => Some(Self::Tips(regions.iter().map(Region::ball).collect())),
            Goal::Grasps(_) => None,
        }
    }

    fn is_empty(&self) -> bool {
        match self {
            Self::Tips(tips) => tips.is_empty(),
            Self::Slides(ends) => ends.is_empty(),
        }
    }
}

/// Reach of the goals from a square.
struct Reach {
    /// Lower bound of the distance of the nearest goal from everything within reach, in metres; 0 or less if one may be in reach.
    beyond_m: f64,
    /// True if a goal is within the bound of the reach from the middle of the square.
    is_from_middle: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    /// A pair is too near in the whole square; its index.
    Blocked(usize),
    /// Every pair keeps its distance in the whole square.
    Free,
    Undecided,
    Split,
}

/// Level, column and row: the square of a level has the edges of the whole divided by 2^level.
type Place = (u32, u32, u32);

struct Squares<'a> {
    base: SlidingBase<'a>,
    goals: Goals,
    start: [f64; 2],
    states: HashMap<Place, State>,
    /// Indices of the pairs that are too near, by corner.
    corners: HashMap<(u32, u32), Vec<usize>>,
    deepest: u32,
}

impl<'a> Squares<'a> {
    fn new(base: SlidingBase<'a>, goals: Goals, start: &[f64]) -> Self {
        let longest = base.limits.iter().map(|[lower, upper]| upper - lower).fold(0.0, f64::max);
        let mut deepest = 0;
        while longest / f64::from(1_u32 << deepest) > FINEST_M && deepest < 20 {
            deepest += 1;
        }
        let start = base.slides_of(start);
        Self { base, goals, start, states: HashMap::new(), corners: HashMap::new(), deepest }
    }

    /// Value of a slide at a line of the finest grid.
    fn value(&self, slide: usize, line: u32) -> f64 {
        let [lower, upper] = self.base.limits[slide];
        lower + (upper - lower) * (f64::from(line) / f64::from(1_u32 << self.deepest))
    }

    fn is_flat(&self, slide: usize) -> bool {
        let [lower, upper] = self.base.limits[slide];
        lower >= upper
    }

    /// Bounds of a square in each slide.
    fn bounds(&self, (level, column, row): Place) -> [[f64; 2]; 2] {
        let shift = self.deepest - level;
        let of = |slide: usize, index: u32| {
            [self.value(slide, index << shift), self.value(slide, (index + 1) << shift)]
        };
        [of(0, column), of(1, row)]
    }

    fn middle(&self, place: Place) -> [f64; 2] {
        self.bounds(place).map(|[lower, upper]| 0.5 * (lower + upper))
    }

    /// Upper bound of the motion of the base from the middle of a square to any of its points, in metres.
    fn half_way_m(&self, place: Place) -> f64 {
        let half = self.bounds(place).map(|[lower, upper]| 0.5 * (upper - lower));
        let [a, b] = [self.base.ways[0] * half[0], self.base.ways[1] * half[1]];
        (a + b).norm().max((a - b).norm()) + ROUNDING_M
    }

    fn touching(&mut self, corner: (u32, u32)) -> &[usize] {
        let slides = [self.value(0, corner.0), self.value(1, corner.1)];
        let pairs = &self.base.pairs;
        self.corners
            .entry(corner)
            .or_insert_with(|| (0..pairs.len()).filter(|pair| pairs[*pair].touches(slides)).collect())
    }

    fn add(&mut self, place: Place) {
        let (level, column, row) = place;
        let shift = self.deepest - level;
        let lines = [column << shift, (column + 1) << shift];
        let rows = [row << shift, (row + 1) << shift];
        let mut common = self.touching((lines[0], rows[0])).to_vec();
        for corner in [(lines[0], rows[1]), (lines[1], rows[0]), (lines[1], rows[1])] {
            if common.is_empty() {
                break;
            }
            let there = self.touching(corner);
            common.retain(|pair| there.contains(pair));
        }
        let (middle, half_way_m) = (self.middle(place), self.half_way_m(place));
        let state = match common.first() {
            Some(pair) => State::Blocked(*pair),
            None if self.base.pairs.iter().all(|pair| pair.is_apart(middle, half_way_m)) => State::Free,
            None => State::Undecided,
        };
        self.states.insert(place, state);
    }

    fn split(&mut self, (level, column, row): Place) {
        self.states.insert((level, column, row), State::Split);
        let halves = |slide: usize, index: u32| {
            if self.is_flat(slide) { vec![index] } else { vec![2 * index, 2 * index + 1] }
        };
        let (columns, rows) = (halves(0, column), halves(1, row));
        for column in columns {
            for row in &rows {
                self.add((level + 1, column, *row));
            }
        }
    }

    fn reach(&self, place: Place) -> Reach {
        let (middle, half_way_m) = (self.middle(place), self.half_way_m(place));
        match &self.goals {
            Goals::Tips(tips) => {
                let centre = self.base.centre + self.base.ways[0] * middle[0] + self.base.ways[1] * middle[1];
                let distance_m = |(tip, radius_m): &(Point, f64)| (tip - centre).norm() - radius_m;
                let nearest = tips.iter().map(distance_m).fold(f64::INFINITY, f64::min);
                let beyond_m = nearest - self.base.radius_m - EXACT_TRANSLATION_M;
                Reach { beyond_m: beyond_m - half_way_m, is_from_middle: beyond_m <= 0.0 }
            }
            Goals::Slides(ends) => {
                let bounds = self.bounds(place);
                let off = |end: &[f64; 2]| {
                    let of = |slide: usize| {
                        let [lower, upper] = bounds[slide];
                        (lower - end[slide]).max(end[slide] - upper) - START_TOLERANCE
                    };
                    of(0).max(of(1))
                };
                let beyond_m = ends.iter().map(off).fold(f64::INFINITY, f64::min);
                Reach { beyond_m, is_from_middle: beyond_m <= 0.0 }
            }
        }
    }

    /// Returns the squares that contain the start within its tolerance.
    fn start_squares(&self) -> Vec<Place> {
        let contains = |place: &Place| {
            let bounds = self.bounds(*place);
            let is_in = |slide: usize| {
                let [lower, upper] = bounds[slide];
                self.start[slide] >= lower - START_TOLERANCE && self.start[slide] <= upper + START_TOLERANCE
            };
            is_in(0) && is_in(1)
        };
        let mut open = vec![(0, 0, 0)];
        let mut found = Vec::new();
        while let Some(place) = open.pop() {
            match self.states.get(&place) {
                Some(State::Split) => {
                    open.extend(self.children(place).into_iter().filter(|child| contains(child)));
                }
                Some(_) => found.push(place),
                None => {}
            }
        }
        found
    }

    fn children(&self, (level, column, row): Place) -> Vec<Place> {
        let all = [(0, 0), (0, 1), (1, 0), (1, 1)].map(|(right, up)| {
            let column = if self.is_flat(0) { column } else { 2 * column + right };
            let row = if self.is_flat(1) { row } else { 2 * row + up };
            (level + 1, column, row)
        });
        all.into_iter()
            .filter(|child| self.states.contains_key(child))
            .collect::<BTreeSet<_>>()
            .into_iter()
            .collect()
    }

    /// Returns the squares that share an edge with a square.
    fn neighbours(&self, place: Place) -> Vec<Place> {
        let (level, column, row) = place;
        let mut found = Vec::new();
        for (slide, is_up) in [(0, false), (0, true), (1, false), (1, true)] {
            if self.is_flat(slide) {
                continue;
            }
            let index = if slide == 0 { column } else { row };
            let next = if is_up {
                index.checked_add(1).filter(|next| *next < 1 << level)
            } else {
                index.checked_sub(1)
            };
            let Some(next) = next else { continue };
            let mut beside = if slide == 0 { (level, next, row) } else { (level, column, next) };
            while !self.states.contains_key(&beside) {
                let (level, column, row) = beside;
                let half = |slide: usize, index: u32| if self.is_flat(slide) { index } else { index / 2 };
                beside = (level - 1, half(0, column), half(1, row));
            }
            let mut open = vec![beside];
            while let Some(place) = open.pop() {
                if self.states[&place] != State::Split {
                    found.push(place);
                    continue;
                }
                // The children at the common edge: the lower ones of a square above, and the upper ones of one below.
                let is_near = |child: &Place| {
                    let index = if slide == 0 { child.1 } else { child.2 };
                    (index % 2 == 0) == is_up
                };
                open.extend(self.children(place).into_iter().filter(is_near));
            }
        }
        found
    }

    /// Returns all squares connected with the start through squares for which `is_open`, and the blocked ones at their edges.
    fn connected(&self, is_open: impl Fn(State) -> bool) -> (Vec<Place>, BTreeMap<usize, usize>) {
        let begin: Vec<Place> =
            self.start_squares().into_iter().filter(|place| is_open(self.states[place])).collect();
        let mut seen: BTreeSet<Place> = begin.iter().copied().collect();
        let mut open: VecDeque<Place> = begin.into();
        let (mut found, mut borders) = (Vec::new(), BTreeMap::new());
        while let Some(place) = open.pop_front() {
            found.push(place);
            for beside in self.neighbours(place) {
                match self.states[&beside] {
                    State::Blocked(pair) => *borders.entry(pair).or_default() += 1,
                    state if is_open(state) && seen.insert(beside) => open.push_back(beside),
                    _ => {}
                }
            }
        }
        (found, borders)
    }

    fn proof(mut self) -> Option<BaseEnclosure> {
        self.add((0, 0, 0));
        loop {
            let (free, _) = self.connected(|state| state == State::Free);
            if free.iter().any(|place| self.reach(*place).is_from_middle) {
                return None;
            }
            let (region, borders) = self.connected(|state| matches!(state, State::Free | State::Undecided));
            if region.is_empty() {
                return None;
            }
            let reaches: Vec<Reach> = region.iter().map(|place| self.reach(*place)).collect();
            let beyond_m = reaches.iter().map(|reach| reach.beyond_m).fold(f64::INFINITY, f64::min);
            if beyond_m > 0.0 {
                // Without borders, the goals are beyond reach from everywhere, which is another reason.
                return (!borders.is_empty()).then(|| self.enclosure(&region, &borders, beyond_m));
            }
            let is_unclear = |(place, reach): &(&Place, &Reach)| {
                let is_partly = reach.beyond_m <= 0.0 && !reach.is_from_middle;
                place.0 < self.deepest && (self.states[place] == State::Undecided || is_partly)
            };
            let unclear: Vec<Place> =
                region.iter().zip(&reaches).filter(is_unclear).map(|(place, _)| *place).collect();
            if unclear.is_empty() || self.states.len() + 4 * unclear.len() > MOST_SQUARES {
                return None;
            }
            for place in unclear {
                self.split(place);
            }
        }
    }

    fn enclosure(&self, region: &[Place], borders: &BTreeMap<usize, usize>, beyond_m: f64) -> BaseEnclosure {
        let used: Vec<usize> = (0..2).filter(|slide| self.base.slides[*slide].is_some()).collect();
        let joints = self.base.robot.joint_names();
        let name = |slide: &usize| self.base.slides[*slide].map(|joint| joints[joint].clone());
        let bounds = |slide: &usize| {
            let all = region.iter().map(|place| self.bounds(*place)[*slide]);
            all.fold([f64::INFINITY, f64::NEG_INFINITY], |[least, most], [lower, upper]| {
                [least.min(lower), most.max(upper)]
            })
        };
        let names: BTreeSet<[String; 2]> =
            borders.keys().map(|pair| self.base.pairs[*pair].names.clone()).collect();
        BaseEnclosure {
            joints: used.iter().filter_map(name).collect(),
            region_m: used.iter().map(bounds).collect(),
            blocked_by: names.into_iter().collect(),
            beyond_m,
            squares: self.states.values().filter(|state| **state != State::Split).count(),
        }
    }
}
