use cranny_collision::World;
use cranny_robot::Robot;

/// What had to be repaired in the meshes of links and bodies so that their inside is well defined: a line for
/// each.
pub fn mesh_repairs(robot: &Robot, world: &World) -> Vec<String> {
    let of_links = robot.links().iter().flat_map(|link| {
        link.collisions.iter().map(move |shape| (format!("link '{}'", link.name), &shape.solid))
    });
    let of_bodies = world
        .bodies()
        .iter()
        .flat_map(|body| body.parts.iter().map(move |part| (format!("body '{}'", body.name), &part.solid)));
    let repaired = |(what, solid): (String, &cranny_shape::Solid)| {
        solid.mesh_repairs().map(|repairs| format!("{what}: {repairs}"))
    };
    of_links.chain(of_bodies).filter_map(repaired).collect()
}
