use cranny_shape::Aabb;
use cranny_spatial::{Point, Vector};

use crate::drawing::draw_list::DrawPoint;
use crate::scene::{Node, Role};
use crate::{Camera, Mesh, Scene, StandardView};

impl Scene {
    /// Returns the camera of a standard view, with all things and the robot's whole motion in it; `aspect` = width / height.
    pub fn camera(&self, view: StandardView, aspect: f64) -> Camera {
        self.camera_from(view.direction_deg(), aspect)
    }

    /// Returns the camera for any direction, in degrees: azimuth about z from x, and elevation above the ground.
    pub fn camera_from(&self, direction_deg: (f64, f64), aspect: f64) -> Camera {
        Camera::framing(direction_deg, &self.focus(), aspect)
    }

    /// Returns the camera for any direction, farther away so that every obstacle is entirely in the picture.
    pub fn whole_camera_from(&self, direction_deg: (f64, f64), aspect: f64) -> Camera {
        Camera::framing(direction_deg, &self.outline(|_| true), aspect)
    }

    /// Returns corners of boxes around robot and target over the whole motion, and around the nearby obstacles.
    fn focus(&self) -> Vec<Point> {
        let matters = |role| !matches!(role, Role::Obstacle(_));
        let mut points = self.outline(matters);
        if points.is_empty() {
            return self.outline(|_| true);
        }
        let near = Aabb::around(&points, NEAR_M);
        let obstacles = self.outline(|role| matches!(role, Role::Obstacle(_)));
        points.extend(
            obstacles
                .chunks_exact(8)
                .filter_map(|corners| {
                    let around = Aabb::around(corners, 0.0);
                    let (low, high) = (around.low().sup(&near.low()), around.high().inf(&near.high()));
                    ((high - low).min() > 0.0).then(|| {
                        let part = [low, high];
                        (0..8_usize)
                            .map(move |i| Point::new(part[i & 1].x, part[i >> 1 & 1].y, part[i >> 2].z))
                    })
                })
                .flatten(),
        );
        points
    }

    /// Returns corners of boxes around everything of some roles over the whole motion, eight for each.
    fn outline(&self, counts: impl Fn(Role) -> bool) -> Vec<Point> {
        let last = self.last_frame();
        let instants =
            [None, last.map(|_| 0), last.map(|last| last / 3), last.map(|last| 2 * last / 3), last];
        let mut points = Vec::new();
        let boxes: Vec<Option<Aabb>> = self.meshes.iter().map(mesh_box).collect();
        for instant in instants {
            let poses = self.world_from_nodes(instant);
            for (node, pose) in self.nodes.iter().zip(&poses) {
                if matches!(node.role, Role::Grasp { .. }) || !counts(node.role) {
                    continue;
                }
                let Some(around) = node.mesh.and_then(|mesh| boxes[mesh]) else { continue };
                for corner in 0..8_u8 {
                    let sign = |bit: u8| if corner & bit == 0 { -1.0 } else { 1.0 };
                    let offset = Vector::new(sign(1), sign(2), sign(4)).component_mul(&around.half_extents);
                    points.push(pose * (around.center + offset));
                }
            }
        }
        points
    }

    /// Returns the centre of the scene on the ground and its radius, in metres.
    pub(crate) fn middle(&self) -> (DrawPoint, f32) {
        let points = self.outline(|_| true);
        if points.is_empty() {
            return (DrawPoint::origin(), 1.0);
        }
        let around = Aabb::around(&points, 0.0);
        let low = Point::new(around.center.x, around.center.y, around.low().z);
        let reach_m = 0.75 * around.half_extents.xy().norm();
        #[allow(clippy::cast_possible_truncation, reason = "single precision is what is meant")]
        (low.cast(), (reach_m as f32).max(0.01))
    }

    /// Returns the nodes of obstacles between the eye and the target, the robot, or the path of its gripper, in ascending order.
    pub(crate) fn hiding(&self, camera: &Camera) -> Vec<usize> {
        let poses = self.world_from_nodes(None);
        let mut wanted: Vec<Point> = Vec::new();
        for (node, pose) in self.nodes.iter().zip(&poses) {
            if node.role == Role::Target
                && let Some(around) = node.mesh.and_then(|mesh| mesh_box(&self.meshes[mesh]))
            {
                // Only the upper half counts, so that the support of the target does not hide it.
                let around = around.transformed(pose);
                let (low, high) = (around.low(), around.high());
                wanted.push(around.center);
                wanted.extend([low.x, high.x].iter().flat_map(|&x| {
                    [low.y, high.y].map(|y| Point::new(x, y, 0.3 * around.center.z + 0.7 * high.z))
                }));
            }
        }
        // These are the robot at its start and at its end.
        for instant in [None, self.last_frame()] {
            let is_seen = |node: &Node| matches!(node.role, Role::Link(_)) && node.mesh.is_some();
            let links = self.nodes.iter().zip(self.world_from_nodes(instant));
            wanted.extend(
                links.filter(|(node, _)| is_seen(node)).map(|(_, pose)| Point::from(pose.translation.vector)),
            );
        }
        if let Some(motion) = &self.motion {
            // The whole path counts at every instant, so that obstacles do not turn translucent during the motion.
            let stride = (motion.gripper_path.len() / PATH_POINTS).max(1);
            wanted.extend(motion.gripper_path.iter().rev().step_by(stride));
        }
        let stride = wanted.len().div_ceil(MOST_WANTED).max(1);
        let wanted: Vec<Point> = wanted.into_iter().step_by(stride).collect();
        let hides = |(index, node): &(usize, &Node)| {
            let (Role::Obstacle(_), Some(mesh)) = (node.role, node.mesh) else { return false };
            let Some(around) = mesh_box(&self.meshes[mesh]) else { return false };
            let node_from_world = poses[*index].inverse();
            let eye = node_from_world * camera.eye;
            wanted.iter().any(|point| is_crossed(&around, &eye, &(node_from_world * point)))
        };
        self.nodes.iter().enumerate().filter(hides).map(|(index, _)| index).collect()
    }

