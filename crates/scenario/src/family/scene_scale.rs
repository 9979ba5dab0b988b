use cranny_robot::{JointKind, Mover, Robot};
use cranny_spatial::{Pose, Rotation, Stream, Vector};
use cranny_task::{PlaceGoal, PlaceRegion};

use crate::error::ScenarioError;
use crate::{Family, FamilyError, Placement, RecipeBody, RecipeShape};

/// Scale of a scene relative to the paper's, so that a robot of another reach can act in it. The scene shrinks about the
/// position of the robot. The object keeps its size as long as the hand can hold it and the scene has space for it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SceneScale {
    /// Scale of the environment away from the robot, in (0, 1].
    pub away: f64,
    /// Scale of the environment across and upwards, in (0, 1].
    pub across: f64,
    /// Scale of the object, in (0, 1].
    pub object: f64,
    /// Additional distance of the scene ahead of the robot, to its right and above its ground, in metres: ahead of an
    /// obstructing base, in front of an arm mounted on one side, on a platform if the arm does not reach the ground.
    pub shift_m: [f64; 3],
}

/// Position of the robot in the scene, in metres along x.
const ROBOT_X_M: f64 = 1.0;

/// Reach ahead that the scenes of the paper require of a robot at the start pose of the paper, in metres.
const FROM_AFAR_M: f64 = 1.6;

/// Distance from the robot to the first obstacle in those scenes, in metres.
const FIRST_OBSTACLE_M: f64 = 0.45;

/// A base that extends no farther than this ahead of its root takes no space from the scenes, in metres.
const SLENDER_M: f64 = 0.2;

/// Required reach upwards and to either side, in metres.
const AROUND_M: f64 = 0.75;

/// Usable share of the reach that the joints permit, with the hand oriented for a grasp.
const USABLE_REACH: f64 = 0.9;

/// Minimum travel of a mobile base, in metres; with less, the robot counts as stationary.
const LEAST_DRIVE_M: f64 = 0.5;

/// Maximum share of the opening of a hand that an object occupies.
const FILLED_OPENING: f64 = 0.85;

impl SceneScale {
    /// Scale of the paper's scenes.
    pub const PAPER: Self = Self { away: 1.0, across: 1.0, object: 1.0, shift_m: [0.0; 3] };

    /// Returns the scale that suits a robot, for a family.
    pub fn of(robot: &Robot, family: Family, opening_m: f64) -> Self {
        let base = Base::of(robot);
        let workspace = Workspace::of(robot, &base);
        let reach_m = USABLE_REACH * workspace.reach_m;
        let across = (reach_m / AROUND_M).min(1.0);
        let mut shift_m = [0.0; 3];
        let (away, across) = match base.drive {
            Drive::Nowhere => {
                let is_slender = base.ahead_m(robot) <= SLENDER_M;
                shift_m = workspace.shift_m(robot.floor_m().unwrap_or(0.0));
                // No obstacle of a scene is closer than the first one.
                let free = FIRST_OBSTACLE_M / FROM_AFAR_M;
                let ahead_m = (start_ahead_m(robot) - free * reach_m) / (1.0 - free);
                shift_m[0] = if is_slender { 0.0 } else { (ahead_m * 100.0).ceil().max(0.0) / 100.0 };
                ((reach_m - shift_m[0]) / FROM_AFAR_M, across)
            }
            // The base drives up to the obstacles, and the arm reaches on from there.
            Drive::OnFloor => {
                ((reach_m - USABLE_REACH * base.ahead_m(robot)) / family.beyond_front_m(), across)
            }
            // Only the hand must fit.
            Drive::Anywhere => (1.0, 1.0),
        };
        let away = away.clamp(LEAST, 1.0);
        let of_hand =
            if opening_m > 0.0 { FILLED_OPENING * opening_m / family.object_width_m() } else { 1.0 };
        // A scene of at most half the size has no space for an object of full size.
        let of_scene = if across < 0.5 { 2.0 * across } else { 1.0 };
        let object = rounded(of_hand.min(of_scene).min(1.0));
        Self { away: rounded(away), across: rounded(across), object, shift_m }
    }

    /// Returns the scale of the parameter of a family.
    pub(crate) fn of_dial(&self, family: Family) -> f64 {
        match family {
            Family::Shelf | Family::Table => self.away,
            Family::Gap | Family::Gate => self.across,
        }
    }

    /// Maps a point of the paper's scene to this one.
    pub(crate) fn point(&self, paper: &Vector) -> Vector {
        let [ahead_m, right_m, up_m] = self.shift_m;
        let x_m = ROBOT_X_M + right_m + self.across * (paper.x - ROBOT_X_M);
        Vector::new(x_m, ahead_m + self.away * paper.y, up_m + self.across * paper.z)
    }

