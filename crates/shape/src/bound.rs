use cranny_spatial::nalgebra::Rotation3;
use cranny_spatial::{Point, Pose, Vector};

/// A ball that contains a shape, in the shape's frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ball {
    /// Centre of the ball.
    pub center: Point,
    /// Radius, in metres.
    pub radius_m: f64,
}

/// A ball and a box that both contain a shape, in the shape's frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Bounding ball.
    pub ball: Ball,
    /// Bounding box.
    pub aabb: Aabb,
}

impl Bounds {
    /// Bounds of `points`, each with a ball of its own radius (m) around it.
    ///
    /// # Panics
    /// If there is no point.
    pub fn around(points: &[(Point, f64)]) -> Self {
        let corner = |sign: f64| {
            let offset = points.iter().map(|(point, radius_m)| point.coords.add_scalar(sign * radius_m));
            offset.reduce(|a, b| if sign > 0.0 { a.sup(&b) } else { a.inf(&b) })
        };
        let (low, high) = (corner(-1.0), corner(1.0));
        let (low, high) = low.zip(high).expect("bounds are built around at least one point");
        let aabb = Aabb { center: ((low + high) * 0.5).into(), half_extents: (high - low) * 0.5 };
        let reach = |(point, radius_m): &(Point, f64)| (point - aabb.center).norm() + radius_m;
        let radius_m = points.iter().map(reach).fold(0.0, f64::max);
        Self { ball: Ball { center: aabb.center, radius_m }, aabb }
    }

    /// Lower bound of the distance (m) of two bounded shapes with poses in a common frame, for a few multiplications; may be
    /// negative. Skips the boxes if the balls show that the distance exceeds `enough_m`.
    pub fn distance_bound(
        &self,
        common_from_self: &Pose,
        other: &Self,
        common_from_other: &Pose,
        enough_m: f64,
    ) -> f64 {
        let between = common_from_self * self.ball.center - common_from_other * other.ball.center;
        let of_balls = between.norm() - self.ball.radius_m - other.ball.radius_m;
        if of_balls > enough_m {
            return of_balls;
        }
        of_balls.max(self.aabb.gap_to(&other.aabb, &common_from_self.inv_mul(common_from_other)))
    }
}

/// Axis-aligned box in its frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aabb {
    /// Centre of the box.
    pub center: Point,
    /// Half extent along each axis, in metres.
    pub half_extents: Vector,
}

impl Aabb {
    /// Smallest box around `points`, grown by `margin_m` (m) on every side.
    ///
    /// # Panics
    /// If there is no point.
    pub fn around<'a>(points: impl IntoIterator<Item = &'a Point>, margin_m: f64) -> Self {
        let mut points = points.into_iter();
        let first = *points.next().expect("a box is built around at least one point");
        let (low, high) = points.fold((first, first), |(low, high), p| (low.inf(p), high.sup(p)));
        Self { center: midpoint(&low, &high), half_extents: (high - low) * 0.5 }.grown(margin_m)
    }

    /// Returns the box with every side moved outwards by `margin_m` (m).
    #[must_use]
    pub fn grown(mut self, margin_m: f64) -> Self {
        self.half_extents.add_scalar_mut(margin_m);
        self
    }

    /// Returns an axis-aligned box of the target frame that contains this one.
    #[must_use]
    pub fn transformed(&self, target_from_box: &Pose) -> Self {
        let rotation = target_from_box.rotation.to_rotation_matrix();
        Self {
            center: target_from_box * self.center,
            half_extents: rotation.matrix().abs() * self.half_extents,
        }
    }

    /// Distance from `point` to the box, in metres; 0 inside.
    pub fn distance_to(&self, point: &Point) -> f64 {
        ((point - self.center).abs() - self.half_extents).sup(&Vector::zeros()).norm()
    }

    /// The corner with the least coordinates.
    pub fn low(&self) -> Point {
        self.center - self.half_extents
    }

    /// The corner with the greatest coordinates.
    pub fn high(&self) -> Point {
        self.center + self.half_extents
    }

    /// Returns true if `point` lies in this box.
    pub fn contains(&self, point: &Point) -> bool {
        ((point - self.center).abs() - self.half_extents).max() <= 0.0
    }

    /// Returns true if the two boxes share a point.
    pub fn overlaps(&self, other: &Self) -> bool {
        ((other.center - self.center).abs() - other.half_extents - self.half_extents).max() <= 0.0
    }

    /// Lower bound of the distance (m) to `other`, which has a pose in this box's frame; 0 or less if no face of either box
    /// separates the two.
    ///
    /// The greater of the distances from each box to the axis-aligned box around the other: exact if a face is nearest, too low
    /// if two edges are nearest.
    pub fn gap_to(&self, other: &Self, self_from_other: &Pose) -> f64 {
        self.gap_to_turned(other, self_from_other, &self_from_other.rotation.to_rotation_matrix())
    }

    /// [`Self::gap_to`] for a pose whose rotation is also known as a matrix.
    pub(crate) fn gap_to_turned(
        &self,
        other: &Self,
        self_from_other: &Pose,
        rotation: &Rotation3<f64>,
    ) -> f64 {
        let turned = rotation.matrix().abs();
        let between = rotation * other.center + self_from_other.translation.vector - self.center;
        let here = between.abs() - self.half_extents - turned * other.half_extents;
        let back = rotation.inverse() * between;
        let there = back.abs() - other.half_extents - turned.transpose() * self.half_extents;
        let distance = |gap: Vector| {
            if gap.max() > 0.0 { gap.sup(&Vector::zeros()).norm() } else { gap.max() }
        };
        distance(here).max(distance(there))
    }
}

fn midpoint(low: &Point, high: &Point) -> Point {
    low + (high - low) * 0.5
}