    /// Returns the instants of the translucent robots that show the motion up to `frame`, equally spaced along the path of the
    /// gripper, from the start on, or from the closing of the hand if an object is then carried.
    pub(crate) fn ghost_frames(&self, frame: Option<usize>, count: usize) -> Vec<usize> {
        let (Some(motion), Some(frame)) = (&self.motion, frame) else { return Vec::new() };
        // Bodies that move without a hand have no gripper path.
        let Some(way) = motion.gripper_path.get(..=frame) else { return Vec::new() };
        let steps = way.windows(2).map(|pair| (pair[1] - pair[0]).norm());
        let mut travelled = vec![0.0];
        for step in steps {
            travelled.push(travelled.last().copied().unwrap_or(0.0) + step);
        }
        let closed = motion
            .modes
            .get(1)
            .map_or(0, |onward| motion.times_s.partition_point(|&time_s| time_s < onward.from_s));
        let begin = if closed < frame { closed } else { 0 };
        let (before, whole) = (travelled[begin], travelled[frame] - travelled[begin]);
        let at =
            |share: f64| travelled.partition_point(|&way| way < before + share * whole).clamp(begin, frame);
        let mut frames: Vec<usize> = (0..count).map(|ghost| at(ghost as f64 / count as f64)).collect();
        frames.dedup();
        frames.retain(|&ghost| ghost < frame);
        frames
    }

    /// Returns the opacity of a mesh, the minimum over its materials.
    pub(crate) fn opacity(&self, mesh: &Mesh) -> f32 {
        mesh.pieces.iter().map(|piece| self.materials[piece.material].opacity).fold(1.0, f32::min)
    }
}

/// Margin around robot and target, in metres, beyond which obstacles may lie outside the picture.
const NEAR_M: f64 = 0.3;

/// Number of sampled points of the gripper path that should be visible.
const PATH_POINTS: usize = 12;

/// Maximum number of points that should be visible, so that a robot of many links, or a target of many components, among many
/// obstacles takes no more time than others: ten times those of a usual scene.
const MOST_WANTED: usize = 256;

/// Returns the bounding box of a mesh; `None` for a mesh without corners.
fn mesh_box(mesh: &Mesh) -> Option<Aabb> {
    let points = || mesh.pieces.iter().flat_map(|piece| &piece.positions);
    let points: Vec<Point> = points().map(|p| p.map(f64::from).into()).collect();
    (!points.is_empty()).then(|| Aabb::around(&points, 0.0))
}

/// Returns true if the segment between two points in the frame of the box crosses the box (slab method: Kay & Kajiya 1986, "Ray
/// tracing complex scenes", whole; Ericson 2005, §5.3.3).
fn is_crossed(around: &Aabb, from: &Point, to: &Point) -> bool {
    let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
    for axis in 0..3 {
        let (begin, step) = (from[axis] - around.center[axis], to[axis] - from[axis]);
        let half = around.half_extents[axis];
        if step.abs() < 1e-12 {
            if begin.abs() > half {
                return false;
            }
            continue;
        }
        let (a, b) = ((-half - begin) / step, (half - begin) / step);
        enter = enter.max(a.min(b));
        leave = leave.min(a.max(b));
    }
    enter < leave
}

#[cfg(test)]
mod tests {
    use strum::VariantArray as _;

    use cranny_scenario::{OpenOptions, Scenario};

    use super::*;
    use crate::SceneSettings;

    fn scene(id: &str) -> Scene {
        let scenario = Scenario::open(id, &OpenOptions::default()).expect("a built-in scenario");
        Scene::of_task(&scenario, None, &SceneSettings::default()).expect("a scene")
    }

    /// Regression test: the gates hid the robots on the sheet of all scenarios.
    #[test]
    fn an_obstacle_before_the_robot_can_be_seen_through() {
        for id in ["041", "045", "031"] {
            let scene = scene(id);
            let camera = scene.camera(StandardView::ThreeQuarter, 4.0 / 3.0);
            let hiding = scene.hiding(&camera);
            let names: Vec<&str> = hiding.iter().map(|&node| scene.nodes[node].name.as_str()).collect();
            assert!(
                names.iter().any(|name| ["gate", "left wall", "right wall"].contains(name)),
                "{id}: {names:?}"
            );
            assert!(!names.contains(&"pedestal"), "{id}: it hides nothing");
        }
    }

    /// Regression test: the table of 021, 2 m wide, extended beyond its picture.
    #[test]
    fn all_of_a_built_in_scenario_is_in_its_picture_on_a_sheet() {
        for entry in cranny_scenario::catalogue() {
            let scene = scene(entry.id);
            for &view in StandardView::VARIANTS {
                let aspect = 4.0 / 3.0;
                let camera = scene.whole_camera_from(view.direction_deg(), aspect);
                let slope = libm::tan(0.5 * camera.height_rad);
                for point in scene.outline(|_| true) {
                    let from_eye = point - camera.eye;
                    let depth = -from_eye.dot(&camera.back()) * slope;
                    let (x, y) =
                        (from_eye.dot(&camera.right) / (depth * aspect), from_eye.dot(&camera.up) / depth);
                    assert!(x.abs().max(y.abs()) < 1.0, "{} {view:?}: {point}", entry.id);
                }
            }
        }
    }
}
