//! Balls about the shapes of colliders, kept in their user data: most pairs of a hand and an object are apart.

use rapier3d_f64::math::Vector;
use rapier3d_f64::prelude::{Collider, Shape};

/// Ball about a shape, in the frame of its collider, rounded outwards to single precision.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct BoundingBall {
    center: Vector,
    radius_m: f64,
}

/// Maximum gap of a predicted contact, in metres.
pub(crate) const PREDICTION_M: f64 = 0.002;
/// Maximum error of a coordinate up to 10 m in single precision, in metres.
const ROUNDING_M: f64 = 1e-6;

impl BoundingBall {
    /// Ball about a shape; `None` if it is not bounded by one of at most 10 m near its frame.
    pub fn of(shape: &dyn Shape) -> Option<Self> {
        let ball = shape.compute_local_bounding_sphere();
        let extent_m = ball.center.length() + ball.radius;
        (extent_m < 10.0).then_some(Self { center: ball.center, radius_m: ball.radius + 2.0 * ROUNDING_M })
    }

    /// Packs the ball; never 0, because its radius is positive.
    #[allow(clippy::cast_possible_truncation, reason = "rounded outwards by the constructor")]
    pub fn into_bits(self) -> u128 {
        let Vector { x, y, z } = self.center;
        [x, y, z, self.radius_m]
            .iter()
            .fold(0, |bits, value| bits << 32 | u128::from((*value as f32).to_bits()))
    }

    /// Unpacks a ball; `None` for 0.
    fn from_bits(bits: u128) -> Option<Self> {
        let value =
            |place: u32| u32::try_from((bits >> (32 * place)) & u128::from(u32::MAX)).map(f32::from_bits);
        let [radius_m, z, y, x] = [0, 1, 2, 3].map(|place| value(place).map_or(0.0, f64::from));
        (bits != 0).then(|| Self { center: Vector::new(x, y, z), radius_m })
    }
}

/// Returns true if two colliders are too far apart for a contact. A cuboid is measured exactly, another shape by its ball.
pub(crate) fn are_apart(first: &Collider, second: &Collider) -> bool {
    let balls = BoundingBall::from_bits(first.user_data).zip(BoundingBall::from_bits(second.user_data));
    let Some((first_ball, second_ball)) = balls else { return false };
    is_beyond(first, &first_ball, second, &second_ball) || is_beyond(second, &second_ball, first, &first_ball)
}

/// Returns true if the ball of `other` is beyond the reach of contacts with `own`.
fn is_beyond(own: &Collider, own_ball: &BoundingBall, other: &Collider, ball: &BoundingBall) -> bool {
    let center = other.position().transform_point(ball.center);
    let center = own.position().inverse_transform_point(center);
    let (gap, radius_m) = match own.shape().as_cuboid() {
        Some(cuboid) => ((center.abs() - cuboid.half_extents).max(Vector::ZERO), 0.0),
        None => (center - own_ball.center, own_ball.radius_m),
    };
    gap.length() > radius_m + ball.radius_m + PREDICTION_M
}

#[cfg(test)]
mod tests {
    use rapier3d_f64::math::Pose;
    use rapier3d_f64::parry::query;
    use rapier3d_f64::prelude::{ColliderBuilder, SharedShape};

    use super::*;

    /// Colliders that are judged apart are farther apart than a contact reaches, whatever their pose.
    #[test]
    fn colliders_that_touch_are_never_apart() {
        let shapes = [
            SharedShape::cuboid(0.02, 0.01, 0.03),
            SharedShape::ball(0.03),
            SharedShape::capsule_y(0.05, 0.004),
            SharedShape::convex_hull(
                &[[0.0, 0.1, 0.0], [0.05, 0.1, 0.0], [0.0, 0.13, 0.01], [0.0, 0.1, 0.04]].map(Vector::from),
            )
            .unwrap(),
        ];
        let collider = |shape: &SharedShape, pose: Pose| {
            let bits = BoundingBall::of(&**shape).unwrap().into_bits();
            ColliderBuilder::new(shape.clone()).position(pose).user_data(bits).build()
        };
        let (mut apart, mut near) = (0, 0);
        for step in 0..4000_u32 {
            let at = |k: u32| f64::from((step * (2 * k + 1) * 37) % 101) / 101.0 - 0.5;
            let [first, second] = [0, 1].map(|side| {
                let turn = Vector::new(at(side + 1), at(side + 3), at(side + 5)) * 6.0;
                let place = Vector::new(at(side + 7), at(side + 9), at(side + 11)) * 0.15;
                let shape = &shapes[(step as usize >> (2 * side)) % shapes.len()];
                collider(shape, Pose::new(place, turn))
            });
            let found =
                query::distance(first.position(), first.shape(), second.position(), second.shape()).unwrap();
            if are_apart(&first, &second) {
                apart += 1;
                assert!(found.distance > PREDICTION_M, "{found:?} {first:?} {second:?}");
            } else {
                near += 1;
            }
        }
        assert!(apart > 500 && near > 500, "{apart} {near}");
    }
}
