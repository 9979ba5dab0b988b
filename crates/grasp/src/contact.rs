use cranny_spatial::{Point, Vector};
use serde::{Deserialize, Serialize};

/// Contact of a finger with the object.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Contact {
    /// Position, in the object's frame.
    pub point_in_object: Point,
    /// Unit normal of the surface there, out of the object.
    pub normal_in_object: Vector,
}

/// Minimum coefficient of friction with which two point contacts hold an object against any force and torque except one
/// about the line between them; infinite if no friction suffices.
///
/// Two contacts with friction are in force closure exactly if the line between them lies inside both friction cones
/// (Nguyen 1988, "Constructing force-closure grasps", Theorem 5), so this is the tangent of the greater of the two angles
/// between the line and the inward normals. `friction_needed(a, b) = friction_needed(b, a)`.
pub fn friction_needed(a: &Contact, b: &Contact) -> f64 {
    let line = b.point_in_object - a.point_in_object;
    tangent_to(&line, &-a.normal_in_object).max(tangent_to(&line, &b.normal_in_object))
}

/// Score of a grasp that needs the friction `needed` of an available `most`: 1 if it needs none, 0 if it needs all or
/// more. `s = 1 − needed / most` (the paper's §IV.C).
pub fn friction_score(needed: f64, most: f64) -> f64 {
    (1.0 - needed / most).clamp(0.0, 1.0)
}

/// Tangent of the angle between two vectors; infinite from a right angle on.
fn tangent_to(line: &Vector, normal: &Vector) -> f64 {
    let along = line.dot(normal);
    // A product of lengths keeps its digits near 0, where the angle's cosine would lose them.
    if along > 0.0 { line.cross(normal).norm() / along } else { f64::INFINITY }
}