    /// Maps a place goal of the paper's scene to this one.
    pub(crate) fn place(&self, place: PlaceGoal) -> PlaceGoal {
        let PlaceRegion::Surface { on, pose, size_m: [across_m, away_m] } = place.spot else { return place };
        let point = self.point(&pose.translation.vector);
        let pose = Pose::from_parts(point.into(), pose.rotation);
        let size_m = [across_m * self.across, away_m * self.away];
        PlaceGoal { spot: PlaceRegion::Surface { on, pose, size_m }, ..place }
    }

    /// Returns the platform under the scene, if it is raised: it extends from the first obstacle to behind the last.
    pub(crate) fn platform(&self) -> Option<RecipeBody> {
        /// Extent in the paper's scene, in metres.
        const LEFT_M: f64 = -0.25;
        const RIGHT_M: f64 = 2.25;
        const BACK_M: f64 = 2.0;
        let up_m = self.shift_m[2];
        let (near, far) = (
            self.point(&Vector::new(LEFT_M, FIRST_OBSTACLE_M, 0.0)),
            self.point(&Vector::new(RIGHT_M, BACK_M, 0.0)),
        );
        let size = Vector::new(far.x - near.x, far.y - near.y, up_m);
        let middle = Pose::from_parts((0.5 * (near + far - Vector::z() * up_m)).into(), Rotation::identity());
        (up_m > 0.0).then(|| RecipeBody::new("platform", middle, RecipeShape::Cuboid(size)))
    }

    /// Maps a size in the paper's scene to this one.
    fn size(&self, paper: &Vector) -> Vector {
        paper.component_mul(&Vector::new(self.across, self.away, self.across))
    }

    pub(crate) fn placement(&self, paper: &Placement) -> Placement {
        let place = self.point(&Vector::new(paper.x_m, paper.y_m, 0.0));
        Placement { x_m: place.x, y_m: place.y, yaw_rad: paper.yaw_rad }
    }

    fn is_of_the_paper(&self) -> bool {
        *self == Self { object: self.object, ..Self::PAPER }
    }

    /// Maps an obstacle of the paper's scene, made of cuboids, to this one.
    pub(crate) fn obstacle(&self, mut body: RecipeBody) -> RecipeBody {
        if self.is_of_the_paper() {
            return body;
        }
        let place = &mut body.scene_from_body.translation.vector;
        *place = self.point(place);
        for (body_from_shape, shape) in &mut body.shapes {
            let place = &mut body_from_shape.translation.vector;
            *place = self.size(place);
            if let RecipeShape::Cuboid(size) = shape {
                *size = self.size(size);
            }
        }
        body
    }

    /// Maps a clutter object to this scene: position and height are scaled, and thickness by at least half the object's scale.
    pub(crate) fn clutter(&self, mut body: RecipeBody) -> RecipeBody {
        if self.is_of_the_paper() {
            return body;
        }
        let place = &mut body.scene_from_body.translation.vector;
        *place = self.point(place);
        let thick = self.across.max(0.5 * self.object);
        for (_, shape) in &mut body.shapes {
            match shape {
                RecipeShape::Cuboid(size) => {
                    *size = size.component_mul(&Vector::new(thick, thick, self.across));
                }
                RecipeShape::Cylinder(radius_m, length_m) => {
                    (*radius_m, *length_m) = (*radius_m * thick, *length_m * self.across);
                }
                _ => {}
            }
        }
        body
    }
}

/// Rounds a scale down to a hundredth, so that a slightly longer robot changes no scene.
fn rounded(scale: f64) -> f64 {
    ((scale * 100.0).floor() / 100.0).max(0.01)
}

/// Minimum scale.
const LEAST: f64 = 0.01;

/// Mobility of the base of a robot.
enum Drive {
    Nowhere,
    OnFloor,
    Anywhere,
}

/// Base of a robot: the joints before the first link with collision geometry.
struct Base {
    drive: Drive,
    joints: Vec<usize>,
}

impl Base {
    fn of(robot: &Robot) -> Self {
        let movers = robot.ancestors(robot.tip()).iter().take_while(|mover| {
            let above = robot.links()[mover.child_link].parent;
            above.is_none_or(|link| robot.links()[link].collisions.is_empty())
        });
        let movers: Vec<Mover> = movers.copied().collect();
        let frames = robot.frames();
        let mut goes = [false; 2];
        for mover in movers.iter().filter(|mover| mover.kind == JointKind::Prismatic) {
            let limits = robot.limits()[mover.joint];
            let axis = frames.link(mover.child_link).rotation * mover.axis_in_child;
            let is_upright = axis.z.abs() > 0.5;
            goes[usize::from(is_upright)] |= limits.upper - limits.lower >= LEAST_DRIVE_M;
        }
        let drive = match goes {
            [true, true] => Drive::Anywhere,
            [true, false] => Drive::OnFloor,
            _ => Drive::Nowhere,
        };
        Self { drive, joints: movers.iter().map(|mover| mover.joint).collect() }
    }

