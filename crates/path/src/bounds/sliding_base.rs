use cranny_collision::{Cell, Collider, DemandedOther};
use cranny_robot::{JointKind, Mover, Robot};
use cranny_shape::{Solid, separation};
use cranny_spatial::{Point, Pose, Vector};

use crate::audit_limits::START_TOLERANCE;

/// Upper bound of rounding errors of distances, in metres.
pub(crate) const ROUNDING_M: f64 = 1e-9;

/// One pair of convex solids, the first of which the slides move.
pub(crate) struct BasePair {
    pub names: [String; 2],
    solid: Solid,
    /// Pose of the first solid with both slides at zero.
    at_zero: Pose,
    /// Translation of the first solid per metre of each slide.
    ways: [Vector; 2],
    part: Solid,
    world_from_part: Pose,
    required_m: f64,
}

impl BasePair {
    fn pose(&self, slides: [f64; 2]) -> Pose {
        Pose::from_parts(
            (self.at_zero.translation.vector + self.ways[0] * slides[0] + self.ways[1] * slides[1]).into(),
            self.at_zero.rotation,
        )
    }

    pub fn touches(&self, slides: [f64; 2]) -> bool {
        let found =
            separation(&self.solid, &self.pose(slides), &self.part, &self.world_from_part, self.required_m);
        found.upper_m < self.required_m - ROUNDING_M
    }

    /// Returns true if the pair keeps its distance wherever the solid is moved by up to `way_m`.
    pub fn is_apart(&self, slides: [f64; 2], way_m: f64) -> bool {
        let enough_m = self.required_m + way_m;
        let pose = self.pose(slides);
        separation(&self.solid, &pose, &self.part, &self.world_from_part, enough_m).lower_m >= enough_m
    }
}

/// The slides of the base, and the links that only they move.
pub(crate) struct SlidingBase<'a> {
    pub robot: &'a Robot,
    /// Indices of the slides in `q`; the second is missing for a single slide.
    pub slides: [Option<usize>; 2],
    /// Translation of the arm per metre of each slide.
    pub ways: [Vector; 2],
    pub limits: [[f64; 2]; 2],
    pub pairs: Vec<BasePair>,
    /// Centre and radius of the reach of the arm, with both slides at zero.
    pub centre: Point,
    pub radius_m: f64,
}

impl<'a> SlidingBase<'a> {
    /// Returns the slides on which the arm of a robot stands, with the other joints at `start` (m, rad; one per joint); `None`
    /// without any, and without a pair to compare.
    pub fn new(cell: &'a Cell, start: &[f64]) -> Option<Self> {
        let robot = &**cell.robot();
        let frames = robot.frames_at(start);
        let way_of =
            |mover: &Mover| frames.link(mover.child_link).rotation * mover.axis_in_child * mover.multiplier;
        let movers = robot.ancestors(robot.tip());
        let leading: Vec<&Mover> =
            movers.iter().take_while(|mover| mover.kind == JointKind::Prismatic).collect();
        let used = &leading[..leading.len().min(2)];
        let first = used.first()?;
        let second = used.get(1).filter(|second| second.joint != first.joint);
        let used: Vec<&Mover> = std::iter::once(*first).chain(second.copied()).collect();
        let slides = [Some(first.joint), second.map(|second| second.joint)];
        let ways = [way_of(first), second.map_or_else(Vector::zeros, |second| way_of(second))];
        let range = |slide: Option<usize>| {
            slide.map_or([0.0; 2], |joint| {
                let limits = robot.limits()[joint];
                [limits.lower - START_TOLERANCE, limits.upper + START_TOLERANCE]
            })
        };
        let limits = slides.map(range);
        if limits.iter().flatten().any(|limit| !limit.is_finite()) {
            return None;
        }
        // Slides that lead the arm beyond these two add to its reach.
        let reach = robot.reach_bound();
        let (mut centre, mut radius_m) = (*reach.middle(), reach.radius_m() + ROUNDING_M);
        for mover in &leading {
            let limits = robot.limits()[mover.joint];
            if used.contains(mover) {
                centre -= way_of(mover) * (0.5 * (limits.lower + limits.upper));
            } else {
                radius_m += (0.5 * (limits.upper - limits.lower) + START_TOLERANCE) * mover.multiplier.abs();
            }
        }
        let is_convex = |solid: &Solid| solid.is_half_space() || solid.support_point(&Vector::z()).is_some();
        let mut pairs = Vec::new();
        for pair in cell.demanded_pairs() {
            let (DemandedOther::Part(part), Some(required_m)) = (pair.other, pair.required_m) else {
                continue;
            };
            let moved_by = robot.ancestors(pair.link);
            if moved_by.is_empty() || !moved_by.iter().all(|mover| used.contains(&mover)) {
                continue;
            }
            let (body, part) = &cell.parts()[part];
            let names = [robot.links()[pair.link].name.clone(), cell.name(Collider::Body(*body)).to_owned()];
            let mut own_ways = [Vector::zeros(); 2];
            let mut start_way = Vector::zeros();
            for mover in moved_by {
                let slide = usize::from(Some(mover.joint) != slides[0]);
                own_ways[slide] += way_of(mover);
                start_way += way_of(mover) * start[mover.joint];
            }
            for (link_from_solid, solid) in cell.solids_of(pair.link) {
                if !(is_convex(solid) && is_convex(&part.solid)) {
                    continue;
                }
                let here = frames.link(pair.link) * link_from_solid;
                let at_zero = Pose::from_parts((here.translation.vector - start_way).into(), here.rotation);
                pairs.push(BasePair {
                    names: names.clone(),
                    solid: solid.clone(),
                    at_zero,
                    ways: own_ways,
                    part: part.solid.clone(),
                    world_from_part: part.world_from_solid,
                    required_m,
                });
            }
        }
        (!pairs.is_empty()).then_some(Self { robot, slides, ways, limits, pairs, centre, radius_m })
    }

    /// Returns the values of the slides in `q` (m, rad; one per joint).
    pub fn slides_of(&self, q: &[f64]) -> [f64; 2] {
        self.slides.map(|slide| slide.map_or(0.0, |joint| q[joint]))
    }
}
