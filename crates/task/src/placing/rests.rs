use cranny_collision::{Body, Extent};
use cranny_shape::{Outline, TriangleSoup, stable_poses};
use cranny_spatial::{Rotation, Vector};

/// Ways to rest that are less likely when the object is dropped are not asked for.
const LEAST_PROBABILITY: f64 = 0.05;
/// At rest, an object is within this of a stable pose, as the chord of an angle (rad): such a one is tried first.
const AS_IT_RESTS_RAD: f64 = 0.1;

/// The rotations of a body's first solid in which it rests on level ground, turns about the vertical aside, from a frame
/// whose z axis is up: those that are likely ([`stable_rests`]), first the one in which it is now. A sphere rests in any,
/// and so does, for want of better, what has no volume: of these the present one.
pub(crate) fn rests(body: &Body, extent: &Extent, level_from_world: &Rotation) -> Vec<Rotation> {
    stable_rests(body, extent, level_from_world, LEAST_PROBABILITY).unwrap_or_else(|| {
        body.parts
            .first()
            .map(|first| level_from_world * first.world_from_solid.rotation)
            .into_iter()
            .collect()
    })
}

/// The rotations of all stable poses of a body ([`stable_poses`]) of at least this probability, with the centre of
/// mass that its extent gives, first the one in which it is now, which is among them in any case;
/// `None` for a sphere and for what has no volume.
pub(crate) fn stable_rests(
    body: &Body,
    extent: &Extent,
    level_from_world: &Rotation,
    least_probability: f64,
) -> Option<Vec<Rotation>> {
    let first = body.parts.first()?;
    let now = level_from_world * first.world_from_solid.rotation;
    let is_sphere = |outline| matches!(outline, Outline::Segment { half_length_m: 0.0, .. });
    if body.parts.len() == 1 && is_sphere(first.solid.outline()) {
        return None;
    }
    let held_from_world = first.world_from_solid.inverse();
    let mut mesh = TriangleSoup::default();
    for part in &body.parts {
        mesh.append(&part.solid.tessellation()?, &(held_from_world * part.world_from_solid));
    }
    let stable = stable_poses(&mesh.vertices, &extent.center_of_mass()).ok()?;
    let up_now = now.inverse() * Vector::z();
    let is_now = |rest: &Rotation| (rest.inverse() * Vector::z() - up_now).norm() < AS_IT_RESTS_RAD;
    let rotations = stable.iter().enumerate().filter_map(|(index, pose)| {
        let rest = pose.ground_from_body.rotation;
        let is_likely = index == 0 || pose.probability >= least_probability;
        (is_likely || is_now(&rest)).then_some(rest)
    });
    let mut rests: Vec<Rotation> = rotations.collect();
    rests.sort_by_key(|rest| !is_now(rest));
    Some(rests)
}