    /// Returns the extent of the base ahead of the axis through the root, in metres.
    fn ahead_m(&self, robot: &Robot) -> f64 {
        let frames = robot.frames();
        let is_base =
            |link: &usize| robot.ancestors(*link).iter().all(|mover| self.joints.contains(&mover.joint));
        let mut ahead_m = 0.0_f64;
        for link in (0..robot.links().len()).filter(is_base) {
            for shape in &robot.links()[link].collisions {
                let pose = frames.link(link) * shape.link_from_shape;
                let Some((points, radius_m)) = shape.solid.bounding_points() else { continue };
                let ahead = points.iter().map(|point| (pose * point).x + radius_m);
                ahead_m = ahead.fold(ahead_m, f64::max);
            }
        }
        ahead_m
    }
}

/// Positions of the tip for many random configurations with fixed prismatic base joints.
struct Workspace {
    /// Maximum distance from the axis through the root, in metres.
    reach_m: f64,
    /// Tip positions ahead of the robot, in its root frame.
    ahead: Vec<Vector>,
}

impl Workspace {
    fn of(robot: &Robot, base: &Base) -> Self {
        const DRAWS: usize = 2000;
        let mut random = Stream::new(0, 0);
        let mut frames = robot.frames();
        let (mut reach_m, mut ahead) = (0.0_f64, Vec::new());
        for _ in 0..DRAWS {
            let mut q = robot.random_configuration(&mut random);
            for &joint in &base.joints {
                if robot.joints()[joint].kind == JointKind::Prismatic {
                    q[joint] = robot.limits()[joint].clamp(0.0);
                }
            }
            robot.forward_kinematics(&q, &mut frames);
            let tip = frames.link(robot.tip()).translation.vector;
            reach_m = reach_m.max(tip.xy().norm());
            if tip.x > 0.0 {
                ahead.push(tip);
            }
        }
        Self { reach_m, ahead }
    }

    /// Returns the lateral and vertical shift of the scenes of a stationary robot; see [`SceneScale::shift_m`].
    fn shift_m(&self, floor_m: f64) -> [f64; 3] {
        /// Lateral offset below which an arm counts as mounted in the middle, in metres.
        const BESIDE_M: f64 = 0.1;
        /// If the tip is seldom lower than this share of its reach, the arm reaches too little at ground level.
        const HIGH: f64 = 0.4;
        // Value below which a fraction `1 / one_of` of the positions lies.
        let quantile = |axis: usize, one_of: usize| {
            let mut values: Vec<f64> = self.ahead.iter().map(|tip| tip[axis]).collect();
            values.sort_by(f64::total_cmp);
            values.get(values.len() / one_of).copied().unwrap_or(0.0)
        };
        let (left_m, low_m) = (quantile(1, 2), quantile(2, 5) - floor_m);
        let right_m = if left_m.abs() > BESIDE_M { -left_m } else { 0.0 };
        let up_m = if low_m > HIGH * self.reach_m { low_m } else { 0.0 };
        [0.0, right_m, up_m].map(|shift_m| (shift_m * 100.0).round() / 100.0)
    }
}

/// Returns the extent of a robot ahead of its root at its start, in metres.
fn start_ahead_m(robot: &Robot) -> f64 {
    let near_zero = || robot.limits().iter().map(|limits| limits.clamp(0.0)).collect::<Vec<f64>>();
    let frames = robot.frames_at(&robot.default_start().map_or_else(near_zero, <[f64]>::to_vec));
    let solids = robot
        .links()
        .iter()
        .enumerate()
        .flat_map(|(link, described)| described.collisions.iter().map(move |shape| (link, shape)));
    let ahead_m = solids.filter_map(|(link, shape)| {
        let pose = frames.link(link) * shape.link_from_shape;
        let (points, radius_m) = shape.solid.bounding_points()?;
        Some(points.iter().map(|point| (pose * point).x + radius_m).fold(0.0, f64::max))
    });
    ahead_m.fold(0.0, f64::max)
}

impl Family {
    /// Returns `value` if it is within the range of the parameter in a scene of that scale.
    ///
    /// # Errors
    /// [`FamilyError::Parameter`] otherwise.
    pub fn checked(self, value: f64, scale: &SceneScale) -> Result<f64, ScenarioError> {
        let [low, high] = self.range_m().map(|end| end * scale.of_dial(self));
        if (low..=high).contains(&value) {
            return Ok(value);
        }
        Err(FamilyError::Parameter { family: self.name(), parameter: self.parameter(), low, high, value }
            .into())
    }
}
