use cranny_spatial::{Point, Vector};
use serde::{Deserialize, Serialize};

/// Where a finger touches the object.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Contact {
    /// The place, in the object's frame.
    pub point_in_object: Point,
    /// The surface's unit normal there, out of the object.
    pub normal_in_object: Vector,
}

/// The least coefficient of friction with which two point contacts hold an object against any force and
/// torque but one about the line between them; infinite where no friction does.
///
/// Two contacts with friction are in force closure exactly if the line between them lies inside both friction cones
/// (Nguyen 1988, "Constructing force-closure grasps", Theorem 5), so this is the tangent of the greater of the two
/// angles between the line and the inward normals. `friction_needed(a, b) = friction_needed(b, a)`.
pub fn friction_needed(a: &Contact, b: &Contact) -> f64 {
    let line = b.point_in_object - a.point_in_object;
    tangent_to(&line, &-a.normal_in_object).max(tangent_to(&line, &b.normal_in_object))
}

/// The score of a grasp that needs the friction `needed` where up to `most` is to be had: 1 if it needs
/// none, 0 if it needs all or more. `s = 1 − needed / most` (the paper's §IV.C).
pub fn friction_score(needed: f64, most: f64) -> f64 {
    (1.0 - needed / most).clamp(0.0, 1.0)
}

/// The tangent of the angle between two vectors; infinite from a right angle on.
fn tangent_to(line: &Vector, normal: &Vector) -> f64 {
    let along = line.dot(normal);
    // A product of lengths keeps its digits near 0, where the angle's cosine would lose them.
    if along > 0.0 { line.cross(normal).norm() / along } else { f64::INFINITY }
}
