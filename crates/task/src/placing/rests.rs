use cranny_collision::{Body, Extent};
use cranny_shape::{Outline, TriangleSoup, stable_poses};
use cranny_spatial::{Rotation, Vector};

/// Least probability with which a dropped object comes to rest in a stable pose that is used.
const LEAST_PROBABILITY: f64 = 0.05;
/// Least tilt, in radians (5°), that a stable pose other than the present one must withstand.
const LEAST_TILT_RAD: f64 = 0.0873;
/// Maximum angle, as a chord (rad), from the present pose within which a stable pose is always included and comes first.
const AS_IT_RESTS_RAD: f64 = 0.1;

/// Returns the rotations of a body's first solid, up to turns about the vertical, in which it rests on level ground, from a
/// frame with z upwards: those that are likely ([`stable_rests`]) and withstand a tilt of 5°, the present one first. For a
/// sphere, a body without volume, and one that withstands no such tilt, it returns only the present rotation.
pub(crate) fn rests(body: &Body, extent: &Extent, level_from_world: &Rotation) -> Vec<Rotation> {
    let stable = stable_rests(body, extent, level_from_world, [LEAST_PROBABILITY, LEAST_TILT_RAD]);
    stable.filter(|rests| !rests.is_empty()).unwrap_or_else(|| {
        body.parts
            .first()
            .map(|first| level_from_world * first.world_from_solid.rotation)
            .into_iter()
            .collect()
    })
}

/// Returns the rotations of all stable poses of a body ([`stable_poses`]) of at least this probability and tilt (rad), with the
/// centre of mass from its extent. The present one comes first and is always included; `None` for a sphere and for a body
/// without volume.
pub(crate) fn stable_rests(
    body: &Body,
    extent: &Extent,
    level_from_world: &Rotation,
    [least_probability, least_tilt_rad]: [f64; 2],
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
        let is_steady = pose.tilt_rad.is_some_and(|tilt_rad| tilt_rad >= least_tilt_rad);
        ((is_likely && is_steady) || is_now(&rest)).then_some(rest)
    });
    let mut rests: Vec<Rotation> = rotations.collect();
    rests.sort_by_key(|rest| !is_now(rest));
    Some(rests)
}

#[cfg(test)]
mod tests {
    use cranny_shape::Solid;
    use cranny_spatial::Pose;

    use super::*;

    #[test]
    fn a_thin_plate_is_not_put_on_its_edge_unless_it_stands_so_now() {
        let count = |thickness_m: f64, now: Rotation| {
            let plate = Solid::cuboid(Vector::new(0.05, 0.05, 0.5 * thickness_m)).unwrap();
            let pose = Pose::from_parts(Vector::zeros().into(), now);
            let body = Body::new("plate", pose, plate);
            let extent = Extent::of(&body).unwrap();
            let rests = |least_tilt_rad: f64| {
                stable_rests(&body, &extent, &Rotation::identity(), [0.0, least_tilt_rad]).unwrap().len()
            };
            (rests(0.0), rests(LEAST_TILT_RAD))
        };
        let on_edge = Rotation::from_axis_angle(&Vector::x_axis(), std::f64::consts::FRAC_PI_2);
        // Edges of 8 mm withstand a tilt of 4.6°, those of 10 mm one of 5.7°.
        assert_eq!(count(0.008, Rotation::identity()), (6, 2));
        assert_eq!(count(0.008, on_edge), (6, 3));
        assert_eq!(count(0.010, Rotation::identity()), (6, 6));
    }
}
