use cranny_collision::World;
use cranny_robot::Robot;
use cranny_shape::Solid;

/// Returns the mesh repairs of links and bodies that were needed to define their inside: a line for each mesh.
pub fn mesh_repairs(robot: &Robot, world: &World) -> Vec<String> {
    [link_repairs(robot), body_repairs(world)].concat()
}

/// Returns the mesh repairs of links.
pub fn link_repairs(robot: &Robot) -> Vec<String> {
    let of_link = |link: &cranny_robot::Link| {
        let name = link.name.clone();
        link.collisions.iter().filter_map(|shape| line("link", &name, &shape.solid)).collect::<Vec<_>>()
    };
    robot.links().iter().flat_map(of_link).collect()
}

/// Returns the mesh repairs of bodies.
pub fn body_repairs(world: &World) -> Vec<String> {
    let parts = world.bodies().iter().flat_map(|body| body.parts.iter().map(move |part| (body, part)));
    parts.filter_map(|(body, part)| line("body", &body.name, &part.solid)).collect()
}

fn line(kind: &str, name: &str, solid: &Solid) -> Option<String> {
    solid.mesh_repairs().map(|repairs| format!("{kind} '{name}': {repairs}"))
}
