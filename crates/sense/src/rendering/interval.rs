use cranny_shape::Outline;
use cranny_spatial::{Point, Vector};

/// Interval of the parameter t of a ray, origin + t · direction, within a convex set; empty if `from > to`.
#[derive(Clone, Copy, Debug)]
struct Interval {
    from: f64,
    to: f64,
}

const EVERYWHERE: Interval = Interval { from: f64::NEG_INFINITY, to: f64::INFINITY };
const NOWHERE: Interval = Interval { from: f64::INFINITY, to: f64::NEG_INFINITY };

impl Interval {
    fn and(self, other: Self) -> Self {
        Self { from: self.from.max(other.from), to: self.to.min(other.to) }
    }

    /// Returns the first parameter that is not negative; 0 if the origin lies within the set.
    fn first(self) -> Option<f64> {
        (self.from <= self.to && self.to >= 0.0).then(|| self.from.max(0.0))
    }
}

/// Side of a solid on which a ray crosses its surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Side {
    /// The ray enters it.
    Front,
    /// The ray leaves it.
    Back,
}

/// Returns the parameter t ≥ 0 at which a ray, in the frame of a solid of this outline, first meets it, 0 from inside, or leaves it,
/// [`f64::MAX`] if it never does. `None` for a miss, and for a hull or a mesh.
pub(crate) fn meeting(outline: &Outline, origin: &Point, direction: &Vector, side: Side) -> Option<f64> {
    let of = |interval: Interval| match side {
        Side::Front => interval.first(),
        Side::Back => interval.first().map(|_| interval.to.min(f64::MAX)),
    };
    match *outline {
        Outline::Cuboid { half_extents } => {
            let slab = |axis: usize| slab(origin[axis], direction[axis], half_extents[axis]);
            of(slab(0).and(slab(1)).and(slab(2)))
        }
        Outline::Segment { half_length_m, radius_m } => {
            let end = |z: f64| of(ball(&(origin - Vector::z() * z), direction, radius_m));
            if half_length_m <= 0.0 {
                return end(0.0);
            }
            let middle = tube(origin, direction, radius_m).and(slab(origin.z, direction.z, half_length_m));
            let all = [of(middle), end(half_length_m), end(-half_length_m)].into_iter().flatten();
            all.reduce(|a, b| if side == Side::Front { a.min(b) } else { a.max(b) })
        }
        Outline::Cylinder { half_length_m, radius_m } => {
            of(tube(origin, direction, radius_m).and(slab(origin.z, direction.z, half_length_m)))
        }
        Outline::HalfSpace => of(below(origin.z, direction.z)),
        Outline::Union | Outline::Other => None,
    }
}

/// Points with |x| ≤ `half` on a line x = origin + t · direction.
fn slab(origin: f64, direction: f64, half: f64) -> Interval {
    if direction == 0.0 {
        return if origin.abs() <= half { EVERYWHERE } else { NOWHERE };
    }
    let (a, b) = ((-half - origin) / direction, (half - origin) / direction);
    Interval { from: a.min(b), to: a.max(b) }
}

/// Points with x ≤ 0 on a line.
fn below(origin: f64, direction: f64) -> Interval {
    if direction == 0.0 {
        return if origin <= 0.0 { EVERYWHERE } else { NOWHERE };
    }
    let at = -origin / direction;
    if direction > 0.0 { Interval { to: at, ..EVERYWHERE } } else { Interval { from: at, ..EVERYWHERE } }
}

/// Points within a ball around the origin.
fn ball(origin: &Point, direction: &Vector, radius_m: f64) -> Interval {
    round(origin.coords, *direction, radius_m)
}

/// Points within the infinite cylinder about z.
fn tube(origin: &Point, direction: &Vector, radius_m: f64) -> Interval {
    round(Vector::new(origin.x, origin.y, 0.0), Vector::new(direction.x, direction.y, 0.0), radius_m)
}

/// Points of a line within a distance of 0. Computed from the point of the line that is nearest to 0, so that no digits are
/// lost where the origin is far away.
fn round(origin: Vector, direction: Vector, radius_m: f64) -> Interval {
    let squared = direction.norm_squared();
    if squared == 0.0 {
        return if origin.norm() <= radius_m { EVERYWHERE } else { NOWHERE };
    }
    let nearest = -origin.dot(&direction) / squared;
    let left = radius_m * radius_m - (origin + direction * nearest).norm_squared();
    if left < 0.0 {
        return NOWHERE;
    }
    let half = (left / squared).sqrt();
    Interval { from: nearest - half, to: nearest + half }
}

#[cfg(test)]
mod tests {
    use cranny_shape::{Range, Solid, separation_in};
    use cranny_spatial::{Pose, Stream};
    use proptest::prelude::*;

    use super::*;

    fn solid(kind: usize, size: [f64; 3]) -> Solid {
        let [a, b, c] = size;
        match kind {
            0 => Solid::cuboid(Vector::new(a, b, c)),
            1 => Solid::sphere(a),
            2 => Solid::capsule(a, b),
            _ => Solid::cylinder(a, b),
        }
        .expect("positive sizes")
    }

    proptest! {
        /// Oracle: the distance of a tiny ball on the ray, by the distances of the collision check.
        #[test]
        fn a_meeting_is_the_first_contact_along_the_ray(seed in any::<u64>(), kind in 0_usize..4) {
            let mut random = Stream::new(seed, 0);
            let solid = solid(kind, std::array::from_fn(|_| random.uniform_between(0.05, 0.5)));
            let origin = Point::from(Vector::from_fn(|_, _| random.uniform_between(-2.0, 2.0)));
            let aim = Vector::from_fn(|_, _| random.uniform_between(-0.5, 0.5));
            let direction = aim - origin.coords;
            let probe = Solid::sphere(1e-6).expect("a positive radius");
            let distance_m = |t: f64| {
                let at = Pose::from_parts((origin.coords + direction * t).into(), cranny_spatial::Rotation::identity());
                separation_in(&solid, &Pose::identity(), &probe, &at, Range::to(10.0)).upper_m
            };
            let [met, left] =
                [Side::Front, Side::Back].map(|side| meeting(&solid.outline(), &origin, &direction, side));
            let end = met.unwrap_or(2.0);
            for step in 0..40 {
                let t = end * f64::from(step) / 40.0;
                if (end - t) * direction.norm() > 1e-5 {
                    prop_assert!(distance_m(t) > 0.0, "inside at {t} before {met:?}");
                }
            }
            if let Some(t) = met {
                prop_assert!(distance_m(t) <= 2e-6, "not on the surface at {t}: {}", distance_m(t));
            }
            prop_assert_eq!(met.is_some(), left.is_some());
            if let Some((met, left)) = met.zip(left) {
                prop_assert!(distance_m(0.5 * (met + left)) <= 2e-6 && distance_m(left) <= 2e-6);
                // A grazing ray is still within the probe's radius just behind.
                prop_assert!(distance_m(left + 0.1 / direction.norm()) > 0.0, "inside after {left}");
            }
        }
    }

    #[test]
    fn a_half_space_begins_at_its_plane() {
        let down = Vector::new(0.3, 0.0, -0.5);
        let met = meeting(&Outline::HalfSpace, &Point::new(0.0, 0.0, 1.0), &down, Side::Front);
        assert!((met.unwrap() - 2.0).abs() < 1e-15);
        assert!(meeting(&Outline::HalfSpace, &Point::new(0.0, 0.0, 1.0), &-down, Side::Front).is_none());
        assert_eq!(meeting(&Outline::HalfSpace, &Point::new(0.0, 0.0, -1.0), &down, Side::Front), Some(0.0));
    }
}
