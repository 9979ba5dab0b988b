//! Law of one spring of a pad: its force on the object, from its deflection.

use cranny_spatial::nalgebra::{Matrix2, Matrix3, Vector2, Vector3};

/// Force of a spring on the object in the frame of the pad (two directions along it, and inward), and its derivative.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Grip {
    /// In newtons; zero without contact.
    pub force: Vector3<f64>,
    /// Derivative of the force with respect to a displacement of the pad against the object, in N/m.
    pub stiffness: Matrix3<f64>,
    /// Displacement of the tip along the pad by sliding, in metres; `None` if it sticks.
    pub slid_m: Option<Vector2<f64>>,
}

/// Stiffness of a tip that slides.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Law {
    /// Derivative of the force: none in the direction of sliding.
    Tangent,
    /// Ratio of force to displacement.
    Secant,
}

/// Maximum depth of a spring, in metres: behind it, a finger is rigid.
pub(crate) const DEEPEST_M: f64 = 5e-3;
/// Minimum component of the normal against the pad: on steeper slopes a tip slides as on this one.
const LEAST_FACING: f64 = 0.3;

/// Returns the force of a spring of this stiffness (N/m; across and along the pad) with this deflection (m; depth, and
/// displacement of the tip along the pad), whose tip lies on a surface with this outward normal and friction.
///
/// The tip bears a force within the cone of friction about the normal. With a depth, and so a force across the pad, the
/// forces along the pad within the cone form a conic. A tip beyond it slides towards the force without friction.
pub(crate) fn grip(
    (across, along): (f64, f64),
    (depth_m, tip_m): (f64, Vector2<f64>),
    (normal, friction): (&Vector3<f64>, f64),
    law: Law,
) -> Grip {
    let pressed_n = across * depth_m;
    if pressed_n <= 0.0 {
        return Grip::NONE;
    }
    let facing = (-normal.z).clamp(LEAST_FACING, 1.0);
    let aside =
        normal.xy().try_normalize(0.0).map_or(Vector2::zeros(), |unit| unit * (1.0 - facing * facing).sqrt());
    let sheared = tip_m * -along;
    let force = Vector3::new(sheared.x, sheared.y, pressed_n);
    let stiffness = Matrix3::from_diagonal(&Vector3::new(along, along, across));
    let sticking = Grip { force, stiffness, slid_m: None };
    // Component of the force along the inward normal.
    let normal_n = pressed_n * facing - sheared.dot(&aside);
    if normal_n >= 0.0 && force.norm_squared() <= (1.0 + friction * friction) * normal_n * normal_n {
        return sticking;
    }
    let without_friction = aside * (-1.0 / facing);
    let pull = sheared - without_friction * pressed_n;
    let toward = pull.try_normalize(0.0).unwrap_or_else(Vector2::zeros);
    let most = reach(friction, facing, aside.dot(&toward));
    if pull.norm() <= most * pressed_n {
        // Within rounding of the cone.
        return sticking;
    }
    let per_press = without_friction + toward * most;
    // The depth changes with the slope on which the tip slides.
    let slope = aside / facing;
    let yielding = 1.0 - across / along * slope.dot(&per_press);
    let pressed_n = across * (depth_m + slope.dot(&tip_m)) / yielding;
    if pressed_n <= 0.0 || yielding <= 0.0 {
        return Grip::NONE;
    }
    let borne = per_press * pressed_n;
    let by_tip = slope * (across / yielding);
    let constant = match law {
        Law::Tangent => toward * toward.transpose(),
        Law::Secant => Matrix2::zeros(),
    };
    let turning = (Matrix2::identity() - constant) * (most * pressed_n / pull.norm());
    let mut stiffness = Matrix3::zeros();
    stiffness[(2, 2)] = across / yielding;
    stiffness.fixed_view_mut::<1, 2>(2, 0).copy_from(&-by_tip.transpose());
    stiffness.fixed_view_mut::<2, 2>(0, 0).copy_from(&(turning * along - per_press * by_tip.transpose()));
    stiffness.fixed_view_mut::<2, 1>(0, 2).copy_from(&(per_press * (across / yielding)));
    let slid_m = Some(-borne / along - tip_m);
    Grip { force: Vector3::new(borne.x, borne.y, pressed_n), stiffness, slid_m }
}

impl Grip {
    /// No contact.
    const NONE: Self = Self {
        force: Vector3::new(0.0, 0.0, 0.0),
        stiffness: Matrix3::new(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
        slid_m: None,
    };
}

/// Distance of the cone of friction from the force without friction, along a direction in the pad, per force across the pad.
/// `leaning`: component of the normal in that direction.
fn reach(friction: f64, facing: f64, leaning: f64) -> f64 {
    let squared = friction * friction;
    let curve = 1.0 - (1.0 + squared) * leaning * leaning;
    let slope = squared * leaning / facing;
    let end = squared / (facing * facing);
    let root = slope * slope + curve * end;
    let below = slope + root.max(0.0).sqrt();
    if root < 0.0 || below <= 0.0 { f64::INFINITY } else { end / below }
}
