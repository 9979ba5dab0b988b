use cranny_robot::Robot;
use serde::Serialize;

use crate::look::robot_look::{by_material, placed};
use crate::scene::{Node, Role};
use crate::{Colour, Material, Mesh, MeshPiece, Scene, viewer::number_row};

/// Surfaces of a scene on a page.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct PageScene {
    materials: Vec<PageMaterial>,
    meshes: Vec<PageMesh>,
    nodes: Vec<PageNode>,
    collision_shapes: Vec<PageNode>,
}

#[derive(Clone, Debug, Serialize)]
struct PageMaterial {
    name: String,
    colour: [f64; 3],
    opacity: f32,
    metallic: f32,
    roughness: f32,
}

#[derive(Clone, Debug, Serialize)]
struct PageMesh {
    name: String,
    pieces: Vec<PagePiece>,
}

#[derive(Clone, Debug, Serialize)]
struct PagePiece {
    material: usize,
    positions: String,
    normals: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    colours: Option<String>,
    triangles: String,
}

#[derive(Clone, Debug, Serialize)]
struct PageNode {
    name: String,
    parent: Option<usize>,
    parent_from_node: [f64; 7],
    mesh: Option<usize>,
    role: &'static str,
}

/// Colour of the collision geometry of the robot, unique in a scene.
const COLLISION: u32 = 0x007a_5cc8;

impl PageScene {
    /// Collects links, obstacles and target of a scene with their collision geometry. Bodies are drawn as they are checked; for
    /// links, the collision geometry is added to the scene.
    pub fn of(mut scene: Scene, robot: &Robot) -> Self {
        let bodies = |node: &&Node| matches!(node.role, Role::Obstacle(_) | Role::Target);
        let mut collision_shapes: Vec<PageNode> = link_shapes(&mut scene, robot);
        collision_shapes.extend(scene.nodes.iter().filter(bodies).filter_map(PageNode::of));
        Self { collision_shapes, ..Self::of_bodies(&scene) }
    }

    /// Collects the visible surfaces of a scene without collision geometry.
    pub fn of_bodies(scene: &Scene) -> Self {
        Self {
            nodes: scene.nodes.iter().filter_map(PageNode::of).collect(),
            materials: scene.materials.iter().map(PageMaterial::of).collect(),
            meshes: scene.meshes.iter().map(PageMesh::of).collect(),
            collision_shapes: Vec::new(),
        }
    }
}

/// Returns one node for each link with collision geometry, below the node of the link.
fn link_shapes(scene: &mut Scene, robot: &Robot) -> Vec<PageNode> {
    let material = scene.material(Material::matt("collision shape", Colour::hex(COLLISION)));
    let mut nodes = Vec::new();
    for (index, link) in robot.links().iter().enumerate() {
        let pieces = link.collisions.iter().filter_map(|shape| {
            let soup = shape.solid.tessellation()?;
            Some(placed(MeshPiece::of_soup(&soup, material), &shape.link_from_shape))
        });
        let pieces = by_material(pieces.collect());
        if pieces.is_empty() {
            continue;
        }
        nodes.push(PageNode {
            name: link.name.clone(),
            parent: Some(index),
            parent_from_node: number_row::pose(&cranny_spatial::Pose::identity()),
            mesh: Some(scene.mesh(format!("{}, collision shape", link.name), pieces)),
            role: "link",
        });
    }
    nodes
}

impl PageNode {
    /// Converts a node; `None` for grasps and the gripper path, which the page draws itself.
    fn of(node: &Node) -> Option<Self> {
        let role = match node.role {
            Role::Link(_) => "link",
            Role::Obstacle(_) => "obstacle",
            Role::Target => "target",
            Role::Grasp { .. } | Role::GripperPath => return None,
        };
        Some(Self {
            name: node.name.clone(),
            parent: node.parent,
            parent_from_node: number_row::pose(&node.parent_from_node),
            mesh: node.mesh,
            role,
        })
    }
}

impl PageMaterial {
    fn of(material: &Material) -> Self {
        let Material { name, colour, opacity, metallic, roughness } = material;
        Self {
            name: name.clone(),
            colour: colour.to_srgb(),
            opacity: *opacity,
            metallic: *metallic,
            roughness: *roughness,
        }
    }
}

impl PageMesh {
    fn of(mesh: &Mesh) -> Self {
        Self { name: mesh.name.clone(), pieces: mesh.pieces.iter().map(PagePiece::of).collect() }
    }
}

impl PagePiece {
    fn of(piece: &MeshPiece) -> Self {
        let piece = piece.welded();
        let colours = piece.colours.iter().flat_map(|colour| colour.0);
        Self {
            material: piece.material,
            positions: number_row::floats32(piece.positions.iter().copied().flatten()),
            normals: number_row::floats32(piece.normals.iter().copied().flatten()),
            colours: (!piece.colours.is_empty()).then(|| number_row::floats32(colours)),
            triangles: number_row::unsigned32(piece.triangles.iter().copied().flatten()),
        }
    }
}
